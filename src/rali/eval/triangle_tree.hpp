#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rali/eval/mesh.hpp"

namespace rali::eval {

/// The point of a triangle nearest to p; exact for triangles without area too.
[[nodiscard]] geometry::Vec3 closest_on_triangle(const geometry::Vec3& p, const geometry::Vec3& a,
                                                 const geometry::Vec3& b, const geometry::Vec3& c);

/// Finds the triangle nearest to a point: a tree of boxes in one flat array, split where the
/// expected work is least. Exact, and the same for any order of queries. Queries may run at the
/// same time.
class TriangleTree {
 public:
  /// @param mesh must have passed check_mesh()
  explicit TriangleTree(const TriangleMesh& mesh);

  struct Nearest {
    double distance_m = 0.0;
    geometry::Vec3 point;        ///< on the triangle
    std::uint32_t triangle = 0;  ///< index in the mesh
  };

  [[nodiscard]] Nearest nearest(const geometry::Vec3& p) const;

  /// Unit normal of a triangle of the mesh; zero if it has no area.
  [[nodiscard]] geometry::Vec3 normal(std::uint32_t triangle) const;

 private:
  struct Box {
    geometry::Vec3 low, high;
    void add(const Box& o);
    void add(const geometry::Vec3& p);
    [[nodiscard]] double half_area() const;
    [[nodiscard]] double distance2(const geometry::Vec3& p) const;
    static Box empty();
  };

  /// Inner: children `first` and first + 1. Leaf: triangles [first, first + count).
  struct Node {
    Box box;
    std::uint32_t first = 0;
    std::uint32_t count = 0;  ///< 0: inner
  };

  struct Triangle {
    std::array<geometry::Vec3, 3> v;
    std::uint32_t id = 0;
  };

  struct Range {
    std::uint32_t node, begin, end, depth;
  };

  static constexpr int kBins = 16;

  /// Triangles of a range, sorted into slices along its longest side.
  struct Bins {
    Bins();
    [[nodiscard]] std::size_t least_work() const;
    std::array<Box, kBins> boxes;
    std::array<std::uint32_t, kBins> counts{};
  };

  [[nodiscard]] std::uint32_t split(const Range& range);
  [[nodiscard]] std::uint32_t split_evenly(const Range& range, int axis);
  [[nodiscard]] Box box_of(std::uint32_t begin, std::uint32_t end) const;

  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;         ///< in the order of the leaves
  std::vector<std::uint32_t> place_of_id_;  ///< id to its place in triangles_
};

}  // namespace rali::eval
