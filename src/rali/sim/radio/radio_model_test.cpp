#include "rali/sim/radio/radio_model.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "rali/sim/radio/places_for_test.hpp"

namespace rali::sim {
namespace {

constexpr Time kStart = kTestStart;

TEST(RadioModel, mean_power_follows_path_loss_and_wall_attenuation) {
  RadioOptions o = RadioOptions::ideal();
  const RadioModel model(o, 1);
  const RadioEnd a = end_at(0, {0, 0, 1});
  EXPECT_NEAR(model.mean_power_dbm(a, end_at(1, {1, 0, 1}), open_air()), -30.0, 1e-9);
  EXPECT_NEAR(model.mean_power_dbm(a, end_at(1, {10, 0, 1}), open_air()), -52.0, 1e-9);
  // One wall of 0.2 m: 3 + 0.2 * 15 = 6 dB.
  EXPECT_NEAR(model.mean_power_dbm(a, end_at(1, {10, 0, 1}), one_wall()), -58.0, 1e-3);
}

TEST(RadioModel, readings_have_the_combined_sigma_of_fading_and_noise) {
  RadioOptions o = RadioOptions::ideal();
  o.fading_db = 3.0;
  o.power_noise_db = 4.0;
  RadioModel model(o, 1);
  const RayCaster air = open_air();
  std::vector<double> readings;
  for (int i = 0; i < 5000; ++i) {
    const auto s = model.measure(at_s(20.0 * i), end_at(0, {0, 0, 1}), end_at(1, {10, 0, 1}), air);
    ASSERT_TRUE(s.has_value());
    readings.push_back(s->rssi_dbm);
  }
  EXPECT_NEAR(moments(readings).mean, -52.0, 0.3);
  EXPECT_NEAR(moments(readings).sd, 5.0, 0.25);
}

TEST(RadioModel, packets_of_one_link_are_serialised_at_the_data_rate) {
  RadioOptions o = RadioOptions::ideal();
  o.data_rate_bps = 1e6;
  o.delay_s = 0.01;
  RadioModel model(o, 1);
  const RadioEnd a = end_at(0, {0, 0, 1});
  const RadioEnd b = end_at(1, {10, 0, 1});
  const RayCaster air = open_air();
  // 12500 bytes take 100 ms on this link.
  const auto first = model.send(kStart, 12500, a, b, air);
  const auto second = model.send(kStart, 12500, a, b, air);
  const auto other_path = model.send(kStart, 12500, b, a, air);
  ASSERT_TRUE(first && second && other_path);
  EXPECT_NEAR(seconds_between(kStart, *first), 0.11, 1e-9);
  EXPECT_NEAR(seconds_between(kStart, *second), 0.21, 1e-9);
  EXPECT_NEAR(seconds_between(kStart, *other_path), 0.11, 1e-9);
  EXPECT_TRUE(model.send(kStart, 300000, a, b, air));  // 2.4 s on the air
  EXPECT_FALSE(model.send(kStart, 1, a, b, air));      // would wait longer than 2 s
  EXPECT_TRUE(model.send(at_s(1.0), 1, a, b, air));
}

TEST(RadioModel, packet_loss_and_delay_have_the_set_fraction_and_mean) {
  RadioOptions o = RadioOptions::ideal();
  o.loss_fraction = 0.2;
  o.delay_jitter_s = 0.02;
  o.data_rate_bps = 1e12;
  RadioModel model(o, 5);
  const RayCaster air = open_air();
  std::vector<double> delays;
  for (int i = 0; i < 10000; ++i) {
    const Time t = at_s(0.1 * i);
    const auto arrival = model.send(t, 10, end_at(0, {0, 0, 1}), end_at(1, {5, 0, 1}), air);
    if (arrival) delays.push_back(seconds_between(t, *arrival));
  }
  EXPECT_NEAR(static_cast<double>(delays.size()) / 10000.0, 0.8, 0.015);
  EXPECT_NEAR(moments(delays).mean, 0.02, 0.001);
}

TEST(RadioModel, nothing_is_received_out_of_radio_range) {
  RadioModel model(RadioOptions{}, 1);
  const RadioEnd a = end_at(0, {0, 0, 1});
  const RadioEnd b = end_at(1, {9000, 0, 1});
  EXPECT_FALSE(model.measure(kStart, a, b, open_air()));
  EXPECT_FALSE(model.send(kStart, 10, a, b, open_air()));
}

}  // namespace
}  // namespace rali::sim
