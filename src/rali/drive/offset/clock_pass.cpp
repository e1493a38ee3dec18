#include "rali/drive/offset/clock_pass.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "rali/drive/member_job.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/read_ahead.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive {
namespace {

/// The timing of the motion needs less accuracy than a map.
vehicle::VehicleSettings odometry_alone(const VehicleJob& job, const InputReport& report) {
  vehicle::VehicleSettings settings = settings_with(job.settings, report);
  settings.odometry.preset = odometry::Preset::kRobust;
  settings.odometry.robust.sampling.update_points /= 2;
  settings.odometry.robust.sampling.insert_points /= 2;
  settings.peers.clear();
  return settings;
}

class Pass {
 public:
  Pass(const vehicle::VehicleSettings& settings, VehicleId self, Executor& executor)
      : vehicle_(self, settings), executor_(executor) {
    out_.evidence.antennas_body_m = settings.antennas_body_m;
  }

  void take(const vehicle::Event& event) {
    if (const auto* range = std::get_if<sensor::RangeSample>(&event)) {
      out_.ranges.push_back(*range);
      return;
    }
    outputs_.clear();
    vehicle_.step(event, executor_, outputs_);
    for (const vehicle::Output& output : outputs_) {
      if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) take(*pose);
    }
  }

  ClockPass finish() {
    take(vehicle::EndOfData{});
    return std::move(out_);
  }

 private:
  void take(const vehicle::PoseEstimate& pose) {
    out_.evidence.add(pose.t, pose.T_local_body, pose.quality,
                      pose.degeneracy.degenerate && !pose.at_rest);
  }

  vehicle::Vehicle vehicle_;
  Executor& executor_;
  vehicle::OutputList outputs_;
  ClockPass out_;
};

}  // namespace

ClockPass play_for_clock(const VehicleJob& job, Executor& executor, bool read_ahead,
                         const std::function<bool(double fraction)>& go_on) {
  const auto source = open_events(job);
  if (!source) return {};
  Pass pass(odometry_alone(job, (*source)->report()), job.input.self, executor);
  std::unique_ptr<ReadAhead> ahead;
  if (read_ahead) ahead = std::make_unique<ReadAhead>(**source);
  EventSource& events = ahead ? static_cast<EventSource&>(*ahead) : **source;
  while (go_on(events.progress())) {
    const auto event = events.next();
    if (!event || !*event) break;
    pass.take(**event);
  }
  return pass.finish();
}

Finding clock_offset_finding(const std::string& vehicle, const std::string& reference,
                             const ClockOffset& offset) {
  Finding f;
  f.id = "D17";
  f.vehicle = vehicle;
  f.value = offset.value_s;
  f.limit = kClockSigmaMax_s;
  if (offset.sigma_s) {
    f.severity = Severity::kInfo;
    f.text = fmt::format("clock: {:+.4f} s added to get the clock of {} ({})", offset.value_s,
                         reference, offset.origin);
    return f;
  }
  f.severity = Severity::kWarning;
  f.text = fmt::format("clock: the offset to that of {} is {}", reference, offset.origin);
  f.effect = "its stamps are taken as they are; ranges may fit no pose";
  f.remedy = fmt::format(
      "Let it drive past a vehicle that stands, or set vehicles.{}.clock_offset_s.", vehicle);
  return f;
}

std::optional<Finding> other_clock_finding(const std::string& vehicle, const std::string& reference,
                                           const ClockOffset& offset) {
  constexpr double kMin_s = 0.1, kSigmas = 5.0;
  if (!offset.sigma_s) return std::nullopt;
  const double limit_s = std::max(kMin_s, kSigmas * *offset.sigma_s);
  if (std::abs(offset.value_s) < limit_s) return std::nullopt;
  Finding f;
  f.id = "D17";
  f.vehicle = vehicle;
  f.severity = Severity::kWarning;
  f.value = offset.value_s;
  f.limit = limit_s;
  f.text = fmt::format("clock: {:.2f} s {} that of {} ({})", std::abs(offset.value_s),
                       offset.value_s < 0.0 ? "ahead of" : "behind", reference, offset.origin);
  f.effect = "while a vehicle drove, its ranges were used at the wrong place of its path";
  f.remedy =
      "Set clock: offset; if the ranges are late instead, ranges.latency_s. Synchronise the "
      "computers before the next recording.";
  return f;
}

}  // namespace rali::drive
