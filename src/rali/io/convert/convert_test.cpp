#include "rali/io/convert/convert.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/files/cloud_file.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/message_source.hpp"
#include "rali/wire/decode.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::io {
namespace {

constexpr auto kRos1 = wire::Encoding::kRos1;

wire::LivoxCustom livox_scan() {
  wire::LivoxCustom scan;
  scan.stamp = Time::from_s(100.0);
  scan.frame_id = "livox";
  for (int i = 0; i < 5; ++i) {
    wire::LivoxPoint point;
    point.offset_time_ns = static_cast<std::uint32_t>(1000 * i);
    point.x_m = 1.0F + static_cast<float>(i);
    point.reflectivity = static_cast<std::uint8_t>(i);
    scan.points.push_back(point);
  }
  return scan;
}

/// A bag of one Livox scan, one message of an unknown type, and one IMU sample.
std::string write_bag(const TestFolder& folder) {
  const std::string path = folder.path("run.bag");
  auto file = AtomicFile::create(path);
  FileSink sink(std::move(*file));
  BagWriter bag(sink, {});
  const auto livox = bag.add_connection("/livox/lidar", "livox_ros_driver/CustomMsg",
                                        "e4d6829bdfe657cb6c21a746c86b21a6", "Header header\n");
  const auto odd = bag.add_connection("/odd", "my_msgs/Odd", std::string(32, '0'), "uint8 x\n");
  const auto imu = bag.add_connection("/imu", "sensor_msgs/Imu",
                                      std::string(wire::message_md5("sensor_msgs/Imu")),
                                      wire::message_definition("sensor_msgs/Imu", kRos1));
  const std::byte one[] = {std::byte{7}};
  EXPECT_TRUE(bag.write(*livox, Time::from_s(100.1), wire::encode(livox_scan(), kRos1)));
  EXPECT_TRUE(bag.write(*odd, Time::from_s(100.2), one));
  EXPECT_TRUE(bag.write(*imu, Time::from_s(100.3), wire::encode(wire::ImuMessage{}, kRos1)));
  EXPECT_TRUE(bag.close());
  EXPECT_TRUE(sink.commit());
  return path;
}

// Viewers support PointCloud2 but not CustomMsg; all other messages must be copied unchanged.
TEST(Convert, bag_becomes_mcap_with_point_clouds) {
  const TestFolder folder;
  const auto done = convert(write_bag(folder), folder.path("run.mcap"));
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(done->done, "3 messages of 3 topics, 1 CustomMsg as PointCloud2");
  EXPECT_FALSE(done->gaps);
  auto source = open_recording(folder.path("run.mcap"));
  ASSERT_TRUE(source) << source.error().message();
  RawMessage message;
  ASSERT_TRUE((*source)->next(message).value());
  const Topic topic = (*source)->topics()[message.topic];
  EXPECT_EQ(topic.type, "sensor_msgs/PointCloud2");
  EXPECT_NE(topic.definition.find("PointField"), std::string::npos);
  EXPECT_EQ(message.t_record, Time::from_s(100.1));
  const auto cloud = wire::decode_point_cloud2(message.data, topic.encoding);
  ASSERT_TRUE(cloud) << cloud.error().message();
  EXPECT_EQ(cloud->width, 5U);
  EXPECT_EQ(cloud->fields.front().name, "offset_time");
  EXPECT_EQ(cloud->stamp, Time::from_s(100.0));
  ASSERT_TRUE((*source)->next(message).value());
  EXPECT_EQ((*source)->topics()[message.topic].type, "my_msgs/Odd");
  EXPECT_EQ((*source)->topics()[message.topic].definition, "uint8 x\n");
  ASSERT_EQ(message.data.size(), 1U);
  EXPECT_EQ(message.data[0], std::byte{7});
}

TEST(Convert, recording_conversion_is_deterministic) {
  const TestFolder folder;
  const std::string bag = write_bag(folder);
  ASSERT_TRUE(convert(bag, folder.path("a.mcap")));
  ASSERT_TRUE(convert(bag, folder.path("b.mcap")));
  EXPECT_EQ(folder.read("a.mcap"), folder.read("b.mcap"));
}

TEST(Convert, truncated_recording_is_converted_and_gaps_are_reported) {
  const TestFolder folder;
  write_bag(folder);
  const std::string whole = folder.read("run.bag");
  const std::string cut = folder.write("cut.bag", whole.substr(0, whole.size() - 700));
  const auto done = convert(cut, folder.path("cut.mcap"));
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_TRUE(done->gaps);
  EXPECT_FALSE(done->findings.empty());
}

constexpr const char* kPcd =
    "VERSION 0.7\nFIELDS x y z intensity ring\nSIZE 8 8 8 4 2\nTYPE F F F F U\nCOUNT 1 1 1 1 1\n"
    "WIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n"
    "500000.123 4000000.5 1 10 3\nnan 2 3 20 4\n500001.25 4000001.5 -2 255 5\n";

// Site coordinates of 4000 km do not fit a float32: through LAS they must keep their millimetres.
TEST(Convert, cloud_keeps_site_coordinates_through_las_and_ply) {
  const TestFolder folder;
  const std::string pcd = folder.write("a.pcd", kPcd);
  const auto las = convert(pcd, folder.path("a.las"));
  ASSERT_TRUE(las) << las.error().message();
  EXPECT_EQ(las->lost,
            (std::vector<std::string>{"fields ring", "1 point without finite coordinates"}));
  const auto back = convert(folder.path("a.las"), folder.path("b.ply"));
  ASSERT_TRUE(back) << back.error().message();
  const auto cloud = read_cloud_file(folder.path("b.ply"));
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->size(), 2U);
  EXPECT_NEAR(cloud->column(cloud->field("x"))[0], 500000.123, 1e-6);
  EXPECT_NEAR(cloud->column(cloud->field("y"))[1], 4000001.5, 1e-6);
  EXPECT_NEAR(cloud->column(cloud->field("z"))[1], -2.0, 1e-6);
  EXPECT_EQ(cloud->column(cloud->field("intensity"))[1], 65535.0);
}

