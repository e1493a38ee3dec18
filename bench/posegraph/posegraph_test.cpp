// T21 of algorithms_fleet.md: optima that do not depend on this program (8.7).
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "problem.hpp"

namespace rali::posegraph {
namespace {

std::optional<io::G2oFile> read(const std::string& name) {
  const char* from_user = std::getenv("RALI_DATA_DIR");
  const std::filesystem::path data = from_user != nullptr ? from_user : RALI_DATA_DIR;
  const std::filesystem::path path = data / "posegraphs" / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  auto file = io::read_g2o(path.string());
  EXPECT_TRUE(file) << file.error().message();
  return file ? std::optional(std::move(*file)) : std::nullopt;
}

struct Case {
  const char* file;
  double chi2;
};

class Optimum : public testing::TestWithParam<Case> {};

TEST_P(Optimum, is_that_of_others) {
  const auto file = read(GetParam().file);
  if (!file) GTEST_SKIP() << "NO DATA: " << GetParam().file << " is not there";
  graph::PoseGraph graph = make_graph(*file, Start::kFile, to_the_end());
  const graph::SolveReport report = graph.solve_full();
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(2.0 * report.cost_after, GetParam().chi2, 1e-4 * GetParam().chi2);
}

INSTANTIATE_TEST_SUITE_P(Public, Optimum,
                         testing::Values(Case{"tinyGrid3D.g2o", 18.6162},
                                         Case{"smallGrid3D.g2o", 1033.8944},
                                         Case{"parking-garage.g2o", 1.268384},
                                         Case{"sphere2500.g2o", 1351.3623},
                                         Case{"input_M3500_g2o.g2o", 137.912951},
                                         Case{"input_INTEL_g2o.g2o", 214.170856}));

TEST(torus, ends_below_what_a_solver_without_rotations_first_reaches) {
  const auto file = read("torus3D.g2o");
  if (!file) GTEST_SKIP() << "NO DATA: torus3D.g2o is not there";
  graph::PoseGraph graph = make_graph(*file, Start::kFile, to_the_end());
  const graph::SolveReport report = graph.solve_full();
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(2.0 * report.cost_after, 24233.02, 2.5) << "59877 without";
}

TEST(intel, needs_rotations_first) {
  const auto file = read("input_INTEL_g2o.g2o");
  if (!file) GTEST_SKIP() << "NO DATA: input_INTEL_g2o.g2o is not there";
  graph::GraphSettings settings = to_the_end();
  settings.start_chi2_per_dof = 1e12;
  graph::PoseGraph graph = make_graph(*file, Start::kFile, settings);
  EXPECT_GT(2.0 * graph.solve_full().cost_after, 1000.0);
}

TEST(robots, files_of_each_robot_solve_jointly_as_the_file_of_all) {
  std::vector<io::G2oFile> files;
  for (int robot = 0; robot < 4; ++robot) {
    const auto file = read("multi_robot/example_4robots/" + std::to_string(robot) + ".g2o");
    if (!file) GTEST_SKIP() << "NO DATA: multi_robot is not there";
    files.push_back(*file);
  }
  graph::PoseGraph joint = make_graph(joined(files), Start::kFile, to_the_end());
  graph::PoseGraph whole =
      make_graph(*read("multi_robot/example_4robots/fullGraph.g2o"), Start::kFile, to_the_end());
  const double chi2 = 2.0 * whole.solve_full().cost_after;
  EXPECT_NEAR(2.0 * joint.solve_full().cost_after, chi2, 1e-6 * chi2);
}

}  // namespace
}  // namespace rali::posegraph
