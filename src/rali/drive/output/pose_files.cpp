#include "rali/drive/output/pose_files.hpp"

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/io/files/text.hpp"

namespace rali::drive {
namespace {

/// Becomes an empty cell.
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

constexpr std::array<std::string_view, 3> kAxisNames{"axial", "lateral", "vertical"};
constexpr std::array<std::string_view, 3> kCategoryNames{"full", "partial", "none"};

/// Sigma of the position along the least observable direction.
double sigma_along_m(const PoseRecord& pose) {
  const geometry::Vec3 d = pose.degenerate_odom.normalized();
  const double variance = d.dot(pose.covariance.bottomRightCorner<3, 3>() * d);
  return variance >= 0.0 ? std::sqrt(variance) : kUnknown;
}

std::vector<std::string> tum_header(const std::string& frame, const std::string& vehicle,
                                    const std::string& point) {
  return {fmt::format("T_{}_{}: pose of {} of {} in {}", frame == "map" ? "map" : "odom", point,
                      point, vehicle, frame),
          "stamp = last point of the scan [s]; x forward, y left, z up",
          "stamp_s x y z qx qy qz qw"};
}

}  // namespace

std::vector<std::string> covariance_columns() {
  std::vector<std::string> columns = {"stamp_s"};
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) columns.push_back(fmt::format("c{}{}", r, c));
  }
  return columns;
}

io::CsvRow covariance_row(Time t, const geometry::Mat6& cov_boxplus,
                          const geometry::Mat3& R_outer_body) {
  const geometry::Mat6 cov = geometry::covariance_fixed_axes(cov_boxplus, R_outer_body);
  io::CsvRow row;
  row.stamp(t);
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) row.scientific(cov(r, c), 6);
  }
  return row;
}

PoseFiles::PoseFiles(io::TumWriter poses, io::CsvWriter covariances)
    : poses_(std::move(poses)), covariances_(std::move(covariances)) {}

Result<PoseFiles> PoseFiles::create(const std::string& out_dir, const std::string& folder,
                                    const std::string& vehicle, const std::string& frame) {
  const std::string dir = out_dir + '/' + folder;
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  if (error) return fail(ErrorCode::kMachine, dir, error.message());
  const std::string stem = dir + '/' + vehicle;
  Result<io::TumWriter> poses =
      io::TumWriter::create(stem + ".tum", tum_header(frame, vehicle, "body"));
  if (!poses) return tl::make_unexpected(poses.error());
  Result<io::CsvWriter> covariances =
      io::CsvWriter::create(stem + ".cov.csv", covariance_columns());
  if (!covariances) return tl::make_unexpected(covariances.error());
  return PoseFiles(std::move(*poses), std::move(*covariances));
}

Status PoseFiles::add(Time t, const geometry::SE3& T, const geometry::Mat6& covariance) {
  if (Status s = poses_.add({t, T}); !s) return s;
  return covariances_.add(covariance_row(t, covariance, T.R), t);
}

Status PoseFiles::close() {
  Status first = poses_.finish();
  Status second = covariances_.finish();
  return first ? second : first;
}

std::vector<std::string> trajectory_header(const MapFrame& frame, const std::string& vehicle) {
  std::vector<std::string> header = tum_header("map", vehicle, frame.point);
  header.insert(header.begin() + 1, io::frame_line(frame.levelled));
  return header;
}

std::string trajectory_text(const std::vector<PoseRecord>& poses, const MapFrame& frame,
                            const std::string& vehicle) {
  std::string text;
  for (const std::string& line : trajectory_header(frame, vehicle)) text += "# " + line + '\n';
  bool cut = false;
  for (const PoseRecord& pose : poses) {
    const bool diverged = pose.quality == vehicle::PoseQuality::kDiverged;
    if (diverged && !cut) text += "# cut from " + io::format_stamp(pose.t) + ": diverged\n";
    cut = diverged;
    if (diverged) continue;
    const geometry::SE3 T_map_body = frame.T_map_local * pose.T_local_body;
    text += io::tum_line({pose.t, T_map_body * frame.T_body_point}) + '\n';
  }
  return text;
}

