#include "rali/io/files/old_names.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "rali/io/files/csv_reader.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

TEST(OldNames, map_to_the_new_names_and_back) {
  EXPECT_EQ(current_name_of("sweeps_dropped"), "scans_dropped");
  EXPECT_EQ(old_name_of("scans_dropped"), "sweeps_dropped");
  EXPECT_EQ(current_name_of("path_m"), "path_m");
  EXPECT_EQ(old_name_of("path_m"), "");
}

TEST(OldNames, of_columns_are_read_if_the_new_name_is_absent) {
  const auto old = CsvReader::from_text("stamp_s,blind,held_by\n1,1,range\n", "a.csv");
  ASSERT_TRUE(old);
  EXPECT_EQ(old->column("degenerate"), 1);
  EXPECT_EQ(*old->require("constrained_by"), 2);
  const auto both = CsvReader::from_text("blind,degenerate\n0,1\n", "b.csv");
  ASSERT_TRUE(both);
  EXPECT_EQ(both->column("degenerate"), 1) << "the new name wins";
}

TEST(OldNames, are_reported_once_per_kind_of_file) {
  const TestFolder folder;
  for (const char* name : {"degeneracy", "errors"}) {
    std::filesystem::create_directories(folder.path(name));
  }
  folder.write("metrics.json", "{\n \"schema\": 1,\n \"vehicles\": {}\n}\n");
  folder.write("evaluation.json", "{\n \"schema\": 2,\n \"how\": \"\"\n}\n");
  folder.write("degeneracy/v1.csv", "stamp_s,blind\n");
  folder.write("degeneracy/v2.csv", "stamp_s,blind\n");
  folder.write("errors/v1.csv", "stamp_s,along_degenerate_m\n");
  const std::vector<std::string> notices = notices_of_old_names(folder.path());
  ASSERT_EQ(notices.size(), 2U);
  EXPECT_NE(notices[0].find("metrics.json"), std::string::npos) << notices[0];
  EXPECT_NE(notices[1].find("degeneracy/*.csv"), std::string::npos) << notices[1];
  EXPECT_TRUE(notices_of_old_names(folder.path("absent")).empty());
}

}  // namespace
}  // namespace rali::io
