#include "rali/scenario/scene/old_scene_keys.hpp"

#include <gtest/gtest.h>

#include "rali/scenario/scene/scene_setup.hpp"

namespace rali::scenario {
namespace {

const std::string kOld =
    "tunnel: {piece_m: 80, length_m: 120}\n"
    "vehicles:\n"
    "  - {start: [1, 0]}\n"
    "motion:\n"
    "  rest_s: 2\n"
    "  jolts: {felt_ratio: 0.5}\n"
    "uwb: {outlier_share: 0.02}\n"
    "escorts: [{begin_s: 3, end_s: 9}]\n";

TEST(OldSceneKeys, are_read_into_the_new_settings) {
  const auto setup = parse_scene(kOld, "scene.yaml", "");
  ASSERT_TRUE(setup) << setup.error().message();
  EXPECT_EQ(setup->tunnel.segment_m, 80.0);
  EXPECT_EQ(setup->tunnel.length_m, 120.0);
  EXPECT_EQ(setup->fleet.vehicle.motion.standstill_s, 2.0);
  EXPECT_EQ(setup->fleet.vehicle.motion.jolts.measured_ratio, 0.5);
  EXPECT_EQ(setup->fleet.uwb.outlier_fraction, 0.02);
  ASSERT_EQ(setup->fleet.vehicle.escorts.size(), 1U);
  EXPECT_EQ(setup->fleet.vehicle.escorts[0].start_s, 3.0);
  EXPECT_EQ(setup->fleet.vehicle.escorts[0].end_s, 9.0);
}

TEST(OldSceneKeys, have_one_notice_each_with_line_and_new_name) {
  const auto setup = parse_scene(kOld, "scene.yaml", "");
  ASSERT_TRUE(setup) << setup.error().message();
  ASSERT_EQ(setup->notices.size(), 5U);
  EXPECT_EQ(setup->notices[0],
            "scene.yaml:1: tunnel.piece_m is called tunnel.segment_m now. The old name is read in "
            "this release only");
  EXPECT_EQ(setup->notices[4],
            "scene.yaml:8: escorts.begin_s is called escorts.start_s now. The old name is read in "
            "this release only");
}

TEST(OldSceneKeys, are_dumped_under_new_names) {
  const auto setup = parse_scene(kOld, "scene.yaml", "");
  ASSERT_TRUE(setup) << setup.error().message();
  const auto again = parse_scene(dump_scene(*setup, ""), "scene.yaml", "");
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_TRUE(again->notices.empty()) << again->notices.front();
  EXPECT_EQ(again->fleet.vehicle.escorts[0].start_s, 3.0);
}

TEST(OldSceneKeys, are_overridden_by_the_new_key) {
  const auto setup = parse_scene("scene: loop\nmotion: {rest_s: 2, standstill_s: 4}\n", "s", "");
  ASSERT_TRUE(setup) << setup.error().message();
  EXPECT_EQ(setup->fleet.vehicle.motion.standstill_s, 4.0);
}

}  // namespace
}  // namespace rali::scenario
