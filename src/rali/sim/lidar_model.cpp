#include "rali/sim/lidar_model.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "rali/base/assert.hpp"
#include "rali/sensor/lidar_models.hpp"

namespace rali::sim {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<double> radians(std::span<const float> angles_deg) {
  std::vector<double> out;
  for (const float a : angles_deg) out.push_back(static_cast<double>(a) * kDegree);
  return out;
}

/// OS1-64 of the first generation: 64 beams from -16.611 to 16.611 deg in equal steps (default
/// beam_altitude_angles of the manufacturer's client).
std::vector<double> os1_64_angles() {
  std::vector<double> out;
  for (int i = 0; i < 64; ++i) out.push_back((-16.611 + 33.222 * i / 63.0) * kDegree);
  return out;
}

std::vector<double> ring_angles(Lidar kind) {
  if (kind == Lidar::kLivox) return {};
  if (kind == Lidar::kOs1_64) return os1_64_angles();
  const sensor::LidarModel* model =
      sensor::find_lidar_model(kLidarNames[static_cast<std::size_t>(kind)]);
  RALI_ASSERT(model != nullptr);
  return radians(model->elevations_deg);
}

int firings_of(Lidar kind) {
  switch (kind) {
    case Lidar::kRs16:   // 55.5 us
    case Lidar::kVlp16:  // 55.296 us
      return 1800;
    case Lidar::kHdl32e:  // 46.08 us
      return 2170;
    case Lidar::kHdl64e:  // 48 us
      return 2083;
    case Lidar::kOs1_64:
    case Lidar::kOs0_128:
      return 1024;  // columns of lidar_mode 1024x10
    case Lidar::kLivox:
      break;
  }
  return 4000;
}

/// Ring of each laser in the order of firing, and the step between two of them [us].
struct FiringOrder {
  std::vector<int> rings;
  double step_us = 0.0;
};

/// RS-LiDAR-16: channels 1-8 from -15 deg upwards, 9-16 from +15 deg downwards, 2.8 us apart.
/// VLP-16, HDL-32E: a laser of the lower half, then one of the upper half, both upwards, 2.304 and
/// 1.152 us apart. HDL-64E: one of each block at once, upwards; the manual gives 48 us for all.
/// Ouster: a whole column at once. (User manuals of the makers.)
FiringOrder firing_order(Lidar kind, int rings) {
  FiringOrder order;
  const int half = rings / 2;
  for (int k = 0; k < rings; ++k) {
    if (kind == Lidar::kRs16) {
      order.rings.push_back(k < half ? k : rings - 1 - (k - half));
    } else if (kind == Lidar::kVlp16 || kind == Lidar::kHdl32e || kind == Lidar::kHdl64e) {
      order.rings.push_back(k % 2 == 0 ? k / 2 : half + k / 2);
    } else {
      order.rings.push_back(k);
    }
  }
  if (kind == Lidar::kRs16) order.step_us = 2.8;
  if (kind == Lidar::kVlp16) order.step_us = 2.304;
  if (kind == Lidar::kHdl32e) order.step_us = 1.152;
  if (kind == Lidar::kLivox) order.step_us = 25.0 / rings;
  return order;
}

/// Ouster's lasers sit in four columns side by side, so neighbouring rings have azimuth offsets.
double azimuth_offset_rad(Lidar kind, int ring) {
  const double outer_deg = kind == Lidar::kOs1_64 ? 3.164 : (kind == Lidar::kOs0_128 ? 10.7 : 0.0);
  constexpr std::array<double, 4> kPart{1.0, 1.0 / 3.0, -1.0 / 3.0, -1.0};
  return outer_deg * kPart[static_cast<std::size_t>(ring % 4)] * kDegree;
}

}  // namespace

