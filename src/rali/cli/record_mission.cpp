#include "rali/cli/record_mission.hpp"

#include <utility>

#include "rali/cli/session.hpp"
#include "rali/scenario/faults/fault_filter.hpp"

namespace rali::cli {
namespace {

/// Wraps the software to end a mission that is interrupted, or whose recording has failed. Faults
/// change what the software receives as they change the recording: a filter of its own with the
/// same seed makes the same choices.
class Watched final : public sim::FleetSoftware {
 public:
  Watched(sim::FleetSoftware& software, const std::function<void(Time)>& each,
          const Status& recorded, scenario::FaultFilter faults)
      : software_(software), each_(each), recorded_(recorded), faults_(std::move(faults)) {}

  void on_message(const sim::FleetMessage& message) override {
    if (faults_.faults().empty()) return software_.on_message(message);
    if (const auto kept = faults_.apply(message)) software_.on_message(*kept);
  }

  std::vector<sim::DriveCommand> decide(Time now,
                                        std::span<const sim::DriveReport> vehicles) override {
    each_(now);
    stop |= !recorded_ || stop_requested();
    return software_.decide(now, vehicles);
  }

  [[nodiscard]] bool finished() const override { return stop || software_.finished(); }

  bool stop = false;

 private:
  sim::FleetSoftware& software_;
  const std::function<void(Time)>& each_;
  const Status& recorded_;
  scenario::FaultFilter faults_;
};

}  // namespace

Result<scenario::RecordingSummary> record_mission(sim::FleetSimulation& sim,
                                                  const scenario::RecordingOptions& options,
                                                  sim::FleetSoftware& software, double time_limit_s,
                                                  const std::function<void(Time)>& each) {
  const auto drive =
      [&](const std::function<Status(const sim::FleetMessage&)>& tap) -> Result<bool> {
    Status recorded;
    Watched watched(software, each, recorded,
                    scenario::FaultFilter(options.faults, sim.t_start(), options.seed));
    sim::ClosedLoopOptions loop;
    loop.time_limit_s = time_limit_s;
    loop.tap = [&](const sim::FleetMessage& message) {
      if (recorded) recorded = tap(message);
    };
    const Result<sim::Mission> mission = sim::run_closed_loop(sim, watched, loop);
    if (!recorded) return tl::make_unexpected(recorded.error());
    if (!mission) return tl::make_unexpected(mission.error());
    return watched.stop || stop_requested();
  };
  return scenario::record_drive(sim, options, drive);
}

}  // namespace rali::cli
