#include "rali/odometry/robust/plane_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rali/base/assert.hpp"
#include "rali/cloud/voxel_sampler.hpp"

namespace rali::odometry {
namespace {

using cloud::floor_to_int;
using cloud::hash_key;
using cloud::voxel_key;
using geometry::SE3;
using geometry::Vec3;

struct CellIndex {
  int x, y, z;
};

CellIndex cell_of(const Vec3& p, double inverse) {
  return {floor_to_int(p.x() * inverse), floor_to_int(p.y() * inverse),
          floor_to_int(p.z() * inverse)};
}

Vec3 center_of(int ix, int iy, int iz, double voxel_m) {
  return {(ix + 0.5) * voxel_m, (iy + 0.5) * voxel_m, (iz + 0.5) * voxel_m};
}

int octant(const Vec3& p, const Vec3& center) {
  return (p.x() >= center.x() ? 1 : 0) | (p.y() >= center.y() ? 2 : 0) |
         (p.z() >= center.z() ? 4 : 0);
}

Vec3 child_center(const Vec3& center, double half_m, int child) {
  const double q = 0.5 * half_m;
  return center + Vec3((child & 1) ? q : -q, (child & 2) ? q : -q, (child & 4) ? q : -q);
}

}  // namespace

PlaneMap::PlaneMap(const PlaneMapSettings& settings)
    : settings_(settings),
      inverse_voxel_(1.0 / settings.voxel_m),
      slots_(1 << 12),
      prune_above_(static_cast<std::size_t>(settings.roots_max)) {}

int PlaneMap::root_cell(int ix, int iy, int iz) const {
  const std::uint64_t key = voxel_key(ix, iy, iz);
  const std::uint64_t mask = slots_.size() - 1;
  for (std::uint64_t s = hash_key(key) & mask; slots_[s].cell >= 0; s = (s + 1) & mask) {
    if (slots_[s].key == key) return slots_[s].cell;
  }
  return -1;
}

/// Adds empty cells and returns the index of the first.
int PlaneMap::add_cells(std::size_t n) {
  const std::size_t first = nodes_.size();
  nodes_.resize(first + n);
  gathered_.resize(first + n);
  for (std::size_t k = first; k < first + n; ++k) {
    gathered_[k].refit_at = settings_.plane.points_min;
  }
  return static_cast<int>(first);
}

int PlaneMap::find_or_make_root(int ix, int iy, int iz) {
  const std::uint64_t key = voxel_key(ix, iy, iz);
  std::uint64_t mask = slots_.size() - 1;
  std::uint64_t s = hash_key(key) & mask;
  while (slots_[s].cell >= 0) {
    if (slots_[s].key == key) return slots_[s].cell;
    s = (s + 1) & mask;
  }
  const int cell = add_cells(1);
  slots_[s] = {key, cell};
  if (++roots_ * 2 > slots_.size()) grow();
  return cell;
}

void PlaneMap::grow() {
  std::vector<Slot> old(slots_.size() * 2);
  old.swap(slots_);
  const std::uint64_t mask = slots_.size() - 1;
  for (const Slot& slot : old) {
    if (slot.cell < 0) continue;
    std::uint64_t s = hash_key(slot.key) & mask;
    while (slots_[s].cell >= 0) s = (s + 1) & mask;
    slots_[s] = slot;
  }
}

void PlaneMap::set_view(const SE3& T_odom_lidar) {
  // A fraction of the smallest cells, and the rotation that moves a point as far at 5 m.
  constexpr double kMoved_m = 0.05;
  constexpr double kTurned_rad = 0.01;
  const geometry::Vec6 moved = geometry::boxminus(T_odom_lidar, T_odom_view_);
  new_view_ =
      empty() || moved.tail<3>().norm() / kMoved_m + moved.head<3>().norm() / kTurned_rad > 1.0;
  if (new_view_) T_odom_view_ = T_odom_lidar;
}

void PlaneMap::insert(const Vec3& p_odom_m, const geometry::Vec3f& ray_odom, double epoch) {
  const CellIndex i = cell_of(p_odom_m, inverse_voxel_);
  const int cell = find_or_make_root(i.x, i.y, i.z);
  insert_at(cell, center_of(i.x, i.y, i.z, settings_.voxel_m), 0.5 * settings_.voxel_m, 0, p_odom_m,
            ray_odom, epoch);
}

void PlaneMap::insert_at(int index, const Vec3& origin, double half_m, int level, const Vec3& p,
                         const geometry::Vec3f& ray, double epoch) {
  Vec3 center = origin;
  int children = nodes_[static_cast<std::size_t>(index)].children;
  while (children >= 0) {
    const int child = octant(p, center);
    index = children + child;
    center = child_center(center, half_m, child);
    half_m *= 0.5;
    ++level;
    children = nodes_[static_cast<std::size_t>(index)].children;
  }
  if (children == kFrozen) return;
  Gathered& gathered = gathered_[static_cast<std::size_t>(index)];
  gathered.sums.add(p - center, ray, epoch, 2.0 * half_m, new_view_);
  if (gathered.sums.n >= gathered.refit_at) refit(index, center, level);
}

void PlaneMap::refit(int index, const Vec3& origin, int level) {
  Node& node = nodes_[static_cast<std::size_t>(index)];
  Gathered& gathered = gathered_[static_cast<std::size_t>(index)];
  const int n = gathered.sums.n;
  Plane plane;
  const bool finest = level + 1 == kLevels;
  const double edge_m = settings_.voxel_m / static_cast<double>(1 << level);
  const FitResult fit = fit_plane(gathered.sums, origin, edge_m, finest, settings_.plane, plane);
  gathered.refit_at = std::max(n + 1, static_cast<int>(std::ceil(n * settings_.refit_growth)));
  if (fit == FitResult::kPlane) {
    if (node.plane < 0) {
      node.plane = static_cast<int>(planes_.size());
      planes_.push_back(plane);
    } else {
      planes_[static_cast<std::size_t>(node.plane)] = plane;
    }
    if (n >= settings_.freeze_points) node.children = kFrozen;
    return;
  }
  if (fit == FitResult::kTooFew) return;
  node.plane = -1;
  if (finest) {
    if (n >= settings_.freeze_points) node.children = kFrozen;  // never a plane: give up
    return;
  }
  // Its sums are dropped: they cannot be split into points, and more points will come.
  const int children = add_cells(8);
  nodes_[static_cast<std::size_t>(index)].children =
      children;  // the vector may have been reallocated
}

int PlaneMap::descend(int index, const Vec3& origin, const Vec3& p) const {
  Vec3 center = origin;
  double half_m = 0.5 * settings_.voxel_m;
  Node node = nodes_[static_cast<std::size_t>(index)];
  while (node.children >= 0) {
    const int child = octant(p, center);
    node = nodes_[static_cast<std::size_t>(node.children + child)];
    center = child_center(center, half_m, child);
    half_m *= 0.5;
  }
  return node.plane;
}

void PlaneMap::set_scan(const ViewPlanes& scan) {
  scan_ = scan;
  for (std::size_t k = 0; k < scan.planes().size(); ++k) {
    if (k == scan_planes_.size()) {
      scan_planes_.push_back(static_cast<int>(planes_.size()));
      planes_.emplace_back();
    }
    planes_[static_cast<std::size_t>(scan_planes_[k])] = scan.planes()[k];
  }
}

int PlaneMap::in_scan(const Vec3& p_odom_m) const {
  const int k = scan_ ? scan_->find(p_odom_m) : -1;
  return k < 0 ? -1 : scan_planes_[static_cast<std::size_t>(k)];
}

int PlaneMap::find(const Vec3& p_odom_m) const {
  const CellIndex i = cell_of(p_odom_m, inverse_voxel_);
  const int root = root_cell(i.x, i.y, i.z);
  const int index =
      root < 0 ? -1 : descend(root, center_of(i.x, i.y, i.z, settings_.voxel_m), p_odom_m);
  return index < 0 ? in_scan(p_odom_m) : index;
}

void PlaneMap::consider(int ix, int iy, int iz, const Vec3& p, int& best, double& best_m) const {
  const int root = root_cell(ix, iy, iz);
  if (root < 0) return;
  // In a neighbour cell, uses the child nearest to the point.
  const Vec3 center = center_of(ix, iy, iz, settings_.voxel_m);
  const double inside = 0.499 * settings_.voxel_m;
  const Vec3 clamped = (p - center).cwiseMax(-inside).cwiseMin(inside) + center;
  const int index = descend(root, center, clamped);
  if (index < 0) return;
  const Plane& candidate = plane(index);
  const double distance_m = std::abs(candidate.n.dot(p - candidate.q));
  if (best < 0 || distance_m < best_m) {
    best = index;
    best_m = distance_m;
  }
}

int PlaneMap::find_near(const Vec3& p_odom_m) const {
  const CellIndex i = cell_of(p_odom_m, inverse_voxel_);
  int best = -1;
  double best_m = 0.0;
  const Vec3 d = p_odom_m - center_of(i.x, i.y, i.z, settings_.voxel_m);
  const int sx = d.x() >= 0.0 ? 1 : -1;
  const int sy = d.y() >= 0.0 ? 1 : -1;
  const int sz = d.z() >= 0.0 ? 1 : -1;
  for (int k = 0; k < 8; ++k) {
    consider(i.x + ((k & 1) ? sx : 0), i.y + ((k & 2) ? sy : 0), i.z + ((k & 4) ? sz : 0), p_odom_m,
             best, best_m);
  }
  return best < 0 ? in_scan(p_odom_m) : best;
}

std::size_t PlaneMap::prune(const Vec3& center_odom_m) {
  if (roots_ <= prune_above_) return 0;
  PlaneMap kept(settings_);
  const double radius2 = settings_.keep_radius_m * settings_.keep_radius_m;
  const std::size_t before = roots_;
  // Slots in table order, which depends only on the insertions and their order.
  for (const Slot& slot : slots_) {
    if (slot.cell < 0) continue;
    constexpr std::uint64_t kMask = (1ULL << 21) - 1;
    constexpr int kOffset = 1 << 20;
    const int ix = static_cast<int>((slot.key >> 42) & kMask) - kOffset;
    const int iy = static_cast<int>((slot.key >> 21) & kMask) - kOffset;
    const int iz = static_cast<int>(slot.key & kMask) - kOffset;
    const Vec3 center = center_of(ix, iy, iz, settings_.voxel_m);
    if ((center - center_odom_m).squaredNorm() > radius2) continue;
    kept.copy_tree(*this, slot.cell, kept.find_or_make_root(ix, iy, iz));
  }
  if (scan_) kept.set_scan(*scan_);
  const auto roots_max = static_cast<std::size_t>(settings_.roots_max);
  kept.T_odom_view_ = T_odom_view_;
  kept.new_view_ = new_view_;
  kept.prune_above_ = std::max(roots_max, kept.roots_ + roots_max / 8);
  *this = std::move(kept);
  return before - roots_;
}

void PlaneMap::copy_tree(const PlaneMap& from, int source, int target) {
  Node node = from.nodes_[static_cast<std::size_t>(source)];
  gathered_[static_cast<std::size_t>(target)] = from.gathered_[static_cast<std::size_t>(source)];
  if (node.plane >= 0) {
    planes_.push_back(from.plane(node.plane));
    node.plane = static_cast<int>(planes_.size()) - 1;
  }
  if (node.children >= 0) {
    const int children = node.children;
    node.children = add_cells(8);
    for (int k = 0; k < 8; ++k) copy_tree(from, children + k, node.children + k);
  }
  nodes_[static_cast<std::size_t>(target)] = node;
}

std::uint64_t PlaneMap::hash() const {
  std::uint64_t h = 0x9e3779b97f4a7c15ULL ^ nodes_.size();
  for (const Plane& p : planes_) {
    for (int k = 0; k < 3; ++k) {
      h = hash_key(h ^ std::bit_cast<std::uint64_t>(p.q[k]));
      h = hash_key(h ^ std::bit_cast<std::uint64_t>(p.n[k]));
    }
  }
  return h;
}

}  // namespace rali::odometry
