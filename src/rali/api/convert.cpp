#include "rali/api/convert.hpp"

#include "rali/vehicle/odom_frame.hpp"

namespace rali::api {
namespace {

std::string name_of(VehicleId id, const VehicleNames& names) {
  return id.value < names.size() ? names[id.value] : std::string();
}

Degeneracy public_degeneracy(const degeneracy::Report& report) {
  Degeneracy result;
  result.degenerate = report.degenerate;
  result.direction_odom = report.degenerate_odom;
  result.sigma_m = report.sigma_degenerate_m;
  for (std::size_t axis = 0; axis < result.translation_sigma_m.size(); ++axis) {
    result.translation_sigma_m[axis] = report.directions[axis].sigma;
  }
  if (report.paper.known) result.degree = report.paper.degree;
  return result;
}

}  // namespace

Pose3 public_pose(const geometry::SE3& T) {
  Pose3 pose = Pose3::Identity();
  pose.linear() = T.R;
  pose.translation() = T.p;
  return pose;
}

geometry::SE3 inner_pose(const Pose3& T) { return {T.linear(), T.translation()}; }

Covariance6 public_covariance(const geometry::Mat6& covariance, const geometry::SE3& T_outer_body) {
  return geometry::covariance_fixed_axes(covariance, T_outer_body.R);
}

RunFinding public_finding(const Finding& finding, const std::string& vehicle) {
  return {finding.id,     static_cast<FindingLevel>(finding.severity),
          finding.t.ns,   finding.vehicle.empty() ? vehicle : finding.vehicle,
          finding.topic,  finding.text,
          finding.effect, finding.remedy};
}

static_assert(static_cast<int>(FindingLevel::kError) == static_cast<int>(Severity::kError));
static_assert(static_cast<int>(PoseQuality::kDiverged) ==
              static_cast<int>(vehicle::PoseQuality::kDiverged));

PoseEstimate public_estimate(const vehicle::PoseEstimate& pose, const std::string& name) {
  PoseEstimate result;
  result.vehicle = name;
  result.stamp_ns = pose.t.ns;
  result.T_odom_body = public_pose(pose.T_odom_body);
  result.T_local_body = public_pose(pose.T_local_body);
  result.v_odom_mps = pose.v_odom_mps;
  result.covariance = public_covariance(
      vehicle::odom_covariance(pose.covariance, pose.T_local_body, pose.T_odom_body),
      pose.T_odom_body);
  result.covariance_local = public_covariance(pose.covariance, pose.T_local_body);
  result.quality = static_cast<PoseQuality>(pose.quality);
  result.degeneracy = public_degeneracy(pose.degeneracy);
  result.correspondences = pose.matches;
  result.standstill = pose.at_rest;
  result.range_correction_m = pose.correction_m;
  return result;
}

Keyframe public_keyframe(const vehicle::KeyframeAdded& added, const std::string& name) {
  const odometry::Keyframe& keyframe = *added.keyframe;
  return {name,
          added.id.seq,
          keyframe.t.ns,
          public_pose(keyframe.T_odom_body),
          keyframe.cloud.x_m,
          keyframe.cloud.y_m,
          keyframe.cloud.z_m,
          keyframe.cloud.intensity};
}

RangeMeasurement public_range(const sensor::RangeSample& sample, const VehicleNames& names) {
  return {sample.t.ns,
          name_of(sample.from, names),
          name_of(sample.to, names),
          sample.from_antenna,
          sample.to_antenna,
          sample.range_m,
          sample.sigma_m,
          sample.rssi_dbm,
          sample.first_path_dbm};
}

RangeResult public_range(const ranging::RangeUse& use, const VehicleNames& names) {
  RangeResult result;
  result.measurement = public_range(use.sample, names);
  result.used = use.used();
  result.reason = ranging::kRangeReasonNames[static_cast<std::size_t>(use.reason)];
  result.predicted_m = use.predicted_m;
  result.residual_m = use.residual_m;
  result.sigma_m = use.sigma_m;
  return result;
}

}  // namespace rali::api
