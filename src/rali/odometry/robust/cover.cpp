#include "rali/odometry/robust/cover.hpp"

#include <fmt/format.h>

#include "rali/odometry/robust/scan_view.hpp"

namespace rali::odometry {

using geometry::SE3;

void CoverWatch::show(const BodyPoints& points, const SE3& T_odom_body) {
  shown_ = points;
  T_odom_shown_ = T_odom_body;
}

bool CoverWatch::covers(const BodyPoints& points, const SE3& T_odom_body) const {
  // Scans that fit poorly for other reasons (a new room, a lost packet, a step of the stamps) have
  // 0 to 0.07 of their points in front; those of a box around the sensor, of dust as deep as the
  // room 0.17 to 1: in a narrow passage most have no counterpart.
  constexpr double kInFront = 0.12;
  // A vehicle that drives on under its cover leaves the view that it compares with.
  constexpr double kStillInFront = 0.03;
  if (!T_odom_shown_ || points.size() == 0) return false;
  const SE3 T_body_lidar{geometry::Mat3::Identity(), p_body_lidar_};
  const SE3 T_shown_this = (*T_odom_shown_ * T_body_lidar).inverse() * T_odom_body * T_body_lidar;
  const ViewAgreement seen =
      ScanView(shown_, p_body_lidar_).points_of(ScanView(points, p_body_lidar_), T_shown_this);
  const double limit = covered_ ? kStillInFront : kInFront;
  return seen.through >= limit * static_cast<double>(points.size());
}

void CoverWatch::note(bool covered, Time t_start, Time t_end, FindingList& findings) {
  if (covered && !covered_) covered_ = Stretch{t_start, t_end};
  if (covered) covered_->last = t_end;
  if (!covered) finish(findings);
}

void CoverWatch::finish(FindingList& findings) {
  if (!covered_) return;
  Finding f;
  f.id = "odometry.covered";
  f.severity = Severity::kWarning;
  f.t = covered_->begin;
  f.t_end = covered_->last;
  f.text = fmt::format(
      "something covered the LiDAR for {:.1f} s: its scans show points where it had seen free "
      "space just before",
      (covered_->last - covered_->begin).s());
  f.effect = "these scans are not used: the pose is predicted until the view is free again";
  f.remedy = "Keep dust, spray, curtains and hands away from the sensor.";
  findings.push_back(f);
  covered_.reset();
}

}  // namespace rali::odometry
