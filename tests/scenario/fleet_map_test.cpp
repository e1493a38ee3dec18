// Two simulated vehicles from their recordings to one map, with the program itself.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "rali/cli/run_for_test.hpp"
#include "rali/eval/alignment.hpp"
#include "rali/eval/drift.hpp"
#include "rali/eval/errors.hpp"
#include "rali/io/files/test_folder.hpp"
#include "rali/io/files/tum.hpp"

namespace rali {
namespace {

std::string read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Poses of one vehicle paired with ground truth.
/// @param kind "trajectory" or "live"
eval::PairList pairs_of(const std::string& recording, const std::string& out,
                        const std::string& vehicle, const std::string& kind = "trajectory") {
  const auto est = io::read_tum(out + "/" + kind + "/" + vehicle + ".tum");
  const auto ref = io::read_tum(recording + "/truth/" + vehicle + ".tum");
  EXPECT_TRUE(est && ref);
  if (!est || !ref) return {};
  eval::PoseList poses, truth;
  for (const auto& pose : est->poses) poses.push_back({pose.t, pose.T});
  for (const auto& pose : ref->poses) truth.push_back({pose.t, pose.T});
  const auto paired = eval::associate(poses, truth, {eval::AssociationMode::kInterpolate});
  EXPECT_TRUE(paired) << (paired ? "" : paired.error().message());
  return paired ? paired->pairs : eval::PairList{};
}

/// RMS error of the second vehicle's position relative to the first one's, without alignment.
double between_m(const eval::PairList& a, const eval::PairList& b) {
  std::vector<double> errors;
  for (const eval::PoseError& e : eval::errors_between(a, b, 0.3)) {
    errors.push_back(e.translation_m);
  }
  EXPECT_GT(errors.size(), 100U);
  return eval::statistics(errors).rmse;
}

/// fleet.yaml without its start poses.
std::string without_priors(const std::string& yaml) {
  std::string out;
  bool within = false;
  std::size_t at = 0;
  while (at < yaml.size()) {
    const std::size_t end = std::min(yaml.find('\n', at), yaml.size() - 1) + 1;
    const std::string line = yaml.substr(at, end - at);
    at = end;
    if (line[0] != ' ') within = line.rfind("priors:", 0) == 0;
    if (!within) out += line;
  }
  return out;
}

TEST(FleetMap, of_a_corridor_is_joined_with_start_poses_and_never_wrongly_without) {
  const io::TestFolder folder;
  const std::string recording = folder.path("recording");
  const cli::Outcome made = cli::run_rali({"simulate", "corridor", "-o", recording, "--seed", "401",
                                           "--duration", "40", "--pedestrians", "2"});
  ASSERT_EQ(made.code, 0) << made.err;

  const std::string out = folder.path("with");
  const cli::Outcome with = cli::run_rali({"map", recording + "/fleet.yaml", "-o", out, "-q"});
  ASSERT_EQ(with.code, 0) << with.err << with.out;
  const eval::PairList a = pairs_of(recording, out, "v1"), b = pairs_of(recording, out, "v2");
  ASSERT_GT(a.size(), 300U);
  ASSERT_GT(b.size(), 300U);
  eval::PairList all = a;
  all.insert(all.end(), b.begin(), b.end());
  const auto T = eval::align(all, eval::Alignment::kSe3);
  ASSERT_TRUE(T) << T.error().message();
  EXPECT_LT(eval::translation_statistics(eval::absolute_errors(all, *T)).rmse, 0.06);
  EXPECT_LT(between_m(a, b), 0.15);

  const std::string silent = recording + "/silent.yaml";
  std::ofstream(silent) << without_priors(read(recording + "/fleet.yaml"));
  const std::string apart = folder.path("without");
  const cli::Outcome without = cli::run_rali({"map", silent, "-o", apart, "-q"});
  if (without.code == 0) {
    EXPECT_LT(between_m(pairs_of(recording, apart, "v1"), pairs_of(recording, apart, "v2")), 0.3);
  } else {
    // Not joining is acceptable if it is reported.
    EXPECT_EQ(without.code, 3) << without.err;
    EXPECT_NE((without.err + without.out).find("v2"), std::string::npos);
  }
}

constexpr const char* kTunnel = R"(schema: 1
tunnel: {length_m: 95, width_m: 6, wall_height_m: 1.5, roughness_m: 0.008}
vehicles:
  - {start: [45.0, 1.6], yaw_deg: 0}
  - {start: [2.0, -1.2], yaw_deg: 0}
rounds:
  - {anchor: v1, routes: {v2: [[2, -1.2], [85, -1.2]]}}
uwb: {max_range_m: 400}
motion: {speed_mps: 1.2, standstill_s: 4}
)";

// The tunnel looks the same from both ends. Before v2 has passed v1, nothing says which way round
// v1 stands; with it the wrong way round, live poses were off by up to twice their distance.
TEST(FleetMap, of_a_passed_vehicle_in_a_tunnel_is_joined_after_the_passage_and_never_wrongly) {
  const io::TestFolder folder;
  const std::string scene = folder.path("tunnel.yaml"), recording = folder.path("recording");
  std::ofstream(scene) << kTunnel;
  // Of seeds 5 to 11, two are joined the wrong way round before the passage, and until it (live
  // only; docs/results.md, open cases). Which ones changes with every detail of the ranges.
  const cli::Outcome made = cli::run_rali({"simulate", scene, "-o", recording, "--seed", "6"});
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string silent = recording + "/silent.yaml", out = folder.path("out");
  std::ofstream(silent) << without_priors(read(recording + "/fleet.yaml"));
  const cli::Outcome mapped = cli::run_rali({"map", silent, "-o", out, "-q"});
  EXPECT_EQ(mapped.code, 0) << mapped.out << mapped.err;
  const eval::PairList standing = pairs_of(recording, out, "v1");
  const eval::PairList passing = pairs_of(recording, out, "v2");
  eval::PairList all = standing;
  all.insert(all.end(), passing.begin(), passing.end());
  const auto T = eval::align(all, eval::Alignment::kSe3);
  ASSERT_TRUE(T) << T.error().message();
  const eval::PairList live = pairs_of(recording, out, "v2", "live");
  EXPECT_LT(eval::translation_statistics(eval::absolute_errors(all, *T)).rmse, 0.3);
  EXPECT_LT(eval::translation_statistics(eval::absolute_errors(live, *T)).max, 2.0)
      << "3.9 m, before";
}

}  // namespace
}  // namespace rali
