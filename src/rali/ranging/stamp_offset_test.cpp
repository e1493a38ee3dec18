#include "rali/ranging/stamp_offset.hpp"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::ranging {
namespace {

using geometry::Vec3;
using Path = std::function<Vec3(double)>;

std::vector<TrackPoint> track_of(const Path& path, double end_s, double speed_sigma_mps = 0.0) {
  std::vector<TrackPoint> track;
  for (int k = 0; 0.1 * k < end_s; ++k)
    track.push_back({Time::from_s(0.1 * k), path(0.1 * k), 0, speed_sigma_mps});
  return track;
}

/// Ranges at 20 Hz to a peer that stands, stamped `offset_s` ahead of the track's clock.
std::vector<TimedRange> ranges_to(const Vec3& peer, const Path& path, double offset_s,
                                  double begin_s, double end_s, double obstructed = 0.05) {
  Rng rng(7, "ranges");
  std::vector<TimedRange> ranges;
  for (double t_s = begin_s; t_s < end_s; t_s += 0.05) {
    double range_m = (path(t_s) - peer).norm() + 0.2 + 0.08 * rng.normal();
    if (rng.uniform() < obstructed) range_m += 3.0;
    ranges.push_back({Time::from_s(t_s + offset_s), range_m});
  }
  return ranges;
}

/// To and fro past the peer, at 1 to 2 m/s.
Vec3 past_the_peer(double t_s) {
  return {10.0 - 10.0 * std::cos(0.15 * t_s), 1.5 * std::sin(0.3 * t_s), 0.0};
}

/// Straight ahead: stands for 8 s, then 1 m/s, stops after 20 m.
Vec3 down_a_tunnel(double t_s) {
  const double ramp_s = std::clamp(t_s - 8.0, 0.0, 2.0),
               cruise_s = std::clamp(t_s - 10.0, 0.0, 20.0);
  const double brake_s = std::clamp(t_s - 30.0, 0.0, 2.0);
  return {0.25 * ramp_s * ramp_s + cruise_s + brake_s - 0.25 * brake_s * brake_s, 0.0, 0.0};
}

TEST(StampOffset, is_that_for_which_the_ranges_fit_the_motion) {
  const auto track = track_of(past_the_peer, 60.0);
  for (const double offset_s : {0.0, -2.6, 3.37}) {
    const StandWindow window{track, ranges_to({8.0, 6.0, 0.4}, past_the_peer, offset_s, 0.0, 60.0)};
    const auto found = find_stamp_offset({&window, 1}, 4.0);
    ASSERT_TRUE(found) << offset_s;
    EXPECT_NEAR(found->value_s, offset_s, 0.02);
    EXPECT_NEAR(found->value_s, offset_s, 4.0 * found->sigma_s);
    EXPECT_LT(found->sigma_s, 0.03);
  }
}

TEST(StampOffset, is_determined_by_start_and_stop_where_the_speed_along_a_tunnel_drifts) {
  // By inertial data alone: the accelerometer's bias is off by 0.02 m/s^2 from the start on.
  const Path drifting = [](double t_s) {
    const double blind_s = std::max(0.0, t_s - 8.0);
    return Vec3(down_a_tunnel(t_s) + Vec3(0.01 * blind_s * blind_s, 0.0, 0.0));
  };
  const auto track = track_of(drifting, 45.0, 1.0);
  std::vector<StandWindow> windows;
  for (const double begin_s : {3.0, 13.0, 23.0}) {
    windows.push_back(
        {track, ranges_to({-3.0, 1.0, 0.0}, down_a_tunnel, 0.5, begin_s, begin_s + 12.0)});
  }
  const auto found = find_stamp_offset(windows, 2.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value_s, 0.5, 0.05);
  EXPECT_NEAR(found->value_s, 0.5, 3.0 * found->sigma_s);
}

TEST(StampOffset, is_not_known_at_constant_speed_straight_away_from_the_peer) {
  const Path path = [](double t_s) { return Vec3(t_s, 0.0, 0.0); };
  const auto track = track_of(path, 60.0);
  const StandWindow window{track, ranges_to({-3.0, 0.0, 0.0}, path, 0.5, 0.0, 60.0)};
  const auto found = find_stamp_offset({&window, 1}, 5.0);
  EXPECT_TRUE(!found || found->sigma_s > 0.1) << "earlier along the line is the same as nearer";
}

TEST(StampOffset, is_not_known_between_vehicles_that_stand) {
  const Path path = [](double) { return Vec3(1.0, 0.0, 0.0); };
  const auto track = track_of(path, 60.0);
  const StandWindow window{track, ranges_to({-3.0, 0.0, 0.0}, path, 0.0, 0.0, 60.0)};
  const auto found = find_stamp_offset({&window, 1}, 5.0);
  EXPECT_TRUE(!found || found->sigma_s > 0.1);
}

TEST(StampOffset, is_not_known_where_another_one_fits_as_well) {
  const Path to_and_fro = [](double t_s) {
    return Vec3(4.0 * std::sin(M_PI * t_s / 4.0), 0.0, 0.0);
  };
  const auto track = track_of(to_and_fro, 100.0);
  const StandWindow window{track, ranges_to({-9.0, 3.0, 0.0}, to_and_fro, 0.5, 20.0, 60.0)};
  NoOffset why = NoOffset::kTooLittle;
  EXPECT_FALSE(find_stamp_offset({&window, 1}, 12.0, &why));
  EXPECT_EQ(why, NoOffset::kSeveral) << "the motion repeats every 8 s";
}

TEST(StampOffset, beyond_the_search_or_without_enough_ranges_is_none) {
  const auto track = track_of(past_the_peer, 60.0);
  const StandWindow few{track, ranges_to({8.0, 6.0, 0.4}, past_the_peer, 0.0, 20.0, 21.5)};
  NoOffset why = NoOffset::kBeyond;
  EXPECT_FALSE(find_stamp_offset({&few, 1}, 5.0, &why));
  EXPECT_EQ(why, NoOffset::kTooLittle);
  EXPECT_FALSE(find_stamp_offset({}, 5.0, &why));
  const StandWindow empty;
  EXPECT_FALSE(find_stamp_offset({&empty, 1}, 5.0, &why));
}

TEST(StampOffset, of_several_windows_states_what_they_disagree_by) {
  const auto track = track_of(past_the_peer, 80.0);
  std::vector<StandWindow> windows;
  for (int k = 0; k < 4; ++k) {  // the peer's clock wanders by 60 ms from window to window
    const double offset_s = 0.3 + (k % 2 == 0 ? 0.06 : -0.06);
    windows.push_back({track, ranges_to({8.0, 6.0, 0.4}, past_the_peer, offset_s, 5.0 + 18.0 * k,
                                        21.0 + 18.0 * k)});
  }
  const auto found = find_stamp_offset(windows, 2.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->value_s, 0.3, 0.05);
  EXPECT_GT(found->sigma_s, 0.02);
}

TEST(PeerFit, finds_antenna_and_bias_by_hand) {
  // On a circle around the peer all ranges are its radius.
  const Path circle = [](double t_s) {
    return Vec3(5.0 * std::cos(0.2 * t_s), 5.0 * std::sin(0.2 * t_s), 0.0);
  };
  const auto track = track_of(circle, 40.0);
  std::vector<TimedRange> ranges;
  for (double t_s = 1.0; t_s < 39.0; t_s += 0.5) ranges.push_back({Time::from_s(t_s), 5.0});
  PeerFit fit(track, ranges, 0.0);
  ASSERT_TRUE(fit.solve());
  EXPECT_LT(fit.state().head<3>().norm(), 0.02) << "the centre";
  EXPECT_NEAR(fit.state()[3], 0.0, 0.02) << "no bias";
  EXPECT_LT(fit.rms_m(), 0.01);
  EXPECT_LT(fit.cost(), 0.2);
}

TEST(PeerFit, does_not_join_a_track_over_a_gap_or_a_loss) {
  std::vector<TrackPoint> track{{Time::from_s(0.0), Vec3::Zero(), 0},
                                {Time::from_s(0.1), Vec3::UnitX(), 0},
                                {Time::from_s(0.2), Vec3::Zero(), 1},
                                {Time::from_s(2.0), Vec3::Zero(), 1}};
  EXPECT_NEAR(point_at(track, Time::from_s(0.05))->p_odom_m.x(), 0.5, 1e-12);
  EXPECT_FALSE(point_at(track, Time::from_s(0.15))) << "another piece";
  EXPECT_FALSE(point_at(track, Time::from_s(1.0))) << "1.8 s without a scan";
  EXPECT_FALSE(point_at(track, Time::from_s(3.0)));
  EXPECT_FALSE(point_at({}, Time::from_s(0.0)));
}

}  // namespace
}  // namespace rali::ranging