std::string trajectory_covariance_text(const std::vector<PoseRecord>& poses,
                                       const MapFrame& frame) {
  std::string text = fmt::format("{}\n", fmt::join(covariance_columns(), ","));
  for (const PoseRecord& pose : poses) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) continue;
    const geometry::Mat3 R_map_body = frame.T_map_local.R * pose.T_local_body.R;
    // Rotation is perturbed in the body, position in the outer frame: only the position part
    // rotates. A point away from the body's origin moves with the rotation.
    geometry::Mat6 J = geometry::Mat6::Identity();
    J.topLeftCorner<3, 3>() = frame.T_body_point.R.transpose();
    J.bottomRightCorner<3, 3>() = frame.T_map_local.R;
    J.bottomLeftCorner<3, 3>() = -R_map_body * geometry::skew(frame.T_body_point.p);
    text += covariance_row(pose.t, J * pose.covariance * J.transpose(),
                           R_map_body * frame.T_body_point.R)
                .line() +
            '\n';
  }
  return text;
}

double position_sigma_m(const PoseRecord& pose) {
  const double trace = pose.covariance.bottomRightCorner<3, 3>().trace();
  return std::isfinite(trace) && trace > 0.0 ? std::sqrt(trace) : 0.0;
}

PoseRecord pose_record(const vehicle::PoseEstimate& pose) {
  PoseRecord record;
  record.t = pose.t;
  record.T_local_body = pose.T_local_body;
  record.T_odom_body = pose.T_odom_body;
  record.covariance = pose.covariance;
  record.quality = pose.quality;
  record.degenerate = pose.degeneracy.degenerate;
  record.sigma_degenerate_m = pose.degeneracy.sigma_degenerate_m;
  if (pose.degeneracy.paper.known) record.degree = pose.degeneracy.paper.degree;
  record.degenerate_odom = pose.degeneracy.degenerate_odom;
  if (record.degenerate_odom.isZero()) {
    record.degenerate_odom = pose.T_local_body.R * pose.degeneracy.paper.e3_body;
  }
  const auto& axes = pose.degeneracy.directions;
  for (int axis = 0; axis < 3; ++axis) {
    const degeneracy::DirectionInfo& d = axes[static_cast<std::size_t>(axis)];
    if (d.direction_odom.isZero()) continue;
    const bool worse =
        record.worst_axis < 0 || d.sigma > axes[static_cast<std::size_t>(record.worst_axis)].sigma;
    if (!worse) continue;
    record.worst_axis = axis;
    record.category = d.category;
  }
  record.correction_m = pose.correction_m;
  record.range_from = pose.range_from;
  return record;
}

std::string degeneracy_text(const std::vector<PoseRecord>& poses, const geometry::SE3& T_map_local,
                            const std::vector<std::string>& vehicles) {
  std::string text =
      "stamp_s,degenerate,degree,dir_x,dir_y,dir_z,sigma_degenerate_m,correction_m,range_from,axis,"
      "category,sigma_m,constrained_by\n";
  for (const PoseRecord& pose : poses) {
    const geometry::Vec3 d = T_map_local.R * pose.degenerate_odom;
    const bool known = !d.isZero() && d.allFinite();
    io::CsvRow row;
    row.stamp(pose.t).integer(pose.degenerate ? 1 : 0);
    row.fixed(pose.degree.value_or(kUnknown), 6);
    for (int axis = 0; axis < 3; ++axis) row.fixed(known ? d[axis] : kUnknown, 6);
    row.fixed(pose.sigma_degenerate_m, 6);
    const bool named = pose.range_from && pose.range_from->value < vehicles.size();
    row.fixed(pose.range_from ? pose.correction_m : kUnknown, 6);
    row.text(named ? vehicles[pose.range_from->value] : "");
    const bool axis_known = pose.worst_axis >= 0;
    row.text(axis_known ? kAxisNames[static_cast<std::size_t>(pose.worst_axis)] : "");
    row.text(axis_known ? kCategoryNames[static_cast<std::size_t>(pose.category)] : "");
    row.fixed(known ? sigma_along_m(pose) : kUnknown, 6);
    row.text(kHeldByNames[static_cast<std::size_t>(pose.held_by)]);
    text += row.line() + '\n';
  }
  return text;
}

PathLength path_length(const std::vector<PoseRecord>& poses) {
  PathLength path;
  const PoseRecord* last = nullptr;
  for (const PoseRecord& pose : poses) {
    if (pose.quality == vehicle::PoseQuality::kDiverged) {
      last = nullptr;
      continue;
    }
    if (last != nullptr) {
      const double step_m = (pose.T_local_body.p - last->T_local_body.p).norm();
      path.path_m += step_m;
      if (pose.degenerate) path.degenerate_m += step_m;
      if (pose.degenerate && pose.held_by == HeldBy::kRange) path.held_m += step_m;
    }
    last = &pose;
  }
  return path;
}

}  // namespace rali::drive
