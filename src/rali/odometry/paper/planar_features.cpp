#include "rali/odometry/paper/planar_features.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "rali/geometry/types.hpp"

namespace rali::odometry::paper {
namespace {

using geometry::Vec3f;

constexpr std::uint32_t kBins = 128;    // azimuth bins per ring
constexpr float kBinsPerUnit = 32.0F;   // the pseudo angle goes from 0 to 4
constexpr float kCellsMax = 524288.0F;  // 2^19 cubes to each side: three indices fit 64 bit
constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;

// Grows with the azimuth like atan2 does, at a tenth of its cost: [0, 4).
float pseudo_angle(float x, float y) {
  const float sum = std::abs(x) + std::abs(y);
  if (sum <= 0.0F) return 0.0F;
  const float t = y / sum;
  const float angle = x < 0.0F ? 2.0F - t : (y < 0.0F ? 4.0F + t : t);
  return angle < 4.0F ? angle : 0.0F;
}

std::uint32_t bin_of(float azimuth) {
  return std::min(kBins - 1U, static_cast<std::uint32_t>(azimuth * kBinsPerUnit));
}

std::uint64_t cell_index(float v) {
  auto i = static_cast<std::int32_t>(v);
  if (static_cast<float>(i) > v) --i;  // floor; std::floor is a call without SSE4.1
  return static_cast<std::uint64_t>(i + (1 << 20));
}

Vec3f difference(const float* a, const float* b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// Not Eigen's cross(): that needs <Eigen/Geometry>, for this function alone.
Vec3f cross(const Vec3f& a, const Vec3f& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
          a.x() * b.y() - a.y() * b.x()};
}

}  // namespace

void PlanarFeatures::clear() {
  for (auto* v : {&x_m, &y_m, &z_m, &nx, &ny, &nz}) v->clear();
  turned.clear();
}

void PlanarFeatureExtractor::extract(const PointsView& points,
                                     const PlanarFeatureSettings& settings, PlanarFeatures& out) {
  out.clear();
  thin(points, static_cast<float>(settings.downsample_m));
  order_rings(points);
  const auto radius = static_cast<float>(2.0 * settings.downsample_m);
  const auto cos_theta =
      static_cast<float>(std::cos(settings.theta_planar_deg * std::numbers::pi / 180.0));
  const std::size_t rings = ring_begin_.size() - 1;
  for (std::size_t ring = 1; ring + 1 < rings; ++ring) {
    for (std::size_t i = ring_begin_[ring]; i < ring_begin_[ring + 1]; ++i) {
      test_candidate(ring, i, radius * radius, cos_theta, out);
    }
  }
}

// All points ring by ring, in the order of measurement within each. Returns the number of rings.
std::size_t PlanarFeatureExtractor::sort_by_ring(const PointsView& points) {
  const std::size_t n = points.size();
  std::uint16_t ring_max = 0;
  for (const std::uint16_t r : points.ring) ring_max = std::max(ring_max, r);
  const std::size_t rings = n == 0 ? 0 : std::size_t{ring_max} + 1;
  ring_cursor_.assign(rings + 1, 0);
  for (const std::uint16_t r : points.ring) ++ring_cursor_[std::size_t{r} + 1];
  for (std::size_t r = 0; r < rings; ++r) ring_cursor_[r + 1] += ring_cursor_[r];
  by_ring_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    by_ring_[ring_cursor_[points.ring[i]]++] = static_cast<std::uint32_t>(i);
  }
  return rings;
}

// Adds a cube to the table; false if it is already there. Keys are never 0.
bool PlanarFeatureExtractor::add_cell(std::uint64_t key) {
  const std::size_t mask = cells_.size() - 1;
  const auto shift = static_cast<unsigned>(64 - std::countr_zero(cells_.size()));
  std::size_t slot = (key * kGolden) >> shift;
  while (cells_[slot] != 0 && cells_[slot] != key) slot = (slot + 1) & mask;
  if (cells_[slot] == key) return false;
  cells_[slot] = key;
  return true;
}

void PlanarFeatureExtractor::grow_cells() {
  std::vector<std::uint64_t> old(2 * cells_.size(), 0);
  old.swap(cells_);
  for (const std::uint64_t key : old) {
    if (key != 0) add_cell(key);
  }
}

// One point per cube: the first of its points in the order (ring, order of measurement). Ring by
// ring, because then neighbouring cubes keep points of the same ring.
void PlanarFeatureExtractor::thin(const PointsView& points, float cell_m) {
  const std::size_t rings = sort_by_ring(points);
  // Sized by the last scan: a table for as many cubes as points would not fit the cache.
  cells_.assign(std::bit_ceil(std::max<std::size_t>(2 * kept_.size(), 1024)), 0);
  kept_.clear();
  ring_begin_.assign(rings + 1, 0);
  const float inverse = 1.0F / cell_m;
  std::uint64_t last_key = 0;
  for (const std::uint32_t i : by_ring_) {
    const float cx = points.x_m[i] * inverse;
    const float cy = points.y_m[i] * inverse;
    const float cz = points.z_m[i] * inverse;
    // Written so that NaN fails.
    if (!(std::abs(cx) < kCellsMax && std::abs(cy) < kCellsMax && std::abs(cz) < kCellsMax)) {
      continue;
    }
    const std::uint64_t key = (cell_index(cx) << 42U) | (cell_index(cy) << 21U) | cell_index(cz);
    if (key == last_key) continue;
    last_key = key;
    if (!add_cell(key)) continue;
    kept_.push_back(i);
    ++ring_begin_[std::size_t{points.ring[i]} + 1];
    if (2 * kept_.size() > cells_.size()) grow_cells();
  }
  for (std::size_t r = 0; r < rings; ++r) ring_begin_[r + 1] += ring_begin_[r];
}

