#include "rali/map/scan_outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace rali::map {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr std::size_t kWedges = 72;   ///< the ground is grown in wedges of 5 degrees
constexpr double kBin_m = 0.4;        ///< steps of that growth
constexpr double kNearest_m = 0.3;    ///< nearer returns are the vehicle itself
constexpr double kPatch_m = 1.0;      ///< reach of the ground under the vehicle
constexpr double kNoise_m = 0.05;     ///< of a height
constexpr double kGap_m = 3.0;        ///< a longer gap makes one ring of a wall look like a ramp
constexpr double kLevel_m = 0.1;      ///< level enough to be ground beside a wall
constexpr double kSlopeNoise = 0.09;  ///< of the slope under the vehicle: 5 degrees
constexpr double kClearGap_m = 0.45;  ///< no relevant obstacle fits into such a gap

struct Sample {
  float x_m, y_m, range_m;  ///< level, relative to the sensor
  float z_m;                ///< above the plane on which the vehicle stands
  std::uint32_t bin;        ///< wedge and step of the growth
};

double turn_of(double x, double y) {
  return std::atan2(y, x) / (2.0 * std::numbers::pi) + 0.5;  // 0 to 1 from -pi
}

std::size_t part_of(double turn, std::size_t parts) {
  return std::min(static_cast<std::size_t>(turn * static_cast<double>(parts)), parts - 1);
}

class Outliner {
 public:
  /// @param rise_level of the plane on which the vehicle stands, per metre along x and y
  Outliner(const OutlineSettings& settings, const Vec3& sensor_level_m, double below_m,
           const Vec2& rise_level)
      : settings_(settings),
        tan_slope_(std::tan(settings.slope_max_deg * std::numbers::pi / 180.0)),
        sensor_level_m_(sensor_level_m),
        below_m_(below_m),
        rise_level_(rise_level),
        sensor_height_m_(above_plane(sensor_level_m)),
        steps_(static_cast<std::size_t>(std::ceil(settings.range_m / kBin_m)) + 1),
        side_(2 * static_cast<std::size_t>(std::ceil(settings.range_m / settings.cell_m)) + 2),
        is_hit_(side_ * side_, 0) {
    nearest_m_.fill(std::numeric_limits<float>::infinity());
    open_m_.fill(0.0F);
    enters_m_.fill(std::numeric_limits<float>::infinity());
  }

  void collect(const Vec3& p_level_m) {
    const Vec3 d = p_level_m - sensor_level_m_;
    const double range_m = d.head<2>().norm();
    if (!(range_m >= kNearest_m) || !(range_m < 1e4) || !(std::abs(d.z()) < 1e4)) return;
    // Beyond the grid's range only the direction is used: one last step holds all.
    const auto step = std::min(static_cast<std::size_t>(range_m / kBin_m), steps_ - 1);
    const std::size_t wedge = part_of(turn_of(d.x(), d.y()), kWedges);
    samples_.push_back({static_cast<float>(d.x()), static_cast<float>(d.y()),
                        static_cast<float>(range_m), static_cast<float>(above_plane(p_level_m)),
                        static_cast<std::uint32_t>(wedge * steps_ + step)});
  }

  void judge(ScanOutline& out) {
    sort_into_bins();
    for (std::size_t wedge = 0; wedge < kWedges; ++wedge) grow(wedge, out);
    fill_free(out);
  }

 private:
  [[nodiscard]] double above_plane(const Vec3& p_level_m) const {
    return p_level_m.z() + below_m_ - rise_level_.dot(p_level_m.head<2>());
  }

  /// A stable counting sort: the order of the points has no other effect.
  void sort_into_bins() {
    begin_.assign(kWedges * steps_ + 1, 0);
    for (const Sample& s : samples_) ++begin_[s.bin + 1];
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    sorted_.resize(samples_.size());
    for (const Sample& s : samples_) sorted_[next[s.bin]++] = s;
  }

  struct Grown {
    double range_m = kPatch_m;
    double z_m = 0.0;
  };

  /// Slopes that may be ground in this wedge, relative to the plane on which the vehicle stands.
  [[nodiscard]] std::pair<double, double> slopes_of(std::size_t wedge) const {
    const double turn = (static_cast<double>(wedge) + 0.5) / static_cast<double>(kWedges) - 0.5;
    const double yaw_rad = 2.0 * std::numbers::pi * turn;
    const double here = rise_level_.dot(Vec2(std::cos(yaw_rad), std::sin(yaw_rad)));
    return {std::min(-tan_slope_ - here, -kSlopeNoise), std::max(tan_slope_ - here, kSlopeNoise)};
  }

