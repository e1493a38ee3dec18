#include "rali/io/files/cloud_file.hpp"

#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto view = text_bytes(text);
  return {view.begin(), view.end()};
}

template <class T>
void append(std::string& out, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  out.append(raw, sizeof value);
}

/// Four floats a point: a small ring of radius 5 m.
std::string kitti_points(std::size_t n) {
  std::string out;
  for (std::size_t i = 0; i < n; ++i) {
    const float angle = static_cast<float>(i) * 0.1F;
    append(out, 5.0F * std::cos(angle));
    append(out, 5.0F * std::sin(angle));
    append(out, -1.0F);
    append(out, 0.25F);
  }
  return out;
}

/// Three floats a point, the same ring.
std::string xyz_points(std::size_t n) {
  std::string out;
  for (std::size_t i = 0; i < n; ++i) {
    const float angle = static_cast<float>(i) * 0.1F;
    append(out, 5.0F * std::cos(angle));
    append(out, 5.0F * std::sin(angle));
    append(out, -1.0F);
  }
  return out;
}

TEST(Kitti, gives_x_y_z_intensity) {
  const auto cloud = parse_cloud_file(bytes_of(kitti_points(100)), "000000.bin");
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->size(), 100U);
  EXPECT_EQ(cloud->point_step, 16U);
  EXPECT_TRUE(cloud->findings.empty());
  EXPECT_EQ(cloud->column(cloud->field("x"))[0], 5.0);
  EXPECT_EQ(cloud->column(cloud->field("intensity"))[99], 0.25);
  const wire::CloudView view = cloud->view(Time::from_s(1.5), "lidar");
  EXPECT_EQ(view.width * view.height, 100U);
  EXPECT_EQ(view.row_step, 1600U);
  EXPECT_EQ(view.data.size(), 1600U);
  EXPECT_EQ(view.frame_id, "lidar");
}

TEST(Kitti, truncated_within_a_point_keeps_the_complete_points_with_a_finding) {
  const std::string whole = kitti_points(100);
  for (std::size_t rest = 1; rest < 16; ++rest) {
    const auto cloud = parse_cloud_file(bytes_of(whole.substr(0, 800 + rest)), "a.bin");
    ASSERT_TRUE(cloud) << cloud.error().message();
    EXPECT_EQ(cloud->size(), 50U);
    EXPECT_EQ(cloud->data.size(), 800U);
    ASSERT_EQ(cloud->findings.size(), 1U);
    EXPECT_EQ(cloud->findings[0].value, static_cast<double>(rest));
  }
}

TEST(Kitti, three_floats_per_point_are_refused_unless_specified) {
  const auto bytes = bytes_of(xyz_points(100));
  const auto refused = parse_cloud_file(bytes, "a.bin");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("12 bytes a point"), std::string::npos)
      << refused.error().message();
  const auto reported = parse_cloud_file(bytes, "a.bin", {KittiLayout::kXyz});
  ASSERT_TRUE(reported);
  EXPECT_EQ(reported->size(), 100U);
  EXPECT_EQ(reported->field("intensity"), -1);
  EXPECT_EQ(reported->column(reported->field("z"))[99], -1.0);
}

TEST(Kitti, a_list_of_times_is_refused_as_scan) {
  std::string times;
  for (int i = 0; i < 1000; ++i) append(times, static_cast<float>(i) * 1e-4F);
  const auto cloud = parse_cloud_file(bytes_of(times), "times.bin");
  ASSERT_FALSE(cloud);
  EXPECT_NE(cloud.error().what.find("is no LiDAR scan"), std::string::npos);
}

TEST(CloudFile, names_the_kind_of_a_file_that_is_no_cloud) {
  const auto message = [](std::string_view content, const std::string& path) {
    const auto cloud = parse_cloud_file(bytes_of(content), path);
    return cloud ? std::string("no error") : cloud.error().what;
  };
  EXPECT_EQ(message("", "a.bin"),
            "is an empty file, not a point cloud (PCD, PLY, LAS or KITTI .bin)");
  EXPECT_EQ(message("#ROSBAG V2.0\n", "a.bin"),
            "is a ROS bag, not a point cloud (PCD, PLY, LAS or KITTI .bin)");
  EXPECT_EQ(message("hello, world, this is text\n", "a.bin"),
            "is text, not a point cloud (PCD, PLY, LAS or KITTI .bin)");
  EXPECT_EQ(message("LASF\x01\x04", "a.ply"), "ends in its header");
  EXPECT_EQ(message(std::string(32, '\0'), "a.ply"),
            "is only zeros, not a point cloud (PCD, PLY, LAS or KITTI .bin)");
}

TEST(CloudFile, format_is_detected_by_content_not_by_file_name) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n2.5\n";
  const auto cloud = parse_cloud_file(bytes_of(ply), "wrong_name.bin");
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->kind, CloudFileKind::kPly);
}

