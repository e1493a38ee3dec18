#include "rali/cli/view/point_times.hpp"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

constexpr const char* kCloud =
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 0 0\n";

report::RunData run_with(std::vector<float> x_m) {
  report::RunData run;
  run.begin = Time::from_s(100.0);
  run.vehicles.resize(1);
  run.vehicles[0].name = "v1";
  run.map.y_m = run.map.z_m = std::vector<float>(x_m.size(), 0.0F);
  run.map.x_m = std::move(x_m);
  return run;
}

TEST(PointTimes, a_point_has_the_time_of_its_first_observing_keyframe) {
  const io::TestFolder folder;
  std::filesystem::create_directories(folder.path("keyframes/v1"));
  folder.write("keyframes/v1/000000.pcd", kCloud);
  // The same cloud from three positions: 1 m ahead of each, and rotated about z at the last.
  folder.write("keyframes.csv",
               "id,vehicle,seq,stamp_s,x,y,z,qx,qy,qz,qw,points,file\n"
               "1,v1,1,109,5,0,0,0,0,0,1,1,keyframes/v1/000000.pcd\n"
               "0,v1,0,103,5,0,0,0,0,0,1,1,keyframes/v1/000000.pcd\n"
               "2,v1,2,112,9,0,0,0,0,1,0,1,keyframes/v1/000000.pcd\n");
  const std::vector<float> times = first_seen_s(folder.path(), run_with({6.1F, 8.1F, 6.4F, 20.0F}));
  ASSERT_EQ(times.size(), 4U);
  EXPECT_FLOAT_EQ(times[0], 3.0F) << "the earlier of two";
  EXPECT_FLOAT_EQ(times[1], 12.0F) << "9 - 1: that keyframe looks back";
  EXPECT_FLOAT_EQ(times[2], 3.0F) << "the cell beside it";
  EXPECT_TRUE(std::isnan(times[3])) << "seen by none";
}

TEST(PointTimes, damaged_rows_and_paths_outside_the_folder_are_skipped) {
  const io::TestFolder folder;
  folder.write("outside.pcd", kCloud);
  folder.write("keyframes.csv",
               "id,vehicle,seq,stamp_s,x,y,z,qx,qy,qz,qw,points,file\n"
               "0,v1,0,103,5,0,0,0,0,0,1,1,keyframes/../outside.pcd\n"
               "1,v1,1,103,5,0,0,0,0,0,1,1,/etc/passwd\n"
               "2,v1,2,103,nan,0,0,0,0,0,1,1,keyframes/v1/a.pcd\n"
               "3,v1,3,103,5,0,0,0,0,0,0,1,keyframes/v1/a.pcd\n"
               "4,v1,4,103,5,0,0,0,0,0,1,1,keyframes/v1/missing.pcd\n");
  EXPECT_TRUE(first_seen_s(folder.path(), run_with({6.0F})).empty());
  const io::TestFolder empty;
  EXPECT_TRUE(first_seen_s(empty.path(), run_with({6.0F})).empty());
}

}  // namespace
}  // namespace rali::cli
