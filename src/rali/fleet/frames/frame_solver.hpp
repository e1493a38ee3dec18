#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "rali/fleet/frames/commit_gate.hpp"

namespace rali::fleet {

/// Vehicles whose relative frames are known.
struct SolvedGroup {
  FrameGroup frames;  ///< T_ref_odom of each; the reference first, then in order of joining
  /// Of (yaw, translation) of T_ref_odom of all but the reference, in their order [rad, m].
  Eigen::MatrixXd covariance;
  std::vector<DecidedBy> by;  ///< per key; of the reference without meaning
};

/// State of the transform between two groups that are not joined yet.
struct OpenLink {
  std::size_t a = 0, b = 0;  ///< indices of groups
  Decision decision;
  Observability seen;
  std::vector<YawPose> T_b_a;  ///< remaining hypotheses, cheapest first
  int views = 0;               ///< unambiguous place recognitions that agree with the first
};

struct FleetFrames {
  std::vector<SolvedGroup> groups;  ///< that of the reference vehicle first
  std::vector<OpenLink> links;
};

/// The frames if the first hypothesis of a link were true; its links are left out.
[[nodiscard]] FleetFrames joined(FleetFrames frames, const OpenLink& link);

/// Names of vehicles for messages; a missing one is called "v" and its number.
using VehicleNames = std::map<VehicleId, std::string>;

/// Determines the frames of a fleet (algorithms_fleet 7). Every vehicle starts as a group of its
/// own. Two groups are joined when their transform is certain, whichever of their vehicles measured
/// it: so a vehicle may be placed through another tag. All frames of a group are solved together.
/// Groups that cannot be joined stay separate, with the reason in words (U23).
///
/// A value without clock; the order in which groups are tried is that of the keys.
class FrameSolver {
 public:
  /// @param reference the vehicle whose frame is the global one; its group is the first
  FrameSolver(const InitSettings& settings, StreamKey reference);

  /// A participating vehicle, even if no measurement of it exists.
  void add_vehicle(StreamKey key);

  /// A range between two vehicles; they are added if they are new.
  TrackUse add_range(StreamKey a, StreamKey b, const RangeObservation& observation);

  /// Other evidence between two vehicles; they are added if they are new. Evidence within one group
  /// helps to solve it.
  void add_evidence(const PoseEvidence& evidence);

  /// Number of keyframes of its local map.
  void set_keyframes(StreamKey key, int keyframes) { keyframes_[key] = keyframes; }

  /// Evaluates all links with new measurements, joins groups whose transform is certain, and solves
  /// the groups again. @param t time of the fleet, not before that of the last call
  void evaluate(Time t);

  /// Places a vehicle by an earlier result, e.g. of the former centre of the fleet: vehicle `a`
  /// joins the group of `b` at once, and `known` stays as evidence. No effect if `a` is in a group
  /// already.
  void place(const PoseEvidence& known);

  [[nodiscard]] FleetFrames frames() const;

  /// One sentence about the relation of the vehicle to the reference.
  [[nodiscard]] std::string text(StreamKey key, const VehicleNames& names) const;

  [[nodiscard]] bool placed(StreamKey key) const;

  /// T_ref_odom, once the vehicle is placed.
  [[nodiscard]] std::optional<YawPose> T_ref_odom(StreamKey key) const;

 private:
  using KeyPair = std::pair<StreamKey, StreamKey>;

  struct Group {
    FrameGroup frames;
    Eigen::MatrixXd covariance;
    std::map<StreamKey, DecidedBy> by;
    std::set<KeyPair> held_priors;  ///< ends of the start poses that agree with its joins
    std::size_t received = 0;       ///< ranges and evidence at the time of its solution
  };

  /// Between two groups, by their first keys.
  struct Link {
    std::size_t received = 0;  ///< ranges and evidence at the last evaluation
    std::size_t members = 0;   ///< of both groups, at that time
    HypothesisSet set;
    Observability seen;
    Decision decision;
    CommitGate gate;
  };

  [[nodiscard]] const Link* link_of(std::size_t a, std::size_t b) const;
  [[nodiscard]] StreamKey partner_of(StreamKey key, const FrameGroup& group) const;
  [[nodiscard]] std::optional<std::size_t> group_of(StreamKey key) const;
  [[nodiscard]] std::size_t received_between(const FrameGroup& a, const FrameGroup& b) const;
  [[nodiscard]] int keyframes(const FrameGroup& a, const FrameGroup& b) const;
  [[nodiscard]] std::vector<PairTrack> tracks_of(const FrameGroup& a, const FrameGroup& b) const;
  bool look(Time t, const Group& a, const Group& b);
  void join(std::size_t a, std::size_t b);
  void solve(Group& group, bool anew);
  void take(Group& group, const FrameProblem& problem, const FrameSolution& solution);

  InitSettings settings_;
  StreamKey reference_;
  std::vector<Group> groups_;
  std::map<KeyPair, PairTrack> tracks_;
  std::vector<PoseEvidence> evidence_;
  std::map<StreamKey, int> keyframes_;
  std::map<KeyPair, Link> links_;
};

}  // namespace rali::fleet
