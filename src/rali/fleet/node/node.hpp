#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rali/fleet/facts/exchange.hpp"
#include "rali/fleet/node/events.hpp"
#include "rali/fleet/node/exploration.hpp"
#include "rali/fleet/node/fleet_mapper.hpp"
#include "rali/fleet/roles/role_machine.hpp"
#include "rali/fleet/rounds/finish.hpp"
#include "rali/fleet/rounds/round_machine.hpp"

namespace rali::fleet {

/// One vehicle's part in the fleet, as a pure function of its events (algorithms_fleet 10, 11). It
/// forwards facts, runs its role and commands its own vehicle. As anchor it also makes the map,
/// finds the frontiers and sends all vehicles to goals. It reads no clock and no bytes. Steps do
/// not solve, draw or search: these are jobs, which the host runs beside the steps (RunJob).
class Node {
 public:
  /// @param fleet all vehicles, this one included  @param start contents of the disk
  Node(VehicleId self, std::vector<VehicleId> fleet, const NodeSettings& settings,
       const FleetKnowledge& known, Time now, NodeStart start = {});

  /// Processes one event and appends the outputs that follow. `now` is the vehicle's own clock; it
  /// must not go back.
  void step(const NodeEvent& event, Time now, NodeOutputs& out);

  [[nodiscard]] const DriveOrder& order() const { return order_; }

  /// Of this vehicle, by the frame in the last table; nothing before.
  [[nodiscard]] std::optional<geometry::SE3> T_map_odom() const;

  [[nodiscard]] const std::optional<OwnPose>& pose() const { return pose_; }

  [[nodiscard]] Mode mode() const;

  [[nodiscard]] std::uint64_t term() const { return role_.durable.term; }

  /// The mission is over: no frontier is left, or no vehicle makes progress.
  [[nodiscard]] bool done() const { return done_; }

  /// No frontier was left when it ended.
  [[nodiscard]] bool explored() const {
    const std::vector<RoundRow>& rows = rounds_.rounds();
    return !rows.empty() && rows.back().ended_by == RoundEnd::kExplored;
  }

  /// As this vehicle received them; for rounds in which it was anchor, with all details.
  [[nodiscard]] const RoundMachine& rounds() const { return rounds_; }

  [[nodiscard]] const FactStore& store() const { return store_; }

  [[nodiscard]] std::uint32_t epoch() const { return epoch_; }

  /// Poses of the fleet's keyframes, as last received.
  [[nodiscard]] const std::map<KeyframeId, KeyframePose>& map_poses() const { return poses_; }

  /// The map made as anchor; null otherwise.
  [[nodiscard]] const FleetMapper* mapper() const { return mapper_.get(); }

  /// Frontier search, once this vehicle has been anchor; null before.
  [[nodiscard]] const Exploration* exploration() const { return exploration_.get(); }

 private:
  struct Peer {
    VehicleStatus status;
    Time t;
  };

  // Received messages and measurements.
  void on(const OwnFact& event);
  void on(const OwnPose& event);
  void on(const ReceivedRange& event);
  void on(const ReceivedRadio& event);
  void on(const DriveStatus& event);
  void on(const Envelope& event);
  void on(const Persisted& event);
  void on(const PersistFailed& event);
  void on(const ConfirmRole& event);
  void on(const OperatorOrder& event);
  void on(const NodeTick& event);
  void on(const JobDone& event);
  void on(const VehicleStatus& status, VehicleId from);
  void restarted(VehicleId peer);
  void on(const Table& table, VehicleId from);
  void on(const SeparatorPrior& separator, VehicleId from);
  void on(const GoalList& goals, VehicleId from);

  // The role.
  void give(const RoleEvent& event);
  void act(const RoleAction& action);
  void follow(VehicleId anchor);
  void send_role(RoleSend send);
  void report_self();
  void watch_finish();
  [[nodiscard]] bool was_near(const FinishInput& input);
  void became_anchor(bool new_round);
  void start_mapper();
  void stopped_anchoring();
  void sealed();
  void solved();
  void round_ended();
  void note_stops();
  void offer_choice();

  // The anchor's map (node_anchor.cpp).
  void mapper_tick();
  [[nodiscard]] double next_estimate_after_s();
  void add_new_facts();
  void report_map();
  void report_tables(double moved_m);
  void keep(const Table& table);
  void report_separator_prior();

  // Its jobs (node_jobs.cpp).
  struct UnderWay {
    JobKind kind = JobKind::kEstimate;
    std::uint64_t number = 0, term = 0;
    bool wanted = true;
  };