  void grow(std::size_t wedge, ScanOutline& out) {
    const auto [falls, rises] = slopes_of(wedge);
    Grown ground;
    for (std::size_t step = 0; step < steps_; ++step) {
      const std::size_t bin = wedge * steps_ + step;
      const std::size_t begin = begin_[bin], end = begin_[bin + 1];
      if (begin == end) continue;
      const double low_m = lowest(begin, end);
      const double range_m = static_cast<double>(sorted_[begin].range_m);
      const double run_m = std::max(range_m - ground.range_m, 0.5 * kBin_m);
      const double rise_m = low_m - ground.z_m;
      const bool slopes = rise_m <= rises * run_m + kNoise_m && rise_m >= falls * run_m - kNoise_m;
      const bool flat = is_flat(begin, end, low_m);
      const bool far = run_m > kGap_m && rise_m > settings_.step_m;
      // A ramp, or one ring on a wall: undecided until seen from nearer.
      if (slopes && flat && far) continue;
      const bool is_ground = slopes && (flat || rise_m <= kLevel_m) && step + 1 < steps_;
      if (is_ground) ground = {range_m, low_m};
      if (!slopes && -rise_m > settings_.drop_m) mark_drop(begin, ground.z_m - low_m, range_m, out);
      const double floor_m =
          is_ground ? settings_.low_m : std::min(settings_.step_m, settings_.low_m);
      for (std::size_t i = begin; i < end; ++i) {
        const double height_m = static_cast<double>(sorted_[i].z_m) - ground.z_m;
        look_along(sorted_[i], height_m);
        if (height_m >= floor_m && height_m <= settings_.high_m) {
          mark(sorted_[i].x_m, sorted_[i].y_m, static_cast<double>(sorted_[i].range_m), out);
        }
      }
    }
  }

  /// Lowest tenth, so that a mirrored point below the floor is not taken for the floor.
  [[nodiscard]] double lowest(std::size_t begin, std::size_t end) {
    heights_.clear();
    for (std::size_t i = begin; i < end; ++i) heights_.push_back(sorted_[i].z_m);
    const auto nth = heights_.begin() + static_cast<std::ptrdiff_t>(heights_.size() / 10);
    std::nth_element(heights_.begin(), nth, heights_.end());
    return static_cast<double>(*nth);
  }

  /// True if no points of a wall are above it.
  [[nodiscard]] bool is_flat(std::size_t begin, std::size_t end, double low_m) const {
    for (std::size_t i = begin; i < end; ++i) {
      const double above_m = static_cast<double>(sorted_[i].z_m) - low_m;
      if (above_m > settings_.step_m && above_m <= settings_.high_m) return false;
    }
    return true;
  }

  /// The edge is where the ray over it crosses the height of the ground in front of it.
  void mark_drop(std::size_t at, double drop_m, double range_m, ScanOutline& out) {
    if (range_m > settings_.drop_range_m || sensor_height_m_ <= 0.0) return;
    const double fraction = sensor_height_m_ / (sensor_height_m_ + drop_m);
    const auto s = static_cast<float>(fraction);
    mark(sorted_[at].x_m * s, sorted_[at].y_m * s, range_m * fraction, out);
  }

  /// Which part of a ray is in the band on its way to the floor, a wall or the ceiling: straight
  /// ahead in a long corridor no ray ends within the band.
  void look_along(const Sample& s, double end_height_m) {
    const double start_m = sensor_height_m_, way_m = end_height_m - start_m;
    const double low = (settings_.low_m - start_m) / way_m;
    const double high = (settings_.high_m - start_m) / way_m;
    // A level ray divides by zero: both are infinite, of the same sign if it is outside the band.
    const double from = std::max(0.0, std::min(low, high));
    const double to = std::min(1.0, std::max(low, high));
    if (!(from < to)) return;
    const double turn = turn_of(static_cast<double>(s.x_m), static_cast<double>(s.y_m));
    const std::size_t sector = part_of(turn, ScanOutline::kSectors);
    open_m_[sector] = std::max(open_m_[sector], static_cast<float>(to) * s.range_m);
    enters_m_[sector] = std::min(enters_m_[sector], static_cast<float>(from) * s.range_m);
  }

