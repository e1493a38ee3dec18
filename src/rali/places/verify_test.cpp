#include "rali/places/verify.hpp"

#include <vector>

#include <gtest/gtest.h>

#include "rali/places/world_for_test.hpp"

namespace rali::places {
namespace {

using geometry::SE3;
using geometry::Vec3;
using test::at;

/// Nine scans on a path of 4 m through a room with an object in it, at these positions in turn.
Submap seen_with(const std::vector<Vec3>& places, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<test::Scan> scans;
  for (std::size_t k = 0; k < 9; ++k) {
    test::World world = test::room();
    if (!places.empty()) {
      const Vec3& p = places[k % places.size()];
      world.push_back({p - Vec3(0.3, 0.3, 0.0), p + Vec3(0.3, 0.3, 1.7)});
    }
    scans.push_back(test::look(world, at(2.0 + 0.5 * static_cast<double>(k), 4.0, 0.0), rng));
  }
  std::vector<PosedScan> posed;
  for (std::size_t k = 0; k < 9; ++k) {
    posed.push_back(scans[k].posed(static_cast<std::uint32_t>(k), test::Sensor{}.height_m));
  }
  return make_submap(posed, 4, SubmapSettings{}).value();
}

int contradictions(const Submap& target, const Submap& source) {
  return agreement(target, source, SE3{}, VerifySettings{}).conflict;
}

/// A person who walks from wall to wall, 0.7 m from scan to scan.
std::vector<Vec3> walk() {
  std::vector<Vec3> places;
  for (int k = 0; k < 9; ++k) places.emplace_back(3.5 + 0.7 * k, k % 2 == 0 ? 2.2 : 2.4, 0.0);
  return places;
}

TEST(verify, does_not_count_a_walking_persons_trail_as_a_contradiction) {
  const Submap empty = seen_with({}, 1);
  const Submap trail = seen_with(walk(), 2);
  const int nobody = contradictions(empty, seen_with({}, 3));
  EXPECT_LE(contradictions(empty, trail), nobody + 5);
  EXPECT_LE(contradictions(trail, empty), nobody + 5);
  int in_empty_space = 0;  // of the trail: these would contradict
  for (const CheckPoint& check : trail.checks()) {
    const bool seen_empty = empty.free_space().look(check.p_m.cast<double>()) == Sight::kFree;
    in_empty_space += check.upright && !check.solid && seen_empty ? 1 : 0;
  }
  EXPECT_GT(in_empty_space, 40);
}

TEST(verify, counts_a_standing_object_in_observed_free_space_as_a_contradiction) {
  const Submap empty = seen_with({}, 1);
  const Submap standing = seen_with({Vec3(5.0, 2.2, 0.0)}, 2);
  EXPECT_GE(contradictions(empty, standing), contradictions(empty, seen_with({}, 3)) + 10);
}

}  // namespace
}  // namespace rali::places
