#include "sample.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "rali/degeneracy/paper_degree.hpp"
#include "rali/degeneracy/zhang.hpp"
#include "rali/geometry/pca3.hpp"
#include "rali/odometry/paper/planar_features.hpp"

namespace rali::degeneracy_bench {

using geometry::Mat3;
using geometry::Mat6;
using geometry::SE3;
using geometry::Vec3;

namespace {

constexpr double kFirst_m = 3.0;  // of map before the first sample
constexpr double kEvery_m = 2.0;

double off_axis_deg(const Vec3& direction_world, const Vec3& axis_world) {
  const Vec3 flat(direction_world.x(), direction_world.y(), 0.0);
  if (!(flat.norm() > 1e-6)) return std::numeric_limits<double>::quiet_NaN();
  const double cosine = std::min(1.0, std::abs(flat.normalized().dot(axis_world)));
  return std::acos(cosine) * 180.0 / std::numbers::pi;
}

std::vector<Vec3> normals_body(const sensor::LidarScan& scan, const Mat3& R_body_lidar) {
  odometry::paper::PlanarFeatures features;
  odometry::paper::extract_planar_features(scan, {}, features);
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < features.size(); ++i) {
    out.push_back(R_body_lidar * Vec3(features.nx[i], features.ny[i], features.nz[i]));
  }
  return out;
}

/// Smallest eigenvalue of the normals' covariance.
double lambda3(const std::vector<Vec3>& normals) {
  if (normals.empty()) return 0.0;
  Vec3 sum = Vec3::Zero();
  Mat3 S = Mat3::Zero();
  for (const Vec3& n : normals) {
    sum += n;
    S += n * n.transpose();
  }
  const auto count = static_cast<double>(normals.size());
  const Vec3 mean = sum / count;
  return std::max(0.0, geometry::pca3(S / count - mean * mean.transpose()).values[2]);
}

double times_chance(const degeneracy::DirectionInfo& d) {
  if (d.noise > 0.0) return d.raw / d.noise;
  return d.raw > 0.0 ? std::numeric_limits<double>::infinity() : 0.0;
}

Reported& of(Sample& sample, Detector which) {
  return sample.reported[static_cast<std::size_t>(which)];
}

void ask_paper(const Station& station, const sensor::Calibration& calibration, Sample& out) {
  const Mat3& R = station.T_world_body.R;
  const auto normals = normals_body(*station.scan, calibration.T_body_lidar.R);
  const degeneracy::PaperDegree paper =
      degeneracy::paper_degree(normals, R.transpose() * Vec3::UnitZ(), {});
  of(out, Detector::kPaper) = {paper.known ? paper.degree : 0.0,
                               off_axis_deg(R * paper.direction_body, station.axis_world)};
  of(out, Detector::kLambda3) = {lambda3(normals),
                                 off_axis_deg(R * paper.e3_body, station.axis_world)};
}

void ask_zhang(const Mat6& JtJ, const Vec3& axis_world, Sample& out) {
  const degeneracy::ZhangFactors zhang(JtJ);
  const double off_deg = off_axis_deg(zhang.translation_direction(), axis_world);
  of(out, Detector::kZhang) = {zhang.factors()[0], off_deg};
  of(out, Detector::kZhangShift) = {zhang.translation(), off_deg};
}

}  // namespace

Judge::Judge(const odometry::RobustSettings& settings, std::string place, std::uint64_t seed,
             int rings, double mask_m)
    : settings_(settings), map_(settings), mask_m_(mask_m), next_m_(kFirst_m) {
  pattern_.place = std::move(place);
  pattern_.seed = seed;
  pattern_.rings = rings;
  pattern_.masked = mask_m > 0.0;
}

void Judge::add(const Station& station, const sensor::Calibration& calibration) {
  map_.look(station, calibration, mask_m_);
  if (station.driven_m >= next_m_) {
    next_m_ += kEvery_m;
    judge(station, calibration);
  }
  map_.insert();
}

void Judge::judge(const Station& station, const sensor::Calibration& calibration) {
  Sample out = pattern_;
  out.driven_m = station.driven_m;
  ask_paper(station, calibration, out);

  const Mat3& R = station.T_world_body.R;
  const odometry::LidarSystem system = map_.at_truth();
  axes_ = degeneracy::physical_axes(system.I, Vec3(0.0, 0.0, -9.81), R, axes_, settings_.aware);
  out.directions =
      degeneracy::direction_information(system.I, map_.evidence(), R, axes_, settings_.aware);
  const auto& axial = out.directions[0];
  const auto& lateral = out.directions[1];
  const double off_deg = off_axis_deg(axial.direction_odom, station.axis_world);
  of(out, Detector::kRaw) = {std::min(axial.raw, lateral.raw), off_deg};
  of(out, Detector::kChance) = {std::min(times_chance(axial), times_chance(lateral)), off_deg};
  of(out, Detector::kAware) = {std::min(axial.information, lateral.information), off_deg};
  ask_zhang(map_.unweighted(), station.axis_world, out);

  out.truth = map_.register_from_beside();
  samples_.push_back(out);
}

}  // namespace rali::degeneracy_bench