LidarModel::LidarModel(Lidar kind)
    : kind_(kind), firings_(firings_of(kind)), elevations_rad_(ring_angles(kind)) {
  rings_ = kind == Lidar::kLivox ? 6 : static_cast<int>(elevations_rad_.size());
  const double period_us = 1e6 * scan_s() / firings_;
  const FiringOrder order = firing_order(kind, rings_);
  order_ = order.rings;
  phase_.assign(order_.size(), 0.0);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const auto slot = static_cast<double>(k);
    phase_[static_cast<std::size_t>(order_[k])] =
        kind == Lidar::kHdl64e ? std::floor(0.5 * slot) / 32.0 : slot * order.step_us / period_us;
  }
  aim_rings();
  for (int i = 0; i < firings_; ++i) {
    // Real spinning sensors turn clockwise seen from above.
    const double azimuth = -2.0 * std::numbers::pi * i / firings_;
    cos_azimuth_.push_back(static_cast<float>(std::cos(azimuth)));
    sin_azimuth_.push_back(static_cast<float>(std::sin(azimuth)));
  }
}

void LidarModel::aim_rings() {
  ring_.clear();
  for (std::size_t r = 0; r < elevations_rad_.size(); ++r) {
    const double e = elevations_rad_[r];
    const double lateral = azimuth_offset_rad(kind_, static_cast<int>(r));
    ring_.push_back({static_cast<float>(std::cos(e) * std::cos(lateral)),
                     static_cast<float>(std::cos(e) * std::sin(lateral)),
                     static_cast<float>(std::sin(e))});
  }
}

void LidarModel::raise_rings(std::span<const double> raised_rad) {
  for (std::size_t r = 0; r < elevations_rad_.size(); ++r) elevations_rad_[r] += raised_rad[r];
  aim_rings();
}

geometry::Vec3f LidarModel::beam(int ring, int firing, std::int64_t scan) const {
  if (kind_ == Lidar::kLivox) return rosette(ring, firing, scan);
  const auto r = static_cast<std::size_t>(ring);
  const auto a = static_cast<std::size_t>(firing);
  const float c = cos_azimuth_[a];
  const float s = sin_azimuth_[a];
  const geometry::Vec3f& d = ring_[r];
  return {d.x() * c - d.y() * s, d.x() * s + d.y() * c, d.z()};
}

/// Two counter-rotating wedge prisms: the sum of two rotating deflections fills a cone of 70 deg
/// and does not repeat within minutes (speeds 7294 and -4664 rpm have no small common period).
geometry::Vec3f LidarModel::rosette(int line, int firing, std::int64_t scan) const {
  constexpr double kDeflection_rad = 17.5 * kDegree;
  constexpr double kFirst_hz = 7294.0 / 60.0;
  constexpr double kSecond_hz = -4664.0 / 60.0;
  const double t_s =
      scan_s() * (static_cast<double>(scan) + static_cast<double>(firing) / firings_);
  const auto turned = [&](double hz) {
    const double turns = hz * t_s;
    return 2.0 * std::numbers::pi * (turns - std::floor(turns));
  };
  const double a = turned(kFirst_hz);
  const double b = turned(kSecond_hz);
  const double y = kDeflection_rad * (std::cos(a) + std::cos(b));
  const double z = kDeflection_rad * (std::sin(a) + std::sin(b)) + (line - 2.5) * 0.2 * kDegree;
  const double c = std::cos(z);
  return {static_cast<float>(c * std::cos(y)), static_cast<float>(c * std::sin(y)),
          static_cast<float>(std::sin(z))};
}

Result<Lidar> lidar_of(std::string_view name) {
  std::string known;
  for (std::size_t i = 0; i < kLidarNames.size(); ++i) {
    if (kLidarNames[i] == name) return static_cast<Lidar>(i);
    known += (i == 0 ? "" : ", ") + std::string(kLidarNames[i]);
  }
  return fail(ErrorCode::kUsage, {}, "there is no LiDAR model \"" + std::string(name) + "\"",
              "The models are " + known + ".");
}

}  // namespace rali::sim
