#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/io/files/cloud_writers.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::report {

/// Content of a synthetic run of `rali map`.
struct TestRun {
  std::vector<std::string> vehicles = {"v1"};
  int poses = 200;  ///< 10 per second
  std::size_t points = 20'000;
  bool fleet = false;  ///< ranges, rounds, loops
  bool truth = false;
  bool old_degeneracy = false;  ///< without the columns that were added later
  std::string status = "complete";
  std::string warning;
};

inline std::vector<std::string> test_names(std::size_t n) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= n; ++i) names.push_back(fmt::format("v{}", i));
  return names;
}

/// Quotes text for JSON, enough for the names of the tests.
inline std::string json_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

class TestRunWriter {
 public:
  TestRunWriter(const io::TestFolder& folder, const TestRun& run) : folder_(folder), run_(run) {}

  void write() const {
    for (const char* name : {"trajectory", "odometry", "degeneracy", "errors"}) {
      std::filesystem::create_directories(folder_.path(name));
    }
    for (std::size_t v = 0; v < run_.vehicles.size(); ++v) write_vehicle(v);
    write_map();
    folder_.write("metrics.json", metrics());
    folder_.write("status.json", fmt::format(R"({{"schema":1,"rali":"0.1.0","status":"{}",)"
                                             R"("files":{{}}}})",
                                             run_.status));
    folder_.write("timing.json", R"({"total_s":7.5,"data_s":20.0,"speed":2.67,"memory_max_mb":104,)"
                                 R"("stages_s":{"open":0.1,"odometry v1":4.1,"map":3.3}})");
    folder_.write("settings.yaml",
                  "schema: 1   # fleet.yaml:1\nvehicles:\n  v1:\n    recording: v1.bag   # "
                  "fleet.yaml:3\n    start_s: 0   # default\n    lidar:\n      model: rs16   # "
                  "found: the recording\n");
    if (run_.fleet) write_fleet();
    if (run_.truth) folder_.write("evaluation.json", evaluation());
  }

 private:
  static constexpr double kStart_s = 1700000000.0;

  /// Vehicles drive side by side along a corridor with a bend.
  static void place(std::size_t v, int i, double& x, double& y, double& z) {
    const double s = 0.12 * i;
    x = s < 14.0 ? s : 14.0;
    y = (s < 14.0 ? 0.3 * std::sin(s) : s - 14.0) - 1.2 * static_cast<double>(v);
    z = 0.02 * std::sin(0.7 * s);
  }

  static bool degenerate(std::size_t v, int i) { return v % 2 == 1 && i >= 80 && i < 130; }

  void write_vehicle(std::size_t v) const {
    const std::string& name = run_.vehicles[v];
    if (name.find('/') != std::string::npos) return;
    std::string tum = "# T_map_body\n", cov = "stamp_s,c00,c01,c02,c11,c12,c22\n";
    std::string degeneracy =
        "stamp_s,degenerate,degree,dir_x,dir_y,dir_z,sigma_degenerate_m,correction_m,range_from";
    degeneracy += run_.old_degeneracy ? "\n" : ",axis,category,sigma_m,constrained_by\n";
    std::string errors = "stamp_s,ape_m,rot_deg,ex,ey,ez,along_degenerate_m,nees\n";
    for (int i = 0; i < run_.poses; ++i) {
      double x = 0.0, y = 0.0, z = 0.0;
      place(v, i, x, y, z);
      const double t_s = kStart_s + 0.1 * i, var = 1e-4 + 2e-5 * i;
      tum += fmt::format("{:.9f} {:.6f} {:.6f} {:.6f} 0 0 0 1\n", t_s, x, y, z);
      cov += fmt::format("{:.9f},{:.6e},0,0,{:.6e},0,{:.6e}\n", t_s, var, var, 0.2 * var);
      const bool is_degenerate = degenerate(v, i);
      degeneracy += fmt::format("{:.9f},{},{:.3f},1,0,0,0.05,,{}", t_s, is_degenerate ? 1 : 0,
                                is_degenerate ? 900.0 : 8.0 + std::sin(0.3 * i),
                                is_degenerate ? run_.vehicles[0] : "");
      degeneracy += run_.old_degeneracy ? "\n"
                    : is_degenerate     ? ",axial,none,0.0487,range\n"
                                        : ",axial,full,0.0213,lidar\n";
      errors += fmt::format("{:.9f},{:.4f},0.2,{:.4f},0.01,-0.02,,{:.3f}\n", t_s, 0.03 + 1e-3 * i,
                            0.02 + 1e-3 * i, 5.0 + std::sin(0.2 * i));
    }
    folder_.write("trajectory/" + name + ".tum", tum);
    folder_.write("trajectory/" + name + ".cov.csv", cov);
    folder_.write("degeneracy/" + name + ".csv", degeneracy);
    if (run_.truth) folder_.write("errors/" + name + ".csv", errors);
  }

