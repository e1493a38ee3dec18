#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"
#include "rali/ranging/range_link.hpp"
#include "rali/ranging/range_sanity.hpp"
#include "rali/ranging/range_thinning.hpp"
#include "rali/ranging/signal_quality.hpp"

// The classes of this module on real ranges: shared/data/uwb_pairs.
namespace rali::ranging {
namespace {

using geometry::Vec3;

std::filesystem::path data_folder() {
  const char* from_user = std::getenv("RALI_DATA_DIR");
  return std::filesystem::path(from_user != nullptr ? from_user : RALI_DATA_DIR) / "uwb_pairs";
}

#define SKIP_WITHOUT_DATA()                                                   \
  do {                                                                        \
    if (!std::filesystem::exists(data_folder())) {                            \
      GTEST_SKIP() << "NO DATA, REAL RANGES NOT LOOKED AT: " << data_folder() \
                   << " not found; set RALI_DATA_DIR";                        \
    }                                                                         \
  } while (false)

/// Rows of numbers, every `step`-th; lines that do not begin with a number are passed over and
/// empty cells are NaN.
std::vector<std::vector<double>> read_rows(const std::filesystem::path& path, char sign,
                                           int step = 1) {
  std::vector<std::vector<double>> rows;
  std::ifstream file(path);
  std::string line;
  for (int n = 0; std::getline(file, line);) {
    if (line.empty() || line[0] < '0' || line[0] > '9' || n++ % step != 0) continue;
    std::vector<double> row;
    for (const char* at = line.c_str(); at != nullptr;) {
      char* end = nullptr;
      const double value = std::strtod(at, &end);
      row.push_back(end == at ? std::numeric_limits<double>::quiet_NaN() : value);
      const char* next = std::find(static_cast<const char*>(end), line.c_str() + line.size(), sign);
      at = next == line.c_str() + line.size() ? nullptr : next + 1;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

struct Recorded {
  Time t;
  double range_m, true_m;
};

using RecordedLink = std::vector<Recorded>;

constexpr int kAnchors = 8;
constexpr int kTags = 3;

/// Three tags on a trolley among eight anchors at 20 Hz: 24 links with their constant bias removed.
std::vector<RecordedLink> trolley_links() {
  const std::array<Vec3, kAnchors> anchors{
      Vec3(-3.4203, 3.0053, 1.0442),  Vec3(0.0016, 3.0110, 1.0446),  Vec3(3.6056, 2.9795, 1.0463),
      Vec3(3.6011, -0.0008, 1.0422),  Vec3(3.5674, -3.0087, 1.0443), Vec3(-0.0072, -2.9652, 1.0444),
      Vec3(-3.4673, -2.9587, 1.0445), Vec3(-3.4858, -0.0098, 1.0457)};
  const std::array<Vec3, kTags> tags{Vec3(-0.0689, -0.1423, 0.0011), Vec3(-0.0750, 0.1402, 0.0016),
                                     Vec3(0.2034, 0.1451, -0.0008)};
  const auto folder = data_folder() / "three_tags";
  const auto truth = read_rows(folder / "dynamic_mid_truth.tum", ' ');
  std::vector<RecordedLink> links(kAnchors * kTags);
  for (const auto& row : read_rows(folder / "dynamic_mid_ranges.csv", ',', 5)) {
    // Poses come at 125 Hz and the trolley is slow: the next one is within millimetres.
    const auto pose = std::lower_bound(truth.begin(), truth.end() - 1, row[0],
                                       [](const auto& p, double t) { return p[0] < t; });
    const double yaw = 2.0 * std::atan2((*pose)[6], (*pose)[7]);
    const auto R = geometry::rotation_from_rpy(0.0, 0.0, yaw);
    const Vec3 p((*pose)[1], (*pose)[2], (*pose)[3]);
    for (std::size_t i = 0; i < links.size(); ++i) {
      const double true_m = (p + R * tags[i % kTags] - anchors[i / kTags]).norm();
      if (std::isfinite(row[1 + i])) links[i].push_back({Time::from_s(row[0]), row[1 + i], true_m});
    }
  }
  for (RecordedLink& link : links) {
    std::vector<double> errors;
    for (const Recorded& r : link) errors.push_back(r.range_m - r.true_m);
    std::nth_element(errors.begin(), errors.begin() + static_cast<long>(errors.size() / 2),
                     errors.end());
    const double bias = errors[errors.size() / 2];
    for (Recorded& r : link) r.range_m -= bias;
  }
  return links;
}

/// Outcome of the ranges of one link, used to track its distance with odometry that drifts.
struct Tracked {
  int ranges = 0, insane = 0, rejected = 0, used = 0;
  double nees_sum = 0.0;

  void add(const Tracked& o) {
    ranges += o.ranges;
    insane += o.insane;
    rejected += o.rejected;
    used += o.used;
    nees_sum += o.nees_sum;
  }
};

Tracked track(const RecordedLink& link, std::uint64_t seed, bool thinned) {
  constexpr double kDriftPerRoot = 0.03;  // m / sqrt(s)
  const RangingSettings s;
  RangeSanity sanity(s.limits, s.sanity);
  RangeLink gate(s.gate, s.link);
  RangeThinning thinning(s.slow);
  Rng rng(seed, "recorded");
  Tracked out;
  double error_m = rng.normal();  // of the tracked distance
  double P = 1.0;
  for (std::size_t i = 1; i < link.size(); ++i) {
    const Recorded& r = link[i];
    const double dt_s = seconds_between(link[i - 1].t, r.t);
    error_m += kDriftPerRoot * std::sqrt(dt_s) * rng.normal();
    P += kDriftPerRoot * kDriftPerRoot * dt_s;
    ++out.ranges;
    const double sigma_m = s.limits.sigma_m;
    const double rate_mps = (r.true_m - link[i - 1].true_m) / dt_s;
    if (sanity.check(r.t, r.range_m, sigma_m, rate_mps)) {
      ++out.insane;
      continue;
    }
    const double nu_m = r.range_m - (r.true_m + error_m);
    const LinkDecision d = gate.decide({r.t, nu_m, P + sigma_m * sigma_m, sigma_m, true});
    if (!d.use) {
      ++out.rejected;
      continue;
    }
    const double f = thinned ? thinning.inflation(r.t, sigma_m, false) : 1.0;
    const double gain = P / (P + f * d.gate.R_m2);
    error_m += gain * nu_m;
    P *= 1.0 - gain;
    ++out.used;
    out.nees_sum += error_m * error_m / P;
  }
  return out;
}

Tracked track_all(bool thinned) {
  Tracked all;
  std::uint64_t seed = 0;
  for (const RecordedLink& link : trolley_links()) all.add(track(link, seed++, thinned));
  return all;
}

TEST(RecordedRanges, of_good_links_are_accepted_with_a_consistent_nees) {
  SKIP_WITHOUT_DATA();
  const Tracked t = track_all(true);
  const double nees = t.nees_sum / t.used;
  std::printf("24 links, %d ranges: %.2f %% insane, %.2f %% rejected, mean NEES %.2f\n", t.ranges,
              100.0 * t.insane / t.ranges, 100.0 * t.rejected / t.ranges, nees);
  ASSERT_GT(t.ranges, 50000);
  EXPECT_LT(t.insane, 0.01 * t.ranges);
  EXPECT_LT(t.rejected, 0.02 * t.ranges);
  EXPECT_GT(nees, 0.5);
  EXPECT_LT(nees, 1.5);
}

TEST(RecordedRanges, without_thinning_give_an_overconfident_tracker) {
  SKIP_WITHOUT_DATA();
  const Tracked t = track_all(false);
  std::printf("without thinning: mean NEES %.2f\n", t.nees_sum / t.used);
  EXPECT_GT(t.nees_sum / t.used, 2.0);
}

// The gap between the powers is the same with and without an obstacle in these recordings: it must
// raise the sigma of almost none of either, or good ranges would be lost for nothing.
TEST(RecordedRanges, signal_strength_raises_sigma_for_under_2_percent_of_los_ranges) {
  SKIP_WITHOUT_DATA();
  int count[2] = {0, 0};
  int raised[2] = {0, 0};
  for (const auto& row : read_rows(data_folder() / "outdoor_static.csv", ',', 10)) {
    sensor::RangeSample sample;
    sample.rssi_dbm = row[5];
    sample.first_path_dbm = row[6];
    const int los = row[0] > 0.5 ? 1 : 0;
    ++count[los];
    raised[los] += signal_quality(sample, {}).clear() ? 0 : 1;
  }
  std::printf("sigma raised: %.2f %% with line of sight, %.2f %% without\n",
              100.0 * raised[1] / count[1], 100.0 * raised[0] / count[0]);
  ASSERT_GT(count[1], 1000);
  EXPECT_LT(raised[1], 0.02 * count[1]);
}

}  // namespace
}  // namespace rali::ranging
