#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/geometry/so3.hpp"
#include "rali/sim/radio/recorded_ranges_for_test.hpp"
#include "rali/sim/radio/uwb_model.hpp"

// The model against real ranges (data pack, folder uwb_pairs). Each test runs the model on the
// distances and directions of the recording. It prints both side by side as rows of the table in
// docs/reference/simulator.md and checks the stated tolerances.
namespace rali::sim {
namespace {

using geometry::SE3;
using geometry::Vec3;

std::filesystem::path data_folder() {
  const char* from_user = std::getenv("RALI_DATA_DIR");
  return std::filesystem::path(from_user != nullptr ? from_user : RALI_DATA_DIR) / "uwb_pairs";
}

#define SKIP_WITHOUT_DATA()                                                     \
  do {                                                                          \
    if (!std::filesystem::exists(data_folder())) {                              \
      GTEST_SKIP() << "NO DATA, MODEL NOT COMPARED: " << data_folder().string() \
                   << " not found; set RALI_DATA_DIR";                          \
    }                                                                           \
  } while (false)

void print_row(const char* what, const Figures& real, const Figures& model) {
  fmt::print(
      "| {} | {} | {:+.3f} / {:+.3f} | {:.3f} / {:.3f} | {:+.2f} / {:+.2f} | {:+.2f} / "
      "{:+.2f} |\n",
      what, real.count, real.mean, model.mean, real.sd, model.sd, real.p1, model.p1, real.p99,
      model.p99);
  std::fflush(stdout);
}

struct Tolerance {
  double mean_m, sd_fraction, p1_m, p99_m;
};

void expect_alike(const Figures& real, const Figures& model, const Tolerance& t) {
  EXPECT_NEAR(model.mean, real.mean, t.mean_m);
  EXPECT_NEAR(model.sd / real.sd, 1.0, t.sd_fraction);
  EXPECT_NEAR(model.p1, real.p1, t.p1_m);
  EXPECT_NEAR(model.p99, real.p99, t.p99_m);
}

Time time_of(double t_s) {
  return Time::from_ns(1'700'000'000'000'000'000) + Duration::from_s(t_s);
}

/// Level ground, and for NLOS a panel of 4 cm across the x axis at x = 1.5 m.
RayCaster field(bool panel) {
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, -1.0}, {400.0, 400.0, 1.0}, 0.0, 0.5);
  if (panel) mesh.add_box({1.5, 0.0, 0.0}, {0.04, 3.0, 3.0}, 0.0, 0.5);
  return RayCaster(mesh);
}

/// The orientations of the units are unknown: each pair of devices gets its own direction.
RadioEnd end_at(int vehicle, const Vec3& p, double yaw_rad) {
  RadioEnd end;
  end.vehicle = vehicle;
  end.T_world_body = {geometry::rotation_from_rpy(0.0, 0.0, yaw_rad), p};
  return end;
}

/// UWB-dataset, outdoors, both ends stationary: 30 distances, 7 heights. The model has 40 pairs of
/// devices, because the bias of the one real pair is a sample of one.
struct StaticField {
  std::vector<double> real, model;
};

StaticField compare_field(bool line_of_sight) {
  const Table table = read_table(data_folder() / "outdoor_static.csv");
  const RayCaster world = field(!line_of_sight);
  StaticField found;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if ((table.at(i, "los") > 0.5) != line_of_sight) continue;
    const double distance = table.at(i, "nominal_m");
    found.real.push_back(table.at(i, "range_m") - distance);
    if (i % 40 != 0) continue;
    const double height = 0.01 * table.at(i, "height_cm");
    for (std::uint64_t pair = 0; pair < 40; ++pair) {
      UwbModel model(UwbOptions::dw1000(), 2, 1000 * i + pair);
      const auto s = model.measure(time_of(0.0), end_at(0, {0, 0, height}, 0.3),
                                   end_at(1, {distance, 0, height}, 1.0), world);
      if (s) found.model.push_back(s->range_m - distance);
    }
  }
  return found;
}

