#include "rali/drive/output/pose_files.hpp"

#include <cmath>
#include <filesystem>
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

OdometryFiles::OdometryFiles(io::AtomicFile poses, io::AtomicFile covariances)
    : poses_(std::move(poses)), covariances_(std::move(covariances)) {}

Result<OdometryFiles> OdometryFiles::create(const std::string& out_dir,
                                            const std::string& vehicle) {
  std::error_code error;
  std::filesystem::create_directories(out_dir + "/odometry", error);
  if (error) return fail(ErrorCode::kMachine, out_dir + "/odometry", error.message());
  const std::string stem = out_dir + "/odometry/" + vehicle;
  Result<io::AtomicFile> poses = io::AtomicFile::create(stem + ".tum", io::OnAbandon::kKeep);
  if (!poses) return tl::make_unexpected(poses.error());
  Result<io::AtomicFile> covariances =
      io::AtomicFile::create(stem + ".cov.csv", io::OnAbandon::kKeep);
  if (!covariances) return tl::make_unexpected(covariances.error());
  OdometryFiles files(std::move(*poses), std::move(*covariances));
  const Status first = files.poses_.write(tum_header("odom/" + vehicle, "body of " + vehicle));
  const Status second = files.covariances_.write(covariance_header());
  if (!first) return tl::make_unexpected(first.error());
  if (!second) return tl::make_unexpected(second.error());
  return files;
}

Status OdometryFiles::add(const PoseRecord& pose) {
  if (Status s = poses_.write(tum_line(pose.t, pose.T_odom_body)); !s) return s;
  if (Status s = covariances_.write(covariance_line(pose.t, pose.covariance, pose.T_odom_body.R));
      !s) {
    return s;
  }
  const bool due = !started_ || pose.t.s() - t_flushed_.s() >= kFlushDataS || pose.t < t_flushed_;
  if (!due) return {};
  started_ = true;
  t_flushed_ = pose.t;
  if (Status s = poses_.sync(); !s) return s;
  return covariances_.sync();
}

Status OdometryFiles::close() {
  Status first = poses_.commit();
  Status second = covariances_.commit();
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

PoseRecord pose_record(const vehicle::PoseEstimate& pose) {
  PoseRecord record;
  record.t = pose.t;
  record.T_odom_body = pose.T_odom_body;
  record.covariance = pose.covariance;
  record.quality = pose.quality;
  record.blind = pose.degeneracy.blind;
  record.sigma_blind_m = pose.degeneracy.sigma_blind_m;
  if (pose.degeneracy.paper.known) record.degree = pose.degeneracy.paper.degree;
  record.blind_odom = pose.degeneracy.blind_odom;
  if (record.blind_odom.isZero()) {
    record.blind_odom = pose.T_odom_body.R * pose.degeneracy.paper.e3_body;
  }
  return record;
}

std::string degeneracy_text(const std::vector<PoseRecord>& poses, const geometry::SE3& T_map_odom) {
  std::string text =
      "stamp_s,blind,degree,dir_x,dir_y,dir_z,sigma_blind_m,correction_m,range_from\n";
  for (const PoseRecord& pose : poses) {
    text += fmt::format("{},{},", stamp_text(pose.t), pose.blind ? 1 : 0);
    if (pose.degree && std::isfinite(*pose.degree)) text += fmt::format("{:.6f}", *pose.degree);
    const geometry::Vec3 d = T_map_odom.R * pose.blind_odom;
    if (d.isZero() || !d.allFinite()) {
      text += ",,,,";
    } else {
      const auto n = [](double v) { return without_negative_zero(v, 0.5e-6); };
      text += fmt::format(",{:.6f},{:.6f},{:.6f},", n(d.x()), n(d.y()), n(d.z()));
    }
    if (std::isfinite(pose.sigma_blind_m)) text += fmt::format("{:.6f}", pose.sigma_blind_m);
    text += ",,\n";
  }
  return text;
}

WayLength way_length(const std::vector<PoseRecord>& poses) {
  WayLength way;
  const PoseRecord* last = nullptr;
  for (const PoseRecord& pose : poses) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) {
      last = nullptr;
      continue;
    }
    if (last != nullptr) {
      const double step_m = (pose.T_odom_body.p - last->T_odom_body.p).norm();
      way.path_m += step_m;
      if (pose.blind) way.blind_m += step_m;
    }
    last = &pose;
  }
  return way;
}

}  // namespace rali::drive