TEST(CloudFile, the_three_encodings_of_a_real_scan_give_the_same_cloud) {
  RALI_NEEDS_DATA("clouds");
  const auto binary = read_cloud_file(real_data("clouds/vlp16_binary.pcd"));
  const auto packed = read_cloud_file(real_data("clouds/vlp16_compressed.pcd"));
  const auto ascii = read_cloud_file(real_data("clouds/vlp16_ascii_full.pcd"));
  ASSERT_TRUE(binary && packed && ascii);
  ASSERT_EQ(binary->size(), 14831U);
  ASSERT_EQ(binary->point_step, 32U);
  ASSERT_EQ(binary->fields.size(), 10U);
  EXPECT_TRUE(binary->data == packed->data);
  ASSERT_EQ(ascii->data.size(), binary->data.size());
  for (int f = 0; f < 10; ++f) {
    const auto a = ascii->column(f);
    const auto b = binary->column(f);
    for (std::size_t i = 0; i < a.size(); ++i) {
      // six significant digits, and whole numbers exactly
      const bool real =
          binary->fields[static_cast<std::size_t>(f)].type == wire::FieldType::kFloat32;
      ASSERT_NEAR(a[i], b[i], real ? 1e-5 * std::abs(b[i]) + 1e-9 : 0.0) << f << " " << i;
    }
  }
}

TEST(CloudFile, reads_every_real_cloud_with_its_known_number_of_points) {
  RALI_NEEDS_DATA("clouds");
  const std::pair<const char*, std::size_t> known[] = {
      {"clouds/bunny.pcd", 397},
      {"clouds/pair_source.ply", 69792},
      {"clouds/pair_target.ply", 69088},
      {"clouds/bun_zipper_res3.ply", 1889},
      {"clouds/canstick.ply", 2101},
      {"recordings/velodyne_vlp16/1673400472138016708.pcd", 14831},
      {"recordings/velodyne_vlp32/1713492677464078412.pcd", 26216},
      {"recordings/hesai_xt16/1732848128093928016.pcd", 26287},
      {"recordings/hesai_qt64/1673401196087570870.pcd", 34158},
      {"recordings/hesai_40p/1673400149711850138.pcd", 56762}};
  for (const auto& [name, points] : known) {
    const auto cloud = read_cloud_file(real_data(name));
    ASSERT_TRUE(cloud) << cloud.error().message();
    EXPECT_EQ(cloud->size(), points) << name;
    EXPECT_EQ(cloud->data.size(), points * cloud->point_step) << name;
    for (const double x : cloud->column(cloud->field("x"))) ASSERT_LT(std::abs(x), 300.0) << name;
  }
  const auto bunny = read_cloud_file(real_data("clouds/bunny.pcd"));
  EXPECT_FLOAT_EQ(static_cast<float>(bunny->column(0)[0]), 0.0054216F);
  const auto pair = read_cloud_file(real_data("clouds/pair_source.ply"));
  EXPECT_GE(pair->field("intensity"), 0);
  const auto zipper = read_cloud_file(real_data("clouds/bun_zipper_res3.ply"));
  EXPECT_FLOAT_EQ(static_cast<float>(zipper->column(zipper->field("z"))[0]), 0.00276757F);
}

TEST(CloudFile, reads_real_kitti_and_refuses_files_with_12_bytes_per_point) {
  RALI_NEEDS_DATA("kitti_0005");
  const auto scan = read_cloud_file(real_data("kitti_0005/scans64_full/000000.bin"));
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->size(), 1974352U / 16U);
  EXPECT_TRUE(scan->findings.empty());
  for (const char* name : {"raw_00", "raw_01", "raw_02", "deskewed_00", "deskewed_01"}) {
    const std::string path = real_data(std::string("lio_samples/newer_06/") + name + ".bin");
    const auto refused = read_cloud_file(path);
    ASSERT_FALSE(refused) << path;
    EXPECT_NE(refused.error().what.find("looks like x y z without intensity"), std::string::npos);
    const auto reported = read_cloud_file(path, {KittiLayout::kXyz});
    ASSERT_TRUE(reported);
  }
  EXPECT_EQ(
      read_cloud_file(real_data("lio_samples/newer_06/raw_00.bin"), {KittiLayout::kXyz})->size(),
      25109U);
  for (const char* name : {"edges_000000", "planes_000000", "edges_000030", "edges_000040"}) {
    const auto refused =
        read_cloud_file(real_data(std::string("lio_samples/newer_01/") + name + ".bin"));
    ASSERT_FALSE(refused) << name;
    EXPECT_NE(refused.error().what.find("looks like x y z without intensity"), std::string::npos);
  }
  const auto times = read_cloud_file(real_data("lio_samples/newer_06/times_00.bin"));
  ASSERT_FALSE(times);
  EXPECT_NE(times.error().what.find("is no LiDAR scan"), std::string::npos);
}

}  // namespace
}  // namespace rali::io