  void start_estimate(JobKind kind);
  void start_exploration(JobKind kind);
  void take_estimate(const UnderWay& job, Job* back);
  void take_exploration(const UnderWay& job, Job* back);
  void cancel_jobs();
  void hold_handover();
  void give_up_seal();
  [[nodiscard]] std::vector<FactPtr> all_facts() const;

  [[nodiscard]] FleetMapper* any_mapper() { return mapper_ ? mapper_.get() : resting_.get(); }

  void send_fleet();
  void note_frontiers(bool facts_agree);
  void report_goals();
  void end_mission(RoundEnd why);
  [[nodiscard]] std::optional<Time> progress_since() const;
  [[nodiscard]] std::vector<PeerState> peer_state() const;
  [[nodiscard]] bool facts_are_here() const;
  [[nodiscard]] bool is_lost(VehicleId vehicle) const;

  // Where to go.
  void drive();
  void stand();
  void go(std::vector<geometry::Vec3> places_map_m);
  [[nodiscard]] std::vector<geometry::Vec3> path_back() const;

  [[nodiscard]] VehicleStatus status() const;
  [[nodiscard]] std::optional<DriveEnd> drive_end() const;
  [[nodiscard]] std::optional<geometry::Vec3> place_of(VehicleId vehicle) const;

  [[nodiscard]] bool is_moving() const { return !standing_since_.has_value(); }

  void post(std::optional<VehicleId> to, Message message);
  void report(std::string id, Severity severity, std::string text);

  VehicleId self_;
  std::uint32_t epoch_ = 0;
  NodeSettings settings_;
  FleetKnowledge known_;
  Time begin_, now_;
  NodeOutputs* out_ = nullptr;  ///< of the step that is being taken

  FactStore store_;
  Exchange exchange_;
  RoleState role_;
  FinishWatch finish_;
  FinishView finish_view_;
  RoundMachine rounds_;
  std::map<VehicleId, Peer> peers_;
  std::uint32_t role_messages_ = 0;

  bool logs_ = false;              ///< what must be stored waits for the disk
  std::uint64_t roles_saved_ = 0;  ///< number of the last SaveRole
  std::uint64_t roles_kept_ = 0;   ///< likewise, of those on the disk
  std::deque<std::pair<std::uint64_t, RoleSend>> waiting_roles_;  ///< for that SaveRole
  bool disk_fails_ = false;

  std::optional<OwnPose> pose_;
  std::optional<Time> rested_, standing_since_;
  std::vector<geometry::Vec3> trail_odom_m_;  ///< of the last metres
  FinishInput input_;                         ///< accumulated since the last evaluation
  double rssi_dbm_ = 0.0;                     ///< last received from the anchor; 0: none
  DriveStatus drive_;
  std::uint32_t ranges_to_anchor_ = 0;
  Time followed_;          ///< start of the round, as a tag
  bool was_near_ = false;  ///< the anchor, in this round
  Time next_status_, next_finish_, next_claim_;

  std::map<StreamKey, geometry::SE3> frames_;  ///< T_map_odom of all, as last received
  std::map<KeyframeId, KeyframePose> poses_;   ///< of all keyframes, as last received
  std::optional<SeparatorPrior> separator_;    ///< of the last anchor that sent one
  std::optional<GoalList> goals_;
  /// Received since this vehicle was last anchor: newer than its own memory of that time.
  std::optional<map::FrontierMemory> frontiers_received_;
  std::pair<std::uint64_t, std::uint32_t> goals_rank_;
  DriveOrder order_;
  bool backs_ = false;
  bool done_ = false;

  std::unique_ptr<FleetMapper> mapper_;
  std::unique_ptr<FleetMapper> resting_;  ///< of a round in which this vehicle was the anchor
  std::unique_ptr<Exploration> exploration_;
  std::map<VehicleId, FinishReason> tags_;
  std::uint32_t revision_ = 0, goal_revision_ = 0;
  Time next_estimate_, next_look_, next_goals_;
  double estimate_after_s_ = 0.0;  ///< from the next estimate to the one after it
  std::optional<Inventory> seal_;
  Time sealed_at_;

  /// A sealed round whose last jobs have not returned yet.
  struct Sealing {
    RoundEnd why = RoundEnd::kOpen;
    bool solved = false;
  };

  std::optional<Sealing> sealing_;
  std::optional<UnderWay> estimating_, exploring_;
  std::uint64_t jobs_ = 0;
  std::vector<VehicleId> ranked_;
  std::string waits_for_;  ///< last report about vehicles that are not placed
};

}  // namespace rali::fleet
