#include "rali/map/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "rali/map/ground_height.hpp"

namespace rali::map {
namespace {

constexpr std::size_t kSectors = 720;
constexpr std::uint16_t kNoHit = 0xffff;
constexpr double kNearest_m = 0.3;  ///< nearer returns are the vehicle itself

std::size_t sector_of(double x, double y) {
  const double turn = std::atan2(y, x) / (2.0 * std::numbers::pi) + 0.5;
  const auto sector = static_cast<std::size_t>(turn * static_cast<double>(kSectors));
  return std::min(sector, kSectors - 1);
}

/// Fractions of a ray's length between which it is below `top`.
std::pair<double, double> part_below(double z_from_m, double z_to_m, double top_m) {
  if (z_from_m <= top_m && z_to_m <= top_m) return {0.0, 1.0};
  if (z_from_m > top_m && z_to_m > top_m) return {0.0, 0.0};
  const double s = (top_m - z_from_m) / (z_to_m - z_from_m);
  return z_from_m <= top_m ? std::pair{0.0, s} : std::pair{s, 1.0};
}

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

std::int64_t whole(double v) { return static_cast<std::int64_t>(std::floor(v)); }

}  // namespace

std::uint8_t OccupancyGrid::at(double x_m, double y_m) const {
  const double column = std::floor((x_m - origin_map_m.x()) / cell_m);
  const double row = std::floor((y_m - origin_map_m.y()) / cell_m);
  if (!(column >= 0.0) || !(row >= 0.0) || !(column < static_cast<double>(width)) ||
      !(row < static_cast<double>(height))) {
    return kUnknownCell;
  }
  return cells[(height - 1 - static_cast<std::size_t>(row)) * width +
               static_cast<std::size_t>(column)];
}

GridBuilder::GridBuilder(const GridSettings& settings)
    : settings_(settings),
      bins_(static_cast<std::size_t>(
          std::clamp(std::ceil(settings.range_m / settings.cell_m), 1.0, 2000.0))),
      open_(kSectors * (bins_ + 1), 0),
      first_hit_(kSectors, kNoHit) {
  const auto half = static_cast<std::int64_t>(bins_);
  for (std::int64_t iy = -half; iy <= half; ++iy) {
    for (std::int64_t ix = -half; ix <= half; ++ix) {
      const auto x = static_cast<double>(ix), y = static_cast<double>(iy);
      const double bin = std::floor(std::hypot(x, y));
      polar_.push_back(static_cast<std::uint16_t>(sector_of(x, y)));
      polar_bin_.push_back(bin < static_cast<double>(bins_) ? static_cast<std::uint16_t>(bin)
                                                            : kNoHit);
    }
  }
}

std::optional<double> GridBuilder::ground_below_body_m(const KeyframeView& keyframe) {
  if (settings_.ground_below_body_m > 0.0) return settings_.ground_below_body_m;
  if (const auto found = ground_below_body(keyframe)) {
    ground_heights_m_.insert(
        std::upper_bound(ground_heights_m_.begin(), ground_heights_m_.end(), *found), *found);
  }
  if (ground_heights_m_.empty()) return std::nullopt;
  // The vehicle's height is constant: the median rejects keyframes that took a bench for ground.
  return ground_heights_m_[ground_heights_m_.size() / 2];
}

void GridBuilder::add(const KeyframeView& keyframe) {
  if (!is_usable(keyframe) || too_large_) return;
  const std::optional<double> below_m = ground_below_body_m(keyframe);
  if (!below_m) return;
  ++keyframes_;
  const geometry::SE3 T_map_lidar = keyframe.T_map_body * keyframe.T_body_lidar;
  std::fill(open_.begin(), open_.end(), std::int16_t{0});
  std::fill(first_hit_.begin(), first_hit_.end(), kNoHit);
  flatten(keyframe, T_map_lidar, keyframe.T_map_body.p.z() - *below_m);
  mark_free(T_map_lidar.p);
}

void GridBuilder::flatten(const KeyframeView& keyframe, const geometry::SE3& T_map_lidar,
                          double ground_z_m) {
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const geometry::Vec3 p_map = keyframe.T_map_body * keyframe.point_body(i);
    if (p_map.allFinite()) add_ray(p_map, T_map_lidar, ground_z_m);
  }
}

void GridBuilder::add_ray(const geometry::Vec3& p_map, const geometry::SE3& T_map_lidar,
                          double ground_z_m) {
  const geometry::Vec3 d = p_map - T_map_lidar.p;
  const double distance_m = d.head<2>().norm();
  if (distance_m < kNearest_m || d.norm() > 1e4) return;
  const double z_from_m = T_map_lidar.p.z() - ground_z_m, z_to_m = p_map.z() - ground_z_m;
  const bool in_band = z_to_m >= settings_.z_m[0] && z_to_m <= settings_.z_m[1];
  const std::size_t sector = sector_of(d.x(), d.y());
  const auto bin_of = [this](double m) {
    return static_cast<std::size_t>(std::min(m / settings_.cell_m, static_cast<double>(bins_)));
  };
  const auto [from, to] = part_below(z_from_m, z_to_m, settings_.z_m[1]);
  const std::size_t begin = bin_of(from * distance_m), end = bin_of(to * distance_m);
  if (end > begin && open_[sector * (bins_ + 1) + begin] < 32000) {
    ++open_[sector * (bins_ + 1) + begin];
    --open_[sector * (bins_ + 1) + end];
  }
  if (!in_band || distance_m > settings_.range_m) return;
  first_hit_[sector] =
      static_cast<std::uint16_t>(std::min<std::size_t>(first_hit_[sector], bin_of(distance_m)));
  Cell* c = cell(whole(p_map.x() / settings_.cell_m), whole(p_map.y() / settings_.cell_m));
  if (c == nullptr || c->last_hit == keyframes_) return;
  c->last_hit = keyframes_;
  if (c->hits < 0xffff) ++c->hits;
}

