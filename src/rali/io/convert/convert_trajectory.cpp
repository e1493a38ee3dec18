#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/io/convert/convert.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"
#include "rali/io/files/tum.hpp"

namespace rali::io {
namespace {

constexpr std::string_view kCsvHeader = "stamp_s,x,y,z,qx,qy,qz,qw";
constexpr std::string_view kEurocHeader =
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
    "q_RS_z []";
constexpr std::size_t kKittiNumbers = 12;
constexpr double kRotationSlack = 0.01;  ///< KITTI matrices have 6 to 7 digits

/// A trajectory of any kind; missing stamps are zero.
struct Trajectory {
  TumFile file;
  bool stamps = true;
  std::vector<std::string> lost;
};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    std::size_t end = at;
    while (end < line.size() && line[end] != ',' && line[end] != ' ' && line[end] != '\t') ++end;
    if (end > at) cells.push_back(line.substr(at, end - at));
    at = end + 1;
  }
  return cells;
}

/// `count` finite numbers from `from` on.
std::optional<std::vector<double>> numbers_of(const std::vector<std::string_view>& cells,
                                              std::size_t from, std::size_t count) {
  if (cells.size() < from + count) return std::nullopt;
  std::vector<double> values;
  for (std::size_t i = from; i < from + count; ++i) {
    const auto value = parse_number(cells[i]);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    values.push_back(*value);
  }
  return values;
}

/// A row of KITTI: the upper 3 x 4 of the pose, row by row.
std::optional<geometry::SE3> kitti_pose(std::string_view line) {
  const auto cells = cells_of(line);
  const auto m = numbers_of(cells, 0, kKittiNumbers);
  if (!m || cells.size() != kKittiNumbers) return std::nullopt;
  geometry::SE3 T;
  for (int row = 0; row < 3; ++row) {
    const auto at = static_cast<std::size_t>(4 * row);
    for (int k = 0; k < 3; ++k) T.R(row, k) = (*m)[at + static_cast<std::size_t>(k)];
    T.p[row] = (*m)[at + 3];
  }
  const double skew = (T.R * T.R.transpose() - geometry::Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(skew < kRotationSlack) || T.R.determinant() < 0.0) return std::nullopt;
  T.R = Eigen::Quaterniond(T.R).normalized().toRotationMatrix();
  return T;
}

/// A row of EuRoC ground truth: nanoseconds, position, quaternion with w first.
std::optional<StampedPose> euroc_pose(std::string_view line) {
  const auto cells = cells_of(line);
  const auto v = numbers_of(cells, 1, 7);
  const auto ns = cells.empty() ? std::nullopt : parse_integer(cells[0]);
  if (!v || !ns) return std::nullopt;
  const Eigen::Quaterniond q((*v)[3], (*v)[4], (*v)[5], (*v)[6]);
  if (!(std::abs(q.norm() - 1.0) < kRotationSlack)) return std::nullopt;
  StampedPose pose;
  pose.t = Time::from_ns(*ns);
  pose.T.p = geometry::Vec3((*v)[0], (*v)[1], (*v)[2]);
  pose.T.R = q.normalized().toRotationMatrix();
  return pose;
}

/// The first line that is neither empty nor a comment.
std::string_view first_row(std::string_view text) {
  std::string_view line;
  while (take_line(text, line)) {
    line = trimmed(line);
    if (!line.empty() && line.front() != '#') return line;
  }
  return {};
}

/// Rows of KITTI or EuRoC, selected by `kitti`.
Result<Trajectory> parse_rows(std::string_view text, const std::string& path, bool kitti) {
  Trajectory out;
  out.stamps = !kitti;
  bool more_columns = false;
  std::string_view line;
  for (std::uint64_t n = 1; take_line(text, line); ++n) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    std::optional<StampedPose> pose;
    if (kitti) {
      if (const auto T = kitti_pose(line)) pose = StampedPose{Time{}, *T};
    } else {
      pose = euroc_pose(line);
      more_columns = more_columns || cells_of(line).size() > 8;
    }
    if (!pose) {
      return fail(ErrorCode::kInput, fmt::format("{}:{}", path, n),
                  kitti ? "is no pose of 12 numbers (KITTI)"
                        : "is no EuRoC row (ns, position, quaternion w x y z)");
    }
    out.file.poses.push_back(*pose);
  }
  if (more_columns) out.lost.emplace_back("columns after the pose (velocity, biases)");
  return out;
}

