#include "rali/map/cell_map.hpp"

#include <algorithm>
#include <cmath>

namespace rali::map {

using geometry::Vec2;

CellMap::Cell CellMap::cell_at(const Vec2& p_map_m) const {
  const auto axis = [this](double p, double origin, int n) {
    const double c = std::floor((p - origin) / cell_m);
    return c >= -2.0 ? static_cast<int>(std::min(c, n + 1.0)) : -2;
  };
  return {axis(p_map_m.x(), origin_map_m.x(), width), axis(p_map_m.y(), origin_map_m.y(), height)};
}

Vec2 CellMap::centre_m(const Cell& c) const {
  return origin_map_m + cell_m * Vec2(c.x + 0.5, c.y + 0.5);
}

}  // namespace rali::map
