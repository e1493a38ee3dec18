#include <cmath>

#include <gtest/gtest.h>

#include "rali/odometry/robust/driven_for_test.hpp"

namespace rali::odometry {
namespace {

/// As wide as a cart, from floor to roof.
TestRoom::Box cart_at(double x_m) { return {{x_m, -0.5, -1.0}, {x_m + 0.8, 0.5, 1.9}}; }

double true_x_m(const Driven& driven) {
  return driven.room.pose(TestRoom::kScan_s * driven.scans).p.x();
}

/// Driving in a tunnel, degenerate along it, shaking: otherwise it would count as standstill.
Driven degenerate_in_a_tunnel(double speed_mps, int scans, std::uint64_t seed) {
  TestRoom room = tunnel();
  room.rng = Rng(seed, "room");
  room.speed_mps = speed_mps;
  room.rings = 16;
  room.columns = 300;
  Driven driven(room, 13, true);
  driven.room.accel_noise_mps2 = 0.3;
  while (driven.scans < scans) driven.scan();
  return driven;
}

/// In how many of the last 40 of 80 scans with a box in view the tunnel's axis is observable.
template <class BoxOf>
int scans_that_see(Driven& driven, const BoxOf& box_of) {
  int seen = 0;
  for (int k = 0; k < 80; ++k) {
    driven.room.pillars = {box_of(driven)};
    driven.scan();
    if (k >= 40 && !driven.filter->degenerate_axis()) ++seen;
  }
  return seen;
}

double off_m(const Driven& driven) { return driven.now().T_odom_body.p.x() - true_x_m(driven); }

// Taken for a wall it holds the vehicle back: 4 to 8 m are lost in half of the seeds. It differs
// from a wall by contradicting the inertial sensor, and by young planes. Of 96 seeds none is held
// back.
TEST(ThinHold, a_cart_driving_ahead_does_not_constrain_motion_along_a_tunnel) {
  struct Case {
    double speed_mps;
    int scans;
    double gap_m;
  };

  constexpr std::uint64_t kSeeds = 24;
  for (const Case& c : {Case{1.0, 25, 2.0}, Case{0.6, 50, 3.0}}) {
    int held_back = 0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      Driven driven = degenerate_in_a_tunnel(c.speed_mps, c.scans, seed);
      const auto cart = [&](const Driven& d) { return cart_at(true_x_m(d) + c.gap_m); };
      const int seen = scans_that_see(driven, cart);
      if (seen >= 10 || std::abs(off_m(driven)) > 2.0) ++held_back;
    }
    EXPECT_LE(held_back, 2) << "of " << kSeeds << " seeds at " << c.speed_mps << " m/s";
  }
}

// Of 64 seeds 19 observe the box in too few scans, and 6 are off by more than 0.4 m; rms 0.22 m.
// With repeated spots counted as samples it was 13, 7 and 0.30 m.
TEST(ThinHold, a_static_box_constrains_motion_along_a_tunnel) {
  constexpr int kSeeds = 24;
  int rarely_seen = 0;
  double sum2_m2 = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Driven driven = degenerate_in_a_tunnel(1.0, 25, seed);
    const TestRoom::Box box = cart_at(true_x_m(driven) + 11.0);
    if (scans_that_see(driven, [&](const Driven&) { return box; }) <= 30) ++rarely_seen;
    sum2_m2 += off_m(driven) * off_m(driven);
  }
  EXPECT_LE(rarely_seen, 8);
  EXPECT_LT(std::sqrt(sum2_m2 / kSeeds), 0.3);
}

/// Posts in the open, seen from 5 m above the ground: its rings are farther apart than a cell of
/// the map is wide, so a single place shows hardly a plane.
TestRoom square() {
  TestRoom room;
  room.walls = {{-90.0, -80.0, -5.0}, {90.0, 80.0, 60.0}};
  room.pillars.clear();
  for (const double x_m : {-22.0, -9.0, 6.0, 14.0, 27.0, 41.0}) {
    for (const double y_m : {-17.0, -8.0, 9.0, 20.0}) {
      room.pillars.push_back({{x_m, y_m, -5.0}, {x_m + 0.8, y_m + 0.8, 4.0}});
    }
  }
  room.rings = 16;
  room.rest_s = 4.0;
  room.ramp_s = 3.0;
  room.speed_mps = 4.0;
  room.radius_m = 200.0;
  return room;
}

// The map of the standing scans has few planes, and none where the first moving scans look. Left
// out, they keep it from growing: the vehicle was lost for two seconds, or a wrong match of 15
// points counted as a jolt and it drove off backwards.
TEST(NewGround, a_vehicle_that_starts_in_the_open_is_not_lost) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    TestRoom room = square();
    room.rng = Rng(seed, "room");
    Driven driven(room, 90, true);
    const double off = (driven.now().T_odom_body.p - room.pose(TestRoom::kScan_s * 90).p).norm();
    EXPECT_LT(off, 0.15) << "seed " << seed;
    for (const Finding& f : driven.findings) {
      EXPECT_NE(f.id, "odometry.diverged") << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace rali::odometry
