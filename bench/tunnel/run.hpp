#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rali/drive/output/corrected_path.hpp"
#include "rali/map/keyframe_view.hpp"
#include "recording.hpp"

namespace rali::tunnel {

/// Prior knowledge and radio conditions of the driver on one path.
struct Case {
  std::string name;
  sim::Scene scene = sim::Scene::kTunnel;
  AnchorPlace anchor = AnchorPlace::kMiddle;
  bool prior = true;             ///< position of the anchor, measured manually: 0.2 m, 3 deg
  double burst_fraction = 0.04;  ///< of the time in line of sight the first path is missed
  double loss_s = 0.0;           ///< radio silence in the middle of the recording
  bool until_received = false;   ///< scored only until ranges end
};

/// One row of a table.
struct Row {
  std::string label;
  Case on;
  bool ranges = true;
  bool mesh = false;                  ///< the map is compared with the world
  std::vector<std::string> settings;  ///< key=value for the vehicle
};

/// One range and its error without the systematic part of the pair (its bias).
struct RangeRow {
  ranging::RangeUse use;
  double error_m = 0.0;
};

/// A keyframe's points, for the map.
struct KeyframeKept {
  KeyframeId id;
  std::shared_ptr<const odometry::Keyframe> keyframe;
};

/// Results of one run.
struct Track {
  Time t_start;
  std::vector<drive::PoseRecord> live;           ///< live estimate at the time of processing
  std::vector<drive::PoseRecord> smoothed;       ///< estimate at the end
  std::vector<drive::KeyframeRecord> keyframes;  ///< smoothed
  std::vector<KeyframeKept> clouds;              ///< if kept
  std::vector<double> cpu_ms;                    ///< per pose: of all steps since the pose before
  eval::PoseList truth;                          ///< of every scan
  std::vector<RangeRow> ranges;
  std::vector<Time> received;  ///< ranges received by the vehicle
  Time loss_start, loss_end;
  std::vector<Finding> findings;
  std::size_t diverged = 0;
  double path_m = 0.0;
};

/// Plays the recording to a vehicle. `settings` precede those of the row. Errors (kUsage): unknown
/// settings.
[[nodiscard]] Result<Track> run(const Recording& recording, const Row& row,
                                const std::vector<std::string>& settings);

/// Checks that the vehicle accepts all these settings.
[[nodiscard]] Status check_settings(const std::vector<std::string>& settings);

}  // namespace rali::tunnel
