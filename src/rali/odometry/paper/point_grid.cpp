#include "rali/odometry/paper/point_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rali::odometry::paper {

using geometry::Vec3f;

namespace {

constexpr std::int32_t kOffset = 1 << 20;
// Two cubes less than the offset: the neighbours of the outermost cube still have a key.
constexpr float kIndexMax = static_cast<float>(kOffset - 2);
constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;

std::int32_t floor_of(float v) {
  const auto i = static_cast<std::int32_t>(v);
  return static_cast<float>(i) > v ? i - 1 : i;
}

}  // namespace

bool PointGrid::index_of(const Vec3f& p, Index3& out) const {
  const Vec3f c = p * inverse_;
  // Written so that NaN fails.
  if (!(std::abs(c.x()) < kIndexMax && std::abs(c.y()) < kIndexMax &&
        std::abs(c.z()) < kIndexMax)) {
    return false;
  }
  out = {floor_of(c.x()), floor_of(c.y()), floor_of(c.z())};
  return true;
}

std::uint64_t PointGrid::key_of(const Index3& i) {
  const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v + kOffset); };
  return (part(i.x) << 42U) | (part(i.y) << 21U) | part(i.z) | (1ULL << 63U);
}

void PointGrid::build(std::span<const PointNormal> points, float radius_m) {
  radius_m_ = radius_m;
  inverse_ = 1.0F / radius_m;
  order_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Index3 index;
    if (index_of(points[i].p, index)) {
      order_.emplace_back(key_of(index), static_cast<std::uint32_t>(i));
    }
  }
  std::sort(order_.begin(), order_.end());
  sorted_.clear();
  sorted_.reserve(order_.size());
  for (const auto& entry : order_) sorted_.push_back(points[entry.second]);
  index_cells();
}

void PointGrid::index_cells() {
  const std::size_t capacity = std::bit_ceil(std::max<std::size_t>(2 * order_.size(), 64));
  shift_ = static_cast<unsigned>(64 - std::countr_zero(capacity));
  cells_.assign(capacity, {});
  for (std::uint32_t begin = 0; begin < order_.size();) {
    const std::uint64_t key = order_[begin].first;
    std::uint32_t end = begin;
    while (end < order_.size() && order_[end].first == key) ++end;
    std::size_t slot = (key * kGolden) >> shift_;
    while (cells_[slot].key != 0) slot = (slot + 1) & (capacity - 1);
    cells_[slot] = {key, begin, end};
    begin = end;
  }
}

const PointGrid::Cell* PointGrid::find(std::uint64_t key) const {
  std::size_t slot = (key * kGolden) >> shift_;
  while (cells_[slot].key != 0) {
    if (cells_[slot].key == key) return &cells_[slot];
    slot = (slot + 1) & (cells_.size() - 1);
  }
  return nullptr;
}

}  // namespace rali::odometry::paper