Result<Trajectory> read_trajectory(const std::string& path) {
  const auto bytes = read_file(path, kCloudBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  if (const std::string kind = content_kind(*bytes); kind != "text") {
    return fail(ErrorCode::kInput, path, "is " + kind + ", not a trajectory");
  }
  std::string_view text = as_text(*bytes);
  const std::string_view row = first_row(text);
  if (row.starts_with("stamp_s")) text.remove_prefix(row.data() + row.size() - text.data());
  const auto cells = cells_of(first_row(text));
  if (cells.size() == kKittiNumbers) return parse_rows(text, path, true);
  const bool euroc = text.starts_with("#timestamp") ||
                     (cells.size() >= 8 && cells[0].size() >= 16 && parse_integer(cells[0]));
  if (euroc) return parse_rows(text, path, false);
  auto tum = parse_tum(text, path);
  if (!tum) return tl::make_unexpected(tum.error());
  return Trajectory{std::move(*tum), true, {}};
}

/// Sets the stamps of the poses from a file with one per line.
Status add_times(Trajectory& trajectory, const std::string& path) {
  const auto bytes = read_file(path, kCloudBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  std::string_view text = as_text(*bytes), line;
  std::vector<StampedPose>& poses = trajectory.file.poses;
  std::size_t stamps = 0;
  for (std::uint64_t n = 1; take_line(text, line); ++n) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    const auto t = parse_stamp(line);
    if (!t) {
      return fail(ErrorCode::kInput, fmt::format("{}:{}", path, n),
                  quoted(line) + " is no stamp in seconds");
    }
    if (stamps < poses.size()) poses[stamps].t = *t;
    ++stamps;
  }
  if (stamps != poses.size()) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("has {} for {}", counted(stamps, "stamp"), counted(poses.size(), "pose")));
  }
  trajectory.stamps = true;
  return {};
}

std::string kitti_row(const geometry::SE3& T) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int k = 0; k < 3; ++k) text += format_fixed(T.R(row, k), 9) + ' ';
    text += format_fixed(T.p[row], 6) + (row < 2 ? " " : "\n");
  }
  return text;
}

std::string row_of(const StampedPose& pose, const std::string& to) {
  if (to == "kitti") return kitti_row(pose.T);
  if (to == "tum") return tum_line(pose) + '\n';
  std::string line = tum_line(pose);
  if (to == "csv") {
    std::replace(line.begin(), line.end(), ' ', ',');
    return line + '\n';
  }
  const auto c = cells_of(line);
  return fmt::format("{},{},{},{},{},{},{},{}\n", pose.t.ns, c[1], c[2], c[3], c[7], c[4], c[5],
                     c[6]);
}

std::string text_of(const Trajectory& trajectory, const std::string& to) {
  std::string text;
  if (to == "tum") {
    for (const std::string& line : trajectory.file.header) text += "# " + line + '\n';
  }
  if (to == "csv") text += std::string(kCsvHeader) + '\n';
  if (to == "euroc") text += std::string(kEurocHeader) + '\n';
  for (const StampedPose& pose : trajectory.file.poses) text += row_of(pose, to);
  return text;
}

}  // namespace

Result<Conversion> convert_trajectory(const std::string& in, const std::string& out,
                                      const std::string& to, const std::string& times) {
  auto trajectory = read_trajectory(in);
  if (!trajectory) return tl::make_unexpected(trajectory.error());
  if (!times.empty()) {
    if (Status status = add_times(*trajectory, times); !status) {
      return tl::make_unexpected(status.error());
    }
  }
  if (!trajectory->stamps && to != "kitti") {
    return fail(ErrorCode::kInput, in, "has no stamps (KITTI), which " + to + " needs",
                "Name a file of stamps, one a line, with --times.");
  }
  if (Status status = write_file_atomic(out, text_of(*trajectory, to)); !status) {
    return tl::make_unexpected(status.error());
  }
  Conversion done;
  done.done = counted(trajectory->file.poses.size(), "pose");
  done.lost = std::move(trajectory->lost);
  if (to == "kitti" && trajectory->stamps) done.lost.emplace_back("stamps: KITTI has none");
  if (to != "tum" && !trajectory->file.header.empty()) {
    done.lost.emplace_back("comments of the header");
  }
  done.findings = std::move(trajectory->file.findings);
  for (const Finding& finding : done.findings) done.gaps |= finding.id == "tum.cut";
  return done;
}

}  // namespace rali::io
