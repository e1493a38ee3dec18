#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/settings.hpp"
#include "rali/geometry/types.hpp"

namespace rali::sim {

enum class Lidar { kRs16, kVlp16, kHdl32e, kHdl64e, kOs1_64, kOs0_128, kLivox };
inline constexpr ChoiceNames<7> kLidarNames{"rs16",   "vlp16",   "hdl32e", "hdl64e",
                                            "os1_64", "os0_128", "livox"};

/// A sensor as a list of firings; within a firing the lasers fire in the order and at the times of
/// the real sensor. Rings are counted upwards from the lowest.
class LidarModel {
 public:
  explicit LidarModel(Lidar kind);

  [[nodiscard]] int rings() const { return rings_; }

  [[nodiscard]] int firings() const { return firings_; }

  [[nodiscard]] double scan_s() const { return 0.1; }

  /// Direction of laser `ring` in firing `firing` of scan number `scan`: unit vector in the sensor
  /// frame, x ahead, z up. A spinning sensor repeats its pattern every scan, a rosette does not.
  [[nodiscard]] geometry::Vec3f beam(int ring, int firing, std::int64_t scan) const;

  /// Raises each ring of a spinning sensor by an angle [rad], one per ring; rosettes have no rings.
  void raise_rings(std::span<const double> raised_rad);

  /// Firing time in units of one firing period after the start of the firing, in [0, 1).
  [[nodiscard]] double phase(int ring) const { return phase_[static_cast<std::size_t>(ring)]; }

  /// Rings in the order in which they fire.
  [[nodiscard]] const std::vector<int>& order() const { return order_; }

  /// Elevation of each ring of a spinning sensor [rad], lowest first; empty for a rosette.
  [[nodiscard]] const std::vector<double>& elevations_rad() const { return elevations_rad_; }

 private:
  void aim_rings();
  [[nodiscard]] geometry::Vec3f rosette(int line, int firing, std::int64_t scan) const;

  Lidar kind_;
  int rings_ = 16;
  int firings_;
  std::vector<double> elevations_rad_;
  std::vector<int> order_;
  std::vector<double> phase_;          ///< by ring
  std::vector<geometry::Vec3f> ring_;  ///< direction of each ring at azimuth zero
  std::vector<float> cos_azimuth_, sin_azimuth_;
};

[[nodiscard]] Result<Lidar> lidar_of(std::string_view name);

}  // namespace rali::sim
