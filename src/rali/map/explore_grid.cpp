#include "rali/map/explore_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "rali/map/ground_height.hpp"

namespace rali::map {
namespace {

using geometry::Vec2;

constexpr std::size_t kKeyframesMax = 60'000;  ///< counters have 16 bits
constexpr double kTurn_rad = 0.004;            ///< half a sector: smaller turns change nothing

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

std::int64_t whole(double v) { return static_cast<std::int64_t>(std::floor(v)); }

void count(std::uint16_t& counter, int sign) {
  counter = static_cast<std::uint16_t>(counter + sign);
}

double angle_between(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * std::numbers::pi));
}

}  // namespace

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

ExploreGrid::ExploreGrid(const ExploreSettings& settings)
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

std::optional<double> ExploreGrid::ground_below_body_m(VehicleId vehicle,
                                                       const KeyframeView& keyframe) {
  if (settings_.ground_below_body_m > 0.0) return settings_.ground_below_body_m;
  std::vector<double>& heights = heights_m_[vehicle];
  if (const auto found = ground_below_body(keyframe)) {
    heights.insert(std::upper_bound(heights.begin(), heights.end(), *found), *found);
  }
  if (heights.empty()) return std::nullopt;
  // The vehicle's height is constant: the median rejects keyframes that took a bench for ground.
  return heights[heights.size() / 2];
}

bool ExploreGrid::add(KeyframeId id, const KeyframeView& keyframe) {
  if (!is_usable(keyframe)) return false;
  if (move(id, keyframe.T_map_body)) return true;
  if (full_ || keyframes_.size() >= kKeyframesMax) return false;
  const auto below_m = ground_below_body_m(id.vehicle, keyframe);
  if (!below_m) return false;
  Keyframe& kept = keyframes_[id];
  kept.outline = outline_of(keyframe, *below_m, settings_);
  kept.p_map_m = keyframe.T_map_body.p.head<2>();
  kept.yaw_rad = yaw_of(keyframe.T_map_body);
  place(kept, 1);
  return true;
}

bool ExploreGrid::move(KeyframeId id, const geometry::SE3& T_map_body) {
  const auto it = keyframes_.find(id);
  if (it == keyframes_.end()) return false;
  if (!T_map_body.p.allFinite() || !T_map_body.R.allFinite()) return true;
  Keyframe& kept = it->second;
  const double yaw_rad = yaw_of(T_map_body);
  const double moved_m = (kept.p_map_m - T_map_body.p.head<2>()).norm();
  if (moved_m <= settings_.move_m && angle_between(yaw_rad, kept.yaw_rad) <= kTurn_rad) return true;
  place(kept, -1);
  kept.p_map_m = T_map_body.p.head<2>();
  kept.yaw_rad = yaw_rad;
  place(kept, 1);
  return true;
}

bool ExploreGrid::remove(KeyframeId id) {
  const auto it = keyframes_.find(id);
  if (it == keyframes_.end()) return false;
  place(it->second, -1);
  keyframes_.erase(it);
  return true;
}

void ExploreGrid::place(const Keyframe& keyframe, int sign) {
  ++stamp_;
  place_hits(keyframe, sign);
  place_free(keyframe, sign);
  place_vehicle(keyframe, sign);
}

void ExploreGrid::place_hits(const Keyframe& keyframe, int sign) {
  const double c = std::cos(keyframe.yaw_rad), s = std::sin(keyframe.yaw_rad);
  const ScanOutline& o = keyframe.outline;
  for (std::size_t i = 0; i < o.hit_x_m.size(); ++i) {
    const auto x = static_cast<double>(o.hit_x_m[i]), y = static_cast<double>(o.hit_y_m[i]);
    const Vec2 p = keyframe.p_map_m + Vec2(c * x - s * y, s * x + c * y);
    Cell* hit = cell(whole(p.x() / settings_.cell_m), whole(p.y() / settings_.cell_m));
    if (hit == nullptr || hit->stamp == stamp_) continue;
    hit->stamp = stamp_;
    count(hit->hits, sign);
  }
}

