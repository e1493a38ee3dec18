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
#include "rali/fleet/messages/peer_status.hpp"
#include "rali/fleet/messages/separator_prior.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/map/named_frontier.hpp"

/// All messages between vehicles, as values; their encoding is in wire/fleet. Facts are permanent;
/// all else is soft state that the next message of its kind replaces, so a lost one only causes a
/// delay (algorithms_fleet 11.1, middleware 4.2).
namespace rali::fleet {

/// Numbers first to last, both included.
struct SeqInterval {
  std::uint32_t first = 0, last = 0;
  constexpr auto operator<=>(const SeqInterval&) const = default;
};

/// Numbers held of one stream: all below `end` except the gaps.
struct StreamInventory {
  StreamKey stream;
  std::uint32_t end = 0;
  std::vector<SeqInterval> gaps;  ///< ascending, disjoint, all below `end`
  bool operator==(const StreamInventory&) const = default;
};

/// A fact, from its author or from a vehicle that forwards it; never null.
struct FactMessage {
  std::shared_ptr<const Fact> fact;
};

/// Facts that a vehicle holds of the whole fleet.
struct Inventory {
  std::uint32_t number = 0;              ///< running number of the sender's inventories
  std::uint64_t free_bytes = 0;          ///< space left on its disk
  std::vector<StreamInventory> streams;  ///< ascending by key
  bool operator==(const Inventory&) const = default;
};

/// An interval of a stream that the sender of a request lacks.
struct Want {
  StreamKey stream;
  SeqInterval numbers;
  std::uint8_t priority = 0;  ///< 0 first; equal ones in the order of the request
  bool operator==(const Want&) const = default;
};

/// Requests facts from one holder, with the number of bytes it may send before the next request.
struct Request {
  std::uint32_t number = 0;  ///< running number of the sender's requests
  std::uint32_t window_bytes = 0;
  /// The sender takes no points now (in a round they go to the anchor alone, 11.4).
  bool without_points = false;
  std::vector<Want> wants;
  bool operator==(const Request&) const = default;
};

/// Answer to a request without points: these requested numbers are points.
struct Withheld {
  StreamKey stream;
  std::vector<SeqInterval> numbers;
  bool operator==(const Withheld&) const = default;
};

/// Uncertainty of a pose in few numbers: the ellipse of its position in the map's plane, height and
/// heading.
struct PoseSigma {
  double major_m = 0.0, minor_m = 0.0;  ///< along the ellipse's axes
  double major_azimuth_rad = 0.0;       ///< of the major axis in the map, [0, pi)
  double z_m = 0.0;
  double yaw_rad = 0.0;
};

/// Current pose of a keyframe.
struct TablePose {
  StreamKey stream;
  std::uint32_t keyframe = 0;
  geometry::SE3 T_map_body;
  PoseSigma sigma;
};

/// Current pose of an odom frame. Frames of one group share one map; the transform between frames
/// of different groups is not known yet (7.4: unplaced).
struct TableFrame {
  StreamKey stream;
  std::uint16_t group = 0;   ///< smallest vehicle number of the connected ones
  geometry::SE3 T_map_odom;  ///< `map` is that of the group
  PoseSigma sigma;
};

/// The central estimate, or its changes since `base_revision`; in parts, so that a lost part does
/// not lose the others. The last (term, revision) wins.
struct Table {
  std::uint64_t term = 0;
  std::uint32_t revision = 0;       ///< of this table, counted within the term
  std::uint32_t base_revision = 0;  ///< base of the changes; 0: none, all poses are included
  std::uint16_t part = 0;           ///< running number of the part, from 0
  bool last_part = true;
  std::uint64_t hash = 0;  ///< over all poses of this revision, not only those sent here (9.3)
  std::vector<TableFrame> frames;  ///< ascending by stream
  std::vector<TablePose> poses;    ///< ascending by stream, keyframe
};

/// Purpose of a role message (middleware 4.3).
enum class RoleOp : std::uint8_t {
  kHeartbeat = 1,  ///< the anchor of `term` renews its lease
  kAck,            ///< answer to a heartbeat, with the timestamps of both
  kFinished,       ///< a tag has finished its part of the round and keeps standstill
  kSeal,           ///< the anchor ends the round: no more tables of this term after `revision`
  kHandover,       ///< names the `candidate` for `term`
  kPropose,        ///< the `candidate` asks for votes for `term`
  kGrant,          ///< a vote for the `candidate` of `term`
  kRefuse,         ///< no vote; `term` is the refuser's own
  kCommit          ///< the `candidate` is the anchor of `term`
};

/// Reason why a tag has finished (algorithms_fleet 10.1).
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
  Duration lease;              ///< heartbeat: how long it is valid after t_send
  Time t_send;                 ///< on the sender's own clock
  /// Ack: the heartbeat's t_send unchanged, and its arrival on this sender's clock. With t_send and
  /// the time of arrival these are the four timestamps of a clock comparison.
  Time t_echo, t_received;
  FinishReason reason = FinishReason::kNone;  ///< finished
  geometry::SE3 T_odom_body;                  ///< finished: pose at standstill
  Inventory inventory;                        ///< finished, seal: facts held by the sender
};

