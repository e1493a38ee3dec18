#include "rali/drive/output/rounds_files.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/drive/output/fleet_run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

using fleet::RoundEnd;

constexpr VehicleId kV1{0}, kV2{1};
const io::RadioNames kNames{{"v1", {kV1, 0}}, {"v2", {kV2, 0}}};

Time at(double t_s) { return Time::from_s(t_s); }

using FactList = std::vector<std::shared_ptr<const fleet::Fact>>;

/// Nodes (time, at rest).
FactList nodes(const std::vector<std::pair<double, bool>>& list) {
  FactList facts;
  for (const auto& [t_s, at_rest] : list) {
    fleet::Increment step;
    step.at_rest = at_rest;
    facts.push_back(std::make_shared<const fleet::Fact>(fleet::Fact{{kV1, 0, 0}, at(t_s), step}));
  }
  return facts;
}

TEST(Stands, last_from_the_first_node_at_rest_until_it_moves_off) {
  const auto stands =
      stands_of(kV1, nodes({{0.0, false}, {1.0, true}, {6.0, true}, {8.5, false}, {9.5, false}}),
                at(9.5), 5.0, 3.0);
  EXPECT_EQ(stands, (std::vector<fleet::Stand>{{kV1, at(1.0), at(8.5)}}));
}

TEST(Stands, extend_to_the_last_scan_but_not_across_a_gap) {
  EXPECT_EQ(stands_of(kV1, nodes({{1.0, true}, {6.0, true}}), at(9.0), 5.0, 3.0),
            (std::vector<fleet::Stand>{{kV1, at(1.0), at(9.0)}}));
  // A node is due every 5 s: the state between 6 and 30 s is unknown.
  EXPECT_EQ(stands_of(kV1, nodes({{1.0, true}, {6.0, true}, {30.0, true}}), at(33.5), 5.0, 3.0),
            (std::vector<fleet::Stand>{{kV1, at(1.0), at(6.0)}, {kV1, at(30.0), at(33.5)}}));
}

/// v1 stands for 20 s and drives off; v2 drives `path_m` in the first 18 s, stands 2 s, follows.
std::vector<VehicleRun> two_vehicles(const std::string& out, double path_m) {
  std::vector<VehicleRun> runs;
  runs.push_back(DrivenVehicle(out, 0).begin(2.0, true).stand(20.0).drive(6.0, 10.0).finish());
  runs.push_back(DrivenVehicle(out, 1)
                     .begin(3.0, false)
                     .drive(3.0 + path_m, 18.0)
                     .stand(2.0)
                     .drive(4.0 + path_m, 10.0)
                     .finish());
  return runs;
}

FleetRunView view_of(const std::vector<VehicleRun>& runs, const std::string& out) {
  FleetRunView fleet{&runs, {}, out};
  for (const VehicleRun& run : runs) fleet.mapped.push_back(&run);
  return fleet;
}

RoundsJob job_here() {
  RoundsJob job;
  job.grid.ground_below_body_m = 0.8;
  job.grid.range_m = 10.0;
  return job;
}

RoundEnd end_of_round(double path_m, const std::vector<sensor::RadioSample>& radio = {}) {
  const io::TestFolder folder;
  const std::vector<VehicleRun> runs = two_vehicles(folder.path(), path_m);
  RoundsJob job = job_here();
  job.radio = radio;
  job.rounds.finish.max_distance_m = 30.0;
  std::vector<fleet::RoundRow> rounds(1);
  rounds[0].anchor = kV1;
  rounds[0].start = at(0.0);
  rounds[0].end = at(20.0);
  rounds[0].ended_by = RoundEnd::kAnchorMoved;
  judge_ends(view_of(runs, folder.path()), job, rounds);
  return rounds[0].ended_by;
}

TEST(RoundEnds, an_anchor_leaving_while_the_tag_explores_is_anchor_moved) {
  EXPECT_EQ(end_of_round(20.0), RoundEnd::kAnchorMoved);
}

