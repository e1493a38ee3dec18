#include "rali/io/files/imu_csv.hpp"

#include <sstream>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

TEST(ImuCsv, reads_columns_in_any_order_to_gyro_and_accelerometer) {
  auto imu = ImuCsvReader::from_text(
      "ax,ay,az,temperature,gx,gy,gz,stamp_s\n1,2,3,40,4,5,6,1630577758.000000001\n", "imu.csv");
  ASSERT_TRUE(imu) << imu.error().message();
  sensor::ImuSample sample;
  ASSERT_TRUE(imu->next(sample).value());
  EXPECT_EQ(sample.t.ns, 1630577758000000001);
  EXPECT_EQ(sample.gyro_radps, geometry::Vec3(4, 5, 6));
  EXPECT_EQ(sample.accel_mps2, geometry::Vec3(1, 2, 3));
  EXPECT_FALSE(imu->next(sample).value());
  EXPECT_TRUE(imu->findings().empty());
}

TEST(ImuCsv, skips_and_counts_invalid_rows) {
  auto imu = ImuCsvReader::from_text(
      "stamp_s,gx,gy,gz,ax,ay,az\n"
      "1,0,0,0,0,0,9\n"
      "2,nan,0,0,0,0,9\n"
      "3,0,0,0,0,,9\n"
      "4,0,0,0,0,zero,9\n"
      "5,0,0,0\n"
      "0.5,0,0,0,0,0,9\n"
      "0.5,0,0,0,0,0,9\n"
      "nan,0,0,0,0,0,9\n"
      "6,inf,0,0,0,0,9",
      "imu.csv");
  ASSERT_TRUE(imu);
  sensor::ImuSample sample;
  int samples = 0;
  while (imu->next(sample).value()) ++samples;
  EXPECT_EQ(samples, 3);
  EXPECT_EQ(imu->stats().rows, 9U);
  EXPECT_EQ(imu->stats().nan_rows, 4U);
  EXPECT_EQ(imu->stats().bad_rows, 2U);
  EXPECT_EQ(imu->stats().back_rows, 2U);
  const FindingList findings = imu->findings();
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_EQ(findings[0].text, "imu.csv:5: not seven numbers; 2 of 9 rows left out");
  EXPECT_EQ(findings[1].text, "imu.csv:3: a value is not known; 4 of 9 rows left out");
  EXPECT_EQ(findings[2].text,
            "imu.csv:7: time does not advance in 2 of 9 rows, at worst 0.500000 s back");
}

TEST(ImuCsv, names_a_missing_column) {
  const auto imu = ImuCsvReader::from_text("stamp_s,gx,gy,gz,ax,ay\n", "imu.csv");
  ASSERT_FALSE(imu);
  EXPECT_NE(imu.error().what.find("has no column 'az'"), std::string::npos);
}

TEST(ImuCsv, reads_real_inertial_data_after_a_header_is_added) {
  RALI_NEEDS_DATA("lio_samples/continuous/imu.txt");
  std::ifstream file(real_data("lio_samples/continuous/imu.txt"));
  std::string table = "stamp_s,ax,ay,az,gx,gy,gz\n";
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string joined;
    for (std::string word; words >> word;) joined += (joined.empty() ? "" : ",") + word;
    table += joined + "\n";
  }
  auto imu = ImuCsvReader::from_text(std::move(table), "imu.csv");
  ASSERT_TRUE(imu);
  sensor::ImuSample sample;
  while (imu->next(sample).value()) ASSERT_LT(sample.gyro_radps.norm(), 5.0);
  EXPECT_EQ(imu->stats().used, 23739U);
  EXPECT_TRUE(imu->findings().empty());
}

}  // namespace
}  // namespace rali::io
