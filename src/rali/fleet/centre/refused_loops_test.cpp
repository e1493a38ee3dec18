#include "rali/fleet/centre/refused_loops.hpp"

#include <gtest/gtest.h>

#include "rali/fleet/centre/frame_search.hpp"
#include "rali/fleet/centre/path_frames.hpp"
#include "rali/fleet/centre/pieces_for_test.hpp"

namespace rali::fleet {
namespace {

/// The second vehicle starts 3 m to the left of the first. The start pose, with a sigma of 0.15 m,
/// gives 6 m.
class RefusedLoops : public ::testing::Test {
 protected:
  RefusedLoops() {
    StartPrior start;
    start.path = 1;
    start.T_relative_path.p = {0.0, 6.0, 0.0};
    start.sigma_m = 0.15;
    start.sigma_rad = 0.03;
    for (const VehiclePath& p : paths) {
      evidence.add_vehicle(stream_of(p));
      evidence.set_keyframes(stream_of(p), 11);
    }
    add_start(paths[0], paths[1], start.T_relative_path, start.sigma_m, start.sigma_rad, init,
              evidence);
  }

  /// As rejected by the graph: both are at keyframe k.
  static LoopVerdict refused(std::uint32_t k, std::uint16_t from = 1, std::uint16_t to = 2) {
    LoopVerdict loop;
    loop.from = {VehicleId{from}, k};
    loop.to = {VehicleId{to}, k};
    loop.T_from_to.p = {0.0, 3.0, 0.0};
    loop.information = 1e4 * geometry::Mat6::Identity();
    loop.reason = "veto";
    return loop;
  }

  [[nodiscard]] std::size_t denying(const std::vector<LoopVerdict>& loops) {
    return add_refused_loops(paths, loops, init, evidence).size();
  }

  [[nodiscard]] double left_m() const {
    return frames_of(paths, solved(paths, evidence, {}, init).frames()).T_map_odom[1].p.y();
  }

  const std::vector<VehiclePath> paths = {straight_path(1), straight_path(2), straight_path(3)};
  const InitSettings init;
  FrameSolver evidence{init, stream_of(paths[0])};
};

TEST_F(RefusedLoops, that_agree_override_a_contradicting_start_pose) {
  EXPECT_NEAR(left_m(), 6.0, 1e-3) << "the start pose alone";
  EXPECT_EQ(denying({refused(2), refused(4), refused(6), refused(8)}), 4U);
  EXPECT_NEAR(left_m(), 3.0, 0.02);
}

TEST_F(RefusedLoops, keep_a_start_pose_that_an_accepted_loop_confirms) {
  LoopVerdict there = refused(5);
  there.T_from_to.p.y() = 6.0;
  there.accepted = true;
  EXPECT_EQ(denying({refused(2), refused(4), there, refused(6), refused(8)}), 0U);
  EXPECT_NEAR(left_m(), 6.0, 1e-3);
}

TEST_F(RefusedLoops, do_not_count_if_few_or_within_one_path) {
  EXPECT_EQ(denying({refused(2), refused(4)}), 0U);
  EXPECT_EQ(denying({refused(2, 1, 1), refused(4, 1, 1), refused(6, 1, 1)}), 0U);
}

TEST_F(RefusedLoops, do_not_include_comparisons_without_a_match) {
  LoopVerdict nothing = refused(2);
  nothing.reason = "no_match:overlap";
  EXPECT_EQ(denying({nothing, nothing, nothing, nothing}), 0U);
}

}  // namespace
}  // namespace rali::fleet
