#include "rali/eval/point_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rali/cloud/voxel_sampler.hpp"

namespace rali::eval {

using geometry::Vec3;

namespace {

struct Ticket {
  std::uint64_t key, lot;
  std::uint32_t index;
};

/// Origin of the cubes: a multiple of cell_m, so that cubes of clouds in one frame coincide.
Vec3 low_corner(const PointList& points, double cell_m) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (const Vec3& p : points) {
    if (p.allFinite()) low = low.cwiseMin(p);
  }
  for (int i = 0; i < 3; ++i)
    low[i] = std::isfinite(low[i]) ? std::floor(low[i] / cell_m) * cell_m : 0.0;
  return low;
}

PointList picked(const PointList& points, std::vector<std::uint32_t>& indices) {
  std::sort(indices.begin(), indices.end());
  PointList out;
  out.reserve(indices.size());
  for (const std::uint32_t i : indices) out.push_back(points[i]);
  return out;
}

}  // namespace

PointList thinned(const PointList& points, double cell_m) {
  const Vec3 low = low_corner(points, cell_m);
  constexpr double kLast = (1 << 21) - 1;
  std::vector<Ticket> tickets;
  tickets.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) continue;
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::floor((points[i][axis] - low[axis]) / cell_m);
      key = (key << 21) | static_cast<std::uint64_t>(std::clamp(cell, 0.0, kLast));
    }
    tickets.push_back({key, cloud::hash_key(i + 1), i});
  }
  std::sort(tickets.begin(), tickets.end(), [](const Ticket& a, const Ticket& b) {
    return a.key != b.key ? a.key < b.key : a.lot < b.lot;
  });
  std::vector<std::uint32_t> kept;
  for (std::size_t k = 0; k < tickets.size(); ++k) {
    if (k == 0 || tickets[k].key != tickets[k - 1].key) kept.push_back(tickets[k].index);
  }
  return picked(points, kept);
}

PointList drawn(const PointList& points, std::size_t n) {
  if (points.size() <= n) return points;
  std::vector<Ticket> tickets;
  tickets.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i)
    tickets.push_back({0, cloud::hash_key(i + 1), i});
  const auto middle = tickets.begin() + static_cast<std::ptrdiff_t>(n);
  std::nth_element(tickets.begin(), middle, tickets.end(),
                   [](const Ticket& a, const Ticket& b) { return a.lot < b.lot; });
  std::vector<std::uint32_t> kept;
  for (auto t = tickets.begin(); t != middle; ++t) kept.push_back(t->index);
  return picked(points, kept);
}

PointGrid::PointGrid(const PointList& points, double radius_m)
    : points_(points), radius_m_(radius_m), low_(low_corner(points, radius_m)) {
  std::vector<Ticket> tickets;
  tickets.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i];
    tickets.push_back(
        {key(coordinate(p.x(), 0), coordinate(p.y(), 1), coordinate(p.z(), 2)), 0, i});
  }
  std::sort(tickets.begin(), tickets.end(), [](const Ticket& a, const Ticket& b) {
    return a.key != b.key ? a.key < b.key : a.index < b.index;
  });
  order_.reserve(tickets.size());
  for (const Ticket& t : tickets) {
    if (cells_.empty() || cells_.back().key != t.key) {
      cells_.push_back({t.key, static_cast<std::uint32_t>(order_.size())});
    }
    order_.push_back(t.index);
  }
  cells_.push_back({~std::uint64_t{0}, static_cast<std::uint32_t>(order_.size())});
}

std::uint64_t PointGrid::coordinate(double value, int axis) const {
  const double cell = std::floor((value - low_[axis]) / radius_m_);
  return static_cast<std::uint64_t>(std::clamp(cell, 0.0, static_cast<double>(kLast)));
}

std::size_t PointGrid::first_cell(std::uint64_t key) const {
  const auto found = std::lower_bound(cells_.begin(), cells_.end(), key,
                                      [](const Cell& c, std::uint64_t k) { return c.key < k; });
  return static_cast<std::size_t>(found - cells_.begin());
}

}  // namespace rali::eval
