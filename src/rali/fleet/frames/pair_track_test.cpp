#include "rali/fleet/frames/pair_track.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "rali/fleet/frames/track_for_test.hpp"

namespace rali::fleet {
namespace {

using geometry::Vec2;

/// A path along x, past a vehicle that stands 3 m beside x = 100 m.
PairTrack past_a_vehicle(double length_m) {
  const std::vector<Vec2> x = along({{0, 0}, {length_m, 0}}, 0.5);
  std::vector<double> ranges_m;
  for (const Vec2& p : x) ranges_m.push_back(std::hypot(p.x() - 100.0, 3.0));
  InitSettings settings;
  settings.track.spacing_m = 0.4;
  return track_of(x, {{100, 3}}, ranges_m, settings);
}

std::ptrdiff_t nearer_than(double range_m, const PairTrack& track) {
  return std::count_if(track.samples().begin(), track.samples().end(),
                       [&](const RangeObservation& o) { return o.range_m < range_m; });
}

// The last 80 m of a straight path fit on both sides of the vehicle: when older ranges were
// dropped, a frame that was right became undecided, or wrong, later.
TEST(PairTrack, keeps_the_ranges_of_a_passage_however_long_the_path_becomes) {
  const PairTrack shorter = past_a_vehicle(130.0), longer = past_a_vehicle(1000.0);
  const auto limit = static_cast<std::size_t>(TrackSettings{}.samples_max);
  EXPECT_EQ(longer.samples().size(), limit);
  EXPECT_EQ(nearer_than(10.0, shorter), 39) << "each 0.5 m for 19.1 m";
  EXPECT_GT(nearer_than(10.0, longer), 30);
  EXPECT_EQ(longer.samples().front().t, Time::from_s(0.0));
  EXPECT_EQ(longer.samples().back().t, Time::from_s(2000.0));
}

TEST(PairTrack, stays_in_time_order_when_it_drops_ranges) {
  const PairTrack track = past_a_vehicle(300.0);
  EXPECT_TRUE(std::is_sorted(
      track.samples().begin(), track.samples().end(),
      [](const RangeObservation& a, const RangeObservation& b) { return a.t < b.t; }));
}

}  // namespace
}  // namespace rali::fleet
