#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "rali/io/containers/bag_writer.hpp"
#include "rali/io/containers/codec.hpp"
#include "rali/io/containers/db3_writer.hpp"
#include "rali/io/containers/file_kind.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/containers/rosbag2_folder.hpp"
#include "rali/io/containers/testing.hpp"
#include "rali/io/files/text.hpp"

namespace rali::io {
namespace {

namespace fs = std::filesystem;

using testing::copy;
using testing::drain;
using testing::Drained;
using testing::first;
using testing::ScratchFolder;
using testing::texts;
using testing::write_file;

std::string refusal(const std::string& path) {
  const auto source = open_recording(path);
  return source ? "accepted" : source.error().message();
}

/// An MCAP with one message per data text, with consecutive times.
std::vector<std::byte> mcap_of(const std::vector<std::string>& data, std::int64_t t_ns = 0) {
  MemorySink sink;
  McapWriter writer(sink, {});
  const auto channel = writer.add_channel(0, "/t", "cdr");
  for (const std::string& text : data) {
    EXPECT_TRUE(writer.write(*channel, Time::from_ns(t_ns), Time::from_ns(t_ns), bytes_of(text)));
    ++t_ns;
  }
  EXPECT_TRUE(writer.close());
  return sink.bytes();
}

/// The texts of all messages, joined.
std::string contents(const Drained& got) {
  std::string out;
  for (const auto& message : got.messages) out += message.data + ' ';
  return out;
}

Drained read(const std::string& path) {
  const auto source = open_recording(path);
  if (source) return drain(**source);
  Drained out;
  out.error = source.error().message();
  return out;
}

TEST(OpenRecording, detects_the_format_by_content_not_by_file_name) {
  ScratchFolder scratch;
  write_file(scratch.path + "/x.bag", mcap_of({"one"}));
  EXPECT_EQ(contents(read(scratch.path + "/x.bag")), "one ");
}

TEST(OpenRecording, names_the_kind_of_an_unsupported_file) {
  ScratchFolder scratch;
  const auto says = [&](std::string_view bytes, std::string_view words) {
    const std::string path = scratch.path + "/x.bag";
    write_file(path, copy(bytes));
    EXPECT_NE(refusal(path).find(words), std::string::npos) << refusal(path);
  };
  says("", "x.bag: empty file.");
  says(std::string_view("\xd4\xc3\xb2\xa1\x02\x00\x04\x00", 8),
       "raw network packets (pcap), not decoded clouds. Convert with the maker's driver");
  says("\x0a\x0d\x0d\x0a\x01", "raw network packets (pcapng)");
  says("# .PCD v0.7\nVERSION 0.7\n", "a point cloud (PCD)");
  says("ply\nformat ascii 1.0\n", "a point cloud (PLY)");
  says("PK\x03\x04zip", "a zip archive. Unpack it first.");
  says("time,x,y,z\n1,2,3,4\n", "text, not a recording");
  says("#ROSBAG V1.2\n", "a ROS 1 bag of an old version");
  says("#ROSBAG V2", "cut within its first line");
  says(std::string_view("\0\0\0\0\0\0\0\0", 8), "only zeros");
  says("\x01\x02\xab\xcd\xef", "unknown kind of file (first bytes 01 02 ab cd ef)");
  EXPECT_NE(refusal(scratch.path + "/none.bag").find("no such file"), std::string::npos);
  fs::create_directory(scratch.path + "/empty");
  EXPECT_NE(refusal(scratch.path + "/empty").find("holds neither a recording"), std::string::npos);
}

TEST(OpenRecording, a_folder_of_bags_asks_for_one_of_them) {
  ScratchFolder scratch;
  write_file(scratch.path + "/a.bag", copy("x"));
  EXPECT_NE(refusal(scratch.path).find("directory of 1 ROS 1 bags. Name one"), std::string::npos);
}

TEST(OpenRecording, splits_without_metadata_are_read_in_the_order_of_their_numbers) {
  ScratchFolder scratch;
  write_file(scratch.path + "/run_10.mcap", mcap_of({"ten"}, 10));
  write_file(scratch.path + "/run_2.mcap", mcap_of({"two"}, 2));
  write_file(scratch.path + "/run_0.mcap", mcap_of({"zero"}, 0));
  const auto source = open_recording(scratch.path);
  ASSERT_TRUE(source) << source.error().message();
  ASSERT_EQ((*source)->topics().size(), 1U);
  EXPECT_EQ((*source)->topics()[0].messages, 3U);
  ASSERT_TRUE((*source)->span());
  EXPECT_EQ((*source)->span()->second.ns, 10);
  const Drained got = drain(**source);
  EXPECT_EQ(contents(got), "zero two ten ");
  EXPECT_EQ(got.health.messages, 3U);
  EXPECT_EQ((*source)->progress(), 1.0);
}

TEST(OpenRecording, metadata_gives_the_order_with_and_without_a_folder_in_its_paths) {
  for (const std::string prefix : {"", "old_name/"}) {
    ScratchFolder scratch;
    write_file(scratch.path + "/a.mcap", mcap_of({"a"}));
    write_file(scratch.path + "/b.mcap", mcap_of({"b"}));
    std::ofstream(scratch.path + "/metadata.yaml")
        << "rosbag2_bagfile_information:\n  compression_mode: \"\"\n  relative_file_paths:\n    - "
        << prefix << "b.mcap\n    - " << prefix << "a.mcap\n    - " << prefix << "gone.mcap\n";
    const Drained got = read(scratch.path);
    EXPECT_EQ(contents(got), "b a ");
    EXPECT_NE(texts(got.health).find("gone.mcap, which is not there"), std::string::npos);
  }
}

TEST(OpenRecording, several_recordings_in_one_folder_are_refused) {
  ScratchFolder scratch;
  write_file(scratch.path + "/v1.mcap", mcap_of({"a"}));
  write_file(scratch.path + "/v2.mcap", mcap_of({"b"}));
  EXPECT_NE(refusal(scratch.path).find("several recordings (v1.mcap, v2.mcap, ...)"),
            std::string::npos)
      << refusal(scratch.path);
}

TEST(OpenRecording, a_damaged_split_is_skipped_and_the_others_are_read) {
  ScratchFolder scratch;
  write_file(scratch.path + "/run_0.mcap", mcap_of({"zero"}));
  write_file(scratch.path + "/run_1.mcap", copy("rubbish"));
  write_file(scratch.path + "/run_2.mcap", mcap_of({"two"}));
  const Drained got = read(scratch.path);
  EXPECT_EQ(contents(got), "zero two ");
  EXPECT_NE(texts(got.health).find("run_1.mcap: text, not a recording"), std::string::npos)
      << texts(got.health);
}

TEST(OpenRecording, folder_single_database_and_compressed_database_give_the_same_messages) {
  ScratchFolder scratch;
  auto writer = Db3Writer::create(scratch.path + "/bag");
  ASSERT_TRUE(writer);
  const auto topic = (*writer)->add_topic("/t", "std_msgs/msg/String");
  ASSERT_TRUE((*writer)->write(*topic, Time::from_ns(5), bytes_of("one")));
  ASSERT_TRUE((*writer)->write(*topic, Time::from_ns(7), bytes_of("two")));
  ASSERT_TRUE((*writer)->close());
  EXPECT_EQ(contents(read(scratch.path + "/bag")), "one two ");
  EXPECT_EQ(texts(read(scratch.path + "/bag").health), "");
  EXPECT_EQ(contents(read((*writer)->database_path())), "one two ");
  const auto packed = compress(Compression::kZstd, testing::read_file((*writer)->database_path()));
  write_file(scratch.path + "/x.db3.zstd", *packed);
  const Drained got = read(scratch.path + "/x.db3.zstd");
  EXPECT_EQ(contents(got), "one two ") << got.error;
  // A folder with a compressed file, as rosbag2's file mode leaves it.
  fs::remove((*writer)->database_path());
  write_file((*writer)->database_path() + ".zstd", *packed);
  EXPECT_EQ(contents(read(scratch.path + "/bag")), "one two ");
}

TEST(OpenRecording, reads_a_truncated_compressed_file_up_to_the_cut) {
  ScratchFolder scratch;
  std::vector<std::string> data;
  std::uint32_t state = 1;
  for (int i = 0; i < 3000; ++i) {
    std::string text;
    for (int k = 0; k < 100; ++k) {
      state = state * 1664525U + 1013904223U;
      text += static_cast<char>(state >> 24);
    }
    data.push_back(text);
  }
  MemorySink sink;
  McapWriter writer(sink, {"ros2", Compression::kNone, 5000});
  const auto channel = writer.add_channel(0, "/t", "cdr");
  for (std::size_t i = 0; i < data.size(); ++i) {
    const Time t = Time::from_ns(static_cast<std::int64_t>(i));
    ASSERT_TRUE(writer.write(*channel, t, t, bytes_of(data[i])));
  }
  ASSERT_TRUE(writer.close());
  const auto packed = *compress(Compression::kZstd, sink.bytes());
  write_file(scratch.path + "/x.mcap.zstd", first(packed, packed.size() * 3 / 4));
  const Drained got = read(scratch.path + "/x.mcap.zstd");
  EXPECT_GT(got.messages.size(), 1000U) << got.error;
  EXPECT_LT(got.messages.size(), 3000U);
  EXPECT_TRUE(got.health.truncated);
  EXPECT_NE(texts(got.health).find("x.mcap.zstd: compressed file is cut"), std::string::npos)
      << texts(got.health);
  for (const Finding& finding : got.health.findings) {
    EXPECT_TRUE(finding.text.starts_with(scratch.path + "/x.mcap.zstd"))
        << "the name of the temporary file says nothing to the user: " << finding.text;
  }
}

TEST(OpenRecording, reads_a_read_only_folder) {
  ScratchFolder scratch;
  auto writer = Db3Writer::create(scratch.path + "/bag");
  ASSERT_TRUE(writer);
  const auto topic = (*writer)->add_topic("/t", "std_msgs/msg/String");
  ASSERT_TRUE((*writer)->write(*topic, Time::from_ns(5), bytes_of("one")));
  ASSERT_TRUE((*writer)->close());
  fs::permissions(scratch.path + "/bag", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_EQ(contents(read(scratch.path + "/bag")), "one ");
  fs::permissions(scratch.path + "/bag", fs::perms::owner_all);
}

TEST(Rosbag2Metadata, both_list_styles_and_the_compression_are_found) {
  const auto block = parse_rosbag2_metadata(
      "info:\n  compression_mode: MESSAGE\n  relative_file_paths:\n    - \"a/b_0.db3\"\n"
      "    - 'b_1.db3'\n  files:\n    - path: c.db3\n");
  EXPECT_EQ(block.files, (std::vector<std::string>{"a/b_0.db3", "b_1.db3"}));
  EXPECT_EQ(block.compression_mode, "MESSAGE");
  const auto flow = parse_rosbag2_metadata("relative_file_paths: [a.db3, \"b.db3\"]\r\n");
  EXPECT_EQ(flow.files, (std::vector<std::string>{"a.db3", "b.db3"}));
  EXPECT_TRUE(parse_rosbag2_metadata("relative_file_paths: [").files.empty());
  EXPECT_TRUE(parse_rosbag2_metadata("").files.empty());
}

TEST(NaturalOrder, numbers_compare_as_numbers) {
  EXPECT_TRUE(natural_less("run_2", "run_10"));
  EXPECT_FALSE(natural_less("run_10", "run_2"));
  EXPECT_TRUE(natural_less("a", "ab"));
  EXPECT_TRUE(natural_less("x_0.db3", "x_0.db3.zstd"));
  EXPECT_FALSE(natural_less("run_1", "run_1"));
  EXPECT_NE(natural_less("run_01", "run_1"), natural_less("run_1", "run_01"));
}

TEST(OpenRecording, real_rosbag2_folders_have_the_messages_their_readme_lists) {
  const std::string folder = std::string(RALI_DATA_DIR) + "/recordings/";
  if (!fs::exists(folder)) GTEST_SKIP() << "no data pack at " << folder;

  struct Real {
    std::string path;
    std::string topic;
    std::size_t messages;
    double span_s;
  };

  const Real all[] = {
      {"velodyne_vlp16/1673400471837873222", "/velodyne_packets", 4, 0.30},
      {"velodyne_vlp32/1713492677464078412", "/sensing/lidar/front/velodyne_packets", 5, 0.38},
      {"hesai_xt16/1732848127890747768", "/pandar_packets", 4, 0.30},
      {"hesai_qt64/1673401195788312575", "/pandar_packets", 4, 0.30},
      {"hesai_40p/1673400149412331409", "/pandar_packets", 4, 0.30},
      {"hesai_40p/1673400149412331409/1673400149412331409_0.db3", "/pandar_packets", 4, 0.30}};
  for (const Real& real : all) {
    const auto source = open_recording(folder + real.path);
    ASSERT_TRUE(source) << source.error().message();
    ASSERT_EQ((*source)->topics().size(), 1U) << real.path;
    EXPECT_EQ((*source)->topics()[0].name, real.topic);
    EXPECT_EQ((*source)->topics()[0].messages, real.messages);
    ASSERT_TRUE((*source)->span());
    EXPECT_NEAR(seconds_between((*source)->span()->first, (*source)->span()->second), real.span_s,
                0.01);
    const Drained got = drain(**source);
    EXPECT_EQ(got.messages.size(), real.messages);
    EXPECT_EQ(texts(got.health), "");
  }
  EXPECT_NE(refusal(folder + "ouster/OS-1-64_1024x10_fw20.pcap").find("(pcap)"), std::string::npos);
  EXPECT_NE(refusal(folder + "hesai_40p/1673400149711850138.pcd").find("(PCD)"), std::string::npos);
  EXPECT_NE(refusal(folder + "converted_pointcloud2").find("several recordings"),
            std::string::npos);
}

}  // namespace
}  // namespace rali::io
