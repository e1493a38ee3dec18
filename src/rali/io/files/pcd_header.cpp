#include "rali/io/files/pcd_header.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/input_file.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

// Real headers are far below these limits; beyond is damage.
constexpr std::size_t kLinesMax = 200;
constexpr std::size_t kColumnsMax = 1000;
constexpr std::uint64_t kPointBytesMax = 1 << 16;

/// Parses the header line by line.
class HeaderReader {
 public:
  HeaderReader(std::span<const std::byte> bytes, const std::string& path)
      : text_(as_text(bytes)), path_(path) {}

  Result<PcdHeader> read() {
    std::string_view rest = text_;
    std::string_view line;
    while (line_ < kLinesMax && take_line(rest, line)) {
      ++line_;
      if (auto status = take(line); !status) return tl::make_unexpected(status.error());
      if (!data_seen_) continue;
      header_.data_offset = text_.size() - rest.size();
      header_.data_line = line_ + 1;
      if (auto status = finish(); !status) return tl::make_unexpected(status.error());
      return std::move(header_);
    }
    return fail(ErrorCode::kInput, path_,
                line_ == 0 ? "is an empty file" : "the PCD header has no DATA line");
  }

 private:
  Status take(std::string_view line) {
    const std::string_view key = take_word(line);
    if (key.empty() || key.front() == '#' || key == "VERSION") return {};
    if (key == "FIELDS" || key == "COLUMNS") return take_fields(line);
    if (key == "SIZE") return take_numbers(line, key, sizes_);
    if (key == "COUNT") return take_numbers(line, key, counts_);
    if (key == "TYPE") return take_types(line);
    if (key == "WIDTH") return take_number(line, key, width_);
    if (key == "HEIGHT") return take_number(line, key, height_);
    if (key == "POINTS") return take_number(line, key, points_);
    if (key == "VIEWPOINT") return take_viewpoint(line);
    if (key == "DATA") return take_data(line);
    return error(fmt::format("{} is no keyword of a PCD header", quoted(key)));
  }