TEST(UwbData, outdoor_line_of_sight_errors_of_the_model_match_the_dw1000) {
  SKIP_WITHOUT_DATA();
  const StaticField f = compare_field(true);
  ASSERT_EQ(f.real.size(), 18627U);
  const Figures real = figures_of(within(f.real, 1.0));
  const Figures model = figures_of(within(f.model, 1.0));
  print_row("outdoor_static, in sight", real, model);
  expect_alike(real, model, {0.05, 0.35, 0.10, 0.10});
}

TEST(UwbData, outdoor_nlos_errors_of_the_model_match_the_dw1000) {
  SKIP_WITHOUT_DATA();
  const StaticField f = compare_field(false);
  ASSERT_EQ(f.real.size(), 17620U);
  const Figures real = figures_of(within(f.real, 1.0));
  const Figures model = figures_of(within(f.model, 1.0));
  print_row("outdoor_static, obstacle", real, model);
  expect_alike(real, model, {0.05, 0.45, 0.10, 0.10});
}

TEST(UwbData, reported_power_over_distance_matches_the_dw1000) {
  SKIP_WITHOUT_DATA();
  const Table table = read_table(data_folder() / "outdoor_static.csv");
  const RayCaster world = field(false);
  for (const double distance : {2.0, 10.0, 20.0, 40.0, 60.0}) {
    std::vector<double> real, model;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (table.at(i, "los") < 0.5 || table.at(i, "nominal_m") != distance) continue;
      if (std::isfinite(table.at(i, "rssi_dbm"))) real.push_back(table.at(i, "rssi_dbm"));
      const double height = 0.01 * table.at(i, "height_cm");
      UwbModel one(UwbOptions::dw1000(), 2, i);
      const auto s = one.measure(time_of(0.0), end_at(0, {0, 0, height}, 0.3),
                                 end_at(1, {distance, 0, height}, 1.0), world);
      if (s) model.push_back(s->rssi_dbm);
    }
    fmt::print("RSSI at {:.0f} m [dBm], real / model: {:.1f} / {:.1f}, sd {:.1f} / {:.1f}\n",
               distance, figures_of(real).mean, figures_of(model).mean, figures_of(real).sd,
               figures_of(model).sd);
    EXPECT_NEAR(figures_of(model).mean, figures_of(real).mean, 2.0) << distance;
  }
}

/// One tag driving among four anchors; ground truth by GNSS at 8 Hz. Held out: no default comes
/// from it. The lever arm between tag and GNSS antenna is unknown. It dominates the error near the
/// anchors, so only ranges above 10 m count. Its remainder and GNSS errors widen the real spread to
/// the left. Four anchors are only four samples of the pair bias. Hence the wide tolerances.
StaticField compare_drive(const std::string& name) {
  const Table gnss = read_table(data_folder() / "outdoor_dynamic" / (name + "_gnss.csv"));
  const Table ranges = read_table(data_folder() / "outdoor_dynamic" / (name + "_ranges.csv"));
  const RayCaster world = field(false);
  StaticField found;
  std::size_t k = 1;
  std::vector<UwbModel> models;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    models.emplace_back(UwbOptions::dw1000(), 2, seed, time_of(0.0));
  }
  for (std::size_t i = 0; i < ranges.rows.size(); ++i) {
    const double t = ranges.at(i, "t_s");
    while (k + 1 < gnss.rows.size() && gnss.at(k, "t_s") < t) ++k;
    const double t0 = gnss.at(k - 1, "t_s");
    const double t1 = gnss.at(k, "t_s");
    if (t < t0 || t > t1) continue;
    const auto place = [&](std::size_t row) {
      return Vec3(gnss.at(row, "x_m"), gnss.at(row, "y_m"), gnss.at(row, "z_m"));
    };
    const double u = (t - t0) / (t1 - t0);
    const Vec3 tag = (1.0 - u) * place(k - 1) + u * place(k);
    const Vec3 anchor(ranges.at(i, "ax_m"), ranges.at(i, "ay_m"), ranges.at(i, "az_m"));
    const double distance = (tag - anchor).norm();
    if (distance < 10.0) continue;
    found.real.push_back(ranges.at(i, "range_m") - distance);
    if (i % 10 != 0) continue;
    RadioEnd base = end_at(0, anchor, 0.0);
    base.antenna = static_cast<int>(ranges.at(i, "anchor_id"));
    for (UwbModel& model : models) {
      const auto s = model.measure(time_of(t), base, end_at(1, tag + Vec3(0, 0, 1), 0.0), world);
      if (s) found.model.push_back(s->range_m - model.last_truth().distance_m);
    }
  }
  return found;
}

