#include "rali/net/fleet_key.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "rali/base/test_folder.hpp"

namespace rali::net {
namespace {

namespace fs = std::filesystem;

const std::string kText = "000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F";

TEST(FleetKey, is_64_hexadecimal_digits_with_optional_surrounding_whitespace) {
  const auto key = parse_fleet_key(" " + kText + "\r\n", "here");
  ASSERT_TRUE(key) << key.error().message();
  for (std::size_t i = 0; i < 32; ++i) EXPECT_EQ(key->bytes[i], i);
}

TEST(FleetKey, invalid_texts_are_refused) {
  for (const std::string& text :
       {std::string(), std::string("key"), kText.substr(1), kText + "0", kText + kText,
        kText.substr(0, 32) + " " + kText.substr(32), kText.substr(0, 63) + "g"}) {
    const auto key = parse_fleet_key(text, "fleet.key");
    ASSERT_FALSE(key) << text;
    EXPECT_EQ(key.error().code, ErrorCode::kInput);
    EXPECT_EQ(key.error().where, "fleet.key");
  }
}

TEST(FleetKey, a_created_key_is_read_back_and_never_overwritten) {
  const TestFolder folder;
  const std::string path = folder.path("fleet.key");
  const auto made = create_fleet_key(path);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const auto read = load_fleet_key(path);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->bytes, made->bytes);
  EXPECT_FALSE(create_fleet_key(path));
  const auto other = create_fleet_key(folder.path("other.key"));
  ASSERT_TRUE(other);
  EXPECT_NE(other->bytes, made->bytes);
}

TEST(FleetKey, a_file_accessible_to_other_users_is_refused) {
  const TestFolder folder;
  const std::string path = folder.path("fleet.key");
  std::ofstream(path) << kText;
  for (const fs::perms more : {fs::perms::group_read, fs::perms::others_read,
                               fs::perms::group_write, fs::perms::others_write}) {
    fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write | more);
    const auto key = load_fleet_key(path);
    ASSERT_FALSE(key);
    EXPECT_NE(key.error().remedy.find("chmod 600"), std::string::npos);
  }
  fs::permissions(path, fs::perms::owner_read);
  EXPECT_TRUE(load_fleet_key(path));
}

TEST(FleetKey, missing_and_non_regular_files_are_refused) {
  const TestFolder folder;
  EXPECT_FALSE(load_fleet_key(folder.path("none")));
  EXPECT_FALSE(load_fleet_key(folder.path("")));
  EXPECT_FALSE(load_fleet_key("/dev/zero"));
}

}  // namespace
}  // namespace rali::net
