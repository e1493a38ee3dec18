// A node and its disk: votes and inventories wait for it, and a restart restores them.
#include <set>

#include <gtest/gtest.h>

#include "rali/fleet/node/node.hpp"

namespace rali::fleet {
namespace {

const std::vector<VehicleId> kFleet = {VehicleId{0}, VehicleId{1}, VehicleId{2}};
const VehicleId kSelf{1};

/// One vehicle of three with a log, fed by hand.
struct Alone {
  explicit Alone(NodeStart start = {}) : node(kSelf, kFleet, {}, {}, now, logged(start)) {}

  static NodeStart logged(NodeStart start) {
    start.logs = true;
    return start;
  }

  NodeOutputs give(const NodeEvent& event) {
    NodeOutputs out;
    node.step(event, now, out);
    return out;
  }

  NodeOutputs receive(VehicleId from, Message message) {
    return give(Envelope{from, std::nullopt, std::move(message)});
  }

  void pass(double s) { now = now + Duration::from_s(s); }

  void own_pose() {
    OwnPose pose;
    pose.t = now;
    pose.at_rest = pose.levelled = true;
    give(pose);
  }

  Time now = Time::from_s(100.0);
  Node node;
};

RoleMessage propose(VehicleId candidate, std::uint64_t term) {
  RoleMessage m;
  m.op = RoleOp::kPropose;
  m.term = term;
  m.candidate = candidate;
  return m;
}

std::vector<RoleOp> role_ops(const NodeOutputs& outputs) {
  std::vector<RoleOp> ops;
  for (const NodeOutput& output : outputs) {
    const auto* envelope = std::get_if<Envelope>(&output);
    const auto* role = envelope ? std::get_if<RoleMessage>(&envelope->message) : nullptr;
    if (role != nullptr) ops.push_back(role->op);
  }
  return ops;
}

template <class Kind>
std::vector<Kind> all_of(const NodeOutputs& outputs) {
  std::vector<Kind> found;
  for (const NodeOutput& output : outputs) {
    if (const auto* one = std::get_if<Kind>(&output)) found.push_back(*one);
  }
  return found;
}

template <class Kind>
std::vector<Kind> messages(const NodeOutputs& outputs) {
  std::vector<Kind> found;
  for (const Envelope& envelope : all_of<Envelope>(outputs)) {
    if (const auto* one = std::get_if<Kind>(&envelope.message)) found.push_back(*one);
  }
  return found;
}

FactPtr fact_of(VehicleId vehicle, std::uint32_t epoch, std::uint32_t seq) {
  return std::make_shared<const Fact>(
      Fact{{vehicle, epoch, seq}, Time::from_s(90.0), EpochStart{"v", {}}});
}

Persisted kept(std::vector<FactKey> facts, std::uint64_t role = 0) {
  Persisted event;
  event.facts = std::move(facts);
  event.role = role;
  event.free_bytes = 1000;
  return event;
}

TEST(NodeDisk, sends_a_vote_only_after_it_is_saved_on_disk) {
  Alone v;
  const NodeOutputs out = v.receive(VehicleId{0}, propose(VehicleId{0}, 1));
  const auto saves = all_of<SaveRole>(out);
  ASSERT_EQ(saves.size(), 1U);
  EXPECT_EQ(saves[0].durable.granted_to, VehicleId{0});
  EXPECT_TRUE(role_ops(out).empty());
  // Asked again, it votes the same again: that vote waits, too.
  EXPECT_TRUE(role_ops(v.receive(VehicleId{0}, propose(VehicleId{0}, 1))).empty());
  EXPECT_TRUE(role_ops(v.give(kept({}, saves[0].number - 1))).empty());
  EXPECT_EQ(role_ops(v.give(kept({}, saves[0].number))),
            (std::vector<RoleOp>{RoleOp::kGrant, RoleOp::kGrant}));
  EXPECT_EQ(role_ops(v.receive(VehicleId{0}, propose(VehicleId{0}, 1))),
            std::vector<RoleOp>{RoleOp::kGrant})
      << "nothing waits any more";
}

TEST(NodeDisk, sends_its_vehicle_status_without_waiting_for_the_disk) {
  Alone v;
  v.receive(VehicleId{0}, propose(VehicleId{0}, 1));
  v.own_pose();
  EXPECT_EQ(messages<VehicleStatus>(v.give(NodeTick{})).size(), 1U);
}

TEST(NodeDisk, saves_each_fact_once_and_lists_only_saved_facts_in_its_inventory) {
  Alone v;
  const auto own = all_of<SaveFact>(v.give(OwnFact{fact_of(kSelf, 0, 0)}));
  ASSERT_EQ(own.size(), 1U);
  const auto foreign =
      all_of<SaveFact>(v.receive(VehicleId{2}, FactMessage{fact_of(VehicleId{2}, 0, 0)}));
  ASSERT_EQ(foreign.size(), 1U);
  EXPECT_TRUE(
      all_of<SaveFact>(v.receive(VehicleId{0}, FactMessage{fact_of(VehicleId{2}, 0, 0)})).empty())
      << "it is known";
  const auto first = messages<Inventory>(v.give(NodeTick{}));
  ASSERT_EQ(first.size(), 1U);
  EXPECT_TRUE(first[0].streams.empty());
  v.give(kept({foreign[0].fact->key}));
  v.pass(6.0);
  const auto second = messages<Inventory>(v.give(NodeTick{}));
  ASSERT_EQ(second.size(), 1U);
  ASSERT_EQ(second[0].streams.size(), 1U);
  EXPECT_EQ(second[0].streams[0].stream, (StreamKey{VehicleId{2}, 0}));
  EXPECT_EQ(second[0].free_bytes, 1000U);
  EXPECT_EQ(v.node.store().size(), 2U) << "both are there";
}

TEST(NodeDisk, without_a_log_treats_everything_as_saved_at_once) {
  const Time now = Time::from_s(100.0);
  Node node(kSelf, kFleet, {}, {}, now);
  NodeOutputs out;
  node.step(OwnFact{fact_of(kSelf, 0, 0)}, now, out);
  node.step(Envelope{VehicleId{0}, std::nullopt, propose(VehicleId{0}, 1)}, now, out);
  EXPECT_TRUE(all_of<SaveFact>(out).empty());
  EXPECT_EQ(role_ops(out), std::vector<RoleOp>{RoleOp::kGrant});
  EXPECT_EQ(node.store().inventory(0, 0).streams.size(), 1U);
}

/// State after it voted for v2 in term 5 and stopped.
NodeStart voted() {
  NodeStart start;
  start.durable.term = 5;
  start.durable.granted_to = VehicleId{2};
  start.durable.fleet = kFleet;
  start.epoch = 3;
  start.facts = {fact_of(kSelf, 2, 0), fact_of(VehicleId{0}, 0, 0)};
  return start;
}

TEST(NodeDisk, after_a_restart_grants_no_second_candidate_a_vote_in_one_term) {
  Alone v(voted());
  EXPECT_EQ(v.node.term(), 5U);
  v.pass(60.0);  // longer than any earlier promise
  EXPECT_EQ(role_ops(v.receive(VehicleId{0}, propose(VehicleId{0}, 5))),
            std::vector<RoleOp>{RoleOp::kRefuse});
  EXPECT_EQ(role_ops(v.receive(VehicleId{2}, propose(VehicleId{2}, 5))),
            std::vector<RoleOp>{RoleOp::kGrant});
  EXPECT_EQ(role_ops(v.receive(VehicleId{0}, propose(VehicleId{0}, 4))),
            std::vector<RoleOp>{RoleOp::kRefuse});
}

TEST(NodeDisk, after_a_restart_neither_saves_nor_sends_its_restored_facts_unasked) {
  Alone v(voted());
  EXPECT_EQ(v.node.epoch(), 3U);
  EXPECT_EQ(v.node.store().size(), 2U);
  v.receive(VehicleId{0}, VehicleStatus{});
  v.own_pose();
  const NodeOutputs out = v.give(NodeTick{});
  EXPECT_TRUE(all_of<SaveFact>(out).empty());
  EXPECT_TRUE(messages<FactMessage>(out).empty());
  const auto inventories = messages<Inventory>(out);
  ASSERT_EQ(inventories.size(), 1U);
  EXPECT_EQ(inventories[0].streams.size(), 2U);
  EXPECT_GT(inventories[0].number, 3U << 20) << "beyond all numbers of earlier epochs";
  const auto statuses = messages<VehicleStatus>(out);
  ASSERT_EQ(statuses.size(), 1U);
  EXPECT_EQ(statuses[0].epoch, 3U);
}

TEST(NodeDisk, votes_with_an_unconfirmed_role_only_after_the_operator_confirms) {
  NodeStart start;
  start.durable.confirmed = false;
  Alone v(start);
  EXPECT_EQ(role_ops(v.receive(VehicleId{0}, propose(VehicleId{0}, 1))),
            std::vector<RoleOp>{RoleOp::kRefuse});
  const auto saves = all_of<SaveRole>(v.give(ConfirmRole{}));
  ASSERT_EQ(saves.size(), 1U);
  EXPECT_TRUE(saves[0].durable.confirmed);
  v.give(kept({}, saves[0].number));
  const auto votes = all_of<SaveRole>(v.receive(VehicleId{0}, propose(VehicleId{0}, 1)));
  ASSERT_EQ(votes.size(), 1U);
  EXPECT_EQ(votes[0].durable.granted_to, VehicleId{0});
}

TEST(NodeDisk, ignores_a_map_frame_that_belongs_to_an_earlier_epoch) {
  Alone v(voted());
  RoleMessage commit;
  commit.op = RoleOp::kCommit;
  commit.term = 6;
  commit.candidate = VehicleId{0};
  v.receive(VehicleId{0}, commit);
  Table table;
  table.term = 6;
  table.frames = {{{kSelf, 2}, 0, {}, {}}};
  v.receive(VehicleId{0}, table);
  EXPECT_FALSE(v.node.T_map_odom());
  table.revision = 1;
  table.frames.push_back({{kSelf, 3}, 0, {}, {}});
  v.receive(VehicleId{0}, table);
  EXPECT_TRUE(v.node.T_map_odom());
}

TEST(NodeDisk, reports_a_failing_disk_once_and_is_no_candidate_until_it_works) {
  Alone v;
  PersistFailed failed;
  failed.facts = {{kSelf, 0, 0}};
  failed.why = "it is full";
  const auto findings = all_of<Finding>(v.give(failed));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "fleet.disk_fails");
  EXPECT_TRUE(all_of<Finding>(v.give(failed)).empty());
  // Nobody acts, it is at standstill and has a link: an able vehicle becomes candidate now.
  const auto stands_for_election = [&v] {
    bool votes = false;
    for (int k = 0; k < 600; ++k) {
      v.pass(0.1);
      v.own_pose();
      v.receive(VehicleId{0}, VehicleStatus{});
      for (const SaveRole& save : all_of<SaveRole>(v.give(NodeTick{}))) {
        votes = votes || save.durable.granted_to == kSelf;
      }
    }
    return votes;
  };
  EXPECT_FALSE(stands_for_election());
  Persisted half = kept({});
  half.failing_facts = 1;
  EXPECT_TRUE(all_of<Finding>(v.give(half)).empty());
  EXPECT_FALSE(stands_for_election());
  EXPECT_EQ(all_of<Finding>(v.give(kept({}))).size(), 1U);
  EXPECT_TRUE(stands_for_election());
}

// The clock of a restarted machine starts anew: its earlier messages seemed newer.
TEST(NodeDisk, accepts_messages_of_a_restarted_peer_whose_clock_was_reset) {
  Alone v;
  VehicleStatus before;
  before.t_send = Time::from_s(5000.0);
  before.term = 1;
  v.receive(VehicleId{0}, before);
  VehicleStatus after;
  after.epoch = 1;
  after.t_send = Time::from_s(10.0);
  after.term = 1;
  after.mode = Mode::kDone;
  VehicleStatus late = before;
  late.mode = Mode::kDone;
  late.t_send = Time::from_s(4000.0);
  v.receive(VehicleId{0}, late);
  EXPECT_FALSE(v.node.done()) << "it overtook nothing";
  v.receive(VehicleId{0}, after);
  EXPECT_TRUE(v.node.done());
}

}  // namespace
}  // namespace rali::fleet