  Status take_fields(std::string_view line) {
    header_.columns.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      header_.columns.push_back({std::string(word), 4, 'F', 1});
    }
    if (header_.columns.size() > kColumnsMax) return error("has more than 1000 fields");
    return {};
  }

  Status take_numbers(std::string_view line, std::string_view key,
                      std::vector<std::uint32_t>& values) {
    values.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      const auto value = parse_integer(word);
      if (!value || *value < 0 || *value > static_cast<std::int64_t>(kPointBytesMax)) {
        return error(fmt::format("{} has {} where a small number belongs", key, quoted(word)));
      }
      values.push_back(static_cast<std::uint32_t>(*value));
    }
    return {};
  }

  Status take_types(std::string_view line) {
    types_.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (word != "I" && word != "U" && word != "F") {
        return error(fmt::format("TYPE {} is not I, U or F", quoted(word)));
      }
      types_.push_back(word.front());
    }
    return {};
  }

  Status take_number(std::string_view line, std::string_view key,
                     std::optional<std::uint64_t>& out) {
    const auto value = parse_integer(trimmed(line));
    if (!value || *value < 0) {
      return error(fmt::format("{} {} is no number of points", key, quoted(trimmed(line))));
    }
    out = static_cast<std::uint64_t>(*value);
    return {};
  }

  Status take_viewpoint(std::string_view line) {
    double v[7] = {};
    for (double& number : v) {
      const auto parsed = parse_number(take_word(line));
      if (!parsed || !std::isfinite(*parsed)) {
        return error("VIEWPOINT is not 7 numbers (x y z qw qx qy qz)");
      }
      number = *parsed;
    }
    const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
    const geometry::Vec3 p(v[0], v[1], v[2]);
    const double norm = q.norm();
    // Some programs write all zeros for "none".
    if (!(norm > 1e-6 && norm < 1e6)) return {};
    const geometry::Mat3 R = q.normalized().toRotationMatrix();
    if (p.norm() > 0.0 || !R.isApprox(geometry::Mat3::Identity(), 1e-12)) {
      header_.viewpoint = geometry::SE3{R, p};
    }
    return {};
  }

  Status take_data(std::string_view line) {
    const std::string_view word = trimmed(line);
    if (word == "ascii") {
      header_.encoding = PcdEncoding::kAscii;
    } else if (word == "binary") {
      header_.encoding = PcdEncoding::kBinary;
    } else if (word == "binary_compressed") {
      header_.encoding = PcdEncoding::kCompressed;
    } else {
      return error(fmt::format("DATA {} is not ascii, binary or binary_compressed", quoted(word)));
    }
    data_seen_ = true;
    return {};
  }

  Status finish() {
    if (auto status = join_columns(); !status) return status;
    return count_points();
  }

  Status join_columns() {
    std::vector<PcdColumn>& columns = header_.columns;
    if (columns.empty()) return error("the header has no FIELDS");
    const std::size_t n = columns.size();
    if (sizes_.size() != n) return mismatch("SIZE", sizes_.size());
    if (types_.size() != n) return mismatch("TYPE", types_.size());
    if (!counts_.empty() && counts_.size() != n) return mismatch("COUNT", counts_.size());
    for (std::size_t i = 0; i < n; ++i) {
      PcdColumn& column = columns[i];
      column.size = sizes_[i];
      column.type = types_[i];
      column.count = counts_.empty() ? 1 : counts_[i];
      const bool known = column.size == 4 || column.size == 8 ||
                         (column.type != 'F' && (column.size == 1 || column.size == 2));
      if (!known) {
        return error(fmt::format("field {} has TYPE {} of SIZE {}, which does not exist",
                                 quoted(column.name), column.type, column.size));
      }
      if (column.count == 0) return error(fmt::format("field {} has COUNT 0", quoted(column.name)));
      header_.point_step += std::uint64_t{column.size} * column.count;
    }
    if (header_.point_step > kPointBytesMax) {
      return error(fmt::format("one point has {} bytes; at most {} are read", header_.point_step,
                               kPointBytesMax));
    }
    return {};
  }

  Status count_points() {
    if (!points_ && !width_) return error("the header has neither POINTS nor WIDTH");
    const std::uint64_t height = height_.value_or(1);
    const std::uint64_t width = width_.value_or(points_.value_or(0));
    constexpr std::uint64_t kMax = kCloudBytesMax;
    if (width > kMax || height > kMax || (height > 0 && width > kMax / height)) {
      return error(fmt::format("{} x {} points are more than a file can hold", width, height));
    }
    const std::uint64_t points = points_.value_or(width * height);
    header_.points = points;
    header_.width = width;
    header_.height = height;
    if (points != width * height) {
      header_.note =
          fmt::format("WIDTH {} x HEIGHT {} is not POINTS {}; POINTS taken", width, height, points);
      header_.width = points;
      header_.height = 1;
    }
    if (points > kMax / header_.point_step) {
      return error(
          fmt::format("{} points of {} bytes are more than 4 GiB", points, header_.point_step));
    }
    return {};
  }

  Status mismatch(std::string_view key, std::size_t n) {
    return error(fmt::format("{} has {} entries for {} fields", key, n, header_.columns.size()));
  }

  tl::unexpected<Error> error(std::string what) const {
    return fail(ErrorCode::kInput, fmt::format("{}:{}", path_, line_), std::move(what));
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t line_ = 0;
  bool data_seen_ = false;
  PcdHeader header_;
  std::vector<std::uint32_t> sizes_, counts_;
  std::vector<char> types_;
  std::optional<std::uint64_t> width_, height_, points_;
};

}  // namespace

Result<PcdHeader> parse_pcd_header(std::span<const std::byte> bytes, const std::string& path) {
  return HeaderReader(bytes, path).read();
}

}  // namespace rali::io
