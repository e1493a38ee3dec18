#include "rali/io/files/tum.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

StampedPose pose_at(double t_s, double yaw_rad) {
  StampedPose pose;
  pose.t = Time::from_s(t_s);
  pose.T.R = geometry::rotation_from_rpy(0.0, 0.0, yaw_rad);
  pose.T.p = geometry::Vec3(1.0, -2.0000004, 3.0000006);
  return pose;
}

TEST(Tum, line_has_9_decimals_for_time_and_6_for_position) {
  EXPECT_EQ(tum_line(pose_at(1.5, 0.0)),
            "1.500000000 1.000000 -2.000000 3.000001 "
            "0.000000000 0.000000000 0.000000000 1.000000000");
}

TEST(Tum, quaternions_never_have_a_negative_w) {
  for (double yaw_rad = -7.0; yaw_rad < 7.0; yaw_rad += 0.01) {
    const std::string line = tum_line(pose_at(0.0, yaw_rad));
    const std::string w = line.substr(line.rfind(' ') + 1);
    ASSERT_NE(w.front(), '-') << yaw_rad << ": " << line;
  }
}

TEST(Tum, written_poses_are_read_back) {
  const TestFolder folder;
  auto writer = TumWriter::create(folder.path("v1.tum"), {"frame map, body", "stamps: last point"});
  ASSERT_TRUE(writer);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(writer->add(pose_at(1630577758.1 + 0.1 * i, 0.05 * i)));
  }
  ASSERT_TRUE(writer->finish());
  const auto file = read_tum(folder.path("v1.tum"));
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_EQ(file->header, (std::vector<std::string>{"frame map, body", "stamps: last point"}));
  ASSERT_EQ(file->poses.size(), 100U);
  EXPECT_TRUE(file->findings.empty());
  for (int i = 0; i < 100; ++i) {
    const StampedPose expected = pose_at(1630577758.1 + 0.1 * i, 0.05 * i);
    const StampedPose& pose = file->poses[static_cast<std::size_t>(i)];
    EXPECT_EQ(pose.t, expected.t);
    EXPECT_LT((pose.T.p - expected.T.p).norm(), 1e-6);
    EXPECT_LT((pose.T.R - expected.T.R).norm(), 1e-8);
  }
}

/// A kill must cost at most 10 s of data: checks the temporary file while it grows.
TEST(Tum, lines_reach_the_disk_within_10_s_of_data) {
  const TestFolder folder;
  auto writer = TumWriter::create(folder.path("v1.tum"), {});
  ASSERT_TRUE(writer);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(writer->add(pose_at(100.0 + 0.1 * i, 0.0)));
    const auto there = parse_tum(folder.read(".v1.tum.tmp"), "tmp");
    ASSERT_TRUE(there);
    ASSERT_LE((Time::from_s(100.0 + 0.1 * i) - there->poses.back().t).s(), 10.0) << i;
    i += 6;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("v1.tum")));
}

TEST(Tum, errors_name_file_and_line) {
  const auto error_of = [](std::string_view text) {
    const auto file = parse_tum(text, "a.tum");
    return file ? std::string("no error") : file.error().message();
  };
  EXPECT_EQ(error_of("# h\n1 0 0 0 0 0 0 1\n2 0 0 x 0 0 0 1\n"),
            "a.tum:3: 'x' is no finite number.");
  EXPECT_EQ(error_of("1 0 0 0 0 0 0 2\n"), "a.tum:1: the quaternion has length 2, not 1.");
  EXPECT_EQ(error_of("1 0 0 0 0 0 0\n"), "a.tum:1: has fewer than 8 numbers.");
  EXPECT_EQ(error_of("1 0 0 0 0 0 0 1 1\n"), "a.tum:1: has more than 8 numbers.");
  EXPECT_EQ(error_of("1 0 0 nan 0 0 0 1\n"), "a.tum:1: 'nan' is no finite number.");
  EXPECT_EQ(error_of("1630577758569490000 0 0 0 0 0 0 1\n"),
            "a.tum:1: '1630577758569490000' is no stamp in seconds (nanoseconds?).");
  EXPECT_EQ(error_of(""), "a.tum: has no poses.");
  EXPECT_EQ(error_of("# only a header\n"), "a.tum: has no poses.");
}

TEST(Tum, truncated_last_lines_are_skipped_and_backward_stamps_reported) {
  const auto cut = parse_tum("1 0 0 0 0 0 0 1\n2 0 0 0 0", "a.tum");
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->poses.size(), 1U);
  ASSERT_EQ(cut->findings.size(), 1U);
  EXPECT_EQ(cut->findings[0].text, "a.tum:2: the last line is cut; left out");
  const auto back = parse_tum("2 0 0 0 0 0 0 1\n1,0,0,0,0,0,0,1\n", "a.tum");
  ASSERT_TRUE(back);
  ASSERT_EQ(back->findings.size(), 1U);
  EXPECT_EQ(back->findings[0].text, "a.tum:2: time does not advance (1 such lines)");
}

TEST(Tum, reads_the_real_trajectories) {
  RALI_NEEDS_DATA("hku_keyframes/poses.tum");
  EXPECT_EQ(read_tum(real_data("hku_keyframes/poses.tum"))->poses.size(), 130U);
  EXPECT_EQ(read_tum(real_data("kitti_0005/reference_registration.tum"))->poses.size(), 154U);
  EXPECT_EQ(read_tum(real_data("uwb_pairs/three_tags/dynamic_mid_truth.tum"))->poses.size(),
            16069U);
  EXPECT_EQ(read_tum(real_data("lio_samples/continuous/traj.txt"))->poses.size(), 2380U);
}

TEST(Tum, the_header_states_whether_the_frame_is_gravity_aligned) {
  for (const bool levelled : {true, false}) {
    const auto file =
        parse_tum("# T_map_body\n# " + frame_line(levelled) + "\n1 0 0 0 0 0 0 1\n", "v1.tum");
    ASSERT_TRUE(file);
    EXPECT_EQ(is_levelled(file->header), levelled);
  }
  EXPECT_FALSE(is_levelled({"timestamp tx ty tz qx qy qz qw"})) << "others do not say it";
}

}  // namespace
}  // namespace rali::io