TEST(UwbData, model_errors_match_outdoor_drives_not_used_for_its_defaults) {
  SKIP_WITHOUT_DATA();
  for (const char* name : {"outdoor_los_A_case1", "outdoor_nlos_A_case1"}) {
    const StaticField f = compare_drive(name);
    ASSERT_GT(f.real.size(), 3000U);
    const Figures real = figures_of(within(f.real, 1.0));
    const Figures model = figures_of(within(f.model, 1.0));
    print_row(name, real, model);
    expect_alike(real, model, {0.18, 0.50, 0.40, 0.15});
    const auto gross = [](const std::vector<double>& v) {
      return 1.0 - static_cast<double>(within(v, 1.0).size()) / static_cast<double>(v.size());
    };
    fmt::print("errors beyond 1 m: {:.4f} / {:.4f}\n", gross(f.real), gross(f.model));
    EXPECT_LT(gross(f.model), 0.02);
  }
}

/// murp: three robots with six antennas each in a motion capture room, means over 1 s of 25 Hz.
/// `every`: the model simulates one of this many rows.
StaticField compare_robots(const std::string& trial, std::size_t every) {
  UwbOptions o;
  o.pair_bias_m = 0.0;
  o.clear_burst_fraction = 0.12;  // six antennas around the robot's own structure
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, 0.0}, {14.0, 12.0, 5.0}, 0.0, 0.5);  // room, seen from inside
  const RayCaster room(mesh);
  UwbModel model(o, 4, 7, time_of(0.0));
  StaticField found;
  for (const char* pair : {"1to2", "1to3", "2to3"}) {
    const Table table =
        read_table(data_folder() / "moving_robots" / ("trial" + trial + "_" + pair + ".csv"));
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      const auto pose = [&](const std::string& who, int number) {
        return end_at(number, {table.at(i, who + "_x"), table.at(i, who + "_y"), 0.5},
                      table.at(i, who + "_yaw") * M_PI / 180.0);
      };
      RadioEnd a = pose("A", pair[0] - '0');
      RadioEnd b = pose("B", pair[3] - '0');
      for (int k = 0; k < 36; ++k) {
        const std::string name = fmt::format("{}_{}", k / 6 + 1, k % 6 + 1);
        const double error = table.at(i, name) - table.at(i, name + "_t");
        if (!std::isfinite(error)) continue;
        found.real.push_back(error);
        if (i % every != 0) continue;
        a.antenna = k / 6;
        b.antenna = k % 6;
        double sum = 0.0;
        int count = 0;
        for (int n = 0; n < 25; ++n) {
          const auto s = model.measure(time_of(table.at(i, "t") + 0.04 * n), a, b, room);
          if (!s) continue;
          sum += s->range_m - model.last_truth().distance_m;
          ++count;
        }
        if (count > 0) found.model.push_back(sum / count);
      }
    }
  }
  return found;
}

TEST(UwbData, model_errors_match_those_of_moving_robots_within_2_m) {
  SKIP_WITHOUT_DATA();
  for (const char* trial : {"09", "16", "21"}) {
    const StaticField f = compare_robots(trial, 40);
    ASSERT_GT(f.real.size(), 15000U);
    const Figures real = figures_of(within(f.real, 2.0));
    const Figures model = figures_of(within(f.model, 2.0));
    print_row(fmt::format("moving_robots, trial {}", trial).c_str(), real, model);
    expect_alike(real, model, {0.06, 0.40, 0.12, 0.30});
  }
}

/// LIAS: three tags on a trolley, eight anchors, motion capture.
struct Trolley {
  Table ranges;
  std::vector<std::vector<double>> truth;  ///< rows of the TUM file
};