void PlanarFeatureExtractor::order_rings(const PointsView& points) {
  if (ring_begin_.size() < 2) ring_begin_.assign(1, 0);
  const std::size_t rings = ring_begin_.size() - 1;
  nodes_.resize(kept_.size());
  bin_begin_.assign(rings * (kBins + 1), 0);
  for (std::size_t ring = 0; ring < rings; ++ring) {
    const std::uint32_t begin = ring_begin_[ring];
    const std::uint32_t end = ring_begin_[ring + 1];
    order_.clear();
    for (std::uint32_t k = begin; k < end; ++k) {
      const std::uint32_t i = kept_[k];
      order_.emplace_back(pseudo_angle(points.x_m[i], points.y_m[i]), i);
    }
    std::sort(order_.begin(), order_.end());
    std::uint32_t* bins = bin_begin_.data() + ring * (kBins + 1);
    std::uint32_t bin = 0;
    for (std::uint32_t k = begin; k < end; ++k) {
      const auto& [azimuth, i] = order_[k - begin];
      kept_[k] = i;
      nodes_[k] = {points.x_m[i], points.y_m[i], points.z_m[i], azimuth};
      while (bin <= bin_of(azimuth)) bins[bin++] = k;
    }
    while (bin <= kBins) bins[bin++] = end;
  }
}

// The nearer of the two points of the ring that enclose the azimuth of `at`.
PlanarFeatureExtractor::Link PlanarFeatureExtractor::nearest_on_ring(std::size_t ring,
                                                                     const Node& at) const {
  const std::uint32_t begin = ring_begin_[ring];
  const std::uint32_t end = ring_begin_[ring + 1];
  if (begin == end) return {};
  std::uint32_t k = bin_begin_[ring * (kBins + 1) + bin_of(at.azimuth)];
  while (k < end && nodes_[k].azimuth < at.azimuth) ++k;
  const Node& after = nodes_[k < end ? k : begin];
  const Node& before = nodes_[k > begin ? k - 1 : end - 1];
  const float d_after = difference(&after.x_m, &at.x_m).squaredNorm();
  const float d_before = difference(&before.x_m, &at.x_m).squaredNorm();
  return d_before < d_after ? Link{&before, d_before} : Link{&after, d_after};
}

const PlanarFeatureExtractor::Node* PlanarFeatureExtractor::nearest_ring_neighbour(
    std::size_t ring, int step, const Node& at, float radius2) const {
  const auto rings = static_cast<std::ptrdiff_t>(ring_begin_.size()) - 1;
  // Thinning removes whole rings where they are denser than the cubes, so the nearest remaining
  // ring may be several further. Beyond a quarter of the rings no neighbour is expected.
  const std::ptrdiff_t reach = std::max<std::ptrdiff_t>(8, rings / 4);
  auto r = static_cast<std::ptrdiff_t>(ring) + step;
  for (std::ptrdiff_t tried = 0; tried < reach && r >= 0 && r < rings; ++tried, r += step) {
    const Link link = nearest_on_ring(static_cast<std::size_t>(r), at);
    if (link.node != nullptr && link.distance2 < radius2) return link.node;
  }
  return nullptr;
}

void PlanarFeatureExtractor::test_candidate(std::size_t ring, std::size_t index, float radius2,
                                            float cos_theta, PlanarFeatures& out) const {
  const std::size_t begin = ring_begin_[ring];
  const std::size_t end = ring_begin_[ring + 1];
  if (end - begin < 3) return;
  const Node& p = nodes_[index];
  const Node& a = nodes_[index > begin ? index - 1 : end - 1];
  const Node& b = nodes_[index + 1 < end ? index + 1 : begin];
  const float da2 = difference(&a.x_m, &p.x_m).squaredNorm();
  const float db2 = difference(&b.x_m, &p.x_m).squaredNorm();
  if (da2 >= radius2 || db2 >= radius2) return;
  const Node* upper = nearest_ring_neighbour(ring, 1, p, radius2);
  if (upper == nullptr) return;
  const Node* lower = nearest_ring_neighbour(ring, -1, p, radius2);
  if (lower == nullptr) return;

  const Vec3f s = difference(&b.x_m, &a.x_m);
  const Vec3f n_G = cross(s, difference(&upper->x_m, &p.x_m));
  const Vec3f n_O = cross(s, difference(&p.x_m, &lower->x_m));  // s x (-l): same side as n_G
  const float norms = n_G.norm() * n_O.norm();
  if (!(norms > 1e-12F) || n_G.dot(n_O) < cos_theta * norms) return;

  Vec3f n = (n_G.normalized() + n_O.normalized()).normalized();
  const bool away = n.x() * p.x_m + n.y() * p.y_m + n.z() * p.z_m > 0.0F;
  if (away) n = -n;
  // A search tree returns the nearer neighbour first, so the raw chord starts there.
  const bool chord_reversed = db2 < da2;
  out.x_m.push_back(p.x_m);
  out.y_m.push_back(p.y_m);
  out.z_m.push_back(p.z_m);
  out.nx.push_back(n.x());
  out.ny.push_back(n.y());
  out.nz.push_back(n.z());
  out.turned.push_back(away != chord_reversed ? 1 : 0);
}

void extract_planar_features(const sensor::LidarScan& scan, const PlanarFeatureSettings& settings,
                             PlanarFeatures& out) {
  PlanarFeatureExtractor extractor;
  extractor.extract(view_of(scan), settings, out);
}

}  // namespace rali::odometry::paper
