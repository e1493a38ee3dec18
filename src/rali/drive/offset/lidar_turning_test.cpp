#include "rali/drive/offset/lidar_turning.hpp"

#include <gtest/gtest.h>

#include "rali/odometry/room_for_test.hpp"

namespace rali::drive {
namespace {

double degenerate_fraction_in(odometry::TestRoom room) {
  room.rest_s = 1e9;
  LidarTurning turning;
  SerialExecutor executor;
  for (int k = 0; k < 20; ++k) turning.see(*room.scan(0.1 * k), executor);
  EXPECT_EQ(turning.scans(), 20U);
  return turning.degenerate_fraction();
}

TEST(LidarTurning, counts_the_scans_of_a_bare_passage_as_degenerate_and_those_of_a_room_not) {
  odometry::TestRoom passage;
  passage.walls.lo.x() = -500.0;
  passage.walls.hi.x() = 500.0;
  passage.pillars.clear();
  EXPECT_GT(degenerate_fraction_in(passage), 0.8);
  EXPECT_LT(degenerate_fraction_in(odometry::TestRoom{}), 0.1);
}

}  // namespace
}  // namespace rali::drive