void GridBuilder::mark_free(const geometry::Vec3& sensor_map_m) {
  // Per sector: the bin from which on nothing is free. A small table that settles most cells.
  std::vector<std::uint16_t> free_end(kSectors, 0);
  for (std::size_t sector = 0; sector < kSectors; ++sector) {
    std::int16_t* row = &open_[sector * (bins_ + 1)];
    for (std::size_t bin = 1; bin <= bins_; ++bin) {
      row[bin] = static_cast<std::int16_t>(row[bin] + row[bin - 1]);
    }
    // One cell of distance to the obstacle: the sensor was rounded to its cell.
    std::size_t end =
        std::min<std::size_t>(bins_, std::max<std::size_t>(first_hit_[sector], 1) - 1);
    while (end > 0 && row[end - 1] <= 0) --end;
    free_end[sector] = static_cast<std::uint16_t>(end);
  }
  const std::int64_t ix0 = whole(sensor_map_m.x() / settings_.cell_m);
  const std::int64_t iy0 = whole(sensor_map_m.y() / settings_.cell_m);
  const auto half = static_cast<std::int64_t>(bins_);
  std::size_t i = 0;
  for (std::int64_t iy = -half; iy <= half; ++iy) {
    for (std::int64_t ix = -half; ix <= half; ++ix, ++i) {
      const std::size_t bin = polar_bin_[i];  // kNoHit beyond the range: no sector ends there
      if (bin >= free_end[polar_[i]] || open_[polar_[i] * (bins_ + 1) + bin] <= 0) continue;
      Cell* c = cell(ix0 + ix, iy0 + iy);
      if (c != nullptr && c->last_hit != keyframes_ && c->passes < 0xffff) ++c->passes;
    }
  }
}

GridBuilder::Cell* GridBuilder::cell(std::int64_t ix, std::int64_t iy) {
  const std::int64_t tx = floor_div(ix, kTile), ty = floor_div(iy, kTile);
  const VoxelKey key = voxel_key(tx, ty, 0);
  const double cells = static_cast<double>(tiles_.size()) * kTile * kTile;
  if (key == kNoVoxel || cells > settings_.cells_max) {
    too_large_ = true;
    return nullptr;
  }
  const VoxelIndex::Slot slot = tile_index_.insert(key);
  if (slot.is_new) {
    tiles_.emplace_back(static_cast<std::size_t>(kTile) * kTile);
    tile_corner_.emplace_back(tx * kTile, ty * kTile);
  }
  const std::int64_t inside = (iy - ty * kTile) * kTile + (ix - tx * kTile);
  return &tiles_[slot.index][static_cast<std::size_t>(inside)];
}

bool GridBuilder::is_occupied(const Cell& c) const {
  if (c.hits == 0) return false;
  if (c.passes == 0) return true;
  const double hits = c.hits;
  return hits >= settings_.hits_min && hits >= settings_.hit_fraction * (hits + c.passes);
}

Result<OccupancyGrid> GridBuilder::finish() const {
  if (tiles_.empty()) {
    return fail(ErrorCode::kNoAnswer, "", "no keyframe shows the ground next to the vehicle",
                "Give the height with map.grid.ground_below_body_m.");
  }
  auto low = tile_corner_.front(), high = low;
  for (const auto& corner : tile_corner_) {
    low = {std::min(low.first, corner.first), std::min(low.second, corner.second)};
    high = {std::max(high.first, corner.first), std::max(high.second, corner.second)};
  }
  const double width = static_cast<double>(high.first - low.first + kTile);
  const double height = static_cast<double>(high.second - low.second + kTile);
  if (too_large_ || width * height > settings_.cells_max) {
    return fail(ErrorCode::kMachine, "",
                fmt::format("the 2-D grid needs more than {:.0f} million cells",
                            settings_.cells_max * 1e-6),
                "Set a larger map.grid.cell_m.");
  }
  OccupancyGrid grid;
  grid.cell_m = settings_.cell_m;
  grid.origin_map_m =
      geometry::Vec2{static_cast<double>(low.first), static_cast<double>(low.second)} *
      settings_.cell_m;
  grid.width = static_cast<std::size_t>(width);
  grid.height = static_cast<std::size_t>(height);
  grid.cells.assign(grid.width * grid.height, kUnknownCell);
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    const auto x0 = static_cast<std::size_t>(tile_corner_[t].first - low.first);
    const auto y0 = static_cast<std::size_t>(tile_corner_[t].second - low.second);
    for (std::size_t i = 0; i < tiles_[t].size(); ++i) {
      const Cell& c = tiles_[t][i];
      if (c.hits == 0 && c.passes == 0) continue;
      const std::size_t x = x0 + i % kTile, y = y0 + i / kTile;
      grid.cells[(grid.height - 1 - y) * grid.width + x] = is_occupied(c) ? kOccupied : kFree;
    }
  }
  return grid;
}

}  // namespace rali::map
