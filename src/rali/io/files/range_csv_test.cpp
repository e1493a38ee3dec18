#include "rali/io/files/range_csv.hpp"

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::io {
namespace {

RadioNames two_vehicles() {
  return {{"v1", {VehicleId{0}, 0}}, {"v2", {VehicleId{1}, 0}}, {"v2/rear", {VehicleId{1}, 1}}};
}

TEST(RangeCsv, reads_all_columns) {
  const auto csv = parse_ranges_csv(
      "to,from,range_m,stamp_s,sigma_m,rssi_dbm,first_path_dbm,from_antenna,to_antenna\n"
      "v2,v1,12.5,100.000000001,0.2,-80,-85,3,rear\n"
      "v2/rear,v1,13,101,,,,,\n",
      "ranges.csv", two_vehicles());
  ASSERT_TRUE(csv) << csv.error().message();
  ASSERT_EQ(csv->samples.size(), 2U);
  const sensor::RangeSample& a = csv->samples[0];
  EXPECT_EQ(a.t.ns, 100000000001);
  EXPECT_EQ(a.from, VehicleId{0});
  EXPECT_EQ(a.to, VehicleId{1});
  EXPECT_EQ(a.from_antenna, 3);
  EXPECT_EQ(a.to_antenna, 1);
  EXPECT_EQ(a.range_m, 12.5);
  EXPECT_EQ(a.sigma_m, 0.2);
  EXPECT_EQ(a.rssi_dbm, -80.0);
  EXPECT_EQ(a.first_path_dbm, -85.0);
  EXPECT_EQ(csv->samples[1].to_antenna, 1);
  EXPECT_EQ(csv->samples[1].sigma_m, 0.0);
  EXPECT_EQ(csv->samples[1].rssi_dbm, 0.0);
  EXPECT_TRUE(csv->findings.empty());
}

TEST(RangeCsv, unknown_radios_are_counted_with_their_first_line) {
  const auto csv = parse_ranges_csv(
      "stamp_s,from,to,range_m,room\n1,v7,v1,2,a\n2,v1,v7,2,a\n3,v1,v2,2,a\n4,v1,v1,2,a\n"
      "5,v1,v2,far,a\n6,v1,v2\n7,v1,v2,nan,a\n",
      "ranges.csv", two_vehicles());
  ASSERT_TRUE(csv) << csv.error().message();
  EXPECT_EQ(csv->samples.size(), 1U);
  EXPECT_EQ(csv->stats.rows, 7U);
  EXPECT_EQ(csv->stats.unknown_rows, 2U);
  EXPECT_EQ(csv->stats.bad_rows, 3U);
  EXPECT_EQ(csv->stats.self_rows, 1U);
  ASSERT_EQ(csv->findings.size(), 4U);
  EXPECT_EQ(csv->findings[0].text,
            "ranges.csv:2: 'v7' is no vehicle (v1, v2, v2/rear); 2 of 7 rows skipped");
  EXPECT_EQ(csv->findings[1].text, "ranges.csv:6: 'far' is no finite number; 3 of 7 rows skipped");
  EXPECT_EQ(csv->findings[2].text, "ranges.csv: 1 of 7 rows link a vehicle with itself; skipped");
  EXPECT_EQ(csv->findings[3].text, "ranges.csv: columns not used: 'room'");
}

TEST(RangeCsv, without_any_valid_row_is_an_error) {
  const auto csv =
      parse_ranges_csv("stamp_s,from,to,range_m\n1,a,b,2\n", "ranges.csv", two_vehicles());
  ASSERT_FALSE(csv);
  EXPECT_EQ(csv.error().code, ErrorCode::kInput);
  EXPECT_NE(csv.error().message().find("has no row that fits"), std::string::npos);
  EXPECT_NE(csv.error().message().find("must name vehicles: v1, v2"), std::string::npos);
  const auto none = parse_ranges_csv("stamp_s,from,to,range_m\n", "ranges.csv", two_vehicles());
  EXPECT_EQ(none.error().what, "has no rows");
  const auto column = parse_ranges_csv("stamp_s,from,to\n", "ranges.csv", two_vehicles());
  EXPECT_NE(column.error().what.find("has no column 'range_m'"), std::string::npos);
}

TEST(RangeCsv, the_number_of_stored_unknown_names_is_limited) {
  std::string text = "stamp_s,from,to,range_m\n0,v1,v2,3\n";
  for (int i = 0; i < 1000; ++i) text += "1,w" + std::to_string(i) + ",v1,2\n";
  const auto csv = parse_ranges_csv(text, "ranges.csv", two_vehicles());
  ASSERT_TRUE(csv);
  EXPECT_EQ(csv->stats.unknown_rows, 1000U);
  EXPECT_EQ(csv->stats.unknown.size(), 100U);
}

TEST(RadioCsv, reads_signal_strengths) {
  const auto csv =
      parse_radio_csv("stamp_s,from,to,rssi_dbm\n5.5,v2,v1,-71.5\n", "radio.csv", two_vehicles());
  ASSERT_TRUE(csv) << csv.error().message();
  ASSERT_EQ(csv->samples.size(), 1U);
  EXPECT_EQ(csv->samples[0].from, VehicleId{1});
  EXPECT_EQ(csv->samples[0].to, VehicleId{0});
  EXPECT_EQ(csv->samples[0].rssi_dbm, -71.5);
  EXPECT_EQ(csv->samples[0].t, Time::from_s(5.5));
}

}  // namespace
}  // namespace rali::io