/// What a vehicle does.
enum class Mode : std::uint8_t {
  kStarting,
  kUnplaced,   ///< its frame has no place in the map yet
  kExploring,  ///< a tag that drives
  kFinished,   ///< a tag at standstill
  kAnchor,     ///< keeps standstill as reference and makes the tables
  kSealed,     ///< an anchor that ends the round
  kCandidate,  ///< asks for votes
  kOrphan,     ///< without a majority: keeps standstill, makes no tables
  kDone,
  kHolding  ///< keeps standstill until the new anchor has its ranges to it
};

/// State of a drive to a goal.
enum class DriveState : std::uint8_t {
  kStanding,  ///< no goal
  kDriving,
  kArrived,
  kUnreachable,  ///< given up: no path leads there
  kBlocked,      ///< given up: another vehicle blocks every path
  kGivenUp       ///< given up; the driver does not say why
};

/// How the drive to a goal ended: arrived, unreachable or blocked.
struct DriveEnd {
  DriveState state = DriveState::kArrived;
  geometry::Vec3 goal_map_m = geometry::Vec3::Zero();
};

/// State of a vehicle, sent once a second.
struct VehicleStatus {
  std::uint32_t epoch = 0;
  std::uint64_t term = 0;
  Mode mode = Mode::kStarting;
  std::string waits_for;  ///< a sentence for people (7.3), at most 240 bytes; empty: nothing
  double battery_fraction = -1.0;  ///< 0 to 1; negative: unknown
  geometry::SE3 T_odom_body;
  double sigma_m = 0.0;  ///< largest standard deviation of the position
  /// Azimuth of the degenerate horizontal direction of the LiDAR, in odom; none: not degenerate.
  std::optional<double> degenerate_azimuth_rad;
  bool at_rest = false;
  double rssi_dbm = 0.0;  ///< median to the anchor; 0: unknown
  Time t_send;            ///< on the sender's own clock
  /// Of its goal; none: it is driving, or has no goal.
  std::optional<DriveEnd> drive_end;
};

/// Border of the mapped area, and the size of the unknown area behind it (10.2).
struct Frontier {
  geometry::Vec3 centre_map_m = geometry::Vec3::Zero();
  double size = 0.0;  ///< by rounds.frontier_size
};

/// Goal of a vehicle.
struct Goal {
  VehicleId vehicle;
  geometry::Vec3 place_map_m = geometry::Vec3::Zero();
  std::optional<std::uint32_t> frontier;  ///< index in the list; none: stop, or drive back
};

/// Frontiers and goals; the last (term, revision) wins.
struct GoalList {
  std::uint64_t term = 0;
  std::uint32_t revision = 0;
  std::uint16_t group = 0;  ///< whose map
  std::vector<Frontier> frontiers;
  std::vector<Goal> goals;
  /// Frontier memory of the anchor, including those given up. The next anchor continues with it,
  /// and sends no vehicle where visits have changed nothing.
  map::FrontierMemory memory;
};

using Message = std::variant<FactMessage, Inventory, Request, Withheld, Table, RoleMessage,
                             VehicleStatus, GoalList, SeparatorPrior, PeerStatus>;

/// A message with sender and receiver.
struct Envelope {
  VehicleId from;
  std::optional<VehicleId> to;  ///< none: all of the fleet
  Message message;
};

}  // namespace rali::fleet