  void write_map() const {
    if (run_.points == 0) return;
    std::vector<float> x, y, z, intensity, sigma;
    std::vector<std::uint16_t> seen(run_.points, 3);
    std::vector<std::uint8_t> vehicle;
    const double lanes = 1.2 * static_cast<double>(run_.vehicles.size()) + 2.0;
    for (std::size_t i = 0; i < run_.points; ++i) {
      const double u = std::fmod(static_cast<double>(i) * 0.6180339887, 1.0);
      const double w = std::fmod(static_cast<double>(i) * 0.7548776662, 1.0);
      const bool wall = i % 3 != 0;
      x.push_back(static_cast<float>(18.0 * u - 2.0));
      y.push_back(static_cast<float>(wall ? (i % 2 == 0 ? 2.0 : -lanes) : 2.0 - (lanes + 2.0) * w));
      z.push_back(static_cast<float>(wall ? 2.5 * w : 0.0));
      intensity.push_back(10.0F);
      sigma.push_back(static_cast<float>(0.02 + 0.1 * u));
      vehicle.push_back(static_cast<std::uint8_t>(i % run_.vehicles.size()));
    }
    const io::MapColumns columns{x, y, z, intensity, sigma, seen, vehicle};
    EXPECT_TRUE(io::write_map_pcd(folder_.path("map.pcd"), run_.points, io::one_part(columns)));
  }

  std::string metrics() const {
    std::string vehicles;
    for (std::size_t v = 0; v < run_.vehicles.size(); ++v) {
      vehicles += fmt::format(
          R"({}{}:{{"path_m":{},"scans":{},"scans_dropped":0,"keyframes":31,"degenerate_fraction":{},)"
          R"("degenerate_constrained_fraction":0.9,"sigma_median_m":0.0412,"sigma_max_m":0.0937,"diverged_s":0,)"
          R"("time_offset_s":0.0012,"accel_scale":1.0,"gaps":{{"jumps":0,"missing_s":0.0}}}})",
          v == 0 ? "" : ",", json_text(run_.vehicles[v]), 0.12 * run_.poses + 0.125, run_.poses,
          v % 2 == 1 ? 0.27 : 0.0);
    }
    const std::string warnings =
        run_.warning.empty()
            ? ""
            : fmt::format(R"({{"id":"D09","vehicle":"v1","text":{}}})", json_text(run_.warning));
    std::string group;
    for (const std::string& name : run_.vehicles) {
      group += (group.empty() ? "" : ",") + json_text(name);
    }
    return fmt::format(
        R"({{"schema":2,"rali":"0.2.0","status":"{}","t_start_s":{:.1f},"t_end_s":{:.1f},)"
        R"("vehicles":{{{}}},"fleet":{{"groups":[[{}]],"loops_accepted":{},"loops_refused":{},)"
        R"("rounds":{}}},"ranges":{{"total":{},"used":{},"rejected":{{"nlos":40,"outlier":20}},)"
        R"("pairs":{{"v1-v2":{{"bias_m":0.123,"bias_sigma_m":0.01,"residual_std_m":0.07,)"
        R"("latency_s":0.046}}}}}},"map":{{"points":{},"voxel_m":0.05,"thickness_m":0.0067}},)"
        R"("warnings":[{}]}})",
        run_.status, kStart_s, kStart_s + 0.1 * run_.poses, vehicles, group, run_.fleet ? 1 : 0,
        run_.fleet ? 1 : 0, run_.fleet ? 2 : 0, run_.fleet ? 600 : 0, run_.fleet ? 540 : 0,
        run_.points, warnings);
  }

