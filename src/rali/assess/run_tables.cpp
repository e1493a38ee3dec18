#include "rali/assess/run_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"

namespace rali::assess {

using geometry::Mat6;
using geometry::Vec3;

namespace {

std::optional<std::size_t> pose_of(const eval::PoseList& poses, Time t) {
  const auto found =
      std::lower_bound(poses.begin(), poses.end(), t,
                       [](const eval::StampedPose& p, Time time) { return p.t < time; });
  if (found == poses.end() || found->t != t) return std::nullopt;
  return static_cast<std::size_t>(found - poses.begin());
}

/// Calls f(index of the pose, reader) for each row whose stamp is that of a pose.
Status for_each_row(io::CsvReader& csv, const eval::PoseList& poses,
                    const std::function<void(std::size_t, const io::CsvReader&)>& f) {
  const Result<int> stamp = csv.require("stamp_s");
  if (!stamp) return tl::make_unexpected(stamp.error());
  while (true) {
    const Result<bool> more = csv.next();
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) return {};
    const auto t = io::parse_stamp(csv.cell(*stamp));
    if (!t) {
      return fail(ErrorCode::kInput, csv.where(),
                  io::quoted(csv.cell(*stamp)) + " is no stamp in seconds");
    }
    if (const auto i = pose_of(poses, *t)) f(*i, csv);
  }
}

double number(const io::CsvReader& csv, int column) {
  return io::parse_number(csv.cell(column)).value_or(std::numeric_limits<double>::quiet_NaN());
}

/// The inverse of geometry::covariance_fixed_axes(): (x y z, rotation about fixed axes) to
/// (rotation about body axes, position).
Mat6 as_boxplus(const Mat6& fixed, const geometry::Mat3& R_outer_body) {
  Mat6 J = Mat6::Zero();
  J.topRightCorner<3, 3>() = R_outer_body.transpose();
  J.bottomLeftCorner<3, 3>() = geometry::Mat3::Identity();
  return J * fixed * J.transpose();
}

}  // namespace

Result<std::vector<Mat6>> read_covariances(const std::string& path, const eval::PoseList& poses) {
  Result<io::CsvReader> csv = io::CsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  std::array<std::array<int, 6>, 6> columns{};
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = r; c < 6; ++c) {
      const Result<int> column = csv->require(fmt::format("c{}{}", r, c));
      if (!column) return tl::make_unexpected(column.error());
      columns[r][c] = columns[c][r] = *column;
    }
  }
  std::vector<Mat6> out(poses.size(), Mat6::Constant(std::numeric_limits<double>::quiet_NaN()));
  const Status read = for_each_row(*csv, poses, [&](std::size_t i, const io::CsvReader& row) {
    Mat6 fixed;
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) {
        fixed(r, c) =
            number(row, columns[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]);
      }
    }
    out[i] = as_boxplus(fixed, poses[i].T.R);
  });
  if (!read) return tl::make_unexpected(read.error());
  return out;
}

Result<std::vector<Vec3>> read_degenerate_directions(const std::string& path,
                                                     const eval::PoseList& poses) {
  Result<io::CsvReader> csv = io::CsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  std::array<int, 4> columns{};
  for (std::size_t i = 0; const char* name : {"degenerate", "dir_x", "dir_y", "dir_z"}) {
    const Result<int> column = csv->require(name);
    if (!column) return tl::make_unexpected(column.error());
    columns[i++] = *column;
  }
  std::vector<Vec3> out(poses.size(), Vec3::Zero());
  const Status read = for_each_row(*csv, poses, [&](std::size_t i, const io::CsvReader& row) {
    const Vec3 d(number(row, columns[1]), number(row, columns[2]), number(row, columns[3]));
    const bool usable = d.allFinite() && d.norm() > 1e-6;
    if (row.cell(columns[0]) == "1" && usable) out[i] = d.normalized();
  });
  if (!read) return tl::make_unexpected(read.error());
  return out;
}

}  // namespace rali::assess
