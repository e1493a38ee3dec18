#include "pair_data.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "number_rows.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::ranges_bench {

using geometry::Vec3;

namespace {

using Row = std::vector<double>;

double cell(const Row& row, int column) { return row[static_cast<std::size_t>(column)]; }

void append(PairRecord& pair, const PairRange& range) {
  if (!std::isfinite(range.range_m) || !std::isfinite(range.true_m)) return;
  pair.ranges.push_back(range);
}

/// Position at time t, linear between the rows before and after; empty outside of them.
std::optional<Vec3> position_at(const std::vector<Row>& track, double t_s) {
  const auto after = std::lower_bound(track.begin(), track.end(), t_s,
                                      [](const Row& row, double t) { return row[0] < t; });
  if (after == track.begin() || after == track.end()) return std::nullopt;
  const Row& a = *(after - 1);
  const Row& b = *after;
  const double s = b[0] > a[0] ? (t_s - a[0]) / (b[0] - a[0]) : 0.0;
  return Vec3((1.0 - s) * a[1] + s * b[1], (1.0 - s) * a[2] + s * b[2],
              (1.0 - s) * a[3] + s * b[3]);
}

Error without_columns(const std::filesystem::path& path) {
  return {ErrorCode::kInput, "columns that are needed are not in it", path.string(), {}};
}

Result<std::vector<PairSet>> outdoor_static(const std::filesystem::path& folder) {
  const auto path = folder / "outdoor_static.csv";
  const auto table = read_number_rows(path, ',');
  if (!table) return tl::make_unexpected(table.error());
  if (table->rows.front().size() < 7) return tl::make_unexpected(without_columns(path));
  std::map<std::tuple<bool, double, double>, PairRecord> places;
  for (const Row& row : table->rows) {
    PairRecord& pair = places[{row[0] > 0.5, row[1], row[2]}];
    pair.at_rest = true;
    PairRange range;
    range.t = Time::from_s(row[3]);
    range.range_m = row[4];
    range.true_m = row[2];
    range.rssi_dbm = row[5];
    range.first_path_dbm = row[6];
    append(pair, range);
  }
  std::vector<PairSet> out{{"outdoor_static, free", {}}, {"outdoor_static, obstacle", {}}};
  for (auto& [place, pair] : places) {
    out[std::get<0>(place) ? 0 : 1].pairs.push_back(std::move(pair));
  }
  return out;
}

Result<PairSet> outdoor_dynamic(const std::filesystem::path& folder, const std::string& name) {
  const auto ranges_path = folder / "outdoor_dynamic" / (name + "_ranges.csv");
  const auto ranges = read_number_rows(ranges_path, ',');
  if (!ranges) return tl::make_unexpected(ranges.error());
  const auto track = read_number_rows(folder / "outdoor_dynamic" / (name + "_gnss.csv"), ',');
  if (!track) return tl::make_unexpected(track.error());
  if (ranges->rows.front().size() < 8 || track->rows.front().size() < 4) {
    return tl::make_unexpected(without_columns(ranges_path));
  }
  std::map<double, PairRecord> anchors;
  for (const Row& row : ranges->rows) {
    const auto p = position_at(track->rows, row[0]);
    if (!p) continue;
    const Vec3 between = *p - Vec3(row[2], row[3], row[4]);
    PairRange range;
    range.t = Time::from_s(row[0]);
    range.range_m = row[5];
    range.true_m = between.norm();
    range.sight = between.normalized();
    range.rssi_dbm = row[6];
    range.first_path_dbm = row[7];
    append(anchors[row[1]], range);
  }
  PairSet out{name, {}};
  for (auto& [id, pair] : anchors) out.pairs.push_back(std::move(pair));
  return out;
}

/// The 36 pairs of antennas of two robots.
Status append_robots(const std::filesystem::path& path, PairSet& out) {
  const auto table = read_number_rows(path, ',');
  if (!table) return tl::make_unexpected(table.error());
  const int a = table->column("A_x");
  const int b = table->column("B_x");
  if (a < 0 || b < 0) return tl::make_unexpected(without_columns(path));
  for (int own = 1; own <= 6; ++own) {
    for (int other = 1; other <= 6; ++other) {
      const int measured = table->column(fmt::format("{}_{}", own, other));
      const int truth = table->column(fmt::format("{}_{}_t", own, other));
      if (measured < 0 || truth < 0) return tl::make_unexpected(without_columns(path));
      PairRecord pair;
      for (const Row& row : table->rows) {
        const Vec3 between(cell(row, a) - cell(row, b), cell(row, a + 1) - cell(row, b + 1),
                           cell(row, a + 2) - cell(row, b + 2));
        PairRange range;
        range.t = Time::from_s(row[0]);
        range.range_m = cell(row, measured);
        range.true_m = cell(row, truth);
        range.sight = between.normalized();
        append(pair, range);
      }
      out.pairs.push_back(std::move(pair));
    }
  }
  return {};
}

Result<PairSet> moving_robots(const std::filesystem::path& folder) {
  PairSet out{"moving_robots", {}};
  for (const char* trial : {"09", "11", "13", "16", "21"}) {
    for (const char* pair : {"1to2", "1to3", "2to3"}) {
      const auto name = fmt::format("trial{}_{}.csv", trial, pair);
      if (auto ok = append_robots(folder / "moving_robots" / name, out); !ok) {
        return tl::make_unexpected(ok.error());
      }
    }
  }
  return out;
}

constexpr std::size_t kTags = 3;

const std::array<Vec3, 8>& anchors_m() {
  static const std::array<Vec3, 8> kAnchors{
      Vec3(-3.4203, 3.0053, 1.0442),  Vec3(0.0016, 3.0110, 1.0446),  Vec3(3.6056, 2.9795, 1.0463),
      Vec3(3.6011, -0.0008, 1.0422),  Vec3(3.5674, -3.0087, 1.0443), Vec3(-0.0072, -2.9652, 1.0444),
      Vec3(-3.4673, -2.9587, 1.0445), Vec3(-3.4858, -0.0098, 1.0457)};
  return kAnchors;
}

Result<PairSet> three_tags(const std::filesystem::path& folder) {
  const std::array<Vec3, kTags> tags{Vec3(-0.0689, -0.1423, 0.0011), Vec3(-0.0750, 0.1402, 0.0016),
                                     Vec3(0.2034, 0.1451, -0.0008)};
  const auto path = folder / "three_tags" / "dynamic_mid_ranges.csv";
  const auto ranges = read_number_rows(path, ',');
  if (!ranges) return tl::make_unexpected(ranges.error());
  const auto truth = read_number_rows(folder / "three_tags" / "dynamic_mid_truth.tum", ' ');
  if (!truth) return tl::make_unexpected(truth.error());
  const std::size_t pairs = anchors_m().size() * kTags;
  if (ranges->rows.front().size() < pairs + 1 || truth->rows.front().size() < 8) {
    return tl::make_unexpected(without_columns(path));
  }
  PairSet out{"three_tags", std::vector<PairRecord>(pairs)};
  for (const Row& row : ranges->rows) {
    // The trolley is slow and its poses come at 125 Hz: the next pose's heading is accurate enough.
    const auto p = position_at(truth->rows, row[0]);
    const auto next = std::lower_bound(truth->rows.begin(), truth->rows.end(), row[0],
                                       [](const Row& r, double t) { return r[0] < t; });
    if (!p) continue;
    const auto R = geometry::rotation_from_rpy(0.0, 0.0, 2.0 * std::atan2((*next)[6], (*next)[7]));
    for (std::size_t i = 0; i < pairs; ++i) {
      const Vec3 between = *p + R * tags[i % kTags] - anchors_m()[i / kTags];
      PairRange range;
      range.t = Time::from_s(row[0]);
      range.range_m = row[1 + i];
      range.true_m = between.norm();
      range.sight = between.normalized();
      append(out.pairs[i], range);
    }
  }
  return out;
}

}  // namespace

Result<std::vector<PairSet>> read_pair_sets(const std::filesystem::path& folder) {
  auto out = outdoor_static(folder);
  if (!out) return out;
  for (const char* name : {"outdoor_los_A_case1", "outdoor_nlos_A_case1", "outdoor_nlos_B_case3"}) {
    auto set = outdoor_dynamic(folder, name);
    if (!set) return tl::make_unexpected(set.error());
    out->push_back(std::move(*set));
  }
  for (const auto read : {moving_robots, three_tags}) {
    auto set = read(folder);
    if (!set) return tl::make_unexpected(set.error());
    out->push_back(std::move(*set));
  }
  return out;
}

}  // namespace rali::ranges_bench
