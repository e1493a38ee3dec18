#include "rali/drive/state/state_dir.hpp"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/drive/state/role_record.hpp"
#include "rali/factlog/folder_for_test.hpp"
#include "rali/factlog/memory_log.hpp"
#include "rali/fleet/facts/facts_for_test.hpp"
#include "rali/fleet/facts/quantise.hpp"

namespace rali::drive {
namespace {

const VehicleId kSelf{1};
const std::vector<VehicleId> kFleet = {VehicleId{0}, VehicleId{1}, VehicleId{2}};

fleet::FactPtr fact_of(VehicleId vehicle, std::uint32_t epoch, std::uint32_t seq,
                       fleet::FactBody body = fleet::EpochStart{"v", {}}) {
  fleet::Fact fact{{vehicle, epoch, seq}, Time::from_s(1.0 + seq), std::move(body)};
  auto quantised = fleet::quantised(fact);
  EXPECT_TRUE(quantised.has_value());
  return std::make_shared<const fleet::Fact>(std::move(*quantised));
}

fleet::FactPtr points_of(std::uint32_t seq, bool fine) {
  fleet::KeyframePoints points;
  const std::vector<float> diagonal_m = {1.0F, 2.0F};
  points.points = fleet::PackedPoints(fleet::PointArrays{diagonal_m, diagonal_m, diagonal_m, {}});
  points.refinement = fine;
  return fact_of(kSelf, 0, seq, points);
}

StateDir opened(const std::string& folder) {
  auto state = StateDir::open(folder, kSelf, kFleet);
  EXPECT_TRUE(state.has_value()) << state.error().message();
  return std::move(*state);
}

/// The persisted facts of all events.
std::vector<fleet::FactKey> kept(const std::vector<fleet::NodeEvent>& events) {
  std::vector<fleet::FactKey> keys;
  for (const fleet::NodeEvent& event : events) {
    const auto* p = std::get_if<fleet::Persisted>(&event);
    if (p != nullptr) keys.insert(keys.end(), p->facts.begin(), p->facts.end());
  }
  return keys;
}

fleet::DurableRole role_of(std::uint64_t term, VehicleId candidate) {
  fleet::DurableRole durable;
  durable.term = term;
  durable.granted_to = candidate;
  durable.fleet = kFleet;
  return durable;
}

TEST(StateDir, restores_the_last_saved_link_state) {
  const TestFolder folder;
  {
    StateDir state = opened(folder.path());
    EXPECT_TRUE(state.seen().empty());
    state.keep_seen(factlog::body_of(1, 100));
    EXPECT_TRUE(state.sync(Time::from_s(1.0)).empty());
    state.keep_seen(factlog::body_of(2, 40));
    static_cast<void>(state.sync(Time::from_s(1.1)));
  }
  EXPECT_EQ(opened(folder.path()).seen(), factlog::body_of(2, 40));
  factlog::write_bytes(folder.path("seen.slots"), factlog::Bytes(8192, std::byte{0x5A}));
  EXPECT_TRUE(opened(folder.path()).seen().empty()) << "a vehicle starts without them";
}

TEST(StateDir, a_new_folder_starts_in_epoch_0) {
  const TestFolder folder;
  StateDir state = opened(folder.path("v2/state"));
  const fleet::NodeStart start = state.take_start();
  EXPECT_EQ(start.epoch, 0U);
  EXPECT_TRUE(start.logs);
  EXPECT_TRUE(start.facts.empty());
  EXPECT_TRUE(start.durable.confirmed);
  EXPECT_EQ(start.durable.term, 0U);
  EXPECT_EQ(start.durable.fleet, kFleet);
  EXPECT_TRUE(state.take_findings().empty());
}

TEST(StateDir, every_start_gets_a_new_epoch) {
  const TestFolder folder;
  for (std::uint32_t epoch = 0; epoch < 4; ++epoch) {
    EXPECT_EQ(opened(folder.path()).epoch(), epoch);
  }
}

TEST(StateDir, restores_facts_and_role) {
  const TestFolder folder;
  const fleet::FactPtr own = fact_of(kSelf, 0, 0), other = fact_of(VehicleId{2}, 7, 5);
  {
    StateDir state = opened(folder.path());
    EXPECT_TRUE(state.take(fleet::SaveFact{own}));
    EXPECT_TRUE(state.take(fleet::SaveFact{other}));
    EXPECT_TRUE(state.take(fleet::SaveRole{role_of(4, VehicleId{2}), 1}));
    EXPECT_FALSE(state.take(Finding{}));
    EXPECT_EQ(kept(state.sync(Time::from_s(1.0), true)).size(), 2U);
  }
  StateDir state = opened(folder.path());
  const fleet::NodeStart start = state.take_start();
  EXPECT_EQ(start.epoch, 1U);
  EXPECT_EQ(start.durable, role_of(4, VehicleId{2}));
  ASSERT_EQ(start.facts.size(), 2U);
  EXPECT_EQ(fleet::content_hash(*start.facts[0]), fleet::content_hash(*own));
  EXPECT_EQ(fleet::content_hash(*start.facts[1]), fleet::content_hash(*other));
}

TEST(StateDir, restores_every_kind_of_fact_exactly) {
  const TestFolder folder;
  Rng rng(3, "state");
  std::vector<fleet::FactPtr> facts;
  const std::vector<fleet::FactBody> bodies = {
      fleet::EpochStart{"v2", {geometry::Vec3(0.1, 0.2, 0.3)}}, fleet::random_increment(rng),
      fleet::random_ranges(rng, kSelf, 3, 60), fleet::random_points(rng, 500, true),
      fleet::random_loop(rng)};
  for (const fleet::FactBody& body : bodies) {
    facts.push_back(fact_of(kSelf, 0, static_cast<std::uint32_t>(facts.size()), body));
  }
  {
    StateDir state = opened(folder.path());
    for (const fleet::FactPtr& fact : facts) state.take(fleet::SaveFact{fact});
    EXPECT_EQ(kept(state.sync(Time::from_s(1.0), true)).size(), facts.size());
  }
  const fleet::NodeStart start = opened(folder.path()).take_start();
  ASSERT_EQ(start.facts.size(), facts.size());
  for (std::size_t k = 0; k < facts.size(); ++k) {
    EXPECT_EQ(fleet::content_hash(*start.facts[k]), fleet::content_hash(*facts[k])) << k;
  }
}

TEST(StateDir, syncs_facts_after_0_5_s_or_64_and_roles_at_once) {
  const TestFolder folder;
  StateDir state = opened(folder.path());
  const auto at = [](double t_s) { return Time::from_s(t_s); };
  EXPECT_TRUE(state.sync(at(10.0)).empty());
  state.take(fleet::SaveFact{fact_of(kSelf, 0, 0)});
  EXPECT_TRUE(state.sync(at(10.4)).empty());
  state.take(fleet::SaveRole{role_of(1, kSelf), 1});
  const auto role = state.sync(at(10.45));
  ASSERT_EQ(role.size(), 1U);
  EXPECT_EQ(std::get<fleet::Persisted>(role[0]).role, 1U);
  EXPECT_TRUE(kept(role).empty());
  EXPECT_EQ(kept(state.sync(at(10.5))).size(), 1U);
  for (std::uint32_t seq = 1; seq < 64; ++seq) {
    state.take(fleet::SaveFact{fact_of(kSelf, 0, seq)});
  }
  EXPECT_TRUE(state.sync(at(10.6)).empty()) << "63 wait";
  state.take(fleet::SaveFact{fact_of(kSelf, 0, 64)});
  EXPECT_EQ(kept(state.sync(at(10.6))).size(), 64U);
  EXPECT_EQ(state.waiting(), 0U);
}

TEST(StateDir, refuses_a_second_process_and_another_vehicle) {
  const TestFolder folder;
  {
    const StateDir state = opened(folder.path());
    const auto second = StateDir::open(folder.path(), kSelf, kFleet);
    ASSERT_FALSE(second.has_value());
    EXPECT_EQ(second.error().code, ErrorCode::kUsage);
  }
  const auto other = StateDir::open(folder.path(), VehicleId{0}, kFleet);
  ASSERT_FALSE(other.has_value());
  EXPECT_EQ(other.error().code, ErrorCode::kUsage);
}

void damage_role(const TestFolder& folder) {
  factlog::write_bytes(folder.path("role.slots"), factlog::Bytes(8192, std::byte{0x5A}));
}

TEST(StateDir, an_unreadable_role_is_unconfirmed_and_starts_a_new_epoch) {
  const TestFolder folder;
  {
    StateDir state = opened(folder.path());
    state.take(fleet::SaveFact{fact_of(kSelf, 0, 0)});
    state.take(fleet::SaveRole{role_of(4, kSelf), 1});
    static_cast<void>(state.sync(Time::from_s(1.0), true));
  }
  damage_role(folder);
  for (const std::uint32_t epoch : {16U, 17U}) {
    StateDir state = opened(folder.path());
    const fleet::NodeStart start = state.take_start();
    EXPECT_FALSE(start.durable.confirmed);
    EXPECT_EQ(start.epoch, epoch);
    EXPECT_EQ(start.facts.size(), 1U);
    const FindingList findings = state.take_findings();
    if (epoch > 16) continue;
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].id, "state.role_unreadable");
  }
}

