#include <algorithm>

#include <fmt/format.h>

#include "rali/fleet/frames/frame_solver.hpp"

namespace rali::fleet {

namespace {

std::string name_of(StreamKey key, const VehicleNames& names) {
  const auto at = names.find(key.vehicle);
  return at != names.end() ? at->second : fmt::format("v{}", key.vehicle.value);
}

}  // namespace

const FrameSolver::Link* FrameSolver::link_of(std::size_t a, std::size_t b) const {
  const auto at = links_.find({groups_[a].frames.keys.front(), groups_[b].frames.keys.front()});
  return at != links_.end() ? &at->second : nullptr;
}

/// The member of a group with the most ranges to a vehicle.
StreamKey FrameSolver::partner_of(StreamKey key, const FrameGroup& group) const {
  StreamKey best = group.keys.front();
  std::size_t maximum = 0;
  for (const StreamKey other : group.keys) {
    const auto at = tracks_.find(std::minmax(key, other));
    if (at == tracks_.end() || at->second.received() <= maximum) continue;
    maximum = at->second.received();
    best = other;
  }
  return best;
}

bool FrameSolver::placed(StreamKey key) const {
  const auto g = group_of(key);
  return g && *g == *group_of(reference_);
}

std::optional<YawPose> FrameSolver::T_ref_odom(StreamKey key) const {
  if (!placed(key)) return std::nullopt;
  const FrameGroup& group = groups_[*group_of(reference_)].frames;
  const auto place = [&group](StreamKey k) {
    const auto at = std::find(group.keys.begin(), group.keys.end(), k);
    return group.T_ref_odom[static_cast<std::size_t>(at - group.keys.begin())];
  };
  return place(reference_).inverse() * place(key);
}

FleetFrames FrameSolver::frames() const {
  FleetFrames out;
  for (const Group& g : groups_) {
    SolvedGroup solved;
    solved.frames = g.frames;
    solved.covariance = g.covariance;
    for (const StreamKey key : g.frames.keys) {
      const auto at = g.by.find(key);
      solved.by.push_back(at != g.by.end() ? at->second : DecidedBy{});
    }
    out.groups.push_back(std::move(solved));
  }
  for (std::size_t b = 0; b < groups_.size(); ++b) {
    for (std::size_t a = b + 1; a < groups_.size(); ++a) {
      const Link* link = link_of(a, b);
      if (link == nullptr) continue;
      OpenLink open;
      open.a = a;
      open.b = b;
      open.decision = link->decision;
      open.seen = link->seen;
      for (const FrameHypothesis& h : link->set.all) open.T_b_a.push_back(h.T_b_a);
      if (!link->set.all.empty()) open.views = link->set.all.front().views;
      out.links.push_back(std::move(open));
    }
  }
  return out;
}

FleetFrames joined(FleetFrames frames, const OpenLink& link) {
  frames.links.clear();
  if (link.T_b_a.empty()) return frames;
  const SolvedGroup from = frames.groups[link.a];
  SolvedGroup& into = frames.groups[link.b];
  for (std::size_t k = 0; k < from.frames.keys.size(); ++k) {
    into.frames.keys.push_back(from.frames.keys[k]);
    into.frames.T_ref_odom.push_back(link.T_b_a.front() * from.frames.T_ref_odom[k]);
    into.by.push_back(link.decision.by);
  }
  into.covariance.resize(0, 0);
  frames.groups.erase(frames.groups.begin() + static_cast<std::ptrdiff_t>(link.a));
  return frames;
}

std::string FrameSolver::text(StreamKey key, const VehicleNames& names) const {
  const std::string own = name_of(key, names);
  const std::string reference = name_of(reference_, names);
  const auto a = group_of(key);
  if (!a) return fmt::format("{}: nothing is known of it", own);
  const std::size_t b = *group_of(reference_);
  const Group& group = groups_[*a];
  if (*a == b) {
    const auto at = group.by.find(key);
    const bool by_prior = at != group.by.end() && at->second == DecidedBy::kPrior;
    return fmt::format("{}: in the frame of {}{}", own, reference,
                       by_prior ? ", decided by the prior" : "");
  }
  std::string tied;
  for (const StreamKey other : group.frames.keys) {
    if (other != key) tied += (tied.empty() ? "" : ", ") + name_of(other, names);
  }
  if (!tied.empty()) tied = fmt::format("{} is tied to {}, but not to {}. ", own, tied, reference);
  const Link* link = link_of(*a, b);
  if (link == nullptr) {
    return tied + advice_text(Advice::kNoContact, Observability{}, own, reference, settings_);
  }
  const StreamKey with = partner_of(key, groups_[b].frames);
  const bool agreeing = link->decision.ready;
  if (agreeing) {
    return tied + fmt::format("{}: frame relative to {} estimated, to be confirmed ({} of {})", own,
                              name_of(with, names), link->gate.agreed(),
                              settings_.commit.evaluations);
  }
  return tied +
         advice_text(link->decision.advice, link->seen, own, name_of(with, names), settings_);
}

}  // namespace rali::fleet
