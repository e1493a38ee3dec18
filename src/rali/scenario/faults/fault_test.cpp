#include <cmath>

#include <gtest/gtest.h>

#include "rali/scenario/faults/fault_filter.hpp"

namespace rali::scenario {
namespace {

using sim::FleetMessage;

constexpr Time kStart = Time::from_ns(1'700'000'000'000'000'000);

Time at_s(double t_s) { return kStart + Duration::from_s(t_s); }

FleetMessage imu_at(int vehicle, double t_s) {
  sensor::ImuSample imu;
  imu.t = at_s(t_s);
  imu.gyro_radps = {0.1, -2.0, 0.2};
  imu.accel_mps2 = {0.5, -20.0, 9.81};
  return {vehicle, imu};
}

FleetMessage scan_at(int vehicle, double t_s) {
  auto scan = std::make_shared<sensor::LidarScan>();
  scan->t_start = at_s(t_s);
  scan->t_end = at_s(t_s + 0.1);
  scan->has_point_times = true;
  for (int i = 0; i < 900; ++i) {
    scan->push_back(1.0F, 2.0F, 3.0F, 10.0F, 1e-4F * static_cast<float>(i), 3);
  }
  return {vehicle, std::shared_ptr<const sensor::LidarScan>(scan)};
}

FleetMessage range_at(int from, int to, double t_s) {
  sensor::RangeSample range;
  range.t = at_s(t_s);
  range.from = VehicleId{static_cast<std::uint16_t>(from)};
  range.to = VehicleId{static_cast<std::uint16_t>(to)};
  range.range_m = 7.0;
  return {from, range};
}

FleetMessage radio_at(int from, int to, double t_s) {
  sensor::RadioSample radio;
  radio.t = at_s(t_s);
  radio.from = VehicleId{static_cast<std::uint16_t>(from)};
  radio.to = VehicleId{static_cast<std::uint16_t>(to)};
  return {to, radio};
}

FaultFilter filter(const std::string& text) {
  const auto faults = parse_fault(text, 3);
  EXPECT_TRUE(faults.has_value());
  return FaultFilter(faults.value_or(std::vector<Fault>{}), kStart, 1);
}

const sensor::ImuSample& imu_of(const std::optional<FleetMessage>& m) {
  return std::get<sensor::ImuSample>(m->data);
}

const sensor::LidarScan& scan_of(const std::optional<FleetMessage>& m) {
  return *std::get<std::shared_ptr<const sensor::LidarScan>>(m->data);
}

std::string error_of(const std::string& text) {
  const auto faults = parse_fault(text, 2);
  return faults ? "" : faults.error().message();
}

TEST(Fault, every_kind_is_read_and_written_back) {
  for (const std::string_view name : kFaultNames) {
    const std::string text = std::string(name) + (name == "cut_file" ? ":v2@10.5" : ":v2@10.5-20");
    const auto faults = parse_fault(text, 2);
    ASSERT_TRUE(faults.has_value()) << text;
    ASSERT_EQ(faults->size(), 1U);
    EXPECT_EQ(faults->front().vehicle, 1);
    EXPECT_EQ(faults->front().t0_s, 10.5);
    EXPECT_EQ(fault_text(faults->front()), text);
  }
  EXPECT_EQ(parse_fault("gap:all@1-2", 3)->size(), 3U);
}

TEST(Fault, invalid_text_is_refused_with_a_reason) {
  EXPECT_EQ(
      error_of("gapp:v1@1-2"),
      "--fault 'gapp:v1@1-2': 'gapp' is no kind of fault. Did you mean 'gap'? Kinds: drop, gap, "
      "clock_jump, nan, cover, time_field, imu_scale, imu_saturate, uwb_bias, uwb_off, radio_loss, "
      "cut_file.");
  EXPECT_EQ(error_of("gap:v3@1-2"),
            "--fault 'gap:v3@1-2': 'v3' is no vehicle. Vehicles: v1, v2, all.");
  EXPECT_EQ(error_of("gap:v1@5-2"),
            "--fault 'gap:v1@5-2': the fault ends before it begins. Give T0 < T1.");
  EXPECT_EQ(error_of("gap"),
            "--fault 'gap': a fault has a kind, a vehicle and a span of time. Write "
            "KIND:VEHICLE@T0-T1, e.g. --fault gap:v1@30-35.");
  for (const char* rubbish :
       {"", ":", "@", ":@", "@:", "gap:v1@", "gap:v1@-", "gap:v1@3", "gap:@1-2", "gap:v1@a-b",
        "gap:v1@1-nan", "gap:v1@-5-2", "gap:v1@1-1e9", "gap:v1@1-2-3", "gap:v1@inf-inf",
        "gap:v0@1-2", "GAP:v1@1-2"}) {
    EXPECT_FALSE(error_of(rubbish).empty()) << rubbish;
  }
}

TEST(FaultFilter, passes_messages_outside_its_vehicle_time_and_sensor) {
  FaultFilter gap = filter("gap:v1@10-20");
  EXPECT_TRUE(gap.apply(imu_at(0, 9.999)));
  EXPECT_TRUE(gap.apply(imu_at(0, 20.0)));
  EXPECT_TRUE(gap.apply(imu_at(1, 15.0)));
  EXPECT_TRUE(gap.apply(range_at(0, 1, 15.0)));
  EXPECT_TRUE(gap.apply(radio_at(0, 1, 15.0)));
  FaultFilter none({}, kStart, 1);
  EXPECT_EQ(imu_of(none.apply(imu_at(0, 1.0))).gyro_radps.y(), -2.0);
}

TEST(FaultFilter, gap_drops_all_lidar_and_imu_messages) {
  FaultFilter gap = filter("gap:v1@10-20");
  EXPECT_FALSE(gap.apply(imu_at(0, 10.0)));
  EXPECT_FALSE(gap.apply(scan_at(0, 19.9)));
}

TEST(FaultFilter, drop_removes_half_of_the_messages) {
  FaultFilter drop = filter("drop:v1@0-100");
  int kept = 0;
  for (int i = 0; i < 10000; ++i) kept += drop.apply(imu_at(0, 0.01 * i)) ? 1 : 0;
  EXPECT_NEAR(kept / 10000.0, 0.5, 0.02);
}

TEST(FaultFilter, clock_jump_shifts_all_stamps_of_the_vehicle_by_1_s) {
  FaultFilter jump = filter("clock_jump:v1@10-20");
  EXPECT_EQ(imu_of(jump.apply(imu_at(0, 15.0))).t, at_s(16.0));
  const auto scan = jump.apply(scan_at(0, 15.0));
  EXPECT_EQ(scan_of(scan).t_start, at_s(16.0));
  EXPECT_EQ(scan_of(scan).t_end, at_s(16.1));
  const auto own = jump.apply(range_at(0, 1, 15.0));
  EXPECT_EQ(std::get<sensor::RangeSample>(own->data).t, at_s(16.0));
  const auto of_other = jump.apply(range_at(1, 0, 15.0));
  EXPECT_EQ(std::get<sensor::RangeSample>(of_other->data).t, at_s(15.0));
  EXPECT_EQ(imu_of(jump.apply(imu_at(0, 19.5))).t, at_s(20.5));
  EXPECT_EQ(imu_of(jump.apply(imu_at(0, 20.0))).t, at_s(20.0));
}

TEST(FaultFilter, nan_replaces_a_third_of_the_points) {
  FaultFilter nan = filter("nan:v1@0-10");
  const auto spoilt = nan.apply(scan_at(0, 1.0));
  int bad = 0;
  for (const float x : scan_of(spoilt).x_m) bad += std::isnan(x) ? 1 : 0;
  EXPECT_NEAR(bad / 900.0, 1.0 / 3.0, 0.06);
  EXPECT_EQ(scan_of(spoilt).size(), 900U);
}

TEST(FaultFilter, cover_ends_most_rays_within_a_metre_and_lengthens_none) {
  FaultFilter cover = filter("cover:v1@0-10");
  const auto clear = scan_at(0, 1.0);
  const auto spoilt = cover.apply(scan_at(0, 1.0));
  const auto range_m = [](const sensor::LidarScan& scan, std::size_t i) {
    return Eigen::Vector3f(scan.x_m[i], scan.y_m[i], scan.z_m[i]).norm();
  };
  int near = 0;
  for (std::size_t i = 0; i < scan_of(spoilt).size(); ++i) {
    const float now_m = range_m(scan_of(spoilt), i);
    EXPECT_LE(now_m, 1.0001F * range_m(scan_of(clear), i));
    EXPECT_GT(now_m, std::min(0.399F, 0.999F * range_m(scan_of(clear), i)));
    near += now_m < 1.0F ? 1 : 0;
  }
  EXPECT_GT(near / 900.0, 0.7);
}

TEST(FaultFilter, time_field_makes_all_point_times_zero) {
  FaultFilter zero = filter("time_field:v1@0-10");
  const auto spoilt = zero.apply(scan_at(0, 1.0));
  for (const float dt : scan_of(spoilt).dt_s) EXPECT_EQ(dt, 0.0F);
  EXPECT_EQ(scan_of(spoilt).t_start, at_s(1.0));
}

TEST(FaultFilter, imu_scale_is_5_percent_and_saturation_clamps_each_axis) {
  FaultFilter scale = filter("imu_scale:v1@0-10");
  EXPECT_NEAR(imu_of(scale.apply(imu_at(0, 1.0))).accel_mps2.z(), 9.81 * 1.05, 1e-12);
  FaultFilter cut = filter("imu_saturate:v1@0-10");
  const auto spoilt = cut.apply(imu_at(0, 1.0));
  EXPECT_EQ(imu_of(spoilt).gyro_radps.y(), -0.3);
  EXPECT_EQ(imu_of(spoilt).gyro_radps.x(), 0.1);
  EXPECT_EQ(imu_of(spoilt).accel_mps2.y(), -11.0);
  EXPECT_EQ(imu_of(spoilt).accel_mps2.z(), 9.81);
}

TEST(FaultFilter, uwb_faults_apply_to_both_ends_of_a_range) {
  FaultFilter bias = filter("uwb_bias:v2@0-10");
  EXPECT_EQ(std::get<sensor::RangeSample>(bias.apply(range_at(0, 1, 1.0))->data).range_m, 7.5);
  EXPECT_EQ(std::get<sensor::RangeSample>(bias.apply(range_at(1, 2, 1.0))->data).range_m, 7.5);
  EXPECT_EQ(std::get<sensor::RangeSample>(bias.apply(range_at(0, 2, 1.0))->data).range_m, 7.0);
  FaultFilter off = filter("uwb_off:v2@0-10");
  EXPECT_FALSE(off.apply(range_at(0, 1, 1.0)));
  EXPECT_FALSE(off.apply(range_at(1, 0, 1.0)));
  EXPECT_TRUE(off.apply(range_at(0, 2, 1.0)));
  EXPECT_TRUE(off.apply(radio_at(0, 1, 1.0)));
}

TEST(FaultFilter, radio_loss_disables_the_radio_link_of_a_vehicle) {
  FaultFilter loss = filter("radio_loss:v2@5-10");
  EXPECT_FALSE(loss.apply(radio_at(0, 1, 6.0)));
  EXPECT_TRUE(loss.apply(radio_at(0, 2, 6.0)));
  EXPECT_TRUE(loss.apply(range_at(0, 1, 6.0)));
  EXPECT_TRUE(loss.apply(radio_at(0, 1, 4.0)));
}

TEST(FaultFilter, cut_file_gives_the_cut_time_and_passes_messages) {
  FaultFilter cut = filter("cut_file:v2@30");
  EXPECT_EQ(cut.cut_at(1), at_s(30.0));
  EXPECT_FALSE(cut.cut_at(0).has_value());
  EXPECT_TRUE(cut.apply(imu_at(1, 40.0)));
}

TEST(FaultFilter, same_seed_gives_same_losses_independent_of_other_faults) {
  const auto lost = [](const std::string& other) {
    auto faults = *parse_fault("drop:v1@0-100", 2);
    if (!other.empty()) faults.push_back(parse_fault(other, 2)->front());
    FaultFilter f(faults, kStart, 5);
    std::vector<bool> kept;
    for (int i = 0; i < 200; ++i) kept.push_back(f.apply(imu_at(0, 0.1 * i)).has_value());
    return kept;
  };
  EXPECT_EQ(lost(""), lost("drop:v2@0-100"));
}

}  // namespace
}  // namespace rali::scenario
