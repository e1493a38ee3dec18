#include "rali/scenario/recording/truth_files.hpp"

#include <fmt/format.h>

#include "rali/io/files/mesh_file.hpp"

namespace rali::scenario {

namespace {

constexpr Duration kPoseStep = Duration::from_ns(10'000'000);
constexpr Duration kBiasStep = Duration::from_ns(1'000'000'000);
constexpr std::size_t kBiases = 0;
constexpr std::size_t kRanges = 1;

}  // namespace

Result<TruthFiles> TruthFiles::create(const std::string& folder,
                                      const std::vector<std::string>& names,
                                      const sim::FleetSimulation& sim) {
  TruthFiles files(folder, names);
  if (Status opened = files.open(sim); !opened) return tl::make_unexpected(opened.error());
  return files;
}

Status TruthFiles::open(const sim::FleetSimulation& sim) {
  next_pose_ = next_bias_ = sim.t_start();
  for (const std::string& name : names_) {
    auto tum = io::TumWriter::create(fmt::format("{}/{}.tum", folder_, name),
                                     {"truth of the simulation: T_world_body, 100 Hz"});
    if (!tum) return tl::make_unexpected(tum.error());
    poses_.push_back(std::move(*tum));
    path_m_.push_back(0.0);
    last_.push_back(sim.truth(static_cast<int>(last_.size()), next_pose_).state.T_world_body.p);
  }
  auto biases =
      io::CsvWriter::create(folder_ + "/biases.csv", {"stamp_s", "of", "quantity", "value"});
  if (!biases) return tl::make_unexpected(biases.error());
  tables_.push_back(std::move(*biases));
  if (names_.size() > 1) {
    auto ranges = io::CsvWriter::create(folder_ + "/ranges.csv",
                                        {"stamp_s", "from", "to", "distance_m", "obstructed"});
    if (!ranges) return tl::make_unexpected(ranges.error());
    tables_.push_back(std::move(*ranges));
    if (Status s = add_pair_biases(sim); !s) return s;
  }
  const sim::TriangleMesh& mesh = sim.mesh();
  return io::write_mesh_ply(folder_ + "/mesh.ply", mesh.vertices, mesh.triangles,
                            mesh.reflectivity);
}

Status TruthFiles::add_bias(Time t, const std::string& of, const char* quantity, double value) {
  io::CsvRow row;
  row.stamp(t).text(of).text(quantity).fixed(value, 6);
  return tables_[kBiases].add(row, t);
}

Status TruthFiles::add_pair_biases(const sim::FleetSimulation& sim) {
  const Time t = sim.t_start();
  for (int a = 0; a < sim.vehicles(); ++a) {
    for (int b = a + 1; b < sim.vehicles(); ++b) {
      const auto count_a = static_cast<int>(sim.antennas(a).size());
      const auto count_b = static_cast<int>(sim.antennas(b).size());
      for (int i = 0; i < count_a; ++i) {
        for (int j = 0; j < count_b; ++j) {
          const std::string of = fmt::format("{}/{}-{}/{}", names_[static_cast<std::size_t>(a)], i,
                                             names_[static_cast<std::size_t>(b)], j);
          if (Status s = add_bias(t, of, "range_m", sim.uwb().pair_bias_m(a, i, b, j)); !s)
            return s;
        }
      }
    }
  }
  return {};
}

Status TruthFiles::add_imu_biases(Time t, const sim::FleetSimulation& sim) {
  constexpr const char* kGyro[] = {"gyro_x_radps", "gyro_y_radps", "gyro_z_radps"};
  constexpr const char* kAccel[] = {"accel_x_mps2", "accel_y_mps2", "accel_z_mps2"};
  for (std::size_t v = 0; v < names_.size(); ++v) {
    const sim::ImuBias bias = sim.imu_bias(static_cast<int>(v));
    for (int k = 0; k < 3; ++k) {
      if (Status s = add_bias(t, names_[v], kGyro[k], bias.gyro_radps[k]); !s) return s;
    }
    for (int k = 0; k < 3; ++k) {
      if (Status s = add_bias(t, names_[v], kAccel[k], bias.accel_mps2[k]); !s) return s;
    }
  }
  return {};
}

Status TruthFiles::reach(Time t, const sim::FleetSimulation& sim) {
  for (; next_pose_ <= t; next_pose_ = next_pose_ + kPoseStep) {
    for (std::size_t v = 0; v < names_.size(); ++v) {
      const sim::Truth truth = sim.truth(static_cast<int>(v), next_pose_);
      const geometry::Vec3& p = truth.state.T_world_body.p;
      path_m_[v] += (p - last_[v]).norm();
      last_[v] = p;
      if (Status s = poses_[v].add({next_pose_, truth.state.T_world_body}); !s) return s;
    }
  }
  for (; next_bias_ <= t; next_bias_ = next_bias_ + kBiasStep) {
    if (Status s = add_imu_biases(next_bias_, sim); !s) return s;
  }
  return {};
}

Status TruthFiles::add(const sensor::RangeSample& range, const sim::RangeTruth& truth) {
  io::CsvRow row;
  row.stamp(truth.t).text(names_[range.from.value]).text(names_[range.to.value]);
  row.fixed(truth.distance_m, 4).integer(truth.obstructed ? 1 : 0);
  return tables_[kRanges].add(row, truth.t);
}

Status TruthFiles::finish(Time until, const sim::FleetSimulation& sim) {
  if (Status s = reach(until, sim); !s) return s;
  for (io::TumWriter& tum : poses_) {
    if (Status s = tum.finish(); !s) return s;
  }
  for (io::CsvWriter& table : tables_) {
    if (Status s = table.finish(); !s) return s;
  }
  return {};
}

}  // namespace rali::scenario
