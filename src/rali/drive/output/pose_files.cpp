#include "rali/drive/output/pose_files.hpp"

#include <cmath>
#include <iterator>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace rali::drive {
namespace {

constexpr const char* kStampRule =
    "# stamp = last point of the sweep [s]; x forward, y left, z up\n";

std::string covariance_header() {
  std::string line = "stamp_s";
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) line += fmt::format(",c{}{}", r, c);
  }
  return line + '\n';
}

std::string tum_header(const std::string& frame, const std::string& body) {
  return fmt::format("# T_{}_body: pose of {} in {}\n{}# stamp_s x y z qx qy qz qw\n",
                     frame == "map" ? "map" : "odom", body, frame, kStampRule);
}

/// "-0.000000" and "0.000000" are the same number: one text for both.
double without_negative_zero(double value, double half_step) {
  return std::abs(value) < half_step ? 0.0 : value;
}

}  // namespace

std::string stamp_text(Time t) {
  const bool negative = t.ns < 0;
  const std::uint64_t ns =
      negative ? ~static_cast<std::uint64_t>(t.ns) + 1 : static_cast<std::uint64_t>(t.ns);
  return fmt::format("{}{}.{:09d}", negative ? "-" : "", ns / 1'000'000'000, ns % 1'000'000'000);
}

std::string tum_line(Time t, const geometry::SE3& T) {
  Eigen::Quaterniond q(T.R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const auto p = [](double v) { return without_negative_zero(v, 0.5e-6); };
  const auto r = [](double v) { return without_negative_zero(v, 0.5e-9); };
  return fmt::format("{} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n", stamp_text(t),
                     p(T.p.x()), p(T.p.y()), p(T.p.z()), r(q.x()), r(q.y()), r(q.z()), r(q.w()));
}

std::string covariance_line(Time t, const geometry::Mat6& cov_boxplus,
                            const geometry::Mat3& R_outer_body) {
  const geometry::Mat6 cov = geometry::covariance_fixed_axes(cov_boxplus, R_outer_body);
  std::string line = stamp_text(t);
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) {
      line += ',';
      if (std::isfinite(cov(r, c))) fmt::format_to(std::back_inserter(line), "{:.6e}", cov(r, c));
    }
  }
  return line + '\n';
}

Result<OdometryFiles> OdometryFiles::create(const std::string& out_dir,
                                            const std::string& vehicle) {
  OdometryFiles files;
  const std::string stem = out_dir + "/odometry/" + vehicle;
  Result<GrowingFile> poses = GrowingFile::create(stem + ".tum");
  if (!poses) return tl::make_unexpected(poses.error());
  Result<GrowingFile> covariances = GrowingFile::create(stem + ".cov.csv");
  if (!covariances) return tl::make_unexpected(covariances.error());
  files.poses_ = std::move(*poses);
  files.covariances_ = std::move(*covariances);
  if (Status s = files.poses_.add(tum_header("odom/" + vehicle, "body of " + vehicle)); !s) {
    return tl::make_unexpected(s.error());
  }
  if (Status s = files.covariances_.add(covariance_header()); !s) {
    return tl::make_unexpected(s.error());
  }
  return files;
}

Status OdometryFiles::add(const PoseRecord& pose) {
  if (Status s = poses_.add(tum_line(pose.t, pose.T_odom_body)); !s) return s;
  if (Status s = covariances_.add(covariance_line(pose.t, pose.covariance, pose.T_odom_body.R));
      !s) {
    return s;
  }
  const bool due = !started_ || pose.t.s() - t_flushed_.s() >= kFlushDataS || pose.t < t_flushed_;
  if (!due) return {};
  started_ = true;
  t_flushed_ = pose.t;
  if (Status s = poses_.flush(); !s) return s;
  return covariances_.flush();
}

Status OdometryFiles::close() {
  Status first = poses_.close();
  Status second = covariances_.close();
  return first ? second : first;
}

std::string trajectory_text(const std::vector<PoseRecord>& poses, const geometry::SE3& T_map_odom,
                            const std::string& vehicle) {
  std::string text = tum_header("map", "body of " + vehicle);
  bool cut = false;
  for (const PoseRecord& pose : poses) {
    const bool diverged = pose.quality == vehicle::PoseQuality::kDiverged;
    if (diverged && !cut) text += fmt::format("# cut from {}: diverged\n", stamp_text(pose.t));
    cut = diverged;
    if (!diverged) text += tum_line(pose.t, T_map_odom * pose.T_odom_body);
  }
  return text;
}

std::string trajectory_covariance_text(const std::vector<PoseRecord>& poses,
                                       const geometry::SE3& T_map_odom) {
  std::string text = covariance_header();
  for (const PoseRecord& pose : poses) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) continue;
    // Rotation is perturbed in the body, position in the outer frame: only the latter turns.
    geometry::Mat6 J = geometry::Mat6::Identity();
    J.bottomRightCorner<3, 3>() = T_map_odom.R;
    text += covariance_line(pose.t, J * pose.covariance * J.transpose(),
                            T_map_odom.R * pose.T_odom_body.R);
  }
  return text;
}

double path_length_m(const std::vector<PoseRecord>& poses) {
  double sum_m = 0.0;
  const PoseRecord* last = nullptr;
  for (const PoseRecord& pose : poses) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) {
      last = nullptr;
      continue;
    }
    if (last != nullptr) sum_m += (pose.T_odom_body.p - last->T_odom_body.p).norm();
    last = &pose;
  }
  return sum_m;
}

}  // namespace rali::drive
