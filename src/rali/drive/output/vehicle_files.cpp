#include "rali/drive/output/vehicle_files.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/graph_files.hpp"
#include "rali/io/files/text.hpp"

namespace rali::drive {

namespace {

/// Added to an edge's information where a direction was degenerate: strict readers require an
/// invertible matrix. A sigma of 1000 m or rad is no information.
constexpr double kInformationMin = 1e-6;

void add_edge(Time t, std::size_t from, std::size_t to, const geometry::SE3& T_from_to,
              const geometry::Mat6& information, io::GraphFile& graph) {
  io::GraphEdge edge;
  edge.t = t;
  edge.from = from;
  edge.to = to;
  edge.T_from_to = T_from_to;
  const geometry::Mat6 symmetric = 0.5 * (information + information.transpose());
  edge.information = symmetric + kInformationMin * geometry::Mat6::Identity();
  const Eigen::LLT<geometry::Mat6> llt(edge.information);
  if (llt.info() != Eigen::Success || !edge.information.allFinite()) {
    edge.information = kInformationMin * geometry::Mat6::Identity();
  }
  edge.covariance = edge.information.llt().solve(geometry::Mat6::Identity());
  graph.edges.push_back(edge);
}

/// Loops and ranges between the vehicles, where both ends are vertices.
void add_joint_edges(const fleet::FleetEstimate& estimate,
                     const std::map<KeyframeId, std::size_t>& vertices, io::GraphFile& graph) {
  for (const fleet::LoopVerdict& loop : estimate.loops) {
    const auto from = vertices.find(loop.from), to = vertices.find(loop.to);
    if (!loop.accepted || from == vertices.end() || to == vertices.end()) continue;
    add_edge(std::max(loop.t_from, loop.t_to), from->second, to->second, loop.T_from_to,
             loop.information, graph);
  }
  for (const fleet::UsedRange& range : estimate.ranges) {
    const auto from = vertices.find(range.a), to = vertices.find(range.b);
    if (from == vertices.end() || to == vertices.end()) continue;
    graph.ranges.push_back(
        {range.t, from->second, to->second, range.range_m, range.sigma_m * range.sigma_m});
  }
}

/// Keyframes, the odometry between them, loops and ranges; diverged keyframes break the chain.
io::GraphFile graph_of(const std::vector<VehicleRun>& runs, const fleet::FleetEstimate& estimate) {
  io::GraphFile graph;
  std::map<KeyframeId, std::size_t> vertices;
  for (const VehicleRun& run : runs) {
    bool chained = false;
    for (const KeyframeRecord& record : run.keyframes()) {
      if (record.diverged) {
        chained = false;
        continue;
      }
      const std::size_t vertex = graph.vertices.size();
      graph.vertices.push_back({record.t, record.id, run.T_map_local() * record.T_local_body});
      vertices[record.id] = vertex;
      if (chained) {
        add_edge(record.t, vertex - 1, vertex, record.T_previous_this, record.information_relative,
                 graph);
      }
      chained = true;
    }
  }
  add_joint_edges(estimate, vertices, graph);
  return graph;
}

std::string loops_text(const fleet::FleetEstimate& estimate,
                       const std::vector<std::string>& names) {
  std::string text =
      "stamp_from_s,vehicle_from,stamp_to_s,vehicle_to,accepted,reason,score,shift_m\n";
  for (const fleet::LoopVerdict& loop : estimate.loops) {
    text += fmt::format("{},{},{},{},{},{},{:.3f},{:.4f}\n", io::format_stamp(loop.t_from),
                        names[loop.from.vehicle.value], io::format_stamp(loop.t_to),
                        names[loop.to.vehicle.value], loop.accepted ? 1 : 0, loop.reason,
                        loop.score, loop.shift_m);
  }
  return text;
}

}  // namespace

Status write_vehicle_files(const VehicleRun& run, const std::string& out_dir,
                           const std::vector<std::string>& vehicles) {
  std::error_code error;
  for (const char* folder : {"/trajectory", "/degeneracy"}) {
    std::filesystem::create_directories(out_dir + folder, error);
    if (error) return fail(ErrorCode::kMachine, out_dir + folder, error.message());
  }
  const std::string trajectory = out_dir + "/trajectory/" + run.name();
  Status status = io::write_file_atomic(trajectory + ".tum",
                                        trajectory_text(run.poses(), run.map_frame(), run.name()));
  if (!status) return status;
  status = io::write_file_atomic(trajectory + ".cov.csv",
                                 trajectory_covariance_text(run.poses(), run.map_frame()));
  if (!status) return status;
  return io::write_file_atomic(out_dir + "/degeneracy/" + run.name() + ".csv",
                               degeneracy_text(run.poses(), run.T_map_local(), vehicles));
}

Status write_fleet_files(const std::vector<VehicleRun>& runs, const fleet::FleetEstimate& estimate,
                         const MapJob& job) {
  std::vector<VehicleKeyframes> keyframes;
  for (const VehicleRun& run : runs) {
    keyframes.push_back({run.name(), run.T_map_local(), &run.keyframes()});
  }
  Status status = io::write_file_atomic(job.out_dir + "/keyframes.csv",
                                        keyframes_text(keyframes, job.write_keyframes));
  if (!status) return status;
  const io::GraphFile graph = graph_of(runs, estimate);
  if (status = io::write_g2o(job.out_dir + "/graph.g2o", graph); !status) return status;
  if (status = io::write_pyfg(job.out_dir + "/graph.pyfg", graph); !status) return status;
  std::vector<std::string> names;
  for (const VehicleRun& run : runs) names.push_back(run.name());
  return io::write_file_atomic(job.out_dir + "/loops.csv", loops_text(estimate, names));
}

}  // namespace rali::drive
