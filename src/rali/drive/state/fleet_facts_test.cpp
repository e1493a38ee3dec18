#include "rali/drive/state/fleet_facts.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "rali/drive/state/states_for_test.hpp"
#include "rali/factlog/folder_for_test.hpp"

namespace rali::drive {
namespace {

namespace fs = std::filesystem;

const VehicleId kA{0}, kB{1};

fleet::FactPtr start_of(VehicleId id, const std::string& name, std::uint32_t epoch = 0,
                        double t_s = 1.0) {
  return quantised_fact(id, epoch, 0, t_s,
                        fleet::EpochStart{name, {geometry::Vec3(0.1, 0.0, 0.5)}});
}

fleet::FactPtr node_of(VehicleId id, std::uint32_t seq, double x_m, std::uint32_t epoch = 0) {
  fleet::Increment step;
  step.node = seq - 1;
  step.T_odom_body.p.x() = x_m;
  step.covariance = step.lidar_information = geometry::Mat6::Identity();
  return quantised_fact(id, epoch, seq, 1.0 + seq, step);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> names_of(const FleetFacts::Member& member) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> names;
  for (const fleet::FactPtr& fact : member.facts) {
    names.emplace_back(fact->key.epoch, fact->key.seq);
  }
  return names;
}

class StatesTest : public testing::Test {
 protected:
  [[nodiscard]] std::string at(const std::string& name) const { return folder_.path(name); }

  [[nodiscard]] std::string error_of(const std::vector<std::string>& folders) const {
    const auto facts = read_fleet_facts(folders);
    return facts ? std::string() : facts.error().message();
  }

  TestFolder folder_;
};

TEST_F(StatesTest, merges_two_folders_with_each_fact_once_in_any_order) {
  write_state(at("v1"), kA, {start_of(kA, "red"), node_of(kA, 1, 0.5), start_of(kB, "blue")});
  write_state(at("v2"), kB, {start_of(kB, "blue"), node_of(kB, 1, 2.0), node_of(kA, 1, 0.5)});
  const std::vector<std::vector<std::string>> orders = {
      {at("v1"), at("v2")}, {at("v2"), at("v1")}, {at("v2"), at("v1"), at("v2") + "/"}};
  for (const auto& folders : orders) {
    const auto facts = read_fleet_facts(folders);
    ASSERT_TRUE(facts) << facts.error().message();
    EXPECT_EQ(facts->folders, (std::vector<std::string>{at("v1"), at("v2")}));
    EXPECT_TRUE(facts->findings.empty());
    ASSERT_EQ(facts->members.size(), 2U);
    EXPECT_EQ(facts->members[0].name, "red");
    EXPECT_EQ(facts->members[1].name, "blue");
    EXPECT_EQ(facts->members[1].antennas_body_m.at(0).z(), 0.5);
    using Names = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
    EXPECT_EQ(names_of(facts->members[0]), (Names{{0, 0}, {0, 1}}));
    EXPECT_EQ(names_of(facts->members[1]), (Names{{0, 0}, {0, 1}}));
    EXPECT_EQ(facts->members[0].missing + facts->members[1].missing, 0U);
  }
}

TEST_F(StatesTest, counts_missing_fact_numbers_of_each_start) {
  // Of start 1 the facts 1 and 2 of 0 to 3; of start 2 the first one of 0 and 1.
  write_state(at("v1"), kA, {start_of(kA, "red"), node_of(kA, 3, 1.0), node_of(kA, 1, 0.0, 1)});
  const auto facts = read_fleet_facts({at("v1")});
  ASSERT_TRUE(facts) << facts.error().message();
  EXPECT_EQ(facts->members.at(0).missing, 3U);
}

TEST_F(StatesTest, a_vehicle_without_facts_gets_an_entry_and_a_default_name) {
  write_state(at("v3"), {2}, {start_of(kA, "red"), start_of({2}, "green")});
  const auto facts = read_fleet_facts({at("v3")});
  ASSERT_TRUE(facts) << facts.error().message();
  ASSERT_EQ(facts->members.size(), 3U);
  EXPECT_EQ(facts->members[1].name, "vehicle_2");
  EXPECT_FALSE(facts->members[1].named);
  EXPECT_TRUE(facts->members[1].facts.empty());
}

TEST_F(StatesTest, rejects_a_vehicle_name_that_escapes_the_output_folder) {
  write_state(at("v1"), kA, {start_of(kA, "../../etc/red"), node_of(kA, 1, 0.0)});
  const auto facts = read_fleet_facts({at("v1")});
  ASSERT_TRUE(facts) << facts.error().message();
  EXPECT_EQ(facts->members.at(0).name, "vehicle_1");
}

TEST_F(StatesTest, refuses_contradicting_folders_of_two_missions) {
  write_state(at("v1"), kA, {start_of(kA, "red"), start_of(kB, "blue")});
  write_state(at("v2"), kB, {start_of(kB, "blue", 0, 900.0)});
  EXPECT_EQ(error_of({at("v2"), at("v1")}),
            at("v2") + ": contradicts " + at("v1") +
                ": vehicle 2, start 1, fact 0 is another one there. Give folders of one mission of "
                "one fleet.");
  const auto facts = read_fleet_facts({at("v1"), at("v2")});
  ASSERT_FALSE(facts.has_value());
  EXPECT_EQ(facts.error().code, ErrorCode::kInput);
}

TEST_F(StatesTest, refuses_two_vehicles_with_the_same_name) {
  write_state(at("a"), kA, {start_of(kA, "red")});
  write_state(at("b"), kB, {start_of(kB, "red")});
  EXPECT_NE(error_of({at("a"), at("b")}).find("vehicles 1 and 2 are both named 'red'"),
            std::string::npos);
}

TEST_F(StatesTest, refuses_a_missing_invalid_or_empty_folder_with_an_explanation) {
  fs::create_directories(at("empty"));
  EXPECT_EQ(error_of({at("none")}), at("none") + ": there is no such folder.");
  EXPECT_NE(error_of({at("empty")}).find("is no state folder of a vehicle (facts-*.log). Give"),
            std::string::npos);
  write_state(at("new"), kA, {});
  EXPECT_NE(error_of({at("new")}).find("holds no fact"), std::string::npos);
}

TEST_F(StatesTest, reports_a_torn_end_without_changing_the_file) {
  write_state(at("v1"), kA, {start_of(kA, "red"), node_of(kA, 1, 0.0), node_of(kA, 2, 1.0)});
  const std::string file = at("v1/facts-000000.log");
  fs::resize_file(file, fs::file_size(file) - 5);
  const auto before = factlog::bytes_in(file);
  const auto facts = read_fleet_facts({at("v1")});
  ASSERT_TRUE(facts) << facts.error().message();
  EXPECT_EQ(facts->members.at(0).facts.size(), 2U);
  ASSERT_EQ(facts->findings.size(), 1U);
  EXPECT_EQ(facts->findings[0].id, "log.torn");
  EXPECT_EQ(factlog::bytes_in(file), before);
}

TEST_F(StatesTest, reads_the_folder_of_a_running_vehicle) {
  auto state = StateDir::open(at("v1"), kA, {kA, kB});
  ASSERT_TRUE(state.has_value());
  state->take(fleet::SaveFact{start_of(kA, "red")});
  static_cast<void>(state->sync(Time::from_s(1.0), true));
  const auto facts = read_fleet_facts({at("v1")});
  ASSERT_TRUE(facts) << facts.error().message();
  EXPECT_EQ(facts->members.at(0).facts.size(), 1U);
}

}  // namespace
}  // namespace rali::drive