Trolley read_trolley() {
  Trolley trolley;
  trolley.ranges = read_table(data_folder() / "three_tags" / "dynamic_mid_ranges.csv");
  std::ifstream file(data_folder() / "three_tags" / "dynamic_mid_truth.tum");
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<double> row;
    for (const std::string& cell : split(line, ' ')) {
      row.push_back(std::strtod(cell.c_str(), nullptr));
    }
    trolley.truth.push_back(std::move(row));
  }
  return trolley;
}

/// Range errors between anchor `a` and tag `g`, every fifth exchange.
StaticField compare_link(const Trolley& trolley, std::size_t a, std::size_t g, UwbModel& model,
                         const RayCaster& room) {
  static const std::vector<Vec3> anchors{{-3.4203, 3.0053, 1.0442},  {0.0016, 3.0110, 1.0446},
                                         {3.6056, 2.9795, 1.0463},   {3.6011, -0.0008, 1.0422},
                                         {3.5674, -3.0087, 1.0443},  {-0.0072, -2.9652, 1.0444},
                                         {-3.4673, -2.9587, 1.0445}, {-3.4858, -0.0098, 1.0457}};
  static const std::vector<Vec3> tags{
      {-0.0689, -0.1423, 0.0011}, {-0.0750, 0.1402, 0.0016}, {0.2034, 0.1451, -0.0008}};
  StaticField found;
  std::size_t k = 0;
  for (std::size_t i = 0; i < trolley.ranges.rows.size(); i += 5) {
    const double t = trolley.ranges.at(i, "t_s");
    while (k + 1 < trolley.truth.size() && trolley.truth[k][0] < t) ++k;
    const std::vector<double>& w = trolley.truth[k];
    RadioEnd base = end_at(0, anchors[a], 0.0);
    base.antenna = static_cast<int>(a);
    RadioEnd tag = end_at(1, {w[1], w[2], w[3]}, 2.0 * std::atan2(w[6], w[7]));
    tag.antenna = static_cast<int>(g);
    tag.p_body_antenna = tags[g];
    const double distance = (tag.position() - base.position()).norm();
    const double error = trolley.ranges.at(i, fmt::format("a{}_t{}", a, g)) - distance;
    if (std::isfinite(error)) found.real.push_back(error);
    const auto s = model.measure(time_of(t), base, tag, room);
    if (s) found.model.push_back(s->range_m - distance);
  }
  return found;
}

/// Held out except for the antenna patterns; the constant bias of each link is removed on both
/// sides and compared separately.
TEST(UwbData, model_errors_match_those_of_tags_on_a_trolley) {
  SKIP_WITHOUT_DATA();
  const Trolley trolley = read_trolley();
  ASSERT_GT(trolley.truth.size(), 1000U);
  UwbOptions o;
  o.pair_bias_m = 0.17;
  o.clear_burst_fraction = 0.0;  // nothing obstructs the tags
  TriangleMesh mesh;
  mesh.add_box({0.0, 0.0, 0.0}, {9.0, 8.0, 4.0}, 0.0, 0.5);
  const RayCaster room(mesh);
  UwbModel model(o, 2, 3, time_of(0.0));
  StaticField rest, bias;
  for (std::size_t link = 0; link < 24; ++link) {
    const StaticField f = compare_link(trolley, link / 3, link % 3, model, room);
    append(rest.real, less_median(f.real));
    append(rest.model, less_median(f.model));
    bias.real.push_back(figures_of(f.real).p50);
    bias.model.push_back(figures_of(f.model).p50);
  }
  const Figures real = figures_of(within(rest.real, 1.0));
  const Figures simulated = figures_of(within(rest.model, 1.0));
  print_row("three_tags, less each link's median", real, simulated);
  expect_alike(real, simulated, {0.02, 0.35, 0.08, 0.08});
  print_row("three_tags, medians of 24 links", figures_of(bias.real), figures_of(bias.model));
  EXPECT_NEAR(figures_of(bias.model).mean, figures_of(bias.real).mean, 0.05);
  EXPECT_NEAR(figures_of(bias.model).sd, figures_of(bias.real).sd, 0.05);
}

}  // namespace
}  // namespace rali::sim
