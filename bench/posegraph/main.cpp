// Cost and optimum of public pose graphs: one row per graph and start.
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "common/command_line.hpp"
#include "common/cpu_time.hpp"
#include "problem.hpp"

namespace rali::posegraph {
namespace {

struct Row {
  const char* name;
  Start start;
  bool rotations;        ///< the start is initialised again from rotations
  const char* expected;  ///< algorithms_fleet 8.7
};

constexpr Row kRows[] = {{"tinyGrid3D.g2o", Start::kFile, false, "18.6162"},
                         {"smallGrid3D.g2o", Start::kFile, false, "1033.8944"},
                         {"smallGrid3D.g2o", Start::kFile, true, "1033.8944"},
                         {"parking-garage.g2o", Start::kFile, true, "1.268384"},
                         {"sphere2500.g2o", Start::kFile, false, "1351.3623"},
                         {"sphere2500.g2o", Start::kFile, true, "1351.3623"},
                         {"input_M3500_g2o.g2o", Start::kFile, false, "137.912951"},
                         {"input_M3500_g2o.g2o", Start::kFile, true, "137.912951"},
                         {"input_INTEL_g2o.g2o", Start::kFile, false, "39324 (wrong minimum)"},
                         {"input_INTEL_g2o.g2o", Start::kFile, true, "214.170856"},
                         {"input_INTEL_g2o.g2o", Start::kOdometry, true, "214.170856"},
                         {"kitti_05.g2o", Start::kOdometry, true, "157.104"},
                         {"kitti_00.g2o", Start::kOdometry, true, "98.3067"},
                         {"torus3D.g2o", Start::kFile, true, "< 59877"}};

void solve(const std::string& name, const io::G2oFile& file, const Row& row) {
  graph::GraphSettings settings = to_the_end();
  if (!row.rotations) settings.start_chi2_per_dof = 1e12;
  graph::PoseGraph graph = make_graph(file, row.start, settings);
  const double before = bench::cpu_ms();
  const graph::SolveReport report = graph.solve_full();
  const double solved = bench::cpu_ms();
  const auto covariances = graph.covariances();
  const double known = bench::cpu_ms();
  fmt::print("| {} | {} | {} | {} | {} | {:.6g} | {:.7g} | {} | {}{} | {:.2f} | {:.2f} |\n", name,
             file.ids.size(), file.graph.edges.size(),
             row.start == Start::kFile ? "file" : "odometry",
             report.rotation_first ? "yes" : (row.rotations ? "no" : "off"),
             2.0 * report.cost_before, 2.0 * report.cost_after, row.expected, report.iterations,
             report.converged ? "" : " (not converged)", 1e-3 * (solved - before),
             1e-3 * (known - solved));
}

bool run(const std::filesystem::path& folder, const std::string& only) {
  fmt::print(
      "| graph | poses | edges | start | rotations first | chi2 at start | chi2 | reference | "
      "steps | solve [s] | covariances [s] |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : kRows) {
    if (std::string(row.name).find(only) == std::string::npos) continue;
    const auto file = io::read_g2o((folder / row.name).string());
    if (!file) {
      fmt::print(stderr, "{}\n", file.error().message());
      return false;
    }
    solve(row.name, *file, row);
  }
  for (const auto& [name, robots] : {std::pair{"example_4robots", 4}, {"example_9robots", 9}}) {
    if (std::string(name).find(only) == std::string::npos) continue;
    std::vector<io::G2oFile> files;
    for (int robot = 0; robot < robots; ++robot) {
      auto file =
          io::read_g2o((folder / "multi_robot" / name / fmt::format("{}.g2o", robot)).string());
      if (!file) return false;
      files.push_back(std::move(*file));
    }
    const auto full = io::read_g2o((folder / "multi_robot" / name / "fullGraph.g2o").string());
    if (!full) return false;
    const Row row{name, Start::kFile, true, "as one file, next row"};
    solve(name, joined(files), row);
    solve(name, *full, {name, Start::kFile, true, "as many files, row above"});
  }
  return true;
}

}  // namespace
}  // namespace rali::posegraph

int main(int argc, char** argv) {
  const char* from_user = std::getenv("RALI_DATA_DIR");
  const std::filesystem::path data = from_user != nullptr ? from_user : RALI_DATA_DIR;
  std::string folder = (data / "posegraphs").string(), only;
  CLI::App app("posegraph: cost and optimum of public pose graphs, one row per graph and start");
  app.add_option("FOLDER", folder, "holds the graphs; default: RALI_DATA_DIR/posegraphs");
  app.add_option("NAME", only, "only graphs whose name contains it");
  if (const auto code = rali::bench::ended_by(app, argc, argv)) return *code;
  if (!std::filesystem::is_directory(folder)) {
    fmt::print(stderr, "NO DATA, NOT MEASURED: {} is not there\n", folder);
    return 1;
  }
  return rali::posegraph::run(folder, only) ? 0 : 1;
}
