#include "rali/cli/view/point_times.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

#include <Eigen/Geometry>

#include "rali/geometry/se3.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/text.hpp"

namespace rali::cli {
namespace {

constexpr double kCell_m = 0.3;
constexpr std::size_t kCellsMax = 8'000'000;  ///< 0.5 GB

struct Keyframe {
  double t_s = 0.0;
  geometry::SE3 T_map_body;
  std::string file;
};

/// 21 bits per axis: 600 km to each side.
std::uint64_t cell_of(double x_m, double y_m, double z_m) {
  const auto part = [](double value_m) {
    const double cell = std::clamp(std::floor(value_m / kCell_m), -1e6, 1e6);
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(cell) + (1 << 20));
  };
  return part(x_m) << 42U | part(y_m) << 21U | part(z_m);
}

/// The row's keyframe; nothing if a cell is not numeric or the file is outside the folder.
std::optional<Keyframe> keyframe_of(const io::CsvReader& csv, Time begin) {
  const std::optional<Time> stamp = io::parse_stamp(csv.cell(csv.column("stamp_s")));
  std::array<double, 7> v{};
  constexpr std::array<const char*, 7> kNames = {"x", "y", "z", "qx", "qy", "qz", "qw"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto value = io::parse_number(csv.cell(csv.column(kNames[i])));
    if (!value || !std::isfinite(*value)) return std::nullopt;
    v[i] = *value;
  }
  Keyframe out;
  out.file = csv.cell(csv.column("file"));
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!stamp || q.norm() < 0.5 || out.file.find("..") != std::string::npos ||
      out.file.substr(0, 10) != "keyframes/") {
    return std::nullopt;
  }
  out.t_s = (*stamp - begin).s();
  out.T_map_body = {q.normalized().toRotationMatrix(), {v[0], v[1], v[2]}};
  return out;
}

std::vector<Keyframe> read_keyframes(const std::string& out_dir, Time begin) {
  std::vector<Keyframe> out;
  auto csv = io::CsvReader::open(out_dir + "/keyframes.csv");
  if (!csv) return out;
  while (true) {
    const Result<bool> more = csv->next();
    if (!more || !*more) break;
    if (std::optional<Keyframe> keyframe = keyframe_of(*csv, begin)) out.push_back(*keyframe);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Keyframe& a, const Keyframe& b) { return a.t_s < b.t_s; });
  return out;
}

using Times = std::unordered_map<std::uint64_t, float>;

/// Cells without an earlier keyframe get the time of this one.
void add_cloud(const std::string& out_dir, const Keyframe& keyframe, Times& times) {
  const auto cloud = io::read_cloud_file(out_dir + '/' + keyframe.file);
  if (!cloud) return;
  std::array<std::vector<double>, 3> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const int field = cloud->field(std::string(1, "xyz"[i]));
    if (field < 0) return;
    axes[i] = cloud->column(field);
  }
  for (std::size_t i = 0; i < axes[0].size() && times.size() < kCellsMax; ++i) {
    const geometry::Vec3 p =
        keyframe.T_map_body * geometry::Vec3(axes[0][i], axes[1][i], axes[2][i]);
    if (p.allFinite()) {
      times.try_emplace(cell_of(p.x(), p.y(), p.z()), static_cast<float>(keyframe.t_s));
    }
  }
}

/// Earliest time of the cell and its neighbours.
float time_near(const Times& times, double x_m, double y_m, double z_m) {
  float best = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 27; ++i) {
    const auto found = times.find(cell_of(
        x_m + kCell_m * (i % 3 - 1), y_m + kCell_m * (i / 3 % 3 - 1), z_m + kCell_m * (i / 9 - 1)));
    if (found != times.end()) best = std::min(best, found->second);
  }
  return std::isinf(best) ? std::numeric_limits<float>::quiet_NaN() : best;
}

}  // namespace

std::vector<float> first_seen_s(const std::string& out_dir, const report::RunData& run) {
  Times times;
  for (const Keyframe& keyframe : read_keyframes(out_dir, run.begin)) {
    const bool joined = std::any_of(run.vehicles.begin(), run.vehicles.end(), [&](const auto& v) {
      return v.in_map && keyframe.file.substr(10, v.name.size() + 1) == v.name + '/';
    });
    if (joined) add_cloud(out_dir, keyframe, times);
  }
  if (times.empty()) return {};
  std::vector<float> out(run.map.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double x = run.map.x_m[i], y = run.map.y_m[i], z = run.map.z_m[i];
    const auto own = times.find(cell_of(x, y, z));
    out[i] = own != times.end() ? own->second : time_near(times, x, y, z);
  }
  return out;
}

}  // namespace rali::cli