  void write_fleet() const {
    std::string ranges =
        "stamp_s,from,to,range_m,predicted_m,residual_m,sigma_m,bias_m,p_los,used,reason\n";
    for (int i = 0; i < 600; ++i) {
      const std::size_t to = 1 + static_cast<std::size_t>(i) % (run_.vehicles.size() - 1);
      const bool used = i % 10 != 0;
      ranges +=
          fmt::format("{:.9f},{},{},2.0,1.9,{:.3f},0.1,0.1,0.9,{},{}\n", kStart_s + i / 30.0,
                      run_.vehicles[0], run_.vehicles[to], used ? 0.07 * std::sin(2.1 * i) : 0.8,
                      used ? 1 : 0, used ? "used" : "nlos");
    }
    folder_.write("ranges.csv", ranges);
    folder_.write(
        "rounds.csv",
        fmt::format("round,anchor,start_s,end_s,ended_by,next_anchor,frontier_id\n1,{0},"
                    "{2:.1f},{3:.1f},arrived,{1},4\n2,{1},{3:.1f},{4:.1f},end,,\n",
                    run_.vehicles[0], run_.vehicles[1], kStart_s, kStart_s + 9.0, kStart_s + 20.0));
    folder_.write(
        "frontiers.csv",
        "round,id,x,y,length_m,nearest_vehicle,state,reason\n1,4,9.5,0.5,1.25,v2,explored,\n"
        "2,5,12.0,3.5,2.5,v1,unreachable,behind the gate\n");
    folder_.write("loops.csv",
                  fmt::format("stamp_from_s,vehicle_from,stamp_to_s,vehicle_to,accepted,reason,"
                              "score,shift_m\n{0:.1f},v1,{1:.1f},v2,1,,0.83,0.12\n{0:.1f},v1,"
                              "{1:.1f},v2,0,too few points,0.31,\n",
                              kStart_s + 2.0, kStart_s + 17.0));
  }

  std::string evaluation() const {
    const std::string track =
        R"({"poses":200,"ape_m":{"rmse":0.1337,"max":0.25},"ape_deg":{"rmse":0.2,"max":0.4},)"
        R"("rpe":[{"distance_m":10.0,"m":{"rmse":0.05,"max":0.1},"deg":{"rmse":0.1}}],)"
        R"("drift_final_m":0.2,"drift_z_m":0.03,"degenerate":{"along_m":{"rmse":0.11},)"
        R"("across_m":{"rmse":0.02}},"nees_pose":{"mean":5.5,"expected_mean":6,)"
        R"("fraction_within_95":0.94}})";
    std::string vehicles, names;
    for (const std::string& name : run_.vehicles) {
      vehicles += (vehicles.empty() ? "" : ",") + json_text(name) + R"(:{"trajectory":)" + track +
                  R"(,"live":)" + track + R"(,"odometry":null})";
      names += (names.empty() ? "" : ",") + json_text(name);
    }
    return fmt::format(
        R"({{"schema":2,"how":"aligned by se3, one transform for the fleet","frames":[{{"vehicles")"
        R"(:[{}],"T_truth_est":{{"xyz_m":[1,2,3],"quat_xyzw":[0,0,0,1]}}}}],"vehicles":{{{}}},)"
        R"("fleet":{{"trajectory":{}}},"cloud":{{"to_mesh":{{"mean_m":0.021,"std_m":0.013,)"
        R"("p95_m":0.05,"fraction_beyond_cut":0.001,"cut_m":1,"completeness":0.82}}}}}})",
        names, vehicles, track);
  }

  const io::TestFolder& folder_;
  const TestRun& run_;
};

inline void write_test_run(const io::TestFolder& folder, const TestRun& run) {
  TestRunWriter(folder, run).write();
}

}  // namespace rali::report
