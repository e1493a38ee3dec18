#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "rali/degeneracy/evidence.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/places/planes.hpp"

namespace rali::places {

class Submap;
struct AlignSettings;

/// Gauss-Newton system in boxplus order (rotation in source, translation in target).
struct System {
  geometry::Mat6 I = geometry::Mat6::Zero();
  geometry::Vec6 b = geometry::Vec6::Zero();
  int matches = 0;
  double square_sum_m2 = 0.0;  ///< of residuals, robustly weighted
  double weight_sum = 0.0;
};

/// Limits within which partners are searched.
struct Gate {
  double search_m = 1.0;    ///< between mean points
  double distance_m = 1.0;  ///< along the normal, before sigma narrows it
  bool fine = false;        ///< weights and gates by sigma, errors of planes counted once
};

/// Pairs planes of the source with planes of the target: the mean of one should lie on the other
/// and both normals should agree. So the two faces of a wall are never paired.
class Partners {
 public:
  explicit Partners(const AlignSettings& settings) : settings_(settings) {}

  /// Uses at most `maximum` planes, evenly chosen.
  void set_source(std::span<const Plane> planes, int maximum);

  void find(const Submap& target, const geometry::SE3& T_target_source, const Gate& gate);

  /// Sums over the pairs of the last find().
  [[nodiscard]] System accumulate(const Submap& target, const geometry::SE3& T_target_source);

  /// Contribution of each target plane to the last accumulate().
  [[nodiscard]] std::span<const degeneracy::PlaneEvidence> evidence() const { return evidence_; }

 private:
  struct Pair {
    std::uint32_t target = 0;
    std::uint32_t source = 0;  ///< into source_
  };

  void add_plane(std::span<const Pair> pairs, const Plane& plane,
                 const geometry::SE3& T_target_source, System& system);
  [[nodiscard]] double weight(double r, double of_target_m2, double of_source_m2) const;
  [[nodiscard]] double rough2() const;

  const AlignSettings& settings_;
  Gate gate_;
  std::vector<Plane> source_;
  std::vector<Pair> pairs_;  ///< by target, then source
  std::vector<degeneracy::PlaneEvidence> evidence_;
};

}  // namespace rali::places
