#include "rali/drive/output/out_dir.hpp"

#include <filesystem>
#include <span>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/io/files/sha256.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

namespace fs = std::filesystem;

TEST(OutDir, recognises_only_its_own_output_names) {
  for (const char* name :
       {"map.pcd", "trajectory/v1.tum", "odometry/v1.cov.csv", "odometry/.v1.tum.tmp",
        "keyframes/v1/000012.pcd", "keyframes/v1/.000012.pcd.tmp", "status.json", ".map.ply.tmp"}) {
    EXPECT_TRUE(is_output_name(name)) << name;
  }
  for (const char* name : {"map.txt", "v1.bag", "notes/map.pcd", "keyframes/v1/mine.pcd",
                           "keyframes/v1/deeper/000001.pcd", "../map.pcd", "trajectory/.tum", "",
                           "keyframes/000001.txt", ".tmp"}) {
    EXPECT_FALSE(is_output_name(name)) << name;
  }
}

TEST(OutDir, is_created_if_missing) {
  const io::TestFolder folder;
  EXPECT_TRUE(prepare_out_dir(folder.path("a/b/out"), false));
  EXPECT_TRUE(fs::is_directory(folder.path("a/b/out")));
}

TEST(OutDir, that_is_not_empty_is_refused_with_the_documented_message) {
  const io::TestFolder folder;
  folder.write("something", "x");
  const Status status = prepare_out_dir(folder.path(), false);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kUsage);
  EXPECT_EQ(status.error().message(), folder.path() +
                                          "/ is not empty. Choose another or "
                                          "--overwrite (removes only what rali wrote).");
}

TEST(OutDir, overwrite_removes_only_files_that_rali_wrote) {
  const io::TestFolder folder;
  fs::create_directories(folder.path("trajectory"));
  fs::create_directories(folder.path("keyframes/v1"));
  for (const char* name : {"map.pcd", "trajectory/v1.tum", "keyframes/v1/000000.pcd", "notes.txt",
                           "trajectory/mine.txt"}) {
    folder.write(name, "x");
  }
  ASSERT_TRUE(write_status(folder.path(), "complete", true));
  ASSERT_TRUE(prepare_out_dir(folder.path(), true));
  EXPECT_FALSE(fs::exists(folder.path("map.pcd")));
  EXPECT_FALSE(fs::exists(folder.path("keyframes")));
  EXPECT_FALSE(fs::exists(folder.path("status.json")));
  EXPECT_TRUE(fs::exists(folder.path("notes.txt")));
  EXPECT_TRUE(fs::exists(folder.path("trajectory/mine.txt")));
}

TEST(OutDir, of_another_program_is_not_changed_even_with_overwrite) {
  const io::TestFolder folder;
  folder.write("map.pcd", "a map from elsewhere");
  EXPECT_FALSE(prepare_out_dir(folder.path(), true));
  folder.write("status.json", "{\"status\":\"fine\"}");
  EXPECT_FALSE(prepare_out_dir(folder.path(), true)) << "not a status of rali";
  EXPECT_TRUE(fs::exists(folder.path("map.pcd")));
}

TEST(OutDir, overwrite_does_not_follow_symbolic_links) {
  const io::TestFolder elsewhere, folder;
  elsewhere.write("v1.tum", "precious");
  ASSERT_TRUE(write_status(folder.path(), "complete", true));
  fs::create_directory_symlink(elsewhere.path(), folder.path("trajectory"));
  ASSERT_TRUE(prepare_out_dir(folder.path(), true));
  EXPECT_EQ(elsewhere.read("v1.tum"), "precious");
}

TEST(OutDir, that_is_a_file_is_refused) {
  const io::TestFolder folder;
  EXPECT_FALSE(prepare_out_dir(folder.write("out", "x"), true));
}

TEST(OutDir, below_a_file_is_a_usage_error) {
  const io::TestFolder folder;
  folder.write("notes.txt", "mine");
  const Status status = prepare_out_dir(folder.path("notes.txt/out/deep"), true);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kUsage);
  EXPECT_NE(status.error().what.find("notes.txt is a file, not a folder"), std::string::npos);
}

TEST(OutDir, that_cannot_be_created_is_a_machine_error) {
  const Status status = prepare_out_dir("/proc/rali/out", false);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kMachine);
}

TEST(Status, contains_the_hash_of_every_output_except_exempt_ones) {
  const io::TestFolder folder;
  folder.write("map.pcd", "abc");
  folder.write("run.log", "differs");
  folder.write("notes.txt", "not ours");
  ASSERT_TRUE(write_status(folder.path(), "partial", true));
  const auto json = nlohmann::json::parse(folder.read("status.json"));
  EXPECT_EQ(json["status"], "partial");
  ASSERT_EQ(json["files"].size(), 1U);
  // FIPS 180-4, example of "abc".
  EXPECT_EQ(json["files"]["map.pcd"],
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Status, adds_a_later_output_and_hashes_it_without_its_variable_part) {
  const io::TestFolder folder;
  folder.write("metrics.json", "{}");
  ASSERT_TRUE(write_status(folder.path(), "complete", true));
  std::string hashes[2];
  for (int i = 0; i < 2; ++i) {
    folder.write("report.html", i == 0 ? "a<b>1 s<e>c" : "a<b>22 s<e>c");
    ASSERT_TRUE(add_to_status(folder.path(), "report.html", "<b>", "<e>"));
    const auto json = nlohmann::json::parse(folder.read("status.json"));
    EXPECT_TRUE(json["files"].contains("metrics.json"));
    EXPECT_EQ(json["status"], "complete");
    hashes[i] = json["files"]["report.html"].get<std::string>();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], io::sha256_hex(std::as_bytes(std::span("a<e>c", 5))));
  folder.write("report.html", "a<b>22 s<e>d");
  ASSERT_TRUE(add_to_status(folder.path(), "report.html", "<b>", "<e>"));
  EXPECT_NE(nlohmann::json::parse(folder.read("status.json"))["files"]["report.html"], hashes[0]);
}

TEST(Status, is_not_extended_if_damaged_or_absent) {
  const io::TestFolder folder;
  folder.write("report.html", "x");
  EXPECT_TRUE(add_to_status(folder.path(), "report.html", "<b>", "<e>"));
  EXPECT_FALSE(std::filesystem::exists(folder.path("status.json")));
  folder.write("status.json", "{\"files\": 3}");
  EXPECT_FALSE(add_to_status(folder.path(), "report.html", "<b>", "<e>"));
}

}  // namespace
}  // namespace rali::drive
