#include "rali/io/input_kind.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"
#include "rali/io/message_source.hpp"

namespace rali::io {
namespace {

std::string refusal(const std::string& path) {
  const auto kind = input_kind(path);
  if (kind) return "accepted";
  EXPECT_EQ(kind.error().code, ErrorCode::kInput) << kind.error().message();
  return kind.error().message();
}

bool holds(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

TEST(InputKind, cyclic_links_and_missing_paths_are_input_errors) {
  const TestFolder f;
  std::filesystem::create_symlink(f.path("loop"), f.path("loop"));
  EXPECT_TRUE(holds(refusal(f.path("loop")), "links lead in a circle")) << refusal(f.path("loop"));
  EXPECT_TRUE(holds(refusal(f.path("none.bag")), "there is no such file or folder"));
  f.write("file", "x");
  EXPECT_TRUE(holds(refusal(f.path("file/none.bag")), "a part of the path is no folder"));
  EXPECT_TRUE(holds(refusal(f.path(std::string(300, 'x'))), "the name is too long"));
  const auto opened = open_recording(f.path("loop"));
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, ErrorCode::kInput) << "not the machine's fault";
}

TEST(InputKind, a_folder_with_clouds_and_recordings_is_refused_as_ambiguous) {
  const TestFolder f;
  std::filesystem::create_directories(f.path("both"));
  std::filesystem::create_directories(f.path("both/100.pcd"));
  f.write("both/v1.bag", "x");
  EXPECT_EQ(input_kind(f.path("both")), InputKind::kRecording) << "a folder is no cloud";
  f.write("both/001.pcd", "x");
  EXPECT_TRUE(holds(refusal(f.path("both")), "holds 1 cloud and 1 recording"));
  f.write("both/metadata.yaml", "");
  EXPECT_EQ(input_kind(f.path("both")), InputKind::kRecording) << "a map saved beside a rosbag2";
  std::filesystem::create_directories(f.path("empty"));
  f.write("empty/notes.txt", "x");
  EXPECT_TRUE(holds(refusal(f.path("empty")), "neither a recording"));
}

TEST(InputKind, files_and_folders_of_one_kind_are_recognised) {
  const TestFolder f;
  EXPECT_EQ(input_kind(f.write("v1.bag", "x")), InputKind::kRecording);
  EXPECT_EQ(input_kind(f.write("cloud.PLY", "x")), InputKind::kCloud);
  std::filesystem::create_directories(f.path("scans"));
  f.write("scans/1.bin", "x");
  f.write("scans/.2.bag", "x");
  EXPECT_EQ(input_kind(f.path("scans")), InputKind::kScanFolder);
}

}  // namespace
}  // namespace rali::io
