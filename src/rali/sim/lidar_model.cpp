#include "rali/sim/lidar_model.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace rali::sim {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::vector<double> even_angles(double lowest_deg, double highest_deg, int rings) {
  std::vector<double> out;
  for (int i = 0; i < rings; ++i) {
    out.push_back((lowest_deg + (highest_deg - lowest_deg) * i / (rings - 1)) * kDegree);
  }
  return out;
}

/// HDL-64E: the upper block has 1/3 deg steps, the lower one 1/2 deg (manual, rev. S2).
std::vector<double> hdl64_angles() {
  std::vector<double> out;
  for (int i = 0; i < 32; ++i) out.push_back((-24.33 + 0.5 * i) * kDegree);
  for (int i = 0; i < 32; ++i) out.push_back((-8.33 + i / 3.0) * kDegree);
  return out;
}

std::vector<double> ring_angles(Lidar kind) {
  switch (kind) {
    case Lidar::kRs16:
    case Lidar::kVlp16:
      return even_angles(-15.0, 15.0, 16);
    case Lidar::kHdl32e:
      return even_angles(-30.67, 10.67, 32);
    case Lidar::kHdl64e:
      return hdl64_angles();
    case Lidar::kOs1_64:
      return even_angles(-22.5, 22.5, 64);
    case Lidar::kOs0_128:
      return even_angles(-45.0, 45.0, 128);
    case Lidar::kLivox:
      break;
  }
  return {};
}

}  // namespace

LidarModel::LidarModel(Lidar kind) : kind_(kind), elevations_rad_(ring_angles(kind)) {
  rings_ = kind == Lidar::kLivox ? 6 : static_cast<int>(elevations_rad_.size());
  firings_ = kind == Lidar::kLivox ? 4000 : 1800;
  if (kind == Lidar::kOs1_64 || kind == Lidar::kOs0_128) firings_ = 1024;
  for (const double e : elevations_rad_) {
    cos_elevation_.push_back(static_cast<float>(std::cos(e)));
    sin_elevation_.push_back(static_cast<float>(std::sin(e)));
  }
  for (int i = 0; i < firings_; ++i) {
    // Real spinning sensors turn clockwise seen from above.
    const double azimuth = -2.0 * std::numbers::pi * i / firings_;
    cos_azimuth_.push_back(static_cast<float>(std::cos(azimuth)));
    sin_azimuth_.push_back(static_cast<float>(std::sin(azimuth)));
  }
}

double LidarModel::phase(int ring) const {
  if (kind_ == Lidar::kOs1_64 || kind_ == Lidar::kOs0_128) return 0.0;  // all at once
  return static_cast<double>(ring) / rings_;
}

geometry::Vec3f LidarModel::beam(int ring, int firing, std::int64_t sweep) const {
  if (kind_ == Lidar::kLivox) return rosette(ring, firing, sweep);
  const auto r = static_cast<std::size_t>(ring);
  const auto a = static_cast<std::size_t>(firing);
  return {cos_elevation_[r] * cos_azimuth_[a], cos_elevation_[r] * sin_azimuth_[a],
          sin_elevation_[r]};
}

/// Two counter-rotating wedge prisms: the sum of two turning deflections fills a cone of 70 deg
/// and does not repeat within minutes (speeds 7294 and -4664 rpm have no small common period).
geometry::Vec3f LidarModel::rosette(int line, int firing, std::int64_t sweep) const {
  constexpr double kDeflection_rad = 17.5 * kDegree;
  constexpr double kFirst_hz = 7294.0 / 60.0;
  constexpr double kSecond_hz = -4664.0 / 60.0;
  const double t_s =
      sweep_s() * (static_cast<double>(sweep) + static_cast<double>(firing) / firings_);
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
