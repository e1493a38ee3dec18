#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "rali/drive/fleet_loop.hpp"
#include "rali/drive/member_job.hpp"
#include "rali/drive/ranges/range_files.hpp"
#include "rali/drive/run_log.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/map/build_map.hpp"
#include "rali/vehicle/vehicle.hpp"

namespace rali::drive::internal {

/// One run of `rali map`: the stages in their order. Each stage adds to `summary_`. Reading and
/// estimation are in map_run.cpp, the offsets of clocks in map_offsets.cpp, the same from facts in
/// map_facts.cpp, the final outputs in map_results.cpp.
class MapRun {
 public:
  MapRun(const MapJob& job, ProgressSink& sink, const std::atomic<bool>& stop)
      : job_(job),
        sink_(sink),
        stop_(stop),
        threads_(job.threads > 0 ? job.threads : cores()),
        executor_(make_executor(threads_)),
        ranges_(std::make_shared<const RangeOptions>(job.ranges)),
        range_log_(vehicle_names(job)) {}

  Result<MapSummary> run();

  /// After an internal fault: writes run.log as far as possible, and status.json with the state
  /// failed. Neither is written if the run has not touched the folder.
  void give_up(std::string_view fault) noexcept;

 private:
  Result<MapSummary> run_in_folder();

  Status open_sources();
  [[nodiscard]] std::function<bool(double)> progress_of(const std::string& vehicle,
                                                        const std::string& stage);
  Status open_again(std::size_t index, VehicleJob job);
  [[nodiscard]] VehicleJob found_so_far(std::size_t index) const;
  Status study_turning();
  Status find_clock_offsets();
  [[nodiscard]] std::vector<ClockOffset> estimate_clock_offsets();
  void check_clocks();
  [[nodiscard]] std::vector<double> clock_offsets_s() const;
  Status open_session();
  void forget_keyframes();
  Status start_vehicles();
  Status run_vehicles();
  void join_fleet();
  Status run_facts();
  Status fill_runs();
  Status finish_vehicle(std::size_t index, const FleetMember& member);
  Status judge_ends(const std::vector<FleetMember>& members);
  Status write_results();
  Status write_imu_rate(std::size_t index);
  void find_site(const std::vector<const VehicleRun*>& mapped);
  Status write_ranges();
  Status write_map();
  Status check_results();
  Status write_rounds();
  Status close(const Status& so_far);
  void report(Finding finding);

  const MapJob& job_;
  ProgressSink& sink_;
  const std::atomic<bool>& stop_;
  std::mutex reporting_;  ///< of progress, by passes in parallel
  int threads_;
  std::unique_ptr<Executor> executor_;
  std::vector<std::unique_ptr<ReportedSource>> sources_;
  std::unique_ptr<SessionFile> session_;
  std::shared_ptr<const RangeOptions> ranges_;
  RangeList range_list_;
  RangeLog range_log_;
  std::vector<vehicle::Vehicle> vehicles_;  ///< none: a run of facts
  std::vector<VehicleRun> runs_;
  std::vector<std::size_t> findings_reported_;  ///< of each source, before its events
  std::vector<map::KeyframeLooks> looks_;       ///< of the map's keyframes
  MapSummary summary_;
  RunLog log_;
  bool interrupted_ = false;
  bool started_ = false;  ///< status.json states that the run is in progress
};

}  // namespace rali::drive::internal