  void mark(float x_m, float y_m, double range_m, ScanOutline& out) {
    const auto x = static_cast<double>(x_m), y = static_cast<double>(y_m);
    const std::size_t sector = part_of(turn_of(x, y), ScanOutline::kSectors);
    nearest_m_[sector] = std::min(nearest_m_[sector], static_cast<float>(range_m));
    if (range_m > settings_.range_m) return;
    const double half = 0.5 * static_cast<double>(side_);
    const auto column = static_cast<std::size_t>(x / settings_.cell_m + half);
    const auto row = static_cast<std::size_t>(y / settings_.cell_m + half);
    std::uint8_t& known = is_hit_[row * side_ + column];
    if (known != 0) return;
    known = 1;
    out.hit_x_m.push_back(x_m + static_cast<float>(out.sensor_level_m.x()));
    out.hit_y_m.push_back(y_m + static_cast<float>(out.sensor_level_m.y()));
  }

  void fill_free(ScanOutline& out) const {
    const auto reach = static_cast<float>(settings_.range_m);
    const bool is_in_band =
        sensor_height_m_ >= settings_.low_m && sensor_height_m_ <= settings_.high_m;
    if (!is_in_band) out.from_m.assign(enters_m_.begin(), enters_m_.end());
    std::vector<std::size_t> rays;
    for (std::size_t s = 0; s < ScanOutline::kSectors; ++s) {
      if (!(open_m_[s] > 0.0F) && !std::isfinite(nearest_m_[s])) continue;
      const bool ends = std::isfinite(nearest_m_[s]);
      out.free_m[s] = std::min({nearest_m_[s], ends ? reach : open_m_[s], reach});
      rays.push_back(s);
    }
    constexpr double kSector_rad = 2.0 * std::numbers::pi / ScanOutline::kSectors;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      const std::size_t from = rays[k], to = rays[(k + 1) % rays.size()];
      const std::size_t gap = (to + ScanOutline::kSectors - from) % ScanOutline::kSectors;
      if (gap < 2) continue;
      const double sight_m = kClearGap_m / (static_cast<double>(gap) * kSector_rad);
      const float free_m =
          std::min({out.free_m[from], out.free_m[to], static_cast<float>(sight_m)});
      for (std::size_t s = 1; s < gap; ++s) {
        const std::size_t between = (from + s) % ScanOutline::kSectors;
        out.free_m[between] = free_m;
        if (!is_in_band) out.from_m[between] = std::max(enters_m_[from], enters_m_[to]);
      }
    }
  }

  const OutlineSettings& settings_;
  double tan_slope_;
  Vec3 sensor_level_m_;
  double below_m_;
  Vec2 rise_level_;
  double sensor_height_m_;
  std::size_t steps_, side_;
  std::vector<std::uint8_t> is_hit_;
  std::array<float, ScanOutline::kSectors> nearest_m_{};  ///< obstacle
  std::array<float, ScanOutline::kSectors> open_m_{};     ///< farthest distance at which a ray was
                                                          ///< in the band
  std::array<float, ScanOutline::kSectors> enters_m_{};   ///< nearest distance at which one was
  std::vector<Sample> samples_, sorted_;
  std::vector<std::uint32_t> begin_;
  std::vector<float> heights_;
};

}  // namespace

double yaw_of(const geometry::SE3& T_map_body) {
  return std::atan2(T_map_body.R(1, 0), T_map_body.R(0, 0));
}

ScanOutline outline_of(const KeyframeView& keyframe, const Ground& ground,
                       const OutlineSettings& settings) {
  ScanOutline out;
  const geometry::Mat3 R_level_map =
      geometry::rotation_from_rpy(0.0, 0.0, -yaw_of(keyframe.T_map_body));
  const geometry::Mat3 R_level_body = R_level_map * keyframe.T_map_body.R;
  const Vec3 sensor = R_level_body * keyframe.T_body_lidar.p;
  out.sensor_level_m = sensor.head<2>();
  const Vec2 rise_level = R_level_map.topLeftCorner<2, 2>() * ground.rise_map;
  Outliner outliner(settings, sensor, ground.below_body_m, rise_level);
  for (std::size_t i = 0; i < keyframe.size(); ++i) {
    const Vec3 p = R_level_body * keyframe.point_body(i);
    if (p.allFinite()) outliner.collect(p);
  }
  outliner.judge(out);
  return out;
}

}  // namespace rali::map