TEST(RoundEnds, a_tag_beyond_the_distance_limit_is_finished) {
  EXPECT_EQ(end_of_round(40.0), RoundEnd::kFinished);
}

TEST(RoundEnds, weak_radio_between_anchor_and_tag_is_finished) {
  std::vector<sensor::RadioSample> weak, elsewhere;
  for (double t_s = 10.0; t_s < 14.0; t_s += 0.25) {
    weak.push_back({at(t_s), kV1, kV2, -95.0});
    elsewhere.push_back({at(t_s), kV1, VehicleId{7}, -95.0});
  }
  EXPECT_EQ(end_of_round(20.0, weak), RoundEnd::kFinished);
  EXPECT_EQ(end_of_round(20.0, elsewhere), RoundEnd::kAnchorMoved);
}

TEST(RoundEnds, an_anchor_standing_until_its_data_end_is_end_of_data) {
  const io::TestFolder folder;
  std::vector<VehicleRun> runs;
  runs.push_back(DrivenVehicle(folder.path(), 0).begin(2.0, true).stand(20.0).finish());
  runs.push_back(DrivenVehicle(folder.path(), 1).begin(3.0, false).drive(50.0, 20.0).finish());
  std::vector<fleet::RoundRow> rounds(1);
  rounds[0].end = at(20.0);
  judge_ends(view_of(runs, folder.path()), job_here(), rounds);
  EXPECT_EQ(rounds[0].ended_by, RoundEnd::kEndOfData);
}

TEST(Rounds, list_the_frontiers_as_of_the_end_of_each_round) {
  const io::TestFolder folder;
  std::vector<VehicleRun> runs;  // v2 goes to the end of the corridor in the second round
  runs.push_back(
      DrivenVehicle(folder.path(), 0).begin(2.0, true).stand(10.0).drive(12.0, 30.0).finish());
  DrivenVehicle second(folder.path(), 1);
  second.begin(3.0, false).drive(20.0, 8.0).stand(6.0);
  for (double x_m = 26.0; x_m < 59.0; x_m += 6.0) second.drive(x_m, 4.0);
  runs.push_back(second.finish());
  FindingList findings;
  const std::vector<double> rest_s{5.0, 5.0};
  const auto found = find_rounds(view_of(runs, folder.path()), job_here(), rest_s, findings);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_TRUE(findings.empty());
  ASSERT_EQ(found->rounds.size(), 2U);
  EXPECT_EQ(found->rounds[0].anchor, kV1);
  EXPECT_EQ(found->rounds[0].next_anchor, kV2);
  EXPECT_EQ(found->rounds[1].start, at(10.5)) << "until it moved off";
  const auto open_in = [&](std::uint32_t round) {
    std::vector<fleet::FrontierRow> rows;
    for (const fleet::FrontierRow& f : found->frontiers) {
      if (f.round == round && f.state == map::FrontierState::kOpen) rows.push_back(f);
    }
    return rows;
  };
  ASSERT_EQ(open_in(1).size(), 1U);
  // Seen 10 m beyond x = 20 m; v2 stands there, and is the next anchor by the rule.
  EXPECT_NEAR(open_in(1)[0].x_m, 30.0, 0.5);
  EXPECT_NEAR(open_in(1)[0].length_m, 2.4, 0.7) << "3 m less the width of the vehicle";
  EXPECT_EQ(open_in(1)[0].nearest_vehicle, kV2);
  EXPECT_EQ(found->rounds[0].frontier, open_in(1)[0].id);
  EXPECT_TRUE(open_in(0).empty()) << "at the end of the data the corridor is known";

  ASSERT_TRUE(write_rounds_files(view_of(runs, folder.path()), *found));
  const std::string text = folder.read("rounds.csv");
  EXPECT_EQ(text.substr(0, text.find('\n', 60)),
            "round,anchor,start_s,end_s,ended_by,next_anchor,frontier_id\n"
            "1,v1,0.000000000,10.500000000,anchor_moved,v2," +
                std::to_string(*found->rounds[0].frontier));
  // The table it writes is valid as a user's table.
  const auto again = read_rounds_csv(folder.path("rounds.csv"), kNames);
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->size(), 2U);
  EXPECT_EQ((*again)[0], (fleet::Stand{kV1, at(0.0), at(10.5)}));
}

