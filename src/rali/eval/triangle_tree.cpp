#include "rali/eval/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

namespace rali::eval {

using geometry::Vec3;

namespace {

constexpr std::uint32_t kLeafSize = 4;
// Below this depth halves are taken, which adds at most 32 levels: the stack of a query suffices.
constexpr std::uint32_t kSplitDepth = 48;
constexpr std::size_t kStack = 96;

Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double length2 = ab.squaredNorm();
  if (!(length2 > 0.0)) return a;
  return a + std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) * ab;
}

Vec3 closest_on_edges(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  Vec3 best = closest_on_segment(p, a, b);
  for (const Vec3& q : {closest_on_segment(p, b, c), closest_on_segment(p, c, a)}) {
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return best;
}

}  // namespace

// Which corner, edge or face is nearest follows from six dot products (Ericson, Real-Time Collision
// Detection, 2005, 5.1.5).
Vec3 closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  // The plane of a sliver is rounding, its edges are not.
  const double sine2_min = 1e-16 * ab.squaredNorm() * ac.squaredNorm();
  if (!(ab.cross(ac).squaredNorm() > sine2_min)) return closest_on_edges(p, a, b, c);
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return b;
  const double w_c = d1 * d4 - d3 * d2;
  if (w_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return c;
  const double w_b = d5 * d2 - d1 * d6;
  if (w_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return a + d2 / (d2 - d6) * ac;
  const double w_a = d3 * d6 - d5 * d4;
  const double from_b = d4 - d3, from_c = d5 - d6;
  if (w_a <= 0.0 && from_b >= 0.0 && from_c >= 0.0) {
    return b + from_b / (from_b + from_c) * (c - b);
  }
  return a + (w_b * ab + w_c * ac) / (w_a + w_b + w_c);
}

void TriangleTree::Box::add(const Box& o) {
  low = low.cwiseMin(o.low);
  high = high.cwiseMax(o.high);
}

void TriangleTree::Box::add(const Vec3& p) {
  low = low.cwiseMin(p);
  high = high.cwiseMax(p);
}

double TriangleTree::Box::half_area() const {
  const Vec3 d = high - low;
  return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

double TriangleTree::Box::distance2(const Vec3& p) const {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

TriangleTree::Box TriangleTree::Box::empty() {
  return {Vec3::Constant(std::numeric_limits<double>::infinity()),
          Vec3::Constant(-std::numeric_limits<double>::infinity())};
}

TriangleTree::Box TriangleTree::box_of(std::uint32_t begin, std::uint32_t end) const {
  Box box = Box::empty();
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const Vec3& v : triangles_[i].v) box.add(v);
  }
  return box;
}

TriangleTree::TriangleTree(const TriangleMesh& mesh) {
  const auto n = static_cast<std::uint32_t>(mesh.triangles.size());
  triangles_.reserve(n);
  for (std::uint32_t t = 0; t < n; ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    triangles_.push_back({{mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]}, t});
  }
  nodes_.reserve(n);
  nodes_.emplace_back();
  std::vector<Range> open{{0, 0, n, 0}};
  while (!open.empty()) {
    const Range range = open.back();
    open.pop_back();
    nodes_[range.node].box = box_of(range.begin, range.end);
    const std::uint32_t middle = split(range);
    if (middle == range.begin) {
      nodes_[range.node].first = range.begin;
      nodes_[range.node].count = range.end - range.begin;
      continue;
    }
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[range.node].first = child;
    nodes_.resize(nodes_.size() + 2);
    open.push_back({child, range.begin, middle, range.depth + 1});
    open.push_back({child + 1, middle, range.end, range.depth + 1});
  }
  place_of_id_.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) place_of_id_[triangles_[i].id] = i;
}

TriangleTree::Bins::Bins() { boxes.fill(Box::empty()); }

