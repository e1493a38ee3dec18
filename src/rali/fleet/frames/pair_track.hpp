#pragma once

#include <cstddef>
#include <vector>

#include "rali/base/time.hpp"
#include "rali/fleet/frames/settings.hpp"
#include "rali/fleet/messages/messages.hpp"
#include "rali/geometry/types.hpp"

namespace rali::fleet {

/// One range between two vehicles, and the positions of its antennas: lever arms are applied (x_i =
/// p_i + R_i l), frames are levelled.
struct RangeObservation {
  Time t;
  geometry::Vec3 x_a_m = geometry::Vec3::Zero();  ///< antenna of a in a's odom frame
  geometry::Vec3 y_b_m = geometry::Vec3::Zero();  ///< antenna of b in b's odom frame
  /// Covariance of these as reported by odometry, growing along the path. Its growth is modelled as
  /// a random walk in addition to that of DriftSettings. Zero: only the latter.
  geometry::Mat3 x_covariance_m2 = geometry::Mat3::Zero();
  geometry::Mat3 y_covariance_m2 = geometry::Mat3::Zero();
  double range_m = 0.0;
  double sigma_m = 0.1;
  bool a_rests = false, b_rests = false;
};

/// What was done with a range that was given to a track.
enum class TrackUse { kKept, kAveraged, kThinned, kRefused };

/// Independent ranges between two vehicles (algorithms_fleet 7.3): one per `spacing_m` travelled by
/// both ends together. While both are at standstill, all ranges are averaged and count as one,
/// because their errors depend on the place. Bounded: beyond `samples_max` those are dropped
/// between which the direction to the other end changes least. So the ranges of a vehicle that is
/// passed, which alone tell its side of a straight path, stay however long the path becomes.
class PairTrack {
 public:
  PairTrack(StreamKey a, StreamKey b, const TrackSettings& settings)
      : a_(a), b_(b), settings_(settings) {}

  /// Refuses values that are not finite, ranges and sigmas that are not positive, and ranges out of
  /// time order.
  TrackUse add(const RangeObservation& observation);

  [[nodiscard]] StreamKey a() const { return a_; }

  [[nodiscard]] StreamKey b() const { return b_; }

  /// By time.
  [[nodiscard]] const std::vector<RangeObservation>& samples() const { return samples_; }

  /// Number of ranges that were not refused.
  [[nodiscard]] std::size_t received() const { return received_; }

  /// The same track with a and b exchanged.
  [[nodiscard]] PairTrack swapped() const;

 private:
  void average(const RangeObservation& o);
  void drop_least();

  StreamKey a_, b_;
  TrackSettings settings_;
  std::vector<RangeObservation> samples_;
  double count_ = 1.0;  ///< number of ranges averaged in the last sample
  std::size_t received_ = 0;
};

}  // namespace rali::fleet
