#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/time.hpp"
#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/messages/boundary.hpp"
#include "rali/fleet/messages/peer_status.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/map/named_frontier.hpp"

/// Everything that goes from one vehicle to another, as values; their bytes are in wire/fleet.
/// Facts are for good; all else is soft state that the next message of its kind replaces, so a lost
/// one only delays (algorithms_fleet 11.1, middleware 4.2).
namespace rali::fleet {

/// Numbers first to last, both included.
struct SeqInterval {
  std::uint32_t first = 0, last = 0;
  constexpr auto operator<=>(const SeqInterval&) const = default;
};

/// What is held of one stream: all numbers below `end` except the gaps.
struct StreamInventory {
  StreamKey stream;
  std::uint32_t end = 0;
  std::vector<SeqInterval> gaps;  ///< ascending, disjoint, all below `end`
  bool operator==(const StreamInventory&) const = default;
};

/// A fact, from its author or from one who passes it on; never null.
struct FactMessage {
  std::shared_ptr<const Fact> fact;
};

/// What a vehicle holds of the whole fleet.
struct Inventory {
  std::uint32_t number = 0;              ///< running number of the sender's inventories
  std::uint64_t free_bytes = 0;          ///< that its disk still takes
  std::vector<StreamInventory> streams;  ///< ascending by key
  bool operator==(const Inventory&) const = default;
};

/// A stretch of a stream that the sender of a request lacks.
struct Want {
  StreamKey stream;
  SeqInterval numbers;
  std::uint8_t priority = 0;  ///< 0 first; with equal ones the order in the request
  bool operator==(const Want&) const = default;
};

/// Asks one holder for facts, and says how many bytes it may send before it is asked again.
struct Request {
  std::uint32_t number = 0;  ///< running number of the sender's requests
  std::uint32_t window_bytes = 0;
  /// The sender takes no points now (in a round they go to the anchor alone, 11.4).
  bool without_points = false;
  std::vector<Want> wants;
  bool operator==(const Request&) const = default;
};

/// Answer to a request without points: these numbers that were asked for are points.
struct Withheld {
  StreamKey stream;
  std::vector<SeqInterval> numbers;
  bool operator==(const Withheld&) const = default;
};

/// What an estimate knows of a pose, in few numbers: the ellipse of its place in the map's plane,
/// height and heading.
struct PoseSigma {
  double major_m = 0.0, minor_m = 0.0;  ///< along the ellipse's axes
  double major_azimuth_rad = 0.0;       ///< of the major axis in the map, [0, pi)
  double z_m = 0.0;
  double yaw_rad = 0.0;
};

/// Where a keyframe lies now.
struct TablePose {
  StreamKey stream;
  std::uint32_t keyframe = 0;
  geometry::SE3 T_map_body;
  PoseSigma sigma;
};

/// Where an odom frame lies now. Frames of one group share one map; frames of different groups
/// have nothing to do with each other yet (7.4: unplaced).
struct TableFrame {
  StreamKey stream;
  std::uint16_t group = 0;   ///< smallest vehicle number of those tied together
  geometry::SE3 T_map_odom;  ///< `map` is that of the group
  PoseSigma sigma;
};

/// The central estimate, or what changed in it since `base_revision`; in parts, so that a lost part
/// does not lose the others. The last (term, revision) wins.
struct Table {
  std::uint64_t term = 0;
  std::uint32_t revision = 0;       ///< of this table, counted within the term
  std::uint32_t base_revision = 0;  ///< what it is a change of; 0: of nothing, all poses are here
  std::uint16_t part = 0;           ///< running number of the part, from 0
  bool last_part = true;
  std::uint64_t hash = 0;  ///< over all poses of this revision, not only those told here (9.3)
  std::vector<TableFrame> frames;  ///< ascending by stream
  std::vector<TablePose> poses;    ///< ascending by stream, keyframe
};

/// What a role message is for (middleware 4.3).
enum class RoleOp : std::uint8_t {
  kHeartbeat = 1,  ///< the anchor of `term` renews its lease
  kAck,            ///< answer to a heartbeat, with the stamps of both
  kFinished,       ///< a tag has finished its part of the round and stands
  kSeal,           ///< the anchor ends the round: no more tables of this term after `revision`
  kHandover,       ///< names the `candidate` for `term`
  kPropose,        ///< the `candidate` asks for votes for `term`
  kGrant,          ///< a vote for the `candidate` of `term`
  kRefuse,         ///< no vote; `term` is the refuser's own
  kCommit          ///< the `candidate` is the anchor of `term`
};

/// Why a tag has finished (algorithms_fleet 10.1).
enum class FinishReason : std::uint8_t {
  kNone,
  kSignal,
  kDistance,
  kExplored,
  kRangeLost,
  kSigma,
  kUnreachable,
  kBattery,
  kTimeout,
  kOperator
};

/// A message of the role machine (algorithms_fleet 10.5).
struct RoleMessage {
  RoleOp op = RoleOp::kHeartbeat;
  std::uint64_t term = 0;
  std::uint32_t number = 0;    ///< running number of the sender's role messages
  VehicleId candidate;         ///< handover, propose, grant, refuse, commit
  std::uint32_t revision = 0;  ///< of the sender's last table: heartbeat, seal, commit
  Duration lease;              ///< heartbeat: how long it is good after t_send
  Time t_send;                 ///< on the sender's own clock
  /// Ack: the heartbeat's t_send as it came, and when it came on this sender's clock. With t_send
  /// and the time of arrival these are the four stamps of a clock comparison.
  Time t_echo, t_heard;
  FinishReason reason = FinishReason::kNone;  ///< finished
  geometry::SE3 T_odom_body;                  ///< finished: where it stands
  Inventory inventory;                        ///< finished, seal: what the sender holds
};

/// What a vehicle does.
enum class Mode : std::uint8_t {
  kStarting,
  kUnplaced,   ///< its frame has no place in the map yet
  kExploring,  ///< a tag on its way
  kFinished,   ///< a tag that stands
  kAnchor,     ///< stands as reference and makes the tables
  kSealed,     ///< an anchor that ends the round
  kCandidate,  ///< asks for votes
  kOrphan,     ///< without a majority: stands, makes no tables
  kDone,
  kHolding  ///< stands until the new anchor has its ranges to it
};

/// How a drive to a goal goes.
enum class DriveState : std::uint8_t {
  kStanding,  ///< no goal
  kDriving,
  kArrived,
  kUnreachable,  ///< given up: no path leads there
  kBlocked       ///< given up: another vehicle stands in every path
};

/// How the drive to a goal ended: arrived, unreachable or blocked.
struct DriveEnd {
  DriveState state = DriveState::kArrived;
  geometry::Vec3 goal_map_m = geometry::Vec3::Zero();
};

/// How a vehicle is, once a second.
struct VehicleStatus {
  std::uint32_t epoch = 0;
  std::uint64_t term = 0;
  Mode mode = Mode::kStarting;
  std::string waits_for;        ///< a sentence for people (7.3), at most 240 bytes; empty: nothing
  double battery_share = -1.0;  ///< 0 to 1; negative: not known
  geometry::SE3 T_odom_body;
  double sigma_m = 0.0;  ///< largest standard deviation of the place
  /// The horizontal direction that LiDAR does not tell, in odom; none: it tells all.
  std::optional<double> blind_azimuth_rad;
  bool at_rest = false;
  double rssi_dbm = 0.0;  ///< median to the anchor; 0: not known
  Time t_send;            ///< on the sender's own clock
  /// Of the goal that it has; none: it is on its path, or has no goal.
  std::optional<DriveEnd> drive_end;
};

/// The edge of what is known, and how much lies behind it (10.2).
struct Frontier {
  geometry::Vec3 centre_map_m = geometry::Vec3::Zero();
  double size = 0.0;  ///< by rounds.frontier_size
};

/// Where a vehicle is to go.
struct Goal {
  VehicleId vehicle;
  geometry::Vec3 place_map_m = geometry::Vec3::Zero();
  std::optional<std::uint32_t> frontier;  ///< index in the list; none: stand, or drive back
};

/// Frontiers and who goes where; the last (term, revision) wins.
struct GoalList {
  std::uint64_t term = 0;
  std::uint32_t revision = 0;
  std::uint16_t group = 0;  ///< whose map
  std::vector<Frontier> frontiers;
  std::vector<Goal> goals;
  /// What the anchor remembers of frontiers, given up ones among them: whoever is anchor next goes
  /// on with it, and sends nobody where visits have changed nothing.
  map::FrontierMemory memory;
};

using Message = std::variant<FactMessage, Inventory, Request, Withheld, Table, RoleMessage,
                             VehicleStatus, GoalList, RoundBoundary, PeerStatus>;

/// A message and its way.
struct Envelope {
  VehicleId from;
  std::optional<VehicleId> to;  ///< none: all of the fleet
  Message message;
};

}  // namespace rali::fleet
