#include "rali/host/fleet_state.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "rali/host/mode_words.hpp"

namespace rali::host {
namespace {

/// An anchor that is silent for this long is lost: the others elect another one.
constexpr double kAnchorLost_s = 10.0;
constexpr double kRangeShown_s = 2.0;

double yaw_of(const geometry::Mat3& R) { return std::atan2(R(1, 0), R(0, 0)); }

StateEllipse ellipse_of(const geometry::Mat3& P_map) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(P_map.topLeftCorner<2, 2>());
  const Eigen::Vector2d major = eigen.eigenvectors().col(1);
  const auto sigma = [&](int k) { return std::sqrt(std::max(0.0, eigen.eigenvalues()[k])); };
  return {sigma(1), sigma(0), std::atan2(major.y(), major.x())};
}

class StateMaker {
 public:
  StateMaker(const FleetSide& side, HostTime now)
      : side_(side),
        now_(now),
        agent_(*side.agent()),
        names_(side.setup().agent.names),
        t_(side.agent_time(now)) {}

  void fill(LiveState& s) const {
    const fleet::Node& node = agent_.node();
    s.t_s = t_.s();
    s.term = node.term();
    s.frame = node.T_map_odom() ? "map" : "local";
    s.mode = mode_word(node.mode());
    s.waits_for = sentence(agent_.self(), node.mode(), !node.order().places_map_m.empty());
    s.round = node.rounds().round();
    s.finished = node.done();
    s.distance_m = side_.distance_m();
    s.mission = mission();
    if (const auto anchor = agent_.anchor()) s.anchor = anchor_of(*anchor);
    for (std::size_t v = 0; v < names_.size(); ++v) {
      const VehicleId id{static_cast<std::uint16_t>(v)};
      s.vehicles.push_back(id == agent_.self() ? own() : other(id));
    }
    put_ranges(s);
    if (const auto& goals = agent_.goals()) {
      for (const fleet::Frontier& f : goals->frontiers) {
        s.frontiers.push_back({f.centre_map_m, f.size});
      }
      for (const fleet::Goal& g : goals->goals) {
        if (g.vehicle.value >= names_.size()) continue;
        // The goals of one vehicle are listed one after the other.
        const std::string& name = names_[g.vehicle.value];
        if (s.goals.empty() || s.goals.back().vehicle != name) s.goals.push_back({name, {}});
        s.goals.back().path_m.push_back(g.place_map_m);
      }
    }
    const PictureShown& picture = side_.picture();
    const MapPicture::Move& move = picture.last_move;
    s.table = StateTable{node.term(), picture.keyframes,          move.keyframes,
                         move.metres, names_[move.vehicle.value], picture.revision};
  }

 private:
  [[nodiscard]] std::string sentence(VehicleId id, fleet::Mode mode, bool has_goal) const {
    return fmt::format("{} {}.", names_[id.value], waiting_words(mode, has_goal));
  }

  [[nodiscard]] std::string mission() const {
    const auto anchor = agent_.anchor();
    const fleet::Node& node = agent_.node();
    if (node.done()) return node.explored() ? "Everything is explored." : "The mission is over.";
    if (!anchor) return "No round has begun.";
    return fmt::format("Round {}: {} stands as the anchor.", node.rounds().round(),
                       names_[anchor->value]);
  }

  [[nodiscard]] StateVehicle own() const {
    const fleet::Node& node = agent_.node();
    StateVehicle v;
    v.name = names_[agent_.self().value];
    v.role = role_word(node.mode());
    v.mode = mode_word(node.mode());
    v.waits_for = sentence(agent_.self(), node.mode(), !node.order().places_map_m.empty());
    v.age_s = 0.0;
    const auto& pose = agent_.pose();
    if (!pose) return v;
    v.age_s = std::max(0.0, seconds_between(pose->t, t_));
    const auto T = node.T_map_odom();
    const geometry::SE3 T_frame_local = T.value_or(geometry::SE3{});
    const geometry::SE3 T_frame_body = T_frame_local * pose->T_local_body;
    v.frame = T ? "map" : "local";
    v.position_m = T_frame_body.p;
    v.yaw_rad = yaw_of(T_frame_body.R);
    const geometry::Mat3 P =
        T_frame_local.R * pose->covariance.bottomRightCorner<3, 3>() * T_frame_local.R.transpose();
    v.ellipse = ellipse_of(P);
    v.sigma_z_m = std::sqrt(std::max(0.0, P(2, 2)));
    v.at_rest = pose->at_rest;
    v.speed_mps = pose->v_odom_mps.norm();
    if (const auto since = side_.degenerate_since()) {
      v.degenerate_axis = T_frame_local.R * pose->degeneracy.degenerate_odom;
      v.degenerate_since_s = seconds_between(*since, now_.boot);
    }
    return v;
  }

