#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rali/host/agent.hpp"
#include "rali/host/host_clock.hpp"
#include "rali/host/live_state.hpp"
#include "rali/host/picture_job.hpp"
#include "rali/host/ros_outputs.hpp"
#include "rali/host/sensor_side.hpp"
#include "rali/view/view_server.hpp"

namespace rali::host {

struct FleetSideSetup {
  AgentSetup agent;
  map::ExploreSettings grid;
  /// If no sensor data arrive for this long, the vehicle joins the fleet with its wall clock.
  double sensors_wait_s = 30.0;
};

/// The outputs of a call; the caller empties it.
struct FleetSideOutputs {
  AgentOutputs agent;
  std::vector<ToSensors> sensors;
  std::vector<RosOut> publish;
  std::vector<std::string> paths;  ///< JSON of /rali/paths
  /// To be run outside the steps, and returned with take_picture(). Null: none.
  std::shared_ptr<PictureJob> picture;
};

/// A finding that the live page and /diagnostics still show.
struct RecentFinding {
  Finding finding;
  Time t_boot;
};

/// A range with its judgement by the odometry.
struct RecentRange {
  ranging::RangeUse use;
  Time t_boot;
};

/// The fleet part of one vehicle: agent, and the published topics of vehicle and map. The work of
/// its thread, without the thread; the map is drawn by jobs.
class FleetSide {
 public:
  FleetSide(FleetSideSetup setup, HostTime now);

  void take(ToAgent news, HostTime now, FleetSideOutputs& out);

  /// Bytes from the verified sender `from`.
  void receive(VehicleId from, std::span<const std::byte> bytes, HostTime now,
               FleetSideOutputs& out);

  void take(const fleet::NodeEvent& from_disk, HostTime now, FleetSideOutputs& out);

  void take(const fleet::JobDone& done, HostTime now, FleetSideOutputs& out);

  /// A requested picture is drawn. Null: it was lost, and is drawn again.
  void take_picture(fleet::Job* done, HostTime now, FleetSideOutputs& out);

  /// A command of `rali operator`. Unknown words and vehicles become a Finding.
  void take(const view::OperatorRequest& request, HostTime now, FleetSideOutputs& out);

  /// Ten times a second.
  void tick(HostTime now, FleetSideOutputs& out);

  /// Null: the clock of the sensors is not known yet.
  [[nodiscard]] const Agent* agent() const { return agent_.get(); }

  [[nodiscard]] const FleetSideSetup& setup() const { return setup_; }

  /// The last picture drawn.
  [[nodiscard]] const PictureShown& picture() const { return shown_; }

  [[nodiscard]] const SensorNews& sensors() const { return sensors_; }

  [[nodiscard]] const std::deque<RecentFinding>& findings() const { return findings_; }

  [[nodiscard]] const std::deque<RecentRange>& ranges() const { return ranges_; }

  [[nodiscard]] std::optional<Time> degenerate_since() const { return degenerate_since_; }

  [[nodiscard]] double distance_m() const { return distance_m_; }

  /// On the clock of the sensors.
  [[nodiscard]] Time agent_time(HostTime now) const { return now.boot + offset_; }

  /// The caller makes the lines of /diagnostics: they also cover links and disk.
  void publish_diagnostics(const std::vector<DiagnosticLine>& lines, HostTime now,
                           FleetSideOutputs& out) const;

 private:
  void start_agent(HostTime now, Duration ahead);
  void take_output(const vehicle::Output& output, Time t, HostTime now, FleetSideOutputs& out);
  void sort_out(HostTime now, FleetSideOutputs& out);
  void publish_goal(Time t, FleetSideOutputs& out);
  void order_picture(Time t, HostTime now, FleetSideOutputs& out);
  [[nodiscard]] bool due(Time& next, double period_s, Time now) const;
  [[nodiscard]] std::string role_text() const;

  FleetSideSetup setup_;
  RosOutputs outputs_;
  Time start_boot_;
  Duration offset_;  ///< agent's clock minus boot clock
  std::unique_ptr<Agent> agent_;
  AgentOutputs agent_out_;
  std::unique_ptr<MapPicture> picture_;  ///< null while a job has it
  MapNewsReader map_news_;
  PictureShown shown_;
  SensorNews sensors_;
  std::deque<RecentFinding> findings_;
  std::deque<RecentRange> ranges_;
  std::optional<Time> degenerate_since_;
  std::optional<geometry::Vec3> p_last_;
  double distance_m_ = 0.0;
  std::optional<std::uint64_t> goal_reported_;
  bool goals_changed_ = false;
  Time next_frame_, next_delta_, next_frontiers_, next_grid_, next_cloud_, next_paths_, next_role_;
};

}  // namespace rali::host
