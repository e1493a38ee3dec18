// Real keyframes: 130 scans of a +-45 degree LiDAR with the poses of a LiDAR-inertial odometry.

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/map/build_map.hpp"
#include "rali/map/test_world.hpp"

namespace rali::map {
namespace {

test::Scan read_scan(const std::filesystem::path& file) {
  test::Scan scan;
  std::ifstream in(file, std::ios::binary);
  std::array<char, 8> record{};
  while (in.read(record.data(), record.size())) {
    std::array<std::int16_t, 3> p{};
    std::uint16_t intensity = 0;
    std::memcpy(p.data(), record.data(), 6);
    std::memcpy(&intensity, record.data() + 6, 2);
    scan.add(0.0025 * p[0], 0.0025 * p[1], 0.0025 * p[2], 0, static_cast<float>(intensity));
  }
  return scan;
}

std::vector<test::Scan> read_keyframes(const std::filesystem::path& folder) {
  std::vector<test::Scan> scans;
  std::ifstream poses(folder / "poses.tum");
  std::string line;
  while (std::getline(poses, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream in(line);
    double t = 0, x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 1;
    in >> t >> x >> y >> z >> qx >> qy >> qz >> qw;
    const std::string number = std::to_string(scans.size());
    test::Scan scan =
        read_scan(folder / "scans" / (std::string(6 - number.size(), '0') + number + ".xyzi"));
    scan.t = Time::from_s(t);
    scan.T_map_body.R = Eigen::Quaterniond(qw, qx, qy, qz).normalized().toRotationMatrix();
    scan.T_map_body.p = {x, y, z};
    scans.push_back(std::move(scan));
  }
  return scans;
}

TEST(RecordedMap, recorded_keyframes_give_walls_thinner_than_5_cm_and_keep_them) {
  const std::filesystem::path folder = std::filesystem::path(RALI_DATA_DIR) / "hku_keyframes";
  if (!std::filesystem::exists(folder / "poses.tum")) {
    GTEST_SKIP() << "NOT CHECKED: no recorded keyframes at " << folder;
  }
  const std::vector<test::Scan> scans = read_keyframes(folder);
  ASSERT_EQ(scans.size(), 130U);
  const auto stream = [&scans](const KeyframeVisitor& visit) -> Status {
    for (std::size_t k = 0; k < scans.size(); k += 4) visit(scans[k].view());
    return {};
  };
  SerialExecutor executor;
  FindingList findings;
  const auto result = build_map(stream, MapSettings{}, executor, findings);
  ASSERT_TRUE(result.has_value());
  EXPECT_TRUE(findings.empty()) << findings[0].text;
  EXPECT_GT(result->map.size(), 50000U);
  // The source names no people; walls must not be removed with people in front of them.
  EXPECT_LT(result->removed.size(), result->map.size() / 50);
  EXPECT_GT(result->thickness.planes, 200U);
  EXPECT_LT(result->thickness.median_m, 0.05);
  EXPECT_TRUE(result->grid.has_value());
  RecordProperty("thickness_mm", static_cast<int>(1000.0 * result->thickness.median_m));
  RecordProperty("points", static_cast<int>(result->map.size()));
  RecordProperty("removed", static_cast<int>(result->removed.size()));
}

}  // namespace
}  // namespace rali::map
