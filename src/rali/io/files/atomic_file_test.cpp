#include "rali/io/files/atomic_file.hpp"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "rali/io/files/input_file.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

TEST(AtomicFile, is_absent_before_commit_and_complete_after) {
  const TestFolder folder;
  auto file = AtomicFile::create(folder.path("map.pcd"));
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->write(std::string_view("half")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("map.pcd")));
  EXPECT_TRUE(std::filesystem::exists(folder.path(".map.pcd.tmp")));
  ASSERT_TRUE(file->write(std::string_view(" whole")));
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(folder.read("map.pcd"), "half whole");
  EXPECT_EQ(folder.files(), 1U);
}

TEST(AtomicFile, leaves_nothing_behind_when_abandoned_and_keeps_the_old_file) {
  const TestFolder folder;
  folder.write("a", "old");
  {
    auto file = AtomicFile::create(folder.path("a"));
    ASSERT_TRUE(file && file->write(std::string_view("new")));
  }
  EXPECT_EQ(folder.read("a"), "old");
  EXPECT_EQ(folder.files(), 1U);
}

TEST(AtomicFile, abandoned_by_assignment_is_removed_too) {
  const TestFolder folder;
  auto file = AtomicFile::create(folder.path("a"));
  ASSERT_TRUE(file);
  auto other = AtomicFile::create(folder.path("b"));
  ASSERT_TRUE(other);
  *file = std::move(*other);
  EXPECT_FALSE(std::filesystem::exists(folder.path(".a.tmp")));
  ASSERT_TRUE(file->commit());
  EXPECT_TRUE(std::filesystem::exists(folder.path("b")));
}

TEST(AtomicFile, abandoned_with_keep_leaves_its_lines_in_the_temporary_file) {
  const TestFolder folder;
  {
    auto file = AtomicFile::create(folder.path("odo.tum"), OnAbandon::kKeep);
    ASSERT_TRUE(file && file->write(std::string_view("line\n")));
  }
  EXPECT_EQ(folder.read(".odo.tum.tmp"), "line\n");
}

TEST(AtomicFile, sync_writes_the_buffered_bytes_to_the_temporary_file) {
  const TestFolder folder;
  auto file = AtomicFile::create(folder.path("odo.tum"));
  ASSERT_TRUE(file && file->write(std::string_view("line\n")));
  EXPECT_EQ(folder.read(".odo.tum.tmp"), "");
  ASSERT_TRUE(file->sync());
  EXPECT_EQ(folder.read(".odo.tum.tmp"), "line\n");
}

TEST(AtomicFile, writes_data_larger_than_its_buffer_in_order) {
  const TestFolder folder;
  std::string expected;
  auto file = AtomicFile::create(folder.path("big"));
  ASSERT_TRUE(file);
  for (int i = 0; i < 40; ++i) {
    const std::string part(static_cast<std::size_t>(i) * 20000 + 1,
                           static_cast<char>('a' + i % 26));
    expected += part;
    ASSERT_TRUE(file->write(std::string_view(part)));
    ASSERT_EQ(file->size(), expected.size());
  }
  ASSERT_TRUE(file->commit());
  EXPECT_TRUE(folder.read("big") == expected);
}

TEST(AtomicFile, overwrites_a_header_in_place) {
  const TestFolder folder;
  auto file = AtomicFile::create(folder.path("x"));
  ASSERT_TRUE(file && file->write(std::string_view("0000 body")));
  ASSERT_TRUE(file->overwrite(1, text_bytes("12")));
  ASSERT_TRUE(file->write(std::string_view(" tail")));
  ASSERT_TRUE(file->commit());
  EXPECT_EQ(folder.read("x"), "0120 body tail");
}

TEST(AtomicFile, in_a_missing_folder_is_a_machine_error_with_its_path) {
  const auto file = AtomicFile::create("/nowhere/at/all/map.pcd");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().code, ErrorCode::kMachine);
  EXPECT_EQ(file.error().message(),
            "/nowhere/at/all/map.pcd: cannot be created: no such file or folder.");
}

TEST(AtomicFile, over_a_folder_fails_and_removes_its_temporary_file) {
  const TestFolder folder;
  std::filesystem::create_directory(folder.path("a"));
  folder.write("a/b", "x");
  const auto status = write_file_atomic(folder.path("a"), std::string_view("text"));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kMachine);
  EXPECT_EQ(folder.files(), 1U);
}

/// /dev/full simulates a full disk; a symbolic link replaces the temporary file.
TEST(AtomicFile, on_a_full_disk_is_a_machine_error_with_the_reason) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "NO /dev/full: full disk not tested";
  const TestFolder folder;
  std::filesystem::create_symlink("/dev/full", folder.path(".a.tmp"));
  const auto status = write_file_atomic(folder.path("a"), std::string_view("text"));
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kMachine);
  EXPECT_EQ(status.error().message(), folder.path("a") +
                                          ": writing failed: the disk is full. Make room on the "
                                          "disk or choose another folder.");
  EXPECT_EQ(folder.files(), 0U);
}

TEST(InputFile, names_the_reason_if_it_cannot_be_read) {
  const TestFolder folder;
  EXPECT_EQ(InputFile::open("/nowhere/x").error().message(),
            "/nowhere/x: cannot be read: no such file or folder.");
  EXPECT_EQ(InputFile::open(folder.path()).error().what, "is a folder, not a file");
  EXPECT_EQ(InputFile::open("/dev/null").error().what, "is no regular file");
  const std::string file = folder.write("big", "12345");
  EXPECT_FALSE(read_file(file, 4));
  EXPECT_EQ(read_file(file, 5)->size(), 5U);
}

}  // namespace
}  // namespace rali::io
