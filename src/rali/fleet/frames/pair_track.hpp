#pragma once

#include <cstddef>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/settings.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/geometry/types.hpp"

namespace rali::fleet {

/// One range between two vehicles, and where its antennas were: lever arms are applied
/// (x_i = p_i + R_i l), frames are levelled.
struct RangeObservation {
  Time t;
  geometry::Vec3 x_a_m = geometry::Vec3::Zero();  ///< antenna of a in a's odom frame
  geometry::Vec3 y_b_m = geometry::Vec3::Zero();  ///< antenna of b in b's odom frame
  /// Covariance of these as odometry tells it, growing along the way. What it grows by is taken for
  /// a random walk besides that of DriftSettings. Zero: only the latter.
  geometry::Mat3 x_covariance_m2 = geometry::Mat3::Zero();
  geometry::Mat3 y_covariance_m2 = geometry::Mat3::Zero();
  double range_m = 0.0;
  double sigma_m = 0.1;
  bool a_rests = false, b_rests = false;
};

/// What has become of a range that was given to a track.
enum class TrackUse { kKept, kAveraged, kThinned, kRefused };

/// Independent ranges between two vehicles (algorithms_fleet 7.3): one per `spacing_m` of way of
/// both ends together; while both stand, all ranges are averaged and count as one, because their
/// errors are those of the place. Bounded: beyond `samples_max` the oldest are dropped.
class PairTrack {
 public:
  PairTrack(StreamKey a, StreamKey b, const TrackSettings& settings)
      : a_(a), b_(b), settings_(settings) {}

  /// Refuses what is not finite, ranges and sigmas that are not positive, and what comes out of
  /// order of time.
  TrackUse add(const RangeObservation& observation);

  [[nodiscard]] StreamKey a() const { return a_; }

  [[nodiscard]] StreamKey b() const { return b_; }

  /// By time.
  [[nodiscard]] const std::vector<RangeObservation>& samples() const { return samples_; }

  /// All that were not refused.
  [[nodiscard]] std::size_t received() const { return received_; }

  /// The same seen from the other end.
  [[nodiscard]] PairTrack swapped() const;

 private:
  void average(const RangeObservation& o);

  StreamKey a_, b_;
  TrackSettings settings_;
  std::vector<RangeObservation> samples_;
  double count_ = 1.0;  ///< ranges that the last sample is the mean of
  std::size_t received_ = 0;
};

}  // namespace rali::fleet
