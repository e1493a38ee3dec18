#include "rali/places/grid_index.hpp"

#include <algorithm>
#include <utility>

namespace rali::places {

void GridIndex::build(std::span<const geometry::Vec3> points, double cell_m) {
  inverse_ = 1.0 / cell_m;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Cell c = cell_of(points[i]);
    order[i] = {cloud::voxel_key(c.x, c.y, c.z), i};
  }
  std::sort(order.begin(), order.end());
  items_.resize(order.size());
  std::size_t cells = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    items_[k] = order[k].second;
    cells += k == 0 || order[k].first != order[k - 1].first ? 1 : 0;
  }
  std::size_t size = 16;
  while (size < 2 * cells) size *= 2;
  slots_.assign(size, Slot{});
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && order[end].first == order[begin].first) ++end;
    std::uint64_t s = cloud::hash_key(order[begin].first) & (size - 1);
    while (slots_[s].end != 0) s = (s + 1) & (size - 1);
    slots_[s] = {order[begin].first, static_cast<std::uint32_t>(begin),
                 static_cast<std::uint32_t>(end)};
    begin = end;
  }
}

}  // namespace rali::places
