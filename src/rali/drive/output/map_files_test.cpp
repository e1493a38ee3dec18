#include "rali/drive/output/map_files.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/drive/output/fleet_run_for_test.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

TEST(MapFiles, assign_a_point_to_the_vehicle_that_observed_it_first) {
  const io::TestFolder folder;
  std::vector<VehicleRun> runs;  // v2 is at 5 m at once, v1 comes to the same position 10 s later
  runs.push_back(DrivenVehicle(folder.path(), 0).drive(5.0, 10.0).finish());
  runs.push_back(DrivenVehicle(folder.path(), 1).begin(5.0, true).finish());
  MapJob job;
  job.out_dir = folder.path();
  job.formats = {"pcd"};
  SerialExecutor executor;
  FindingList findings;
  const auto numbers = write_map_files({&runs[0], &runs[1]}, job, std::nullopt, executor, findings);
  ASSERT_TRUE(numbers) << numbers.error().message();
  ASSERT_GT(numbers->points, 1000U);
  const auto file = io::read_cloud_file(folder.path("map.pcd"));
  ASSERT_TRUE(file) << file.error().message();
  ASSERT_EQ(file->size(), numbers->points);
  const auto vehicle = std::find_if(file->fields.begin(), file->fields.end(),
                                    [](const auto& f) { return f.name == "vehicle"; });
  ASSERT_NE(vehicle, file->fields.end());
  std::size_t of_v2 = 0;
  for (std::size_t i = 0; i < file->size(); ++i) {
    of_v2 += file->data[i * file->point_step + vehicle->offset] == std::byte{1} ? 1 : 0;
  }
  EXPECT_EQ(of_v2, file->size());
}

/// Points removed from the map when v2 is in front of v1 in all its keyframes, 4 m ahead.
std::size_t removed_of_v2(bool common_clock) {
  const io::TestFolder folder;
  const map::test::Cylinder body{5.0, 1.5, 0.25, 0.75};
  std::vector<VehicleRun> runs;
  runs.push_back(DrivenVehicle(folder.path(), 0).sees(body).begin(1.0, true).finish());
  runs.push_back(DrivenVehicle(folder.path(), 1).begin(5.0, true).finish());
  MapJob job;
  job.out_dir = folder.path();
  job.formats = {"pcd"};
  job.known.common_clock = common_clock;
  SerialExecutor executor;
  FindingList findings;
  const auto numbers = write_map_files({&runs[0], &runs[1]}, job, std::nullopt, executor, findings);
  EXPECT_TRUE(numbers) << numbers.error().message();
  return numbers ? numbers->removed : 0;
}

TEST(MapFiles, omit_points_on_another_vehicle_that_never_moved) {
  EXPECT_GT(removed_of_v2(true), 20U);
}

TEST(MapFiles, without_a_common_clock_keep_points_on_other_vehicles) {
  EXPECT_EQ(removed_of_v2(false), 0U);
}

}  // namespace
}  // namespace rali::drive
