#pragma once

// A vehicle without sensors, for tests of agents in this room and of whole fleets.

#include <algorithm>
#include <ctime>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "rali/drive/hall_recording_for_test.hpp"
#include "rali/host/fleet_side.hpp"
#include "rali/net/fleet_link.hpp"

namespace rali::host {

inline FleetSideSetup setup_of(std::size_t index, const std::vector<std::string>& names,
                               const std::vector<geometry::SE3>& starts) {
  FleetSideSetup setup;
  setup.agent.self = VehicleId{static_cast<std::uint16_t>(index)};
  setup.agent.names = names;
  for (std::size_t v = 1; v < starts.size(); ++v) {
    fleet::GivenStart start;
    start.relative_to = VehicleId{0};
    start.vehicle = VehicleId{static_cast<std::uint16_t>(v)};
    start.T_relative_vehicle = starts[0].inverse() * starts[v];
    setup.agent.known.starts.push_back(start);
  }
  return setup;
}

/// A vehicle with exactly known poses in the hall, in place of sensors and odometry.
class ExactVehicle {
 public:
  ExactVehicle(std::size_t index, const std::vector<std::string>& names,
               const std::vector<geometry::SE3>& starts, double speed_mps,
               std::unique_ptr<net::FleetLink> fleet_link, HostTime now)
      : id_{static_cast<std::uint16_t>(index)},
        T_world_start_(starts[index]),
        speed_mps_(speed_mps),
        side(setup_of(index, names, starts), now),
        link(std::move(fleet_link)) {
    FleetSideOutputs out;
    side.take(ClockNews{}, now, out);
    make_fact(now.wall, fleet::EpochStart{names[index], {geometry::Vec3::Zero()}}, now);
  }

  void order(const view::OperatorRequest& request, HostTime now) { side.take(request, now, out_); }

  /// Advances by a tenth of a second.
  void step(HostTime now, double t_s) {
    measure(now, t_s);
    const double start_s = cpu_s();
    for (const net::Arrived& arrived : link->take()) {
      side.receive(arrived.from, std::as_bytes(std::span(arrived.bytes)), now, out_);
    }
    receive_s_max = std::max(receive_s_max, cpu_s() - start_s);
    side.tick(now, out_);
    while (!out_.agent.empty()) obey(std::exchange(out_.agent, {}), now);
    if (const auto picture = std::exchange(out_.picture, nullptr)) {
      SerialExecutor executor;
      picture->run(executor, false);
      side.take_picture(picture.get(), now, out_);
    }
    for (std::string& json : out_.paths) paths.push_back(std::move(json));
    for (RosOut& message : out_.publish) published.push_back(std::move(message));
    for (const ToSensors& news : out_.sensors) {
      peers_received += std::holds_alternative<fleet::PeerStatus>(news) ? 1 : 0;
    }
    out_ = {};
  }

  /// CPU time of the thread: other processes of a busy machine do not count.
  static double cpu_s() {
    timespec used{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  }

 private:
  VehicleId id_;
  geometry::SE3 T_world_start_;
  double speed_mps_;

 public:
  FleetSide side;
  std::unique_ptr<net::FleetLink> link;
  std::vector<RosOut> published;
  std::vector<std::string> paths;  ///< JSON of /rali/paths
  std::size_t peers_received = 0;
  double receive_s_max = 0.0;  ///< longest time to receive messages [CPU time]

 private:
  /// Jobs end at once; their outputs are processed next.
  void obey(const AgentOutputs& made, HostTime now) {
    for (const AgentOutput& output : made) {
      if (const auto* job = std::get_if<fleet::RunJob>(&output)) {
        SerialExecutor executor;
        job->job->run(executor, false);
        side.take(fleet::JobDone{job->number, job->job}, now, out_);
      } else if (const auto* send = std::get_if<SendBytes>(&output)) {
        const auto* bytes = reinterpret_cast<const std::uint8_t*>(send->bytes.data());
        static_cast<void>(link->send(send->to, send->urgency, {bytes, send->bytes.size()}));
      }
    }
  }

  void give(vehicle::Output output, HostTime now) {
    side.take(VehicleNews{std::move(output)}, now, out_);
  }

  void make_fact(Time t, fleet::FactBody body, HostTime now) {
    const fleet::Fact fact{{id_, 0, facts_++}, t, std::move(body), {}};
    give(vehicle::FactMade{std::make_shared<const fleet::Fact>(fact)}, now);
  }

  void measure(HostTime now, double t_s) {
    const double driven_m = speed_mps_ * std::clamp(t_s - 5.0, 0.0, 16.0);
    const bool at_rest = driven_m == driven_last_m_;
    driven_last_m_ = driven_m;
    vehicle::PoseEstimate pose;
    pose.vehicle = id_;
    pose.t = now.wall;
    pose.T_local_body.p.x() = driven_m;
    pose.T_odom_body = pose.T_local_body;
    pose.covariance = geometry::Mat6::Identity() * 1e-6;
    pose.at_rest = at_rest;
    give(vehicle::PeerStatus{id_, now.wall, at_rest, fleet::PeerPose{pose.T_local_body}}, now);
    give(pose, now);
    const bool keyframe = facts_ < 2 || driven_m - keyframe_m_ >= 1.0;
    if (!keyframe && t_s - node_s_ < 1.0) return;
    node_s_ = t_s;
    fleet::Increment step;
    step.node = nodes_++;
    if (keyframe) step.keyframe = keyframes_++;
    step.begins = step.node == 0;
    step.at_rest = at_rest;
    step.levelled = true;
    step.T_odom_body = pose.T_odom_body;
    step.covariance = pose.covariance;
    step.lidar_information = geometry::Mat6::Identity() * 1e6;
    make_fact(now.wall, step, now);
    if (!keyframe) return;
    keyframe_m_ = driven_m;
    make_fact(now.wall, points_at(T_world_start_ * pose.T_odom_body, *step.keyframe), now);
  }

  static fleet::KeyframePoints points_at(const geometry::SE3& T_world_body, std::uint32_t number) {
    fleet::KeyframePoints points;
    fleet::PointArrays arrays;
    points.keyframe = number;
    for (int k = 0; k < 3200; ++k) {
      const double up = (2.0 * (k % 16) - 15.0) * std::numbers::pi / 180.0;
      const double turn = 2.0 * std::numbers::pi * (k / 16) / 200.0 + 0.003;
      const geometry::Vec3 d(std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn),
                             std::sin(up));
      const geometry::Vec3 p =
          drive::test::HallRecording::distance(T_world_body.p, T_world_body.R * d) * d;
      arrays.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                       static_cast<float>(p.z()));
    }
    points.points = fleet::PackedPoints(arrays);
    return points;
  }

  FleetSideOutputs out_;
  std::uint32_t facts_ = 0, nodes_ = 0, keyframes_ = 0;
  double driven_last_m_ = 0.0, keyframe_m_ = 0.0, node_s_ = -1.0;
};

}  // namespace rali::host
