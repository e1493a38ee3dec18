#include "rali/drive/output/georeference.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "rali/base/counted.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"

namespace rali::drive {
namespace {

constexpr double kYawSigmaMax_rad = 3.0 * std::numbers::pi / 180.0;
constexpr std::array<const char*, 6> kColumns = {"vehicle", "stamp_s", "x_m",
                                                 "y_m",     "z_m",     "sigma_m"};

tl::unexpected<Error> bad_cell(const io::CsvReader& csv, const char* name, int column,
                               const char* wanted) {
  return fail(ErrorCode::kInput, csv.where(),
              fmt::format("{} is {}, not {}", name, io::quoted(csv.cell(column)), wanted));
}

Result<SiteMark> mark_of(const io::CsvReader& csv, const std::array<int, 6>& columns,
                         const io::RadioNames& names) {
  SiteMark mark;
  const auto vehicle = names.find(csv.cell(columns[0]));
  if (vehicle == names.end()) {
    return fail(ErrorCode::kInput, csv.where(),
                io::quoted(csv.cell(columns[0])) + " is no vehicle of the fleet",
                "Use the names under `vehicles`.");
  }
  mark.vehicle = vehicle->second.vehicle;
  const auto t = io::parse_stamp(csv.cell(columns[1]));
  if (!t) return bad_cell(csv, kColumns[1], columns[1], "a time in seconds");
  mark.t = *t;
  for (std::size_t k = 2; k < columns.size(); ++k) {
    const auto value = io::parse_number(csv.cell(columns[k]));
    if (!value || !std::isfinite(*value)) {
      return bad_cell(csv, kColumns[k], columns[k], "a number");
    }
    if (k < 5) mark.p_site_m[static_cast<Eigen::Index>(k - 2)] = *value;
    if (k == 5) mark.sigma_m = *value;
  }
  if (!(mark.sigma_m > 0.0)) return bad_cell(csv, kColumns[5], columns[5], "above 0");
  return mark;
}

/// Weighted means of both sides.
struct Centre {
  geometry::Vec3 map_m = geometry::Vec3::Zero(), site_m = geometry::Vec3::Zero();
  double weight = 0.0;
};

double weight_of(const MarkPair& mark) { return 1.0 / (mark.sigma_m * mark.sigma_m); }

Centre centre_of(std::span<const MarkPair> marks) {
  Centre centre;
  for (const MarkPair& mark : marks) {
    const double w = weight_of(mark);
    centre.weight += w;
    // Running means: sums of site coordinates of 4000 km would cost digits.
    centre.map_m += w / centre.weight * (mark.p_map_m - centre.map_m);
    centre.site_m += w / centre.weight * (mark.p_site_m - centre.site_m);
  }
  return centre;
}

}  // namespace

Result<std::vector<SiteMark>> read_marks_csv(const std::string& path, const io::RadioNames& names) {
  Result<io::CsvReader> csv = io::CsvReader::open(path);
  if (!csv) return tl::make_unexpected(csv.error());
  std::array<int, 6> columns{};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const Result<int> column = csv->require(kColumns[k]);
    if (!column) return tl::make_unexpected(column.error());
    columns[k] = *column;
  }
  std::vector<SiteMark> marks;
  for (;;) {
    const Result<bool> more = csv->next();
    if (!more) return tl::make_unexpected(more.error());
    if (!*more) break;
    const Result<SiteMark> mark = mark_of(*csv, columns, names);
    if (!mark) return tl::make_unexpected(mark.error());
    marks.push_back(*mark);
  }
  if (marks.size() < kMarksMin) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("has {}; a georeference needs {}", counted(marks.size(), "mark"), kMarksMin),
        "Stand over more marks, or leave output.georeference out.");
  }
  return marks;
}

geometry::Vec3 SiteFrame::site_of(const geometry::Vec3& p_map_m) const {
  return geometry::rotation_from_rpy(0.0, 0.0, yaw_rad) * p_map_m + p_site_map_m;
}

Result<SiteFrame> solve_site(std::span<const MarkPair> marks) {
  if (marks.size() < kMarksMin) {
    return fail(
        ErrorCode::kNoAnswer, "output.georeference",
        fmt::format("{} of the map; {} are needed", counted(marks.size(), "mark"), kMarksMin));
  }
  const Centre centre = centre_of(marks);
  double cosine = 0.0, sine = 0.0, information = 0.0;
  for (const MarkPair& mark : marks) {
    const geometry::Vec3 a = mark.p_map_m - centre.map_m, b = mark.p_site_m - centre.site_m;
    const double w = weight_of(mark);
    cosine += w * (a.x() * b.x() + a.y() * b.y());
    sine += w * (a.x() * b.y() - a.y() * b.x());
    information += w * (a.x() * a.x() + a.y() * a.y());
  }
  SiteFrame site;
  site.yaw_sigma_rad = 1.0 / std::sqrt(information);
  if (!(site.yaw_sigma_rad < kYawSigmaMax_rad)) {
    return fail(ErrorCode::kNoAnswer, "output.georeference",
                "the marks lie too close together to give a heading",
                "Stand over marks at the ends of the site.");
  }
  site.yaw_rad = std::atan2(sine, cosine);
  site.p_site_map_m =
      centre.site_m - geometry::rotation_from_rpy(0.0, 0.0, site.yaw_rad) * centre.map_m;
  double squares_m2 = 0.0;
  for (const MarkPair& mark : marks) {
    const geometry::Vec3 residual = site.site_of(mark.p_map_m) - mark.p_site_m;
    squares_m2 += residual.squaredNorm();
    site.residuals.push_back({mark.vehicle, mark.t, residual, mark.sigma_m});
  }
  site.rms_m = std::sqrt(squares_m2 / static_cast<double>(marks.size()));
  return site;
}

}  // namespace rali::drive
