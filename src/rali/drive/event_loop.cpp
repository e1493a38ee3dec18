#include "rali/drive/event_loop.hpp"

#include <chrono>
#include <memory>
#include <utility>

#include "rali/drive/read_ahead.hpp"

namespace rali::drive {
namespace {

/// Tells the sink how far the run is, at most ten times per second of wall clock: printing must
/// not cost time, and nothing here enters a result.
class Reporter {
 public:
  Reporter(ProgressSink& sink, const VehicleRun& run) : sink_(sink), run_(run) {}

  void report(double share, bool always) {
    const auto now = std::chrono::steady_clock::now();
    if (!always && now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    Progress progress;
    progress.vehicle = run_.name();
    progress.stage = "odometry";
    progress.share = share;
    progress.path_m = run_.path_m();
    progress.blind_share = run_.path_m() > 0.0 ? run_.blind_m() / run_.path_m() : 0.0;
    if (!run_.poses().empty()) {
      progress.t = run_.poses().back().t;
      const double data_s = seconds_between(run_.poses().front().t, progress.t);
      const double wall_s = std::chrono::duration<double>(now - begin_).count();
      progress.speed = wall_s > 0.0 ? data_s / wall_s : 0.0;
    }
    sink_.progress(progress);
  }

 private:
  ProgressSink& sink_;
  const VehicleRun& run_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_;
};

bool is_lost(const VehicleRun& run) {
  return !run.poses().empty() && run.poses().back().quality == vehicle::PoseQuality::kDiverged;
}

}  // namespace

LoopEnd run_events(ReportedSource& source, bool read_ahead, bool strict, vehicle::Vehicle& vehicle,
                   Executor& executor, VehicleRun& run, FindingList& findings, ProgressSink& sink,
                   const std::atomic<bool>& stop) {
  LoopEnd end;
  std::unique_ptr<ReadAhead> ahead;
  if (read_ahead) ahead = std::make_unique<ReadAhead>(source);
  EventSource& events = ahead ? static_cast<EventSource&>(*ahead) : source;
  Reporter reporter(sink, run);
  vehicle::OutputList outputs;
  bool ended = false;
  while (!ended) {
    vehicle::Event event = vehicle::EndOfData{};
    end.interrupted = stop.load(std::memory_order_relaxed);
    if (end.interrupted || (strict && is_lost(run))) {
      // What was handed over is finished: the vehicle still works on waiting scans.
      ended = true;
    } else {
      Result<std::optional<vehicle::Event>> next = events.next();
      if (!next) end.error = next.error();
      ended = !next || !*next;
      if (!ended) event = std::move(**next);
    }
    outputs.clear();
    vehicle.step(event, executor, outputs);
    const std::size_t known = findings.size();
    Status taken = run.see(event);
    if (taken) taken = run.take(outputs, findings);
    for (std::size_t i = known; i < findings.size(); ++i) sink.finding(findings[i]);
    if (!taken) {
      end.error = taken.error();
      break;
    }
    reporter.report(events.progress(), ended);
  }
  return end;
}

}  // namespace rali::drive