TEST(Rounds, without_a_standstill_list_the_final_frontiers) {
  const io::TestFolder folder;
  std::vector<VehicleRun> runs;
  runs.push_back(DrivenVehicle(folder.path(), 0).begin(2.0, false).drive(12.0, 10.0).finish());
  runs.push_back(DrivenVehicle(folder.path(), 1).begin(3.0, false).drive(20.0, 10.0).finish());
  FindingList findings;
  const std::vector<double> rest_s{5.0, 5.0};
  const auto found = find_rounds(view_of(runs, folder.path()), job_here(), rest_s, findings);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_TRUE(found->rounds.empty());
  ASSERT_FALSE(found->frontiers.empty());
  EXPECT_EQ(found->frontiers[0].round, 0U);
}

TEST(Rounds, from_a_table_outside_the_data_give_a_finding) {
  const io::TestFolder folder;
  const std::vector<VehicleRun> runs = two_vehicles(folder.path(), 20.0);
  RoundsJob job = job_here();
  job.from = RoundsFrom::kTable;
  job.table = {{kV2, at(5000.0), at(5060.0)}};
  FindingList findings;
  const std::vector<double> rest_s{5.0, 5.0};
  const auto found = find_rounds(view_of(runs, folder.path()), job, rest_s, findings);
  ASSERT_TRUE(found) << found.error().message();
  ASSERT_EQ(found->rounds.size(), 1U);
  EXPECT_EQ(found->rounds[0].ended_by, RoundEnd::kOperator);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].id, "fleet.rounds_elsewhere");
}

TEST(RoundsTable, reports_the_line_of_an_error) {
  const io::TestFolder folder;
  const auto error_of = [&](const std::string& rows) {
    const auto table =
        read_rounds_csv(folder.write("r.csv", "anchor,start_s,end_s\n" + rows), kNames);
    return table ? std::string() : table.error().message();
  };
  EXPECT_EQ(error_of("v1,0,10\nv2,10,20\n"), "");
  EXPECT_NE(error_of("v1,0,10\nv3,10,20\n").find("r.csv:3: the anchor 'v3' is no vehicle"),
            std::string::npos)
      << error_of("v1,0,10\nv3,10,20\n");
  EXPECT_NE(error_of("v1,0,10\nv2,9,20\n").find("r.csv:3"), std::string::npos);
  EXPECT_NE(error_of("v1,10,0\n").find("r.csv:2"), std::string::npos);
  EXPECT_NE(error_of("v1,x,0\n").find("not a time"), std::string::npos);
  EXPECT_FALSE(read_rounds_csv(folder.write("n.csv", "anchor,start_s\nv1,0\n"), kNames));
  EXPECT_FALSE(read_rounds_csv(folder.path("none.csv"), kNames));
}

TEST(FinalPath, has_poses_only_between_its_first_and_last_scan) {
  const io::TestFolder folder;
  const VehicleRun run = DrivenVehicle(folder.path(), 0).begin(2.0, false).drive(3.0, 1.0).finish();
  const FinalPath path(run.poses(), run.T_map_local());
  ASSERT_TRUE(path.at(at(0.25)));
  EXPECT_NEAR(path.at(at(0.25))->p.x(), 2.25, 1e-12);
  EXPECT_NEAR(path.at(at(1.0))->p.x(), 3.0, 1e-12);
  EXPECT_FALSE(path.at(at(1.1)));
  EXPECT_FALSE(path.at(at(-0.1)));
  EXPECT_NEAR(path.last_known(at(50.0))->p.x(), 3.0, 1e-12);
  EXPECT_FALSE(path.last_known(at(-0.1)));
  EXPECT_EQ(path.before(at(-0.1)), nullptr);
}

}  // namespace
}  // namespace rali::drive
