#include "rali/io/files/tum.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/content_kind.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

constexpr std::string_view kLevelled = "frame levelled by gravity: z is up";
constexpr std::string_view kNotLevelled = "frame not levelled by gravity: z is up only roughly";

Eigen::Quaterniond with_positive_w(const geometry::Mat3& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  // At w = 0 both signs are the same half turn: the first part that is not zero is positive.
  const double parts[] = {q.w(), q.x(), q.y(), q.z()};
  for (const double part : parts) {
    if (part == 0.0) continue;
    if (part < 0.0) q.coeffs() = -q.coeffs();
    break;
  }
  return q;
}

/// Parses one line; on failure returns the reason.
std::optional<std::string> read_pose(std::string_view line, StampedPose& pose) {
  std::string blanked(line);
  std::replace(blanked.begin(), blanked.end(), ',', ' ');
  std::string_view rest = blanked;
  const std::string_view stamp = take_word(rest);
  const auto t = parse_stamp(stamp);
  if (!t) {
    const bool number = parse_number(stamp).has_value();
    return fmt::format("{} is no stamp in seconds{}", quoted(stamp),
                       number ? " (nanoseconds?)" : "");
  }
  pose.t = *t;
  std::array<double, 7> v = {};
  for (double& value : v) {
    const std::string_view word = take_word(rest);
    if (word.empty()) return std::string("has fewer than 8 numbers");
    const auto number = parse_number(word);
    if (!number || !std::isfinite(*number)) return quoted(word) + " is no finite number";
    value = *number;
  }
  if (!trimmed(rest).empty()) return std::string("has more than 8 numbers");
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(std::abs(q.norm() - 1.0) < 0.01)) {
    return fmt::format("the quaternion has length {:.4g}, not 1", q.norm());
  }
  pose.T.R = q.normalized().toRotationMatrix();
  pose.T.p = geometry::Vec3(v[0], v[1], v[2]);
  return std::nullopt;
}

Finding finding_of(std::string id, std::string text, double value) {
  Finding finding;
  finding.id = std::move(id);
  finding.text = std::move(text);
  finding.value = value;
  return finding;
}

}  // namespace

std::string pose_text(const geometry::SE3& T, int decimals_position, int decimals_rotation) {
  const Eigen::Quaterniond q = with_positive_w(T.R);
  std::string text;
  for (int i = 0; i < 3; ++i) text += format_fixed(T.p[i], decimals_position) + ' ';
  text += format_fixed(q.x(), decimals_rotation) + ' ';
  text += format_fixed(q.y(), decimals_rotation) + ' ';
  text += format_fixed(q.z(), decimals_rotation) + ' ';
  return text + format_fixed(q.w(), decimals_rotation);
}

std::string tum_line(const StampedPose& pose) {
  return format_stamp(pose.t) + ' ' + pose_text(pose.T, 6, 9);
}

Result<TumWriter> TumWriter::create(const std::string& path,
                                    const std::vector<std::string>& header) {
  auto file = StreamFile::create(path);
  if (!file) return tl::make_unexpected(file.error());
  for (const std::string& line : header) {
    if (auto status = file->add("# " + line + "\n"); !status) {
      return tl::make_unexpected(status.error());
    }
  }
  return TumWriter(std::move(*file));
}

Status TumWriter::add(const StampedPose& pose) { return file_.add(tum_line(pose) + "\n", pose.t); }

std::string frame_line(bool levelled) { return std::string(levelled ? kLevelled : kNotLevelled); }

std::optional<bool> is_levelled(const std::vector<std::string>& header) {
  for (const std::string& line : header) {
    if (line == kLevelled) return true;
    if (line == kNotLevelled) return false;
  }
  return std::nullopt;
}

Result<TumFile> parse_tum(std::string_view text, const std::string& name) {
  TumFile file;
  const bool ends_whole = text.ends_with('\n');
  std::string_view line;
  std::uint64_t back_in_time = 0;
  std::uint64_t first_back = 0;
  for (std::uint64_t n = 1; take_line(text, line); ++n) {
    line = trimmed(line);
    if (line.empty()) continue;
    if (line.front() == '#') {
      file.header.emplace_back(trimmed(line.substr(1)));
      continue;
    }
    StampedPose pose;
    if (const auto wrong = read_pose(line, pose)) {
      const std::string where = fmt::format("{}:{}", name, n);
      if (!text.empty() || ends_whole || file.poses.empty()) {
        return fail(ErrorCode::kInput, where, *wrong);
      }
      file.findings.push_back(finding_of("tum.cut", where + ": the last line is cut; left out", 1));
      break;
    }
    if (!file.poses.empty() && pose.t <= file.poses.back().t && back_in_time++ == 0) first_back = n;
    file.poses.push_back(pose);
  }
  if (back_in_time > 0) {
    file.findings.push_back(finding_of(
        "tum.order",
        fmt::format("{}:{}: time does not advance ({} such lines)", name, first_back, back_in_time),
        static_cast<double>(back_in_time)));
  }
  if (file.poses.empty()) return fail(ErrorCode::kInput, name, "has no poses");
  return file;
}

Result<TumFile> read_tum(const std::string& path) {
  const auto bytes = read_file(path, kCloudBytesMax);
  if (!bytes) return tl::make_unexpected(bytes.error());
  const std::string kind = content_kind(*bytes);
  if (kind != "text") return fail(ErrorCode::kInput, path, "is " + kind + ", not a trajectory");
  return parse_tum(as_text(*bytes), path);
}

}  // namespace rali::io
