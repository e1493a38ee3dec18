#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "rali/base/executor.hpp"
#include "rali/fleet/node/node.hpp"

namespace rali::fleet {

using geometry::SE3;
using geometry::Vec3;

inline VehicleId id(std::size_t v) { return {static_cast<std::uint16_t>(v)}; }

/// Vehicles with links without delay, fed by hand; v0 has its odom at the map's origin and each
/// other one stands two metres further along x.
class Fleet {
 public:
  explicit Fleet(std::size_t n) {
    std::vector<VehicleId> all;
    FleetKnowledge known;
    for (std::size_t v = 0; v < n; ++v) all.push_back(id(v));
    for (std::size_t v = 1; v < n; ++v) {
      GivenStart start;
      start.relative_to = id(0);
      start.vehicle = id(v);
      start.T_relative_vehicle.p = {2.0 * static_cast<double>(v), 0.0, 0.0};
      known.starts.push_back(start);
    }
    NodeSettings settings;
    settings.fleet.loops.use = false;
    for (std::size_t v = 0; v < n; ++v) {
      nodes.emplace_back(id(v), all, settings, known, now);
      facts.push_back(0);
    }
  }

  void give(std::size_t v, const NodeEvent& event) {
    NodeOutputs out;
    nodes[v].step(event, now, out);
    for (const NodeOutput& o : out) {
      if (const auto* e = std::get_if<Envelope>(&o)) air.push_back(*e);
      if (const auto* a = std::get_if<RoleAction>(&o)) actions.push_back({v, a->kind});
      if (const auto* j = std::get_if<RunJob>(&o)) run_job(v, *j);
      if (const auto* c = std::get_if<CancelJob>(&o)) cancelled.push_back(c->number);
    }
  }

  /// Computed at once; the result is returned after its duration, or at once if it is cancelled.
  void run_job(std::size_t v, const RunJob& order) {
    SerialExecutor executor;
    const std::atomic<bool> never = false;
    order.job->run(executor, never);
    const bool explored = explores(order.kind);
    const Time due = now + Duration::from_s(explored ? search_s : solve_s);
    (explored ? searches : jobs).push_back({v, due, {order.number, order.job}, order.kind});
  }

  struct Pending {
    std::size_t vehicle = 0;
    Time due;
    JobDone done;
    JobKind kind = JobKind::kEstimate;
  };

  void deliver_jobs() {
    deliver(jobs);
    deliver(searches);
  }

  void deliver(std::vector<Pending>& under_way) {
    for (std::size_t k = 0; k < under_way.size();) {
      const bool given_up = std::find(cancelled.begin(), cancelled.end(),
                                      under_way[k].done.number) != cancelled.end();
      if (now < under_way[k].due && !(given_up && !solves_in_step)) {
        ++k;
        continue;
      }
      const Pending job = under_way[k];
      under_way.erase(under_way.begin() + static_cast<std::ptrdiff_t>(k));
      give(job.vehicle, job.done);
    }
  }

  /// As when steps solved: until then the vehicle neither receives messages nor has a tick.
  [[nodiscard]] bool is_busy(std::size_t v) const {
    return solves_in_step &&
           std::any_of(jobs.begin(), jobs.end(), [v](const Pending& j) { return j.vehicle == v; });
  }

  void fact(std::size_t v, FactBody body) {
    const Fact f{{id(v), 0, facts[v]++}, now, std::move(body)};
    give(v, OwnFact{std::make_shared<const Fact>(f)});
  }

  /// The vehicle's start and a keyframe of a square of ground and walls around it.
  void start(std::size_t v) {
    fact(v, EpochStart{"v", {Vec3::Zero()}});
    Increment step;
    step.keyframe = 0;
    step.begins = true;
    step.at_rest = true;
    step.levelled = true;
    step.covariance = geometry::Mat6::Identity() * 1e-6;
    step.lidar_information = geometry::Mat6::Identity() * 1e6;
    fact(v, step);
  }

  /// All pending messages, then every vehicle's tick.
  void step(double dt_s) {
    now = now + Duration::from_s(dt_s);
    deliver_jobs();
    std::deque<Envelope> mail;
    mail.swap(air);
    for (const Envelope& e : mail) {
      for (std::size_t v = 0; v < nodes.size(); ++v) {
        if (id(v) == e.from || (e.to && *e.to != id(v)) || silent.contains(v)) continue;
        if (silent.contains(e.from.value)) continue;
        if (is_busy(v)) {
          held[v].push_back(e);
          continue;
        }
        for (const Envelope& before : std::exchange(held[v], {})) give(v, before);
        give(v, e);
      }
    }
    for (std::size_t v = 0; v < nodes.size(); ++v) {
      if (is_busy(v)) continue;
      OwnPose pose;
      pose.t = now;
      pose.at_rest = !moving.contains(v);
      pose.levelled = true;
      pose.degenerate = degenerate.contains(v);
      give(v, pose);
      give(v, NodeTick{});
    }
  }

  void run(double duration_s) {
    for (double t = 0.0; t < duration_s; t += 0.1) step(0.1);
  }

  [[nodiscard]] bool did(std::size_t v, RoleActionKind kind) const {
    return std::any_of(actions.begin(), actions.end(),
                       [&](const auto& a) { return a.first == v && a.second == kind; });
  }

  std::vector<Node> nodes;
  std::vector<std::uint32_t> facts;
  std::deque<Envelope> air;
  std::vector<std::pair<std::size_t, RoleActionKind>> actions;
  std::set<std::size_t> moving, silent, degenerate;

  std::vector<Pending> jobs;      ///< running estimates
  std::vector<Pending> searches;  ///< likewise, explorations
  std::vector<std::uint64_t> cancelled;
  std::map<std::size_t, std::deque<Envelope>> held;
  double solve_s = 0.0, search_s = 0.0;
  bool solves_in_step = false;
  Time now = Time::from_s(100.0);
};

/// The second vehicle receives the first one well, then too weakly, until it has finished.
/// @return why, as recorded by the anchor
inline FinishReason receive_weakly(Fleet& fleet) {
  for (int k = 0; k < 30; ++k) {
    fleet.give(1, ReceivedRadio{id(0), -60.0});
    fleet.step(0.1);
  }
  // Three packets below -85 dBm are a weak radio, which is latched.
  const auto reason = [&] { return fleet.nodes[0].rounds().finished(id(1)); };
  for (int k = 0; k < 30 && reason() == FinishReason::kNone; ++k) {
    fleet.give(1, ReceivedRadio{id(0), -90.0});
    fleet.step(0.1);
  }
  return reason();
}

}  // namespace rali::fleet
