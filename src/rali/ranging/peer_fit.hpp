#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "rali/base/time.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::ranging {

/// Position of a moving antenna in the frame of its odometry, which knows nothing of ranges.
struct TrackPoint {
  Time t;
  geometry::Vec3 p_odom_m = geometry::Vec3::Zero();
  std::uint32_t piece = 0;       ///< a new one starts after each loss of tracking
  double speed_sigma_mps = 0.0;  ///< metres per second where the LiDAR is degenerate
};

using Track = std::span<const TrackPoint>;

/// Between the two neighbours in time; empty outside, in a gap, and between two pieces.
[[nodiscard]] std::optional<TrackPoint> point_at(Track track, Time t);

/// Diagonal of the box around all positions [m].
[[nodiscard]] double extent_m(Track track);

struct TimedRange {
  Time t;
  double range_m = 0.0;
};

/// The position of a standing antenna and the bias of the pair, from ranges along a track whose
/// speed and acceleration may be wrong by constants, as far as they are not observed. Robust:
/// ranges far off the fit hardly count.
class PeerFit {
 public:
  /// @param offset_s by which the stamps of the ranges are ahead of the track's clock
  PeerFit(Track track, std::span<const TimedRange> ranges, double offset_s);

  /// Position [m], bias [m], error of the track's speed [m/s] and acceleration [m/s^2].
  using State = Eigen::Matrix<double, 10, 1>;

  /// False with fewer than kRangesMin ranges on the track, or without a finite solution.
  [[nodiscard]] bool solve();

  /// Descends from another start, such as the solution for a similar offset, and keeps the better.
  void try_from(const State& start);

  [[nodiscard]] const State& state() const { return x_; }

  /// By how much a mean of the residuals is less certain than with independent errors: errors of
  /// ranges change slowly with the place. At least 1 (variance).
  [[nodiscard]] double alike() const;

  /// Sum over the ranges of log(1 + (residual / 0.15 m)^2), plus the priors.
  [[nodiscard]] double cost() const { return cost(kScale_m); }

  /// Root mean square of the residuals, each with its weight [m].
  [[nodiscard]] double rms_m() const;

  [[nodiscard]] std::size_t size() const { return samples_.size(); }

  /// Residuals beyond it are increasingly downweighted.
  static constexpr double kScale_m = 0.15;
  static constexpr std::size_t kRangesMin = 40;

 private:
  struct Sample {
    geometry::Vec3 p_m;
    double range_m = 0.0;
    double t_s = 0.0;  ///< since the middle of the ranges
  };

  [[nodiscard]] State prior_information() const;
  [[nodiscard]] geometry::Vec3 to_peer(const Sample& sample) const;
  [[nodiscard]] double residual_m(const Sample& sample) const;
  void start();
  void descend();
  [[nodiscard]] State mirrored(const State& state) const;
  [[nodiscard]] double cost(double scale_m) const;
  void step(double scale_m, double damping);

  std::vector<Sample> samples_;
  double speed_sigma_mps_ = 0.0;
  State x_ = State::Zero();
};

}  // namespace rali::ranging
