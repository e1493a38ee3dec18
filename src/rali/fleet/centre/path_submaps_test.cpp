#include "rali/fleet/centre/path_submaps.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace rali::fleet {
namespace {

/// A path with a keyframe of one point at each place along x.
VehiclePath path_at(const std::vector<double>& x_m) {
  VehiclePath path(VehicleId{1});
  for (std::uint32_t k = 0; k < x_m.size(); ++k) {
    Increment step;
    step.node = k;
    step.keyframe = k;
    step.begins = k == 0;
    step.T_odom_body.p.x() = x_m[k];
    path.add(Time::from_s(k), step);
    KeyframePoints points;
    points.keyframe = k;
    points.points = PackedPoints(PointArrays{{1.0F}, {1.0F}, {1.0F}, {}});
    path.add(Time::from_s(k), points);
  }
  return path;
}

std::vector<PathSubmap> cut(const VehiclePath& path) {
  SerialExecutor executor;
  return cut_into_submaps({&path, 1}, CutSettings{}, places::PlacesSettings{}, executor);
}

TEST(PathSubmaps, of_8_m_length_start_every_4_m) {
  std::vector<double> x_m;
  for (int k = 0; k <= 16; ++k) x_m.push_back(k);
  const std::vector<PathSubmap> pieces = cut(path_at(x_m));
  ASSERT_EQ(pieces.size(), 3U);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_DOUBLE_EQ(pieces[i].path_m, 4.0 + 4.0 * static_cast<double>(i));
    EXPECT_EQ(pieces[i].submap.scans().size(), 9U);
  }
}

TEST(PathSubmaps, a_jump_of_the_path_does_not_multiply_the_submaps) {
  // A vehicle that has lost track, or sends wrong data, may leap as far as a message can encode.
  std::vector<double> x_m;
  for (int k = 0; k < 10; ++k) x_m.push_back(k % 2 == 0 ? 9e6 : -9e6);
  EXPECT_LE(cut(path_at(x_m)).size(), 2 * x_m.size());
  EXPECT_LE(cut(path_at({0.0, 1.0, 90000.0, 90001.0})).size(), 8U);
}

}  // namespace
}  // namespace rali::fleet