/// The first bin of the right side at which a query has least to do (surface area heuristic);
/// 0 if no split leaves triangles on both sides.
std::size_t TriangleTree::Bins::least_work() const {
  std::array<double, kBins> work_right{};
  std::array<std::uint32_t, kBins> count_right{};
  Box right = Box::empty();
  std::uint32_t n = 0;
  for (std::size_t b = kBins - 1; b > 0; --b) {
    right.add(boxes[b]);
    n += counts[b];
    count_right[b] = n;
    work_right[b] = n > 0 ? right.half_area() * n : 0.0;
  }
  Box left = Box::empty();
  n = 0;
  double least = std::numeric_limits<double>::infinity();
  std::size_t best = 0;
  for (std::size_t b = 1; b < kBins; ++b) {
    left.add(boxes[b - 1]);
    n += counts[b - 1];
    if (n == 0 || count_right[b] == 0) continue;
    const double work = left.half_area() * n + work_right[b];
    if (work >= least) continue;
    least = work;
    best = b;
  }
  return best;
}

/// Where the range parts, after sorting its triangles to both sides; its begin: a leaf.
std::uint32_t TriangleTree::split(const Range& range) {
  if (range.end - range.begin <= kLeafSize) return range.begin;
  const auto centre = [](const Triangle& t) -> Vec3 { return (t.v[0] + t.v[1] + t.v[2]) / 3.0; };
  Box centres = Box::empty();
  for (std::uint32_t i = range.begin; i < range.end; ++i) centres.add(centre(triangles_[i]));
  int axis = 0;
  const double extent = (centres.high - centres.low).maxCoeff(&axis);
  if (!(extent > 0.0) || range.depth > kSplitDepth) return split_evenly(range, axis);
  const auto bin_of = [&](const Triangle& t) {
    const double share = (centre(t)[axis] - centres.low[axis]) / extent;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(share * kBins), 0, kBins - 1));
  };
  Bins bins;
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const std::size_t bin = bin_of(triangles_[i]);
    ++bins.counts[bin];
    for (const Vec3& v : triangles_[i].v) bins.boxes[bin].add(v);
  }
  const std::size_t best = bins.least_work();
  if (best == 0) return split_evenly(range, axis);
  const auto middle =
      std::stable_partition(triangles_.begin() + range.begin, triangles_.begin() + range.end,
                            [&](const Triangle& t) { return bin_of(t) < best; });
  return static_cast<std::uint32_t>(middle - triangles_.begin());
}

std::uint32_t TriangleTree::split_evenly(const Range& range, int axis) {
  const std::uint32_t middle = range.begin + (range.end - range.begin) / 2;
  std::nth_element(triangles_.begin() + range.begin, triangles_.begin() + middle,
                   triangles_.begin() + range.end, [axis](const Triangle& a, const Triangle& b) {
                     const double ca = a.v[0][axis] + a.v[1][axis] + a.v[2][axis];
                     const double cb = b.v[0][axis] + b.v[1][axis] + b.v[2][axis];
                     return ca != cb ? ca < cb : a.id < b.id;
                   });
  return middle;
}

TriangleTree::Nearest TriangleTree::nearest(const Vec3& p) const {
  struct Open {
    double distance2;
    std::uint32_t node;
  };

  std::array<Open, kStack> stack;
  std::size_t size = 0;
  stack[size++] = {nodes_[0].box.distance2(p), 0};
  Nearest best;
  double best2 = std::numeric_limits<double>::infinity();
  while (size > 0) {
    const Open open = stack[--size];
    if (open.distance2 >= best2) continue;
    const Node& node = nodes_[open.node];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Triangle& t = triangles_[i];
        const Vec3 q = closest_on_triangle(p, t.v[0], t.v[1], t.v[2]);
        const double d2 = (q - p).squaredNorm();
        if (d2 >= best2) continue;
        best2 = d2;
        best = {0.0, q, t.id};
      }
      continue;
    }
    Open near{nodes_[node.first].box.distance2(p), node.first};
    Open far{nodes_[node.first + 1].box.distance2(p), node.first + 1};
    if (far.distance2 < near.distance2) std::swap(near, far);
    if (far.distance2 < best2) stack[size++] = far;
    if (near.distance2 < best2) stack[size++] = near;
  }
  best.distance_m = std::sqrt(best2);
  return best;
}

Vec3 TriangleTree::normal(std::uint32_t triangle) const {
  const Triangle& t = triangles_[place_of_id_[triangle]];
  const Vec3 n = (t.v[1] - t.v[0]).cross(t.v[2] - t.v[0]);
  const double length = n.norm();
  return length > 0.0 ? Vec3(n / length) : Vec3::Zero();
}

}  // namespace rali::eval
