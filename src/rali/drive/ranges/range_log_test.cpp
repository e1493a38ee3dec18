#include "rali/drive/ranges/range_log.hpp"

#include <gtest/gtest.h>

#include "rali/drive/ranges/range_options.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

using ranging::RangeReason;
using ranging::RangeUse;

RangeUse use_of(double t_s, RangeReason reason, double residual_m = 0.0) {
  RangeUse use;
  use.sample.t = Time::from_s(t_s);
  use.sample.from = VehicleId{0};
  use.sample.to = VehicleId{1};
  use.sample.range_m = 10.0;
  use.reason = reason;
  use.residual_m = residual_m;
  return use;
}

const VehicleId kFirst{0}, kSecond{1};

TEST(RangeLog, prefers_the_result_that_used_the_range_then_the_moving_vehicle) {
  RangeLog log({"v1", "v2"});
  for (const double t_s : {1.0, 2.0, 3.0}) {
    log.add_handed(use_of(t_s, RangeReason::kNoPose).sample);
  }
  log.answer(use_of(1.0, RangeReason::kUsed), kFirst, false);
  log.answer(use_of(1.0, RangeReason::kNlos), kSecond, true);
  log.answer(use_of(2.0, RangeReason::kOutlier), kFirst, false);
  log.answer(use_of(2.0, RangeReason::kNlos), kSecond, true);
  const RangeTally tally = log.tally();
  EXPECT_EQ(tally.used(), 1U);
  EXPECT_EQ(tally.by_reason[static_cast<std::size_t>(RangeReason::kNlos)], 1U);
  EXPECT_EQ(tally.by_reason[static_cast<std::size_t>(RangeReason::kNoPose)], 1U) << "no answer";
  EXPECT_EQ(tally.total, 3U);
}

TEST(RangeLog, repeated_rows_get_one_result_each) {
  RangeLog log({"v1", "v2"});
  log.add_handed(use_of(1.0, RangeReason::kNoPose).sample);
  log.add_handed(use_of(1.0, RangeReason::kNoPose).sample);
  log.answer(use_of(1.0, RangeReason::kUsed), kFirst, true);
  log.answer(use_of(1.0, RangeReason::kDuplicate), kFirst, true);
  log.answer(use_of(1.0, RangeReason::kOutlier), kFirst, true);  // one too many
  log.answer(use_of(7.0, RangeReason::kUsed), kFirst, true);     // never passed on
  EXPECT_EQ(log.tally().total, 2U);
  EXPECT_EQ(log.tally().used(), 1U);
  EXPECT_EQ(log.tally().by_reason[static_cast<std::size_t>(RangeReason::kDuplicate)], 1U);
}

TEST(RangeLog, table_is_sorted_by_time_with_empty_cells_for_unknown_values) {
  const io::TestFolder folder;
  RangeLog log({"v1", "v2"});
  log.name_strangers({{unknown_name(0).value, "v7"}});
  RangeUse late = use_of(0.5, RangeReason::kLate);
  log.add_handed(use_of(1.0, RangeReason::kNoPose).sample);
  RangeUse stranger = use_of(0.75, RangeReason::kUnknownId);
  stranger.sample.to = unknown_name(0);
  log.add_refused(stranger.sample, RangeReason::kUnknownId);
  stranger.sample.to = unknown_radio(12);
  log.add_refused(stranger.sample, RangeReason::kUnknownId);
  stranger.sample.to = kNobody;
  log.add_refused(stranger.sample, RangeReason::kUnknownId);
  log.add_refused(late.sample, RangeReason::kLate);
  RangeUse used = use_of(1.0, RangeReason::kUsed, -0.05);
  used.predicted_m = 10.05;
  used.sigma_m = 0.1;
  used.bias_m = 0.02;
  log.answer(used, kFirst, true);
  ASSERT_TRUE(log.write(folder.path("ranges.csv")));
  EXPECT_EQ(folder.read("ranges.csv"),
            "stamp_s,from,to,range_m,predicted_m,residual_m,sigma_m,bias_m,p_los,used,reason\n"
            "0.500000000,v1,v2,10.0000,,,,,,0,late\n"
            "0.750000000,v1,v7,10.0000,,,,,,0,unknown_id\n"
            "0.750000000,v1,12,10.0000,,,,,,0,unknown_id\n"
            "0.750000000,v1,,10.0000,,,,,,0,unknown_id\n"
            "1.000000000,v1,v2,10.0000,10.0500,-0.0500,0.1000,0.0200,,1,used\n");
}

TEST(RangeLog, pairs_have_the_standard_deviation_of_used_residuals_and_the_last_bias) {
  RangeLog log({"v1", "v2"});
  const double residuals_m[] = {0.1, -0.1, 0.3};
  for (int i = 0; i < 3; ++i) {
    RangeUse use = use_of(i, RangeReason::kUsed, residuals_m[i]);
    use.bias_m = 0.01 * i;
    if (i == 1) std::swap(use.sample.from, use.sample.to);
    log.add_handed(use.sample);
    log.answer(use, kFirst, true);
  }
  const RangeTally tally = log.tally();
  ASSERT_EQ(tally.pairs.size(), 1U) << "both directions are one pair";
  EXPECT_EQ(tally.pairs[0].name, "v1-v2");
  EXPECT_NEAR(tally.pairs[0].residual_std_m, 0.2, 1e-12);  // 0.1, -0.1, 0.3 about 0.1
  EXPECT_NEAR(tally.pairs[0].bias_m, 0.02, 1e-12);
}

TEST(RangeTally, returns_the_most_common_reason_of_refusal) {
  RangeTally tally;
  EXPECT_EQ(tally.commonest_refusal(), RangeReason::kUsed) << "none";
  tally.by_reason[0] = 100;
  tally.by_reason[static_cast<std::size_t>(RangeReason::kNlos)] = 3;
  tally.by_reason[static_cast<std::size_t>(RangeReason::kLate)] = 2;
  EXPECT_EQ(tally.commonest_refusal(), RangeReason::kNlos);
}

}  // namespace
}  // namespace rali::drive
