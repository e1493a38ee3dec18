#include "rali/odometry/paper/octree.hpp"

#include <algorithm>
#include <cmath>

namespace rali::odometry::paper {

using geometry::Vec3f;

namespace {

// A leaf of 8 points costs about as much to search as a level of the tree.
constexpr std::uint32_t kLeafPoints = 8;
// 20 halvings of 200 m are 0.2 mm: only equal points would need more.
constexpr int kDepthMax = 20;

unsigned octant(const Vec3f& p, const Vec3f& centre) {
  return (p.x() >= centre.x() ? 1U : 0U) | (p.y() >= centre.y() ? 2U : 0U) |
         (p.z() >= centre.z() ? 4U : 0U);
}

Vec3f octant_centre(const Vec3f& centre, float half_child_m, unsigned which) {
  return centre + half_child_m * Vec3f((which & 1U) != 0U ? 1.0F : -1.0F,
                                       (which & 2U) != 0U ? 1.0F : -1.0F,
                                       (which & 4U) != 0U ? 1.0F : -1.0F);
}

}  // namespace

void Octree::build(std::span<const float> x_m, std::span<const float> y_m,
                   std::span<const float> z_m) {
  points_.clear();
  nodes_.clear();
  Vec3f low = Vec3f::Zero();
  Vec3f high = Vec3f::Zero();
  for (std::size_t i = 0; i < x_m.size(); ++i) {
    const Vec3f p(x_m[i], y_m[i], z_m[i]);
    if (!p.allFinite()) continue;
    low = points_.empty() ? p : Vec3f(low.cwiseMin(p));
    high = points_.empty() ? p : Vec3f(high.cwiseMax(p));
    points_.push_back(p);
  }
  if (points_.empty()) return;
  scratch_.resize(points_.size());
  const Vec3f centre = 0.5F * low + 0.5F * high;
  const float half_m = (high - centre).cwiseMax(centre - low).maxCoeff();
  nodes_.push_back({centre, half_m, 0, static_cast<std::uint32_t>(points_.size()), kNone});
  split(0, 0);
}

void Octree::split(std::uint32_t node, int depth) {
  const Node parent = nodes_[node];
  if (parent.end - parent.begin <= kLeafPoints || depth >= kDepthMax) return;

  // Counting sort of the points by octant.
  std::array<std::uint32_t, 9> begin{};
  for (std::uint32_t i = parent.begin; i < parent.end; ++i) {
    ++begin[octant(points_[i], parent.centre) + 1];
  }
  for (std::size_t k = 0; k < 8; ++k) begin[k + 1] += begin[k];
  std::array<std::uint32_t, 9> cursor = begin;
  for (std::uint32_t i = parent.begin; i < parent.end; ++i) {
    scratch_[cursor[octant(points_[i], parent.centre)]++] = points_[i];
  }
  std::copy_n(scratch_.begin(), parent.end - parent.begin, points_.begin() + parent.begin);

  const auto first_child = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first_child = first_child;
  const float half_child_m = 0.5F * parent.half_m;
  for (unsigned k = 0; k < 8; ++k) {
    nodes_.push_back({octant_centre(parent.centre, half_child_m, k), half_child_m,
                      parent.begin + begin[k], parent.begin + begin[k + 1], kNone});
  }
  for (std::uint32_t k = 0; k < 8; ++k) split(first_child + k, depth + 1);
}

bool Octree::any_within(const Vec3f& query, float radius_m) const {
  if (nodes_.empty() || !query.allFinite()) return false;
  const float radius2 = radius_m * radius_m;
  // Depth first; at most seven siblings are pending on each level.
  std::array<std::uint32_t, 7 * kDepthMax + 8> stack;
  std::size_t waiting = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const Node& node = nodes_[stack[--waiting]];
    if (node.begin == node.end) continue;
    const Vec3f gap =
        ((query - node.centre).cwiseAbs().array() - node.half_m).cwiseMax(0.0F).matrix();
    if (gap.squaredNorm() > radius2) continue;
    if (node.first_child == kNone) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if ((points_[i] - query).squaredNorm() < radius2) return true;
      }
      continue;
    }
    // Pushes the octant of the query last, so that it is searched first.
    const unsigned own = octant(query, node.centre);
    for (unsigned k = 7; k >= 1; --k) stack[waiting++] = node.first_child + (own ^ k);
    stack[waiting++] = node.first_child + own;
  }
  return false;
}

}  // namespace rali::odometry::paper
