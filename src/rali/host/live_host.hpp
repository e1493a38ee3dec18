#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "rali/base/executor.hpp"
#include "rali/drive/state/state_dir.hpp"
#include "rali/host/fleet_side.hpp"
#include "rali/host/record_writer.hpp"
#include "rali/host/sensor_side.hpp"
#include "rali/net/fleet_link.hpp"
#include "rali/net/ros_bus.hpp"
#include "rali/net/serial_port.hpp"
#include "rali/view/view_server.hpp"

namespace rali::host {

struct LiveHostSetup {
  SensorSideSetup sensors;
  FleetSideSetup fleet;
  std::uint32_t epoch = 0;
};

/// The parts of the host. All but the bus may be null: a single vehicle, no view, no state.
struct LiveHostParts {
  net::RosBus* bus = nullptr;
  net::FleetLink* link = nullptr;
  view::ViewServer* view = nullptr;
  drive::StateDir* state = nullptr;
  RecordWriter* record = nullptr;
  io::TumWriter* poses = nullptr;     ///< receives T_map_body of each pose as it is published
  net::SerialPort* serial = nullptr;  ///< of a LinkTrack radio
};

/// Callbacks of a run, called from the caller's thread.
class HostListener {
 public:
  virtual ~HostListener() = default;
  virtual void finding(const Finding& finding) = 0;

  /// Once a second.
  virtual void state(const LiveState& state) = 0;
};

/// How a run ended.
struct LiveHostEnd {
  Status status;            ///< kMachine: the recording or the poses could not be written
  std::uint64_t scans = 0;  ///< with a pose
  LiveState last;
};

/// `rali run`: one vehicle with its threads. Sensors and odometry share one; the disk, the
/// recording and the serial port have one each; agent, fleet link and view run on the caller's.
/// Values move between them through bounded queues; values that do not fit are counted and
/// reported.
class LiveHost {
 public:
  /// `executor` is used by the odometry's thread; estimates, explorations and pictures have a
  /// thread each. All parts must outlive the object.
  LiveHost(LiveHostSetup setup, const LiveHostParts& parts, Executor& executor);
  ~LiveHost();

  /// Runs until `stop`; then work in progress is finished and the state is on the disk.
  [[nodiscard]] LiveHostEnd run(HostListener& listener, const std::atomic<bool>& stop);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace rali::host
