#include "rali/io/files/stream_file.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "rali/io/files/size_limit_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

TEST(StreamFile, on_a_full_disk_keeps_the_complete_lines) {
  const TestFolder folder;
  auto file = StreamFile::create(folder.path("v1.tum"));
  ASSERT_TRUE(file);
  const std::string line = "123456789\n";  // 10 bytes; the disk holds 25
  {
    const FileSizeLimit limit(25);
    Status status;
    for (int i = 0; i < 5; ++i) {
      if (status) status = file->add(line, Time::from_s(20.0 * i));
    }
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kMachine);
    EXPECT_FALSE(file->finish()) << "what is missing must be told";
  }
  EXPECT_EQ(folder.read("v1.tum"), line + line);
  EXPECT_EQ(folder.files(), 1U) << "no .v1.tum.tmp";
}

TEST(StreamFile, without_a_complete_line_on_disk_leaves_no_file) {
  const TestFolder folder;
  auto file = StreamFile::create(folder.path("v1.tum"));
  ASSERT_TRUE(file);
  const FileSizeLimit limit(5);
  EXPECT_FALSE(file->add("123456789\n", Time::from_s(1.0)));
  EXPECT_FALSE(file->finish());
  EXPECT_EQ(folder.files(), 0U);
}

}  // namespace
}  // namespace rali::io
