#include "rali/drive/output/vehicle_files.hpp"

#include <filesystem>

#include <Eigen/Cholesky>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/graph_files.hpp"

namespace rali::drive {

namespace {

/// Added to an edge's information where a direction was blind: strict readers want a matrix that
/// can be inverted. A sigma of 1000 m or rad says nothing.
constexpr double kInformationMin = 1e-6;

void add_edge(const KeyframeRecord& record, io::GraphFile& graph) {
  io::GraphEdge edge;
  edge.t = record.t;
  edge.from = graph.vertices.size() - 2;
  edge.to = graph.vertices.size() - 1;
  edge.T_from_to = record.T_previous_this;
  const geometry::Mat6 symmetric =
      0.5 * (record.information_relative + record.information_relative.transpose());
  edge.information = symmetric + kInformationMin * geometry::Mat6::Identity();
  const Eigen::LLT<geometry::Mat6> llt(edge.information);
  if (llt.info() != Eigen::Success || !edge.information.allFinite()) {
    edge.information = kInformationMin * geometry::Mat6::Identity();
  }
  edge.covariance = edge.information.llt().solve(geometry::Mat6::Identity());
  graph.edges.push_back(edge);
}

/// Keyframes and the odometry between them; what diverged cuts the chain.
io::GraphFile graph_of(const std::vector<VehicleRun>& runs) {
  io::GraphFile graph;
  for (const VehicleRun& run : runs) {
    bool chained = false;
    for (const KeyframeRecord& record : run.keyframes()) {
      if (record.diverged) {
        chained = false;
        continue;
      }
      graph.vertices.push_back({record.t, record.id, run.T_map_odom() * record.T_odom_body});
      if (chained) add_edge(record, graph);
      chained = true;
    }
  }
  return graph;
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
                                        trajectory_text(run.poses(), run.T_map_odom(), run.name()));
  if (!status) return status;
  status = io::write_file_atomic(trajectory + ".cov.csv",
                                 trajectory_covariance_text(run.poses(), run.T_map_odom()));
  if (!status) return status;
  return io::write_file_atomic(out_dir + "/degeneracy/" + run.name() + ".csv",
                               degeneracy_text(run.poses(), run.T_map_odom(), vehicles));
}

Status write_fleet_files(const std::vector<VehicleRun>& runs, const MapJob& job) {
  std::vector<VehicleKeyframes> keyframes;
  for (const VehicleRun& run : runs) {
    keyframes.push_back({run.name(), run.T_map_odom(), &run.keyframes()});
  }
  Status status = io::write_file_atomic(job.out_dir + "/keyframes.csv",
                                        keyframes_text(keyframes, job.write_keyframes));
  if (!status) return status;
  const io::GraphFile graph = graph_of(runs);
  if (status = io::write_g2o(job.out_dir + "/graph.g2o", graph); !status) return status;
  if (status = io::write_pyfg(job.out_dir + "/graph.pyfg", graph); !status) return status;
  // No loops are looked for yet: an empty table says that none was closed or refused.
  return io::write_file_atomic(
      job.out_dir + "/loops.csv",
      "stamp_from_s,vehicle_from,stamp_to_s,vehicle_to,accepted,reason,score,shift_m\n");
}

}  // namespace rali::drive
