#include "rali/map/evidence_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace rali::map {
namespace {

using geometry::Vec2;

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

std::int64_t whole(double v) { return static_cast<std::int64_t>(std::floor(v)); }

void count(std::uint16_t& counter, int sign) {
  if (sign > 0 && counter == 0xffff) return;
  counter = static_cast<std::uint16_t>(counter + sign);
}

Vec2 turned(const Vec2& p, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

/// Free space of an outline by the sectors of the map.
struct FreeSectors {
  std::array<float, ScanOutline::kSectors> from_m{}, to_m{};
  float farthest_m = 0.0F;
};

/// Turns the outline by whole sectors. Free space ends half a cell before the obstacle, because the
/// sensor is rounded to the middle of its cell.
FreeSectors free_sectors(const ScanOutline& outline, double yaw_rad, double cell_m) {
  constexpr auto n = static_cast<std::int64_t>(ScanOutline::kSectors);
  const double turn = yaw_rad / (2.0 * std::numbers::pi);
  const auto shift = static_cast<std::int64_t>(std::llround(turn * static_cast<double>(n)));
  FreeSectors out;
  for (std::int64_t k = 0; k < n; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const auto to = static_cast<std::size_t>(k + shift - floor_div(k + shift, n) * n);
    out.to_m[to] = outline.free_m[at] - static_cast<float>(0.5 * cell_m);
    if (!outline.from_m.empty()) out.from_m[to] = outline.from_m[at];
    out.farthest_m = std::max(out.farthest_m, out.to_m[to]);
  }
  return out;
}

}  // namespace

EvidenceGrid::EvidenceGrid(const Settings& settings)
    : settings_(settings),
      reach_(static_cast<std::int64_t>(std::ceil(settings.range_m / settings.cell_m))) {
  for (std::int64_t y = -reach_; y <= reach_; ++y) {
    for (std::int64_t x = -reach_; x <= reach_; ++x) {
      const auto dx = static_cast<double>(x), dy = static_cast<double>(y);
      const double turn = std::atan2(dy, dx) / (2.0 * std::numbers::pi) + 0.5;
      const auto sector = static_cast<std::size_t>(turn * ScanOutline::kSectors);
      polar_.push_back(static_cast<std::uint16_t>(std::min(sector, ScanOutline::kSectors - 1)));
      polar_m_.push_back(static_cast<float>(std::hypot(dx, dy) * settings_.cell_m));
    }
  }
}

void EvidenceGrid::place(const ScanOutline& outline, const Vec2& p_map_m, double yaw_rad,
                         int sign) {
  ++stamp_;
  place_hits(outline, p_map_m, yaw_rad, sign);
  place_free(outline, p_map_m, yaw_rad, sign);
  place_vehicle(p_map_m, sign);
}

void EvidenceGrid::place_hits(const ScanOutline& o, const Vec2& p_map_m, double yaw_rad, int sign) {
  for (std::size_t i = 0; i < o.hit_x_m.size(); ++i) {
    const Vec2 hit_level(static_cast<double>(o.hit_x_m[i]), static_cast<double>(o.hit_y_m[i]));
    const Vec2 p = p_map_m + turned(hit_level, yaw_rad);
    Cell* hit = cell(whole(p.x() / settings_.cell_m), whole(p.y() / settings_.cell_m));
    if (hit == nullptr || hit->stamp == stamp_) continue;
    hit->stamp = stamp_;
    count(hit->hits, sign);
  }
}

void EvidenceGrid::place_free(const ScanOutline& o, const Vec2& p_map_m, double yaw_rad, int sign) {
  const Vec2 sensor = p_map_m + turned(o.sensor_level_m, yaw_rad);
  const FreeSectors free = free_sectors(o, yaw_rad, settings_.cell_m);
  const std::int64_t x0 = whole(sensor.x() / settings_.cell_m);
  const std::int64_t y0 = whole(sensor.y() / settings_.cell_m);
  const double cells = std::ceil(static_cast<double>(free.farthest_m) / settings_.cell_m);
  const auto far = std::min(reach_, static_cast<std::int64_t>(cells));
  cells_written_ += static_cast<std::uint64_t>((2 * far + 1) * (2 * far + 1));
  for (std::int64_t y = -far; y <= far; ++y) {
    std::vector<Cell>* here = nullptr;
    std::int64_t tile_x = 0;
    const std::int64_t tile_y = floor_div(y0 + y, kTile);
    for (std::int64_t x = -far; x <= far; ++x) {
      const auto i = static_cast<std::size_t>((y + reach_) * (2 * reach_ + 1) + x + reach_);
      const std::uint16_t sector = polar_[i];
      if (polar_m_[i] >= free.to_m[sector] || polar_m_[i] < free.from_m[sector]) continue;
      const std::int64_t tx = floor_div(x0 + x, kTile);
      if (here == nullptr || tx != tile_x) here = tile(tx, tile_y);
      tile_x = tx;
      if (here == nullptr) continue;
      Cell& passed = (*here)[static_cast<std::size_t>((y0 + y - tile_y * kTile) * kTile +
                                                      (x0 + x - tx * kTile))];
      if (passed.stamp != stamp_) count(passed.passes, sign);
    }
  }
}

void EvidenceGrid::place_vehicle(const Vec2& p_map_m, int sign) {
  const double r = settings_.vehicle_radius_m, side = settings_.cell_m;
  const auto n = static_cast<std::int64_t>(std::ceil(r / side));
  const std::int64_t x0 = whole(p_map_m.x() / side);
  const std::int64_t y0 = whole(p_map_m.y() / side);
  for (std::int64_t y = y0 - n; y <= y0 + n; ++y) {
    for (std::int64_t x = x0 - n; x <= x0 + n; ++x) {
      const Vec2 centre = side * Vec2(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      if ((centre - p_map_m).norm() > r) continue;
      if (Cell* under = cell(x, y)) count(under->driven, sign);
    }
  }
}

std::vector<EvidenceGrid::Cell>* EvidenceGrid::tile(std::int64_t tx, std::int64_t ty) {
  const VoxelKey key = voxel_key(tx, ty, 0);
  if (key == kNoVoxel) return nullptr;
  if (const auto known = tile_index_.find(key)) return &tiles_[*known];
  const double cells = static_cast<double>((tiles_.size() + 1) * kTile * kTile);
  if (full_ || cells > settings_.cells_max) {
    full_ = true;
    return nullptr;
  }
  static_cast<void>(tile_index_.insert(key));
  tiles_.emplace_back(static_cast<std::size_t>(kTile * kTile));
  tile_corner_.emplace_back(tx * kTile, ty * kTile);
  return &tiles_.back();
}

EvidenceGrid::Cell* EvidenceGrid::cell(std::int64_t ix, std::int64_t iy) {
  const std::int64_t tx = floor_div(ix, kTile), ty = floor_div(iy, kTile);
  std::vector<Cell>* here = tile(tx, ty);
  if (here == nullptr) return nullptr;
  return &(*here)[static_cast<std::size_t>((iy - ty * kTile) * kTile + (ix - tx * kTile))];
}

const EvidenceGrid::Cell* EvidenceGrid::find(const Vec2& p_map_m) const {
  const double x = p_map_m.x() / settings_.cell_m, y = p_map_m.y() / settings_.cell_m;
  if (!(std::abs(x) < 1e6) || !(std::abs(y) < 1e6)) return nullptr;
  const std::int64_t tx = floor_div(whole(x), kTile), ty = floor_div(whole(y), kTile);
  const VoxelKey key = voxel_key(tx, ty, 0);
  const auto known = key == kNoVoxel ? std::nullopt : tile_index_.find(key);
  if (!known) return nullptr;
  const std::int64_t inside = (whole(y) - ty * kTile) * kTile + (whole(x) - tx * kTile);
  return &tiles_[*known][static_cast<std::size_t>(inside)];
}

tl::unexpected<Error> EvidenceGrid::too_large(std::string_view settings_group) const {
  return fail(
      ErrorCode::kMachine, "",
      fmt::format("the 2-D grid needs more than {:.0f} million cells", settings_.cells_max * 1e-6),
      fmt::format("Set a larger {}.cell_m.", settings_group));
}

Result<CellMap> EvidenceGrid::picture(const StateOf& state_of,
                                      std::string_view settings_group) const {
  if (tiles_.empty()) {
    return fail(ErrorCode::kNoAnswer, "", "no keyframe shows the ground next to the vehicle",
                fmt::format("Give the height with {}.ground_below_body_m.", settings_group));
  }
  auto low = tile_corner_.front(), high = low;
  for (const auto& corner : tile_corner_) {
    low = {std::min(low.first, corner.first), std::min(low.second, corner.second)};
    high = {std::max(high.first, corner.first), std::max(high.second, corner.second)};
  }
  const std::int64_t width = high.first - low.first + kTile;
  const std::int64_t height = high.second - low.second + kTile;
  if (static_cast<double>(width) * static_cast<double>(height) > settings_.cells_max) {
    return too_large(settings_group);
  }
  CellMap out;
  out.cell_m = settings_.cell_m;
  out.width = static_cast<int>(width);
  out.height = static_cast<int>(height);
  out.origin_map_m =
      settings_.cell_m * Vec2(static_cast<double>(low.first), static_cast<double>(low.second));
  out.cells.assign(static_cast<std::size_t>(width * height), CellState::kUnknown);
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    const std::int64_t x0 = tile_corner_[t].first - low.first;
    const std::int64_t y0 = tile_corner_[t].second - low.second;
    for (std::int64_t i = 0; i < kTile * kTile; ++i) {
      const auto at = static_cast<std::size_t>((y0 + i / kTile) * width + x0 + i % kTile);
      out.cells[at] = state_of(tiles_[t][static_cast<std::size_t>(i)]);
    }
  }
  return out;
}

}  // namespace rali::map