TEST(StateDir, a_missing_role_beside_saved_facts_is_unconfirmed) {
  const TestFolder folder;
  {
    StateDir state = opened(folder.path());
    state.take(fleet::SaveFact{fact_of(kSelf, 0, 0)});
    static_cast<void>(state.sync(Time::from_s(1.0), true));
  }
  std::filesystem::remove(folder.path("role.slots"));
  EXPECT_FALSE(opened(folder.path()).take_start().durable.confirmed);
}

TEST(StateDir, drops_and_reports_damaged_facts_and_those_of_unknown_vehicles) {
  auto log = std::make_shared<factlog::MemoryLog>();
  auto slots = std::make_shared<factlog::MemorySlots>();
  {
    auto state = StateDir::restore(log, slots, kSelf, kFleet);
    ASSERT_TRUE(state.has_value());
    state->take(fleet::SaveFact{fact_of(VehicleId{9}, 0, 0)});
    state->take(fleet::SaveFact{fact_of(kSelf, 0, 0)});
    static_cast<void>(state->sync(Time::from_s(1.0), true));
  }
  ASSERT_EQ(log->append({kSelf, 0, 1}, 3, factlog::body_of(1, 40)), factlog::Appended::kWritten);
  auto state = StateDir::restore(log, slots, kSelf, kFleet);
  ASSERT_TRUE(state.has_value());
  EXPECT_EQ(state->take_start().facts.size(), 1U);
  const FindingList findings = state->take_findings();
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].id, "log.unreadable");
  EXPECT_EQ(findings[1].id, "log.strangers");
}

