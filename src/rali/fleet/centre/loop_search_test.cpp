#include "rali/fleet/centre/loop_search.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::fleet {
namespace {

/// Appearance of a place: `fraction` of one place's descriptor, the rest that of another.
/// Descriptors of different places are uncorrelated: their similarity is 0.1 at most.
places::Descriptor look(std::uint64_t place, std::uint64_t other = 0, double fraction = 1.0) {
  const auto pure = [](std::uint64_t seed) {
    std::vector<double> fields(places::kRings * places::kSectors);
    Rng rng(seed, "look");
    double square = 0.0;
    for (double& f : fields) square += std::pow(f = rng.normal(), 2);
    for (double& f : fields) f /= std::sqrt(square);
    return fields;
  };
  const std::vector<double> p = pure(place), q = pure(other);
  const double rest = std::sqrt(1.0 - fraction * fraction);
  places::Descriptor out;
  out.ring_key.fill(1.0F);
  for (std::size_t i = 0; i < p.size(); ++i) {
    out.fields[i] = static_cast<float>(fraction * p[i] + rest * q[i]);
  }
  return out;
}

/// A piece every 4 m of each path, with the given descriptors.
class Pieces {
 public:
  void add(std::size_t path, const std::vector<places::Descriptor>& looks) {
    for (std::uint32_t k = 0; k < looks.size(); ++k) {
      const std::vector<float> x = {1.0F};
      places::PosedScan scan;
      scan.scan.id = {VehicleId{static_cast<std::uint16_t>(path)}, k};
      scan.scan.x_m = scan.scan.y_m = scan.scan.z_m = x;
      PathSubmap piece;
      piece.path = path;
      piece.path_m = 4.0 * k;
      piece.submap = places::make_submap({&scan, 1}, 0, {}).value();
      piece.descriptor = looks[k];
      all.push_back(std::move(piece));
    }
  }

  /// @return (piece of the first path, piece of the second)
  [[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> alike(int row, int tries) const {
    LoopSettings settings;
    settings.row = row;
    std::vector<std::pair<std::size_t, std::size_t>> out;
    for (const LoopCandidate& c : alike_candidates(all, 0, 1, {}, settings, tries)) {
      EXPECT_FALSE(c.guess);
      out.emplace_back(static_cast<std::size_t>(all[c.target].path_m / 4.0),
                       static_cast<std::size_t>(all[c.source].path_m / 4.0));
    }
    return out;
  }

  std::vector<PathSubmap> all;
};

/// The best of a source.
std::size_t first_of(const std::vector<std::pair<std::size_t, std::size_t>>& pairs,
                     std::size_t source) {
  for (const auto& [target, s] : pairs) {
    if (s == source) return target;
  }
  return 99;
}

const std::vector<places::Descriptor> kPath = {look(10), look(11), look(12), look(13),
                                               look(14), look(15), look(16)};

// The middle one of the second path is similar to the first path's 6 (0.8), and less to the true
// match, 3 (0.6). In a row 3 has (1 + 0.6 + 1)/3, 6 has (0 + 0.8)/2.
TEST(AlikeCandidates, neighbouring_submaps_resolve_two_candidates_that_look_alike) {
  Pieces pieces;
  pieces.add(0, kPath);
  pieces.add(1, {look(12), look(16, 13, 0.8), look(14)});
  EXPECT_EQ(first_of(pieces.alike(0, 24), 1), 6U) << "else this tests nothing";
  EXPECT_EQ(first_of(pieces.alike(1, 24), 1), 3U);
}

TEST(AlikeCandidates,
     neighbouring_submaps_resolve_candidates_in_the_opposite_driving_direction_too) {
  Pieces pieces;
  pieces.add(0, kPath);
  pieces.add(1, {look(14), look(16, 13, 0.8), look(12)});
  EXPECT_EQ(first_of(pieces.alike(0, 24), 1), 6U) << "else this tests nothing";
  EXPECT_EQ(first_of(pieces.alike(1, 24), 1), 3U);
}

// A vehicle that passed something large: its piece is similar to no place (0.3 is below the limit
// of a candidate), but it lies between two known ones.
TEST(AlikeCandidates, pairs_a_submap_without_matching_descriptor_by_its_neighbours_matches) {
  Pieces pieces;
  pieces.add(0, kPath);
  pieces.add(1, {look(12), look(13, 77, 0.3), look(14)});
  EXPECT_EQ(first_of(pieces.alike(0, 24), 1), 3U);
  EXPECT_EQ(first_of(pieces.alike(1, 24), 1), 3U);
}

// A few pieces similar to all others used up all tries, by their second and third best.
TEST(AlikeCandidates, rank_the_best_match_of_every_submap_before_any_second_best) {
  Pieces pieces;
  const places::Descriptor plain = look(50);
  pieces.add(0, {plain, plain, plain, plain, look(11), look(12)});
  pieces.add(1, {plain, look(11, 60, 0.9), look(12, 61, 0.9)});
  const auto pairs = pieces.alike(0, 3);
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_EQ(first_of(pairs, 1), 4U);
  EXPECT_EQ(first_of(pairs, 2), 5U);
}

TEST(AlikeCandidates, skip_submaps_with_empty_descriptors) {
  Pieces pieces;
  pieces.add(0, kPath);
  pieces.add(1, {places::Descriptor{}, places::Descriptor{}});
  EXPECT_TRUE(pieces.alike(3, 24).empty());
}

TEST(AlikeCandidates, are_empty_without_pairs_of_submaps_or_a_limit_of_zero) {
  Pieces pieces;
  EXPECT_TRUE(pieces.alike(3, 24).empty());
  pieces.add(0, kPath);
  EXPECT_TRUE(pieces.alike(3, 24).empty());
  pieces.add(1, {look(10)});
  EXPECT_TRUE(pieces.alike(3, 0).empty());
  EXPECT_EQ(first_of(pieces.alike(100, 24), 0), 0U) << "a row longer than the paths";
}

}  // namespace
}  // namespace rali::fleet
