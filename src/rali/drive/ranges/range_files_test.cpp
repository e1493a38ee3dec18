#include "rali/drive/ranges/range_files.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

using ranging::RangeReason;

RangeOptions two_vehicles() {
  RangeOptions options;
  options.names = {
      {"v1", {VehicleId{0}, 0}}, {"v1/rear", {VehicleId{0}, 1}}, {"v2", {VehicleId{1}, 0}}};
  options.antennas = {2, 1};
  return options;
}

TEST(RangeFiles, sorts_rows_of_all_files_by_time_minus_latency) {
  const io::TestFolder folder;
  RangeOptions options = two_vehicles();
  options.files = {{folder.write("a.csv", "stamp_s,from,to,range_m\n3,v1,v2,5\n1,v2,v1,4\n"), {}},
                   {folder.write("b.csv",
                                 "to,stamp_s,range_m,from,from_antenna\n"
                                 "v2,2,6,v1,rear\nv2,1,7,v1,\n"),
                    {}}};
  options.latency_s = 0.25;
  const auto list = read_range_files(options);
  ASSERT_TRUE(list) << list.error().message();
  ASSERT_EQ(list->samples.size(), 4U);
  EXPECT_EQ(list->samples[0].t, Time::from_s(0.75));
  EXPECT_EQ(list->samples[0].range_m, 4.0) << "at one time the first file is first";
  EXPECT_EQ(list->samples[1].range_m, 7.0);
  EXPECT_EQ(list->samples[2].from_antenna, 1);
  EXPECT_EQ(list->samples[3].t, Time::from_s(2.75));
}

TEST(RangeFiles, correct_each_file_by_the_offset_of_the_clock_that_stamped_it) {
  const io::TestFolder folder;
  RangeOptions options = two_vehicles();
  options.files = {{folder.write("a.csv", "stamp_s,from,to,range_m\n3,v1,v2,5\n"), VehicleId{0}},
                   {folder.write("b.csv", "stamp_s,from,to,range_m\n1,v1,v2,6\n"), VehicleId{1}}};
  options.latency_s = 0.5;
  const std::vector<double> clock_offsets_s = {0.0, 10.0};
  const auto list = read_range_files(options, clock_offsets_s);
  ASSERT_TRUE(list);
  ASSERT_EQ(list->samples.size(), 2U);
  EXPECT_EQ(list->samples[0].t, Time::from_s(2.5));
  EXPECT_EQ(list->samples[1].t, Time::from_s(10.5)) << "later than the first, on one clock";
  EXPECT_EQ(list->samples[0].clock, VehicleId{0});
  EXPECT_EQ(list->samples[1].clock, VehicleId{1});
}

TEST(RangeFiles, keeps_rows_of_unknown_vehicles_by_name_with_a_finding) {
  const io::TestFolder folder;
  RangeOptions options = two_vehicles();
  options.files = {
      {folder.write("a.csv",
                    "stamp_s,from,to,range_m\n1,v1,v7,5\n2,v1,v2,5\n3,v8,v7,5\n4,v1,v2/front,5\n"),
       {}}};
  const auto list = read_range_files(options);
  ASSERT_TRUE(list);
  ASSERT_EQ(list->samples.size(), 4U);
  EXPECT_EQ(list->strangers.at(list->samples[0].to.value), "v7");
  EXPECT_EQ(list->strangers.at(list->samples[2].from.value), "v8");
  EXPECT_EQ(list->samples[2].to, list->samples[0].to) << "one name, one number";
  EXPECT_EQ(judge_range(list->samples[0], options), RangeReason::kUnknownId);
  EXPECT_EQ(judge_range(list->samples[1], options), RangeReason::kNoPose);
  EXPECT_FALSE(list->findings.empty());
}

TEST(RangeFiles, refuses_invalid_files_and_skips_invalid_rows) {
  const io::TestFolder folder;
  const auto read = [&](const std::string& text) {
    RangeOptions options = two_vehicles();
    options.files = {{folder.write("x.csv", text), {}}};
    return read_range_files(options);
  };
  for (const char* text : {"", "\n", "stamp_s,from,to\n1,v1,v2\n", "\x00\xff\x7f",
                           "stamp_s,from,to,range_m\n", "stamp_s,from,to,range_m\n1,a,b,3\n"}) {
    const auto list = read(text);
    ASSERT_FALSE(list) << text;
    EXPECT_EQ(list.error().code, ErrorCode::kInput) << text;
  }
  const auto list = read(
      "stamp_s,from,to,range_m\nnan,v1,v2,3\n1,v1,v2,nan\n2,v1,v2,inf\n"
      "3,v1,v1,2\n4,v1\n1e300,v1,v2,4\n5,v1,v2,6\n");
  ASSERT_TRUE(list);
  EXPECT_EQ(list->samples.size(), 1U);
  RangeOptions missing = two_vehicles();
  missing.files = {{folder.path("none.csv"), {}}};
  EXPECT_EQ(read_range_files(missing).error().code, ErrorCode::kInput);
}

TEST(RangeFiles, checks_ranges_against_limits_and_antennas) {
  const RangeOptions options = two_vehicles();
  sensor::RangeSample sample;
  sample.from = VehicleId{0};
  sample.to = VehicleId{1};
  for (const double bad_m : {0.1, 200.1, -5.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    sample.range_m = bad_m;
    EXPECT_EQ(judge_range(sample, options), RangeReason::kOutOfLimits) << bad_m;
  }
  sample.range_m = 10.0;
  EXPECT_EQ(judge_range(sample, options), RangeReason::kNoPose);
  sample.to_antenna = 1;
  EXPECT_EQ(judge_range(sample, options), RangeReason::kUnknownId) << "v2 has one antenna";
}

}  // namespace
}  // namespace rali::drive