void ExploreGrid::place_free(const Keyframe& keyframe, int sign) {
  constexpr std::size_t n = ScanOutline::kSectors;
  const double c = std::cos(keyframe.yaw_rad), s = std::sin(keyframe.yaw_rad);
  const Vec2 at = keyframe.outline.sensor_level_m;
  const Vec2 sensor = keyframe.p_map_m + Vec2(c * at.x() - s * at.y(), s * at.x() + c * at.y());
  // Turns the outline by whole sectors; free space ends half a cell before the obstacle, because
  // the sensor is rounded to the middle of its cell.
  const double turn = keyframe.yaw_rad / (2.0 * std::numbers::pi);
  const auto shift = static_cast<std::int64_t>(std::llround(turn * static_cast<double>(n)));
  std::array<float, n> free_m{};
  float farthest_m = 0.0F;
  for (std::size_t k = 0; k < n; ++k) {
    const auto to = static_cast<std::int64_t>(k) + shift;
    const auto sector =
        static_cast<std::size_t>(to - floor_div(to, std::int64_t{n}) * std::int64_t{n});
    free_m[sector] = keyframe.outline.free_m[k] - static_cast<float>(0.5 * settings_.cell_m);
    farthest_m = std::max(farthest_m, free_m[sector]);
  }
  const std::int64_t x0 = whole(sensor.x() / settings_.cell_m);
  const std::int64_t y0 = whole(sensor.y() / settings_.cell_m);
  const auto far = std::min(
      reach_,
      static_cast<std::int64_t>(std::ceil(static_cast<double>(farthest_m) / settings_.cell_m)));
  cells_written_ += static_cast<std::uint64_t>((2 * far + 1) * (2 * far + 1));
  for (std::int64_t y = -far; y <= far; ++y) {
    std::vector<Cell>* here = nullptr;
    std::int64_t tile_x = 0;
    const std::int64_t tile_y = floor_div(y0 + y, kTile);
    for (std::int64_t x = -far; x <= far; ++x) {
      const auto i = static_cast<std::size_t>((y + reach_) * (2 * reach_ + 1) + x + reach_);
      if (polar_m_[i] >= free_m[polar_[i]]) continue;
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

void ExploreGrid::place_vehicle(const Keyframe& keyframe, int sign) {
  const double r = settings_.vehicle_radius_m, side = settings_.cell_m;
  const auto n = static_cast<std::int64_t>(std::ceil(r / side));
  const std::int64_t x0 = whole(keyframe.p_map_m.x() / side);
  const std::int64_t y0 = whole(keyframe.p_map_m.y() / side);
  for (std::int64_t y = y0 - n; y <= y0 + n; ++y) {
    for (std::int64_t x = x0 - n; x <= x0 + n; ++x) {
      const Vec2 centre = side * Vec2(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      if ((centre - keyframe.p_map_m).norm() > r) continue;
      if (Cell* under = cell(x, y)) count(under->driven, sign);
    }
  }
}

std::vector<ExploreGrid::Cell>* ExploreGrid::tile(std::int64_t tx, std::int64_t ty) {
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

ExploreGrid::Cell* ExploreGrid::cell(std::int64_t ix, std::int64_t iy) {
  const std::int64_t tx = floor_div(ix, kTile), ty = floor_div(iy, kTile);
  std::vector<Cell>* here = tile(tx, ty);
  if (here == nullptr) return nullptr;
  return &(*here)[static_cast<std::size_t>((iy - ty * kTile) * kTile + (ix - tx * kTile))];
}

double ExploreGrid::log_odds(const Cell& c) const {
  return std::clamp(settings_.hit * c.hits + settings_.pass * c.passes, settings_.log_odds_min,
                    settings_.log_odds_max);
}

CellState ExploreGrid::state_of(const Cell& c) const {
  if (c.driven > 0) return CellState::kFree;
  if (c.hits == 0 && c.passes == 0) return CellState::kUnknown;
  const double odds = log_odds(c);
  if (odds > settings_.occupied) return CellState::kOccupied;
  // `<=`, so that a single pass (-0.4) is enough.
  return odds <= settings_.free ? CellState::kFree : CellState::kUnknown;
}

double ExploreGrid::log_odds_at(const Vec2& p_map_m) const {
  const double x = p_map_m.x() / settings_.cell_m, y = p_map_m.y() / settings_.cell_m;
  if (!(std::abs(x) < 1e6) || !(std::abs(y) < 1e6)) return 0.0;
  const std::int64_t tx = floor_div(whole(x), kTile), ty = floor_div(whole(y), kTile);
  const VoxelKey key = voxel_key(tx, ty, 0);
  const auto known = key == kNoVoxel ? std::nullopt : tile_index_.find(key);
  if (!known) return 0.0;
  const std::int64_t inside = (whole(y) - ty * kTile) * kTile + (whole(x) - tx * kTile);
  return log_odds(tiles_[*known][static_cast<std::size_t>(inside)]);
}

Result<CellMap> ExploreGrid::picture() const {
  if (tiles_.empty()) {
    return fail(ErrorCode::kNoAnswer, "", "no keyframe shows the ground next to the vehicle",
                "Give the height with fleet.explore.ground_below_body_m.");
  }
  auto low = tile_corner_.front(), high = low;
  for (const auto& corner : tile_corner_) {
    low = {std::min(low.first, corner.first), std::min(low.second, corner.second)};
    high = {std::max(high.first, corner.first), std::max(high.second, corner.second)};
  }
  const std::int64_t width = high.first - low.first + kTile;
  const std::int64_t height = high.second - low.second + kTile;
  if (static_cast<double>(width) * static_cast<double>(height) > settings_.cells_max) {
    return fail(ErrorCode::kMachine, "",
                fmt::format("the grid for frontiers needs more than {:.0f} million cells",
                            settings_.cells_max * 1e-6),
                "Set a larger fleet.explore.cell_m.");
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
