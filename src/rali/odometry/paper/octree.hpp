#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "rali/geometry/types.hpp"

namespace rali::odometry::paper {

/// Octree over a fixed set of points (Meagher 1982). It answers "is any point within a radius?",
/// from which the overlap of two clouds is computed. Points are copied and sorted into leaves.
class Octree {
 public:
  /// Rebuilds the tree, reusing its memory. Points that are not finite are ignored.
  void build(std::span<const float> x_m, std::span<const float> y_m, std::span<const float> z_m);

  /// True if a point is nearer than radius_m to `query`.
  [[nodiscard]] bool any_within(const geometry::Vec3f& query, float radius_m) const;

  [[nodiscard]] std::size_t size() const { return points_.size(); }

  [[nodiscard]] std::size_t nodes() const { return nodes_.size(); }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  struct Node {
    geometry::Vec3f centre;
    float half_m = 0.0F;  ///< half the edge
    std::uint32_t begin = 0, end = 0;
    std::uint32_t first_child = kNone;  ///< of eight in a row; kNone: a leaf
  };

  void split(std::uint32_t node, int depth);

  std::vector<geometry::Vec3f> points_;
  std::vector<geometry::Vec3f> scratch_;
  std::vector<Node> nodes_;
};

}  // namespace rali::odometry::paper
