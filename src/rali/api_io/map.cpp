#include "rali/map.hpp"

#include <algorithm>
#include <atomic>
#include <exception>

#include <fmt/format.h>

#include "rali/api/convert.hpp"
#include "rali/api/errors.hpp"
#include "rali/api_io/fleet_config.hpp"
#include "rali/drive/run_log.hpp"
#include "rali/drive/version.hpp"
#include "rali/jobs/input_checks.hpp"
#include "rali/jobs/load_inputs.hpp"
#include "rali/jobs/map_job.hpp"
#include "rali/jobs/run_report.hpp"

namespace rali {
namespace {

/// Passes progress and findings to the caller's callbacks. Their exceptions must not unwind through
/// a run, whose outputs would stay unfinished: the exception is stored and the run stopped.
class CallbackSink final : public drive::ProgressSink {
 public:
  explicit CallbackSink(const MapCallbacks& callbacks) : callbacks_(callbacks) {}

  void progress(const drive::Progress& p) override {
    if (!callbacks_.progress) return;
    guarded([&] {
      const MapProgress progress{
          p.vehicle, p.stage, p.fraction, p.speed, p.path_m, p.degenerate_fraction, p.t.ns};
      if (!callbacks_.progress(progress)) stop_.store(true, std::memory_order_relaxed);
    });
  }

  void finding(const Finding& finding) override {
    if (!callbacks_.finding) return;
    guarded([&] { callbacks_.finding(api::public_finding(finding)); });
  }

  [[nodiscard]] const std::atomic<bool>& stop() const { return stop_; }

  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  template <class F>
  void guarded(const F& call) {
    if (thrown_) return;
    try {
      call();
    } catch (...) {
      thrown_ = std::current_exception();
      stop_.store(true, std::memory_order_relaxed);
    }
  }

  const MapCallbacks& callbacks_;
  std::atomic<bool> stop_{false};
  std::exception_ptr thrown_;
};

jobs::MapOptions inner_options(const MapOptions& options) {
  for (const std::string& format : options.formats) {
    api::check(jobs::check_format(format, "formats"));
  }
  if (options.threads < 0 || options.threads > 1024) {
    throw SettingsError("threads", fmt::format("{} is not 0 to 1024", options.threads), "");
  }
  jobs::MapOptions inner;
  inner.out_dir = options.out;
  inner.formats = options.formats;
  inner.mcap = options.session_mcap;
  inner.keyframes = options.keyframe_clouds;
  inner.strict = options.strict;
  inner.overwrite = options.overwrite;
  inner.threads = options.threads;
  inner.command_line = fmt::format("library rali {}", drive::version());
  return inner;
}

VehicleSummary public_summary(const drive::VehicleSummary& vehicle) {
  VehicleSummary summary;
  summary.name = vehicle.name;
  summary.distance_m = vehicle.path_m;
  summary.scans = vehicle.scans;
  summary.scans_dropped = vehicle.scans_dropped;
  summary.keyframes = vehicle.keyframes;
  summary.degenerate_fraction = vehicle.degenerate_fraction;
  summary.sigma_median_m = vehicle.sigma_median_m;
  summary.sigma_max_m = vehicle.sigma_max_m;
  return summary;
}

MapSummary public_summary(const drive::MapSummary& run) {
  MapSummary summary;
  if (run.status == drive::RunStatus::kPartial) summary.status = MapStatus::kPartial;
  if (run.status == drive::RunStatus::kInterrupted) summary.status = MapStatus::kInterrupted;
  summary.out = run.out_dir;
  for (const auto& vehicle : run.vehicles) summary.vehicles.push_back(public_summary(vehicle));
  summary.connected = drive::is_connected(run.fleet);
  summary.gaps = run.gaps;
  summary.map_points = run.map_points;
  summary.ranges = run.ranges.total;
  summary.ranges_used = run.ranges.used();
  summary.loops_closed = static_cast<std::size_t>(
      std::count_if(run.fleet.loops.begin(), run.fleet.loops.end(),
                    [](const fleet::LoopVerdict& loop) { return loop.accepted; }));
  for (const Finding& finding : run.findings) {
    summary.findings.push_back(api::public_finding(finding));
  }
  summary.metrics_json = run.metrics_json;
  return summary;
}

}  // namespace

MapSummary map_recordings(const FleetConfig& config, const MapOptions& options,
                          const MapCallbacks& callbacks) {
  const config::FleetConfig& fleet = config.impl().fleet;
  jobs::MapOptions inner = inner_options(options);
  inner.facts = config.impl().facts;
  const drive::MapJob job = api::value_or_throw(jobs::make_map_job(fleet, inner));
  api::check(jobs::check_recordings(fleet));
  CallbackSink sink(callbacks);
  const Result<drive::MapSummary> run = drive::run_map(job, sink, sink.stop());
  Status reported;
  if (run && options.report) {
    reported = jobs::add_report(options.out);
    if (!reported) drive::mark_failed(options.out, "error: " + reported.error().message());
  }
  sink.rethrow();
  if (!run) api::throw_error(run.error());
  api::check(reported);
  return public_summary(*run);
}

}  // namespace rali