TEST(StateDir, a_filling_disk_refuses_fine_points_then_coarse_points_then_increments) {
  auto log = std::make_shared<factlog::MemoryLog>(10'000);
  auto slots = std::make_shared<factlog::MemorySlots>();
  StateSettings settings;
  settings.reserve_bytes = 4'000;
  auto state = StateDir::restore(log, slots, kSelf, kFleet, settings);
  ASSERT_TRUE(state.has_value());
  const auto fits = [&](const fleet::FactPtr& fact) {
    state->take(fleet::SaveFact{fact});
    return !kept(state->sync(Time::from_s(1.0), true)).empty();
  };
  EXPECT_TRUE(fits(points_of(0, true)));
  log->set_capacity(8'000);
  EXPECT_FALSE(fits(points_of(1, true)));
  EXPECT_TRUE(fits(points_of(2, false)));
  log->set_capacity(4'000);
  EXPECT_FALSE(fits(points_of(3, false)));
  EXPECT_TRUE(fits(fact_of(kSelf, 0, 4)));
  log->set_capacity(0);
  EXPECT_FALSE(fits(fact_of(kSelf, 0, 5)));
  EXPECT_EQ(state->waiting(), 3U);
}

TEST(StateDir, reports_a_failed_write_once_and_retries_it) {
  auto log = std::make_shared<factlog::MemoryLog>(0);
  auto slots = std::make_shared<factlog::MemorySlots>();
  auto state = StateDir::restore(log, slots, kSelf, kFleet);
  ASSERT_TRUE(state.has_value());
  state->take(fleet::SaveFact{fact_of(kSelf, 0, 0)});
  const auto failed = state->sync(Time::from_s(1.0), true);
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_EQ(std::get<fleet::PersistFailed>(failed[0]).facts.size(), 1U);
  EXPECT_TRUE(state->sync(Time::from_s(2.0), true).empty());
  log->set_capacity(1'000'000);
  EXPECT_TRUE(state->sync(Time::from_s(3.0), true).empty()) << "not yet tried again";
  const auto events = state->sync(Time::from_s(7.0), true);
  ASSERT_EQ(kept(events).size(), 1U);
  EXPECT_EQ(std::get<fleet::Persisted>(events[0]).failing_facts, 0U);
  EXPECT_EQ(log->size(), 1U);
}

TEST(StateDir, writes_facts_again_after_a_failed_sync) {
  auto log = std::make_shared<factlog::MemoryLog>();
  auto slots = std::make_shared<factlog::MemorySlots>();
  auto state = StateDir::restore(log, slots, kSelf, kFleet);
  ASSERT_TRUE(state.has_value());
  state->take(fleet::SaveFact{fact_of(kSelf, 0, 0)});
  log->break_syncs(true);
  const auto failed = state->sync(Time::from_s(1.0), true);
  ASSERT_EQ(failed.size(), 1U);
  EXPECT_EQ(std::get<fleet::PersistFailed>(failed[0]).facts.size(), 1U);
  EXPECT_EQ(log->size(), 0U);
  log->break_syncs(false);
  EXPECT_EQ(kept(state->sync(Time::from_s(7.0), true)).size(), 1U);
  EXPECT_EQ(log->size(), 1U);
}

TEST(StateDir, refuses_to_start_after_the_last_epoch) {
  auto log = std::make_shared<factlog::MemoryLog>();
  auto slots = std::make_shared<factlog::MemorySlots>();
  fleet::DurableRole durable;
  durable.fleet = kFleet;
  ASSERT_TRUE(slots->save(encode_role({kSelf, 4094, durable})).has_value());
  const auto last = StateDir::restore(log, slots, kSelf, kFleet);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->epoch(), 4095U);
  const auto beyond = StateDir::restore(log, slots, kSelf, kFleet);
  ASSERT_FALSE(beyond.has_value());
  EXPECT_EQ(beyond.error().code, ErrorCode::kInput);
}

TEST(RoleRecord, is_decoded_from_its_bytes_but_never_from_truncated_ones) {
  const RoleRecord record{kSelf, 12, role_of(1ULL << 40, VehicleId{2})};
  const wire::Bytes bytes = encode_role(record);
  EXPECT_EQ(decode_role(bytes), record);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(decode_role(std::span(bytes).first(size)).has_value()) << size;
  }
  wire::Bytes newer = bytes;
  newer[0] = std::byte{2};
  EXPECT_EQ(decode_role(newer).error().code, ErrorCode::kNoAnswer);
}

}  // namespace
}  // namespace rali::drive
