#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "rali/sensor/lidar_models.hpp"
#include "rali/wire/internal/time_choice.hpp"

// The azimuth of a spinning sensor's point gives its time, if the start and direction of the turn
// are known. If the points are ordered by azimuth, once around, their order gives both. Otherwise
// the direction is the sensor's (clockwise for all known makes) and the start KITTI's convention:
// from the rear, s = 0.5 (1 - atan2(y, x) / pi).
namespace rali::wire::internal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// Fraction of the horizon with points, in sectors of 10 deg.
double horizon_fraction(const FirstClouds& first) {
  std::array<bool, 36> seen{};
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    for (std::size_t i = 0; i < cloud.valid.size(); ++i) {
      if (cloud.valid[i] == 0) continue;
      const double fraction = std::atan2(cloud.y_m[i], cloud.x_m[i]) / kTurn + 0.5;
      seen[std::min<std::size_t>(35, static_cast<std::size_t>(fraction * 36.0))] = true;
    }
  }
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) / 36.0;
}

/// Start and direction of the turn, from the order of the points.
struct Turn {
  double start_rad = 0.0;
  bool clockwise = true;
};

std::optional<Turn> turn_of(const FirstClouds::Cloud& cloud) {
  double turned = 0.0, back_and_forth = 0.0, previous = 0.0;
  std::vector<double> start;
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.valid.size(); ++i) {
    if (cloud.valid[i] == 0) continue;
    const double azimuth = std::atan2(cloud.y_m[i], cloud.x_m[i]);
    if (count > 0) {
      const double step = std::remainder(azimuth - previous, kTurn);
      turned += step;
      back_and_forth += std::abs(step);
    }
    previous = azimuth;
    if (count++ == 0) start.push_back(azimuth);
  }
  // Once around, with little backward motion: lasers of one column differ by some degrees.
  const bool once = std::abs(turned) > 0.6 * kTurn && std::abs(turned) < 1.1 * kTurn;
  if (!once || count < 100) return std::nullopt;
  // The mean step back within a column must be small relative to a turn.
  const double mean_step = back_and_forth / static_cast<double>(count);
  if (mean_step > 0.2) return std::nullopt;
  return Turn{start[0], turned < 0.0};
}

std::optional<Turn> common_turn(const FirstClouds& first) {
  std::optional<Turn> common;
  for (const FirstClouds::Cloud& cloud : first.clouds) {
    const std::optional<Turn> turn = turn_of(cloud);
    if (!turn) return std::nullopt;
    if (common && common->clockwise != turn->clockwise) return std::nullopt;
    if (!common) common = turn;
  }
  return common;
}

std::string deskewing_off(std::string_view because, CloudFormat& format) {
  format.point_time = PointTime::kNone;
  format.findings.push_back(cloud_finding("D02", Severity::kWarning,
                                          fmt::format("no point times: {}", because),
                                          "deskewing is off: motion within a scan blurs the map",
                                          "Set lidar.model if the sensor spins, deskewed: true if "
                                          "the clouds are undistorted already."));
  return "time: none, deskewing off";
}

}  // namespace

std::string choose_azimuth(const FirstClouds& first, const CloudFormatOptions& options,
                           CloudFormat& format) {
  const bool asked = options.point_time == PointTime::kAzimuth;
  const sensor::LidarModel* model = sensor::find_lidar_model(format.model);
  const bool known = model != nullptr && !model->elevations_deg.empty();
  const bool ringed = format.ring_from != RingFrom::kNone && format.rings >= 8;
  if (!asked && model != nullptr && !model->spinning && model->name != "generic") {
    return deskewing_off(fmt::format("a {} does not spin", model->name), format);
  }
  // Sensors turn at 5 to 20 Hz: clouds farther apart are a selection from a recording, usually by a
  // program that has undistorted them.
  constexpr double kSlowestTurn_s = 0.25;
  if (!asked && format.scan_period_s > kSlowestTurn_s) {
    return deskewing_off(
        fmt::format("no time field, and no sensor turns once in {:.2f} s", format.scan_period_s),
        format);
  }
  constexpr double kWholeHorizon = 0.6;
  if (!asked && !known && !ringed) {
    return deskewing_off("no time field, and the sensor's model is not known", format);
  }
  if (!asked && horizon_fraction(first) < kWholeHorizon) {
    return deskewing_off("no time field, and the clouds do not cover the horizon", format);
  }
  format.point_time = PointTime::kAzimuth;
  format.header_stamp =
      options.header_stamp == HeaderStamp::kEnd ? HeaderStamp::kEnd : HeaderStamp::kStart;
  format.span_s = format.scan_period_s;
  std::string from = "from the rear";
  if (const std::optional<Turn> turn = common_turn(first)) {
    format.azimuth_clockwise = turn->clockwise;
    format.azimuth_start_rad = turn->start_rad;
    from = fmt::format("from {:.0f} deg", std::round(turn->start_rad * 360.0 / kTurn) + 0.0);
  } else if (model != nullptr) {
    format.azimuth_clockwise = model->clockwise;
  }
  if (!asked) {
    format.findings.push_back(cloud_finding(
        "D02", Severity::kWarning,
        fmt::format("no usable point times: rebuilt from the azimuth ({})", format.model),
        "clouds that are undistorted already would be distorted by it",
        "Set deskewed: true or point_time: none for undistorted clouds."));
  }
  return fmt::format("time: from azimuth, {} {}, {:.4f} s per turn; stamp = {} of scan",
                     format.azimuth_clockwise ? "clockwise" : "counter-clockwise", from,
                     format.scan_period_s,
                     format.header_stamp == HeaderStamp::kEnd ? "end" : "start");
}

}  // namespace rali::wire::internal
