// The program drives a fleet by itself: from start poses alone to one map.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "rali/cli/run_for_test.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/errors.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"

namespace rali {
namespace {

/// Two rooms with a door between them that the first vehicle cannot look through.
constexpr const char* kTwoRooms = R"(schema: 1
floor_plan:
  height_m: 2.8
  areas:
    - {rectangle: [0, 0, 7, 6]}
    - {rectangle: [7.2, 0, 13, 6]}
  doors:
    - {at: [7.1, 5.0], yaw_deg: 0, width_m: 1.4, depth_m: 0.2, height_m: 2.1}
  furniture:
    - {at: [5.5, 3.2], size_m: [1.2, 0.8, 0.9], yaw_deg: 20}
    - {at: [10.5, 1.2], size_m: [1.6, 0.8, 0.9], yaw_deg: 10}
vehicles:
  - {start: [2.0, 1.2], yaw_deg: 0}
  - {start: [1.2, 3.2], yaw_deg: 0}
lidar: vlp16
)";

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class ClosedLoop : public testing::Test {
 protected:
  ClosedLoop() { std::ofstream(scene_) << kTwoRooms; }

  [[nodiscard]] cli::Outcome drive(const std::string& out, const std::string& limit_s,
                                   const std::string& threads) const {
    return cli::run_rali({"simulate", scene_, "-o", out, "--closed-loop", "--duration", limit_s,
                          "--threads", threads, "-q"});
  }

  io::TestFolder folder_;
  std::string scene_ = folder_.path("scene.yaml");
};

void add_pairs(const std::string& recording, const std::string& out, const std::string& vehicle,
               eval::PairList& all) {
  const auto est = io::read_tum(out + "/trajectory/" + vehicle + ".tum");
  const auto ref = io::read_tum(recording + "/truth/" + vehicle + ".tum");
  ASSERT_TRUE(est && ref) << vehicle;
  eval::PoseList poses, truth;
  for (const auto& pose : est->poses) poses.push_back({pose.t, pose.T});
  for (const auto& pose : ref->poses) truth.push_back({pose.t, pose.T});
  const auto paired = eval::associate(poses, truth, {eval::AssociationMode::kInterpolate});
  ASSERT_TRUE(paired) << paired.error().message();
  all.insert(all.end(), paired->pairs.begin(), paired->pairs.end());
}

TEST_F(ClosedLoop, two_vehicles_explore_two_rooms_end_by_themselves_and_make_one_map) {
  const std::string recording = folder_.path("recording"), out = folder_.path("out");
  const cli::Outcome driven = drive(recording, "240", "0");
  ASSERT_EQ(driven.code, 0) << driven.out << driven.err;
  const std::string rounds = read(recording + "/rounds.csv");
  EXPECT_NE(rounds.find(",explored,"), std::string::npos) << rounds;

  const cli::Outcome mapped = cli::run_rali({"map", recording + "/fleet.yaml", "-o", out, "-q"});
  ASSERT_EQ(mapped.code, 0) << mapped.err << mapped.out;
  eval::PairList all;
  add_pairs(recording, out, "v1", all);
  add_pairs(recording, out, "v2", all);
  const auto T = eval::align(all, eval::Alignment::kSe3);
  ASSERT_TRUE(T) << T.error().message();
  double farthest_m = 0.0;
  for (const eval::PosePair& pair : all) farthest_m = std::max(farthest_m, pair.ref.p.x());
  // v1 never has to drive, and half of the ranges pass through the wall. Used as line-of-sight
  // ranges they would shift it by 0.5 m, contradicting the scans of both vehicles.
  EXPECT_LT(eval::translation_statistics(eval::absolute_errors(all, *T)).rmse, 0.03);
  EXPECT_GT(farthest_m, 6.0) << "somebody looked into the second room";
}

TEST_F(ClosedLoop, same_seed_gives_the_same_files_for_any_number_of_threads) {
  const std::string one = folder_.path("one"), two = folder_.path("two");
  for (const auto& [out, threads] : {std::pair(one, "1"), std::pair(two, "3")}) {
    const cli::Outcome driven = drive(out, "14", threads);
    ASSERT_EQ(driven.code, 1) << driven.out << driven.err;
  }
  for (const char* name :
       {"/rounds.csv", "/frontiers.csv", "/truth/v1.tum", "/truth/v2.tum", "/ranges.csv"}) {
    EXPECT_EQ(read(one + name), read(two + name)) << name;
  }
  EXPECT_NE(read(one + "/rounds.csv").find("end_of_data"), std::string::npos);
}

}  // namespace
}  // namespace rali