  [[nodiscard]] StateVehicle other(VehicleId id) const {
    StateVehicle v;
    v.name = names_[id.value];
    const auto received = agent_.received().find(id);
    if (received == agent_.received().end()) return v;
    const fleet::VehicleStatus& status = received->second.status;
    v.age_s = seconds_between(received->second.t, t_);
    v.role = role_word(status.mode);
    v.mode = *v.age_s > kAnchorLost_s ? "lost" : mode_word(status.mode);
    v.waits_for = status.waits_for.empty() ? sentence(id, status.mode, true) : status.waits_for;
    v.at_rest = status.at_rest;
    if (status.battery_fraction >= 0.0) v.battery = status.battery_fraction;
    const auto& frames = side_.picture().T_map_local;
    const auto T = frames.find(id);
    if (T == frames.end()) return v;
    const geometry::SE3 T_map_body = T->second * status.T_odom_body;
    v.position_m = T_map_body.p;
    v.yaw_rad = yaw_of(T_map_body.R);
    if (status.sigma_m > 0.0) v.ellipse = StateEllipse{status.sigma_m, status.sigma_m, 0.0};
    if (status.degenerate_azimuth_rad) {
      const double a = *status.degenerate_azimuth_rad;
      v.degenerate_axis = T->second.R * geometry::Vec3(std::cos(a), std::sin(a), 0.0);
    }
    return v;
  }

  [[nodiscard]] StateAnchor anchor_of(VehicleId id) const {
    StateAnchor anchor;
    anchor.vehicle = names_[id.value];
    const auto& rows = agent_.node().rounds().rounds();
    if (!rows.empty()) anchor.since_s = std::max(0.0, seconds_between(rows.back().start, t_));
    const auto received = agent_.received().find(id);
    if (id == agent_.self() || received == agent_.received().end()) return anchor;
    const double age_s = seconds_between(received->second.t, t_);
    if (age_s < kAnchorLost_s) return anchor;
    StateAnchorLost lost;
    lost.vehicle = anchor.vehicle;
    lost.age_s = age_s;
    lost.position_m = other(id).position_m;
    lost.message = fmt::format("No message from {} for {:.0f} s. The others elect a new anchor.",
                               anchor.vehicle, age_s);
    lost.command = "rali operator assume-lost " + anchor.vehicle;
    anchor.lost = std::move(lost);
    return anchor;
  }

  /// The newest range of each pair.
  void put_ranges(LiveState& s) const {
    std::map<std::pair<VehicleId, VehicleId>, StateRange> newest;
    for (const RecentRange& recent : side_.ranges()) {
      const sensor::RangeSample& sample = recent.use.sample;
      const double age_s = seconds_between(recent.t_boot, now_.boot);
      const bool known = sample.from.value < names_.size() && sample.to.value < names_.size();
      if (!known || age_s > kRangeShown_s) continue;
      StateRange range{names_[sample.from.value],
                       names_[sample.to.value],
                       sample.range_m,
                       recent.use.used(),
                       "",
                       age_s};
      if (!range.used) {
        range.reason = ranging::kRangeReasonNames[static_cast<std::size_t>(recent.use.reason)];
      }
      newest[{sample.from, sample.to}] = std::move(range);
    }
    for (auto& [pair, range] : newest) s.ranges.push_back(std::move(range));
  }

  const FleetSide& side_;
  HostTime now_;
  const Agent& agent_;
  const std::vector<std::string>& names_;
  Time t_;
};

}  // namespace

LiveState live_state(const FleetSide& side, const HostFacts& host, HostTime now) {
  const auto& names = side.setup().agent.names;
  const std::string& self = names[side.setup().agent.self.value];
  LiveState s;
  s.vehicle = self;
  s.t_s = side.agent_time(now).s();
  s.epoch = host.epoch;
  s.mode = "start";
  const std::string& waits_for = side.sensors().waits_for;
  s.waits_for = fmt::format("{} {}", self, waits_for.empty() ? "waits for sensors." : waits_for);
  if (side.agent() != nullptr) StateMaker(side, now).fill(s);
  for (const net::LinkCounts& link : host.links) {
    if (link.peer.value >= names.size()) continue;
    StateLink out;
    out.from = names[link.peer.value];
    out.to = self;
    out.connected = link.matched;
    const auto rate = host.rates_Bps.find(link.peer);
    if (rate != host.rates_Bps.end()) out.rate_Bps = rate->second;
    out.refused = link.refused;
    out.forged = link.forged;
    out.repeated = link.repeated;
    if (side.agent() != nullptr) {
      const auto received = side.agent()->received().find(link.peer);
      if (received != side.agent()->received().end()) {
        out.age_s = seconds_between(received->second.t, side.agent_time(now));
      }
    }
    s.links.push_back(std::move(out));
  }
  for (const SensorHealth& sensor : side.sensors().sensors) {
    if (sensor.name == "tf_static") continue;  // published only once
    StateSensor out{sensor.name, sensor.topic, sensor.rate_hz, 0, std::nullopt};
    if (sensor.t_last) out.age_s = seconds_between(*sensor.t_last, now.wall);
    if (sensor.name == "lidar") out.drops = side.sensors().order.dropped_scans;
    s.sensors.push_back(std::move(out));
  }
  s.diagnostics = diagnose(side, host, now);
  s.disk = host.disk;
  s.step_p50_s = host.step_p50_s;
  s.step_p99_s = host.step_p99_s;
  s.step_max_s = host.step_max_s;
  s.queue = host.queue;
  s.queue_max = host.queue_max;
  s.latency_p50_s = side.sensors().latency_p50_s;
  s.latency_p99_s = side.sensors().latency_p99_s;
  return s;
}

}  // namespace rali::host
