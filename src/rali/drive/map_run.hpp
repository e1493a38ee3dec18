#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/check_tally.hpp"
#include "rali/drive/input/input_report.hpp"
#include "rali/drive/live/live_files.hpp"
#include "rali/drive/output/georeference.hpp"
#include "rali/drive/output/rounds_input.hpp"
#include "rali/drive/ranges/range_log.hpp"
#include "rali/drive/ranges/range_options.hpp"
#include "rali/drive/reported_source.hpp"
#include "rali/fleet/centre/centre.hpp"
#include "rali/map/settings.hpp"
#include "rali/vehicle/settings.hpp"

namespace rali::drive {

struct FleetFacts;

/// One vehicle of a mapping job: its data and how to read them.
struct VehicleJob {
  std::vector<std::string> inputs;  ///< recordings in order, or one folder of scans
  std::string imu_file;             ///< CSV beside a folder of scans; empty: imu.csv of the folder
  /// Opens the data in place of `inputs`, for sensor data in memory. May be called twice.
  std::function<Result<std::unique_ptr<ReportedSource>>(const InputOptions&)> open;
  InputOptions input;             ///< input.vehicle is the vehicle's name
  bool find_time_offset = false;  ///< estimate input.lidar_time_offset from the data
  bool clock_offset_given = false;
  vehicle::VehicleSettings settings;
};

/// Makes the text of settings.yaml once all input decisions are made.
using SettingsText = std::function<std::string(const std::vector<InputReport>&)>;

/// The point of a vehicle that trajectory/ describes; fleet.yaml `output.frame`.
enum class OutputPoint : std::uint8_t { kBody, kLidar, kImu };

/// The job of one `rali map` run.
struct MapJob {
  std::vector<VehicleJob> vehicles;
  /// The facts that the vehicles sent each other, in place of recordings; its members correspond to
  /// `vehicles` by index.
  std::shared_ptr<const FleetFacts> facts;
  std::string out_dir = "out";
  bool overwrite = false;
  bool strict = false;          ///< the first gap ends the run
  int threads = 0;              ///< 0: one per core; results do not depend on it
  bool find_clock_offsets = false;  ///< of vehicles whose input.clock_offset is not given
  RangeOptions ranges;          ///< of all vehicles
  fleet::FleetSettings fleet;   ///< of the joint map
  fleet::FleetKnowledge known;  ///< start poses and radios, as measured by users
  RoundsJob rounds;             ///< source of the rounds, settings of the frontiers
  std::vector<std::string> formats = {"pcd", "ply"};  ///< of map.*: pcd ply las
  map::MapSettings map;                               ///< voxel, dynamic points, 2-D grid
  /// Marks with known site coordinates; empty: no georeference.
  std::vector<SiteMark> marks;
  OutputPoint point = OutputPoint::kBody;  ///< that trajectory/ describes
  bool imu_rate = false;                   ///< also trajectory/<v>.imu.tum
  bool write_mcap = true;
  bool write_keyframes = true;  ///< false: removed again when the map is made
  std::string command_line;     ///< for run.log
  SettingsText settings_text;   ///< empty: settings.yaml is left out
};

/// Progress of a run.
struct Progress {
  std::string vehicle;
  double fraction = 0.0;  ///< 0 to 1
  double speed = 0.0;     ///< seconds of data per second
  double path_m = 0.0;
  double degenerate_fraction = 0.0;  ///< of the path
  std::size_t ranges = 0;            ///< received by the vehicle
  std::size_t ranges_used = 0;
  Time t;             ///< data time
  std::string stage;  ///< "odometry", "map", "files"
};

/// Receives progress and findings during a run; called from the thread that called run_map.
class ProgressSink {
 public:
  virtual ~ProgressSink() = default;
  virtual void progress(const Progress& progress) = 0;
  virtual void finding(const Finding& finding) = 0;
};

enum class RunStatus { kComplete, kPartial, kInterrupted, kFailed };

/// Results of one vehicle's run.
struct VehicleSummary {
  std::string name;
  InputReport input;
  double path_m = 0.0;
  std::size_t scans = 0;
  std::size_t scans_dropped = 0;
  std::size_t keyframes = 0;
  double degenerate_fraction = 0.0;       ///< of the path
  double degenerate_held_fraction = 0.0;  ///< of the degenerate path, constrained by ranges
  double sigma_median_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN without a pose
  double sigma_max_m = std::numeric_limits<double>::quiet_NaN();     ///< the same
  Time t_sigma_max;
  double diverged_s = 0.0;
  imu::MeasuredNoise imu_noise;        ///< while driving
  imu::NoiseDensity imu_noise_stated;  ///< by the settings, for a moving vehicle
  geometry::SE3 T_map_odom;            ///< at the first pose
  /// Of T_map_odom, order x y z rx ry rz about the fixed axes of map; empty without a pose.
  std::optional<geometry::Mat6> T_map_odom_cov;
  LiveTally live;
  bool levelled = false;        ///< map: by gravity, of this or a vehicle that shares it
  double tilt_sigma_rad = 0.0;  ///< of T_map_odom about the horizontal axes; NaN: not known
};

/// True if all vehicles share one frame.
[[nodiscard]] bool is_connected(const fleet::FleetEstimate& estimate);

/// Results of a run; the command line prints them.
struct MapSummary {
  RunStatus status = RunStatus::kComplete;
  std::vector<VehicleSummary> vehicles;
  RangeTally ranges;
  fleet::FleetEstimate fleet;  ///< groups, frames, loops and biases
  std::vector<fleet::RoundRow> rounds;
  std::size_t map_points = 0;
  std::size_t removed_points = 0;
  double map_thickness_m = 0.0;
  FindingList findings;      ///< all, in the order in which they came up
  std::string metrics_json;  ///< text of metrics.json
  std::string out_dir;
  CheckTally checks;
  std::optional<SiteFrame> site;  ///< pose of map on the site, from the marks
  bool gaps = false;              ///< exit code 3
};

/// Runs the vehicles over their recordings, joins them, and writes the outputs of
/// docs/reference/outputs.md. Vehicles that cannot be joined keep frames of their own, levelled by
/// gravity; `map.*` holds the largest group.
/// @param stop set from outside: the run ends at the data time reached, outputs are finished.
/// Errors: kUsage (folder not empty), kInput (unfit input), kMachine (disk); complete outputs are
/// kept.
/// Throws what an internal fault throws, once run.log and status.json (failed) are written.
[[nodiscard]] Result<MapSummary> run_map(const MapJob& job, ProgressSink& sink,
                                         const std::atomic<bool>& stop);

/// `rali map --dry-run`: opens the inputs, decides how to read them, writes nothing.
[[nodiscard]] Result<std::vector<InputReport>> plan_map(const MapJob& job);

}  // namespace rali::drive
