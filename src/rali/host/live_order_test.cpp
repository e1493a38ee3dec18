#include "rali/host/live_order.hpp"

#include <gtest/gtest.h>

namespace rali::host {
namespace {

Time at_ms(double t) { return Time::from_s(100.0 + t * 1e-3); }

sensor::ImuSample imu_at(double t) {
  sensor::ImuSample sample;
  sample.t = at_ms(t);
  return sample;
}

std::shared_ptr<const sensor::LidarScan> scan_at(double t_end) {
  auto scan = std::make_shared<sensor::LidarScan>();
  scan->t_start = at_ms(t_end - 100.0);
  scan->t_end = at_ms(t_end);
  scan->x_m = scan->y_m = scan->z_m = {1.0F};
  return scan;
}

sensor::RangeSample range_at(double t) {
  sensor::RangeSample range;
  range.t = at_ms(t);
  range.to = VehicleId{1};
  range.range_m = 5.0;
  return range;
}

/// "i100 r103 s105": the events passed on, with their times.
std::string words(const std::vector<LiveEvent>& events) {
  std::string text;
  const auto put = [&](char kind, Time t) {
    if (!text.empty()) text += ' ';
    text += kind + std::to_string(std::lround((t - at_ms(0.0)).s() * 1e3));
  };
  for (const LiveEvent& e : events) {
    if (const auto* imu = std::get_if<sensor::ImuSample>(&e.event)) put('i', imu->t);
    if (const auto* range = std::get_if<sensor::RangeSample>(&e.event)) put('r', range->t);
    if (const auto* scan = std::get_if<std::shared_ptr<const sensor::LidarScan>>(&e.event)) {
      put('s', (*scan)->t_end);
    }
  }
  return text;
}

class LiveOrderTest : public testing::Test {
 protected:
  template <class T>
  void arrive(double t_arrival, T event) {
    order_.set_arrival(at_ms(t_arrival));
    order_.push(event);
  }

  std::string take(double now) {
    std::vector<LiveEvent> out;
    order_.take(at_ms(now), out);
    return words(out);
  }

  /// Two scans have passed: the step between them is known.
  void warm_up() {
    for (const double end : {0.0, 100.0}) {
      arrive(end + 5.0, imu_at(end));
      arrive(end + 5.0, scan_at(end));
      take(end + 5.0);
    }
  }

  LiveOrder order_{LiveOrderSettings{}, ranging::ExchangeSettings{}};
};

TEST_F(LiveOrderTest, outputs_a_scan_once_an_inertial_sample_reaches_its_end) {
  warm_up();
  arrive(203.0, scan_at(200.0));
  EXPECT_EQ(take(203.0), "");
  arrive(204.0, imu_at(198.0));
  EXPECT_EQ(take(204.0), "i198");
  arrive(205.0, imu_at(203.0));
  EXPECT_EQ(take(205.0), "s200 i203");
}

TEST_F(LiveOrderTest, inertial_samples_before_the_expected_scan_end_do_not_wait) {
  warm_up();
  arrive(141.0, imu_at(140.0));
  EXPECT_EQ(take(141.0), "i140");
}

TEST_F(LiveOrderTest, inertial_samples_after_the_expected_scan_end_wait_for_the_scan) {
  warm_up();
  arrive(196.0, imu_at(195.0));
  arrive(206.0, imu_at(205.0));
  EXPECT_EQ(take(206.0), "");
  arrive(210.0, scan_at(200.0));
  EXPECT_EQ(take(210.0), "i195 s200 i205");
}

TEST_F(LiveOrderTest, at_equal_times_outputs_inertial_samples_then_ranges_then_scans) {
  warm_up();
  arrive(201.0, scan_at(200.0));
  arrive(202.0, range_at(200.0));
  arrive(203.0, imu_at(200.0));
  arrive(204.0, imu_at(210.0));
  EXPECT_EQ(take(204.0), "i200 r200 s200 i210");
}

TEST_F(LiveOrderTest, waits_at_most_250_ms_for_a_missing_scan) {
  warm_up();
  arrive(196.0, imu_at(195.0));
  EXPECT_EQ(take(196.0 + 249.0), "");
  EXPECT_EQ(take(196.0 + 250.0), "i195");
  EXPECT_EQ(order_.tally().forced, 1U);
}

TEST_F(LiveOrderTest, outputs_a_scan_after_50_ms_without_inertial_samples) {
  warm_up();
  arrive(203.0, scan_at(200.0));
  EXPECT_EQ(order_.due(), at_ms(253.0));
  EXPECT_EQ(take(252.0), "");
  EXPECT_EQ(take(253.0), "s200");
}

TEST_F(LiveOrderTest, drops_and_counts_messages_older_than_the_last_output) {
  warm_up();
  arrive(141.0, imu_at(140.0));
  EXPECT_EQ(take(141.0), "i140");
  arrive(142.0, imu_at(139.0));
  arrive(142.0, scan_at(90.0));
  EXPECT_EQ(take(142.0), "");
  EXPECT_EQ(order_.tally().late_imu, 1U);
  EXPECT_EQ(order_.tally().late_scans, 1U);
}

TEST_F(LiveOrderTest, drops_the_oldest_scans_if_the_queue_is_full) {
  for (int k = 0; k < 10; ++k) arrive(100.0 * k, scan_at(100.0 * k));
  EXPECT_EQ(order_.tally().dropped_scans, 2U);
  arrive(901.0, imu_at(901.0));
  EXPECT_EQ(take(901.0), "s200 s300 s400 s500 s600 s700 s800 s900 i901");
}

}  // namespace
}  // namespace rali::host