TEST(Convert, cloud_keeps_all_fields_through_pcd_and_ply) {
  const TestFolder folder;
  const std::string pcd = folder.write("a.pcd", kPcd);
  ASSERT_TRUE(convert(pcd, folder.path("b.ply")));
  EXPECT_NE(folder.read("b.ply").find("property ushort scalar_ring"), std::string::npos);
  const auto done = convert(folder.path("b.ply"), folder.path("c.pcd"));
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_TRUE(done->lost.empty());
  const auto cloud = read_cloud_file(folder.path("c.pcd"));
  ASSERT_TRUE(cloud) << cloud.error().message();
  ASSERT_EQ(cloud->size(), 3U);
  EXPECT_EQ(cloud->column(cloud->field("x"))[0], 500000.123);
  EXPECT_TRUE(std::isnan(cloud->column(cloud->field("x"))[1]));
  EXPECT_EQ(cloud->column(cloud->field("ring"))[2], 5.0);
}

TEST(Convert, kitti_cloud_reports_the_lost_fields_and_precision) {
  const TestFolder folder;
  const auto done = convert(folder.write("a.pcd", kPcd), folder.path("a.bin"));
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(done->lost,
            (std::vector<std::string>{"fields ring", "1 point without finite coordinates",
                                      "millimetres: the coordinates are too large for float32"}));
  EXPECT_EQ(folder.read("a.bin").size(), 2U * 16U);
}

TEST(Convert, refuses_a_compressed_or_inconsistent_las) {
  const TestFolder folder;
  ASSERT_TRUE(convert(folder.write("a.pcd", kPcd), folder.path("a.las")));
  std::string bytes = folder.read("a.las");
  std::string laz = bytes;
  laz[104] = static_cast<char>(laz[104] | '\x80');
  auto refused = convert(folder.write("z.las", laz), folder.path("z.pcd"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().what, "is compressed (LAZ)");
  bytes[247] = '\x7f';
  refused = convert(folder.write("l.las", bytes), folder.path("l.pcd"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("names 127 points"), std::string::npos);
}

constexpr const char* kTum =
    "# frame levelled by gravity: z is up\n1700000000.123456789 1 2 3 0 0 0.707106781 0.707106781\n"
    "1700000001.000000000 2 2 3 0 0 0 1\n";

TEST(Convert, trajectory_survives_a_round_trip_through_every_format) {
  const TestFolder folder;
  const std::string tum = folder.write("a.tum", kTum);
  for (const std::string middle : {"b.csv", "b.euroc"}) {
    const auto there = convert(tum, folder.path(middle));
    ASSERT_TRUE(there) << there.error().message();
    EXPECT_EQ(there->lost, std::vector<std::string>{"comments of the header"});
    ASSERT_TRUE(convert(folder.path(middle), folder.path("c.tum")));
    EXPECT_EQ(folder.read("c.tum"),
              "1700000000.123456789 1.000000 2.000000 3.000000 0.000000000 0.000000000 0.707106781 "
              "0.707106781\n1700000001.000000000 2.000000 2.000000 3.000000 0.000000000 "
              "0.000000000 0.000000000 1.000000000\n")
        << middle;
  }
  EXPECT_EQ(folder.read("b.euroc").substr(folder.read("b.euroc").find('\n') + 1, 30),
            "1700000000123456789,1.000000,2");
}

TEST(Convert, kitti_trajectory_needs_stamps) {
  const TestFolder folder;
  ConvertOptions options;
  options.to = "kitti";
  const auto there = convert(folder.write("a.tum", kTum), folder.path("poses.txt"), options);
  ASSERT_TRUE(there) << there.error().message();
  EXPECT_EQ(there->lost.front(), "stamps: KITTI has none");
  const auto refused = convert(folder.path("poses.txt"), folder.path("c.tum"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message().find("--times"), std::string::npos);
  options.to.clear();
  options.times = folder.write("times.txt", "1.5\n2.5\n");
  ASSERT_TRUE(convert(folder.path("poses.txt"), folder.path("c.tum"), options));
  EXPECT_TRUE(folder.read("c.tum").starts_with("1.500000000 1.000000 2.000000 3.000000 0.00000"));
  options.times = folder.write("times.txt", "1.5\n");
  EXPECT_FALSE(convert(folder.path("poses.txt"), folder.path("d.tum"), options));
}

TEST(Convert, lists_the_target_formats_for_an_unknown_extension) {
  const TestFolder folder;
  const auto refused = convert(folder.write("a.tum", kTum), folder.path("b.xyz"));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  EXPECT_NE(refused.error().what.find("mcap, pcd"), std::string::npos);
}

}  // namespace
}  // namespace rali::io
