// Recorded scans twice a second, LiDAR only, started anywhere: correct, or reported as lost.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/base/executor.hpp"
#include "rali/odometry/make_odometry.hpp"

namespace rali {
namespace {

using geometry::SE3;

struct Recorded {
  sensor::LidarScan scan;
  SE3 T_map_lidar;
};

sensor::LidarScan read_scan(const std::filesystem::path& file, Time t) {
  sensor::LidarScan scan;
  scan.t_start = t;
  scan.t_end = t;
  std::ifstream in(file, std::ios::binary);
  std::array<char, 8> record{};
  while (in.read(record.data(), record.size())) {
    std::array<std::int16_t, 3> p{};
    std::memcpy(p.data(), record.data(), 6);
    scan.push_back(0.0025F * p[0], 0.0025F * p[1], 0.0025F * p[2], 0.0F, 0.0F, 0);
  }
  return scan;
}

std::vector<Recorded> read_recording(const std::filesystem::path& folder) {
  std::vector<Recorded> out;
  std::ifstream poses(folder / "poses.tum");
  std::string line;
  while (std::getline(poses, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    double t = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 1;
    in >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
    const auto file = folder / "scans" / fmt::format("{:06d}.xyzi", out.size());
    const Eigen::Quaterniond q(qw, qx, qy, qz);
    out.push_back(
        {read_scan(file, Time::from_s(t)), {q.normalized().toRotationMatrix(), {x, y, z}}});
  }
  return out;
}

std::vector<Recorded> backward(std::vector<Recorded> scans) {
  const Time first = scans.front().scan.t_end;
  const Time last = scans.back().scan.t_end;
  std::reverse(scans.begin(), scans.end());
  for (Recorded& r : scans) r.scan.t_start = r.scan.t_end = first + (last - r.scan.t_end);
  return scans;
}

std::vector<Recorded> halved(const std::vector<Recorded>& scans) {
  std::vector<Recorded> out;
  for (std::size_t k = 0; k < scans.size(); k += 2) out.push_back(scans[k]);
  return out;
}

struct Outcome {
  double silent_max_m = 0.0;  ///< largest unreported error beyond the limit
  bool lost = false;
};

Outcome run(const std::vector<Recorded>& scans, double start_s, double duration_s) {
  constexpr double kLimit_m = 0.15;
  constexpr double kSigmas = 3.5;
  const auto odometry = odometry::make_odometry({}, {}, false);
  SerialExecutor executor;
  FindingList findings;
  Outcome out;
  std::optional<SE3> T_map_odom;
  for (const Recorded& r : scans) {
    const double t_s = (r.scan.t_end - scans.front().scan.t_end).s();
    if (t_s < start_s || t_s > start_s + duration_s) continue;
    const odometry::ScanResult result = odometry->process(r.scan, executor, findings);
    if (!T_map_odom) T_map_odom = r.T_map_lidar * result.T_odom_body.inverse();
    const double error_m = ((*T_map_odom * result.T_odom_body).p - r.T_map_lidar.p).norm();
    const bool cut = result.state == odometry::TrackState::kDiverged;
    out.lost = out.lost || cut;
    const double sigma_m = std::sqrt(result.covariance.diagonal().tail<3>().maxCoeff());
    const bool reported = out.lost && error_m < kSigmas * sigma_m;
    if (!cut && !reported && error_m > kLimit_m)
      out.silent_max_m = std::max(out.silent_max_m, error_m);
  }
  const bool reported = std::any_of(findings.begin(), findings.end(), [](const Finding& f) {
    return f.id == "odometry.diverged" && f.t_end > f.t;
  });
  EXPECT_EQ(out.lost, reported);
  return out;
}

TEST(LidarAloneStarts, a_start_at_any_time_is_correct_or_reported_as_lost) {
  const std::filesystem::path folder = std::filesystem::path(RALI_DATA_DIR) / "hku_keyframes";
  if (!std::filesystem::exists(folder / "poses.tum")) {
    GTEST_SKIP() << "NOT CHECKED: no recorded keyframes at " << folder;
  }
  const std::vector<Recorded> forward = read_recording(folder);
  ASSERT_EQ(forward.size(), 130U);
  int lost = 0;
  int runs = 0;
  for (const auto& scans : {forward, backward(forward), halved(forward)}) {
    // At standstill, then a turn of 40 degrees between two scans; in motion; in a turn.
    for (const double start_s : {2.0, 4.0, 14.0, 16.0, 26.0, 34.0, 44.0, 46.0, 48.0}) {
      const Outcome out = run(scans, start_s, 7.0);
      EXPECT_EQ(out.silent_max_m, 0.0) << "variant of run " << runs << ", start " << start_s;
      lost += out.lost ? 1 : 0;
      ++runs;
    }
  }
  EXPECT_LE(lost, runs / 5);
}

}  // namespace
}  // namespace rali
