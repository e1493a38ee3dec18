#include "rali/cli/demo/demo_recording.hpp"

#include <filesystem>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/wire/cloud_pack.hpp"
#include "rali/wire/definitions.hpp"
#include "rali/wire/encode.hpp"

namespace rali::cli {
namespace {

constexpr auto kCdr = wire::Encoding::kCdr;
using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

/// The two topics of the recording.
class McapRecorder {
 public:
  explicit McapRecorder(io::AtomicFile file) : sink_(std::move(file)), mcap_(sink_, {}) {}

  Status open() {
    if (Status s = open_topic("/velodyne_points", "sensor_msgs/msg/PointCloud2", lidar_); !s) {
      return s;
    }
    return open_topic("/imu/data", "sensor_msgs/msg/Imu", imu_);
  }

  Status add(const sensor::ImuSample& sample) {
    return mcap_.write(imu_, sample.t, sample.t, wire::encode({sample, "imu"}, kCdr));
  }

  Status add(const sensor::LidarScan& scan) {
    const wire::PackedCloud cloud = wire::pack_cloud(scan, "velodyne", wire::CloudStyle::kVelodyne);
    return mcap_.write(lidar_, scan.t_end, scan.t_end, wire::encode(cloud.view, kCdr));
  }

  Status close() {
    if (Status s = mcap_.close(); !s) return s;
    return sink_.commit();
  }

 private:
  Status open_topic(const std::string& topic, const std::string& type, std::uint16_t& channel) {
    const Result<std::uint16_t> schema =
        mcap_.add_schema(type, "ros2msg", wire::message_definition(type, kCdr));
    if (!schema) return tl::make_unexpected(schema.error());
    const Result<std::uint16_t> made = mcap_.add_channel(*schema, topic, "cdr");
    if (!made) return tl::make_unexpected(made.error());
    channel = *made;
    return {};
  }

  io::FileSink sink_;
  io::McapWriter mcap_;
  std::uint16_t lidar_ = 0, imu_ = 0;
};

std::string extrinsics_text(const geometry::SE3& T) {
  const Eigen::Quaterniond q(T.R);
  return fmt::format(
      "{{xyz_m: [{:.4f}, {:.4f}, {:.4f}], quat_xyzw: [{:.6f}, {:.6f}, {:.6f}, "
      "{:.6f}]}}",
      T.p.x(), T.p.y(), T.p.z(), q.x(), q.y(), q.z(), q.w());
}

Status write_fleet(const std::string& path, const sensor::Calibration& calibration, bool has_imu) {
  return io::write_file_atomic(
      path, fmt::format("schema: 1\n"
                        "vehicles:\n"
                        "  v1:\n"
                        "    recording: v1.mcap\n"
                        "    lidar: {{model: rs16, T_body_lidar: {}}}\n"
                        "    imu: {{{}T_body_imu: {}}}\n",
                        extrinsics_text(calibration.T_body_lidar), has_imu ? "" : "topic: none, ",
                        extrinsics_text(calibration.T_body_imu)));
}

Status write_truth(const std::string& path, const eval::PoseList& truth) {
  Result<io::TumWriter> tum = io::TumWriter::create(
      path, {"truth of the simulation: T_world_body at the last point of each sweep"});
  if (!tum) return tl::make_unexpected(tum.error());
  for (const eval::StampedPose& pose : truth) {
    if (Status s = tum->add({pose.t, pose.T}); !s) return s;
  }
  return tum->finish();
}

Status record(sim::Simulation& sim, const DemoProgress& progress, McapRecorder& recorder,
              eval::PoseList& truth) {
  const double span_s = seconds_between(sim.t_begin(), sim.t_end());
  while (const std::optional<sim::Message> message = sim.next()) {
    if (const auto* imu = std::get_if<sensor::ImuSample>(&*message)) {
      if (Status s = recorder.add(*imu); !s) return s;
      continue;
    }
    const sensor::LidarScan& scan = *std::get<ScanPtr>(*message);
    if (Status s = recorder.add(scan); !s) return s;
    truth.push_back({scan.t_end, sim.truth(scan.t_end).state.T_world_body});
    const double share = span_s > 0.0 ? seconds_between(sim.t_begin(), scan.t_end) / span_s : 1.0;
    if (!progress(share)) return fail(ErrorCode::kInterrupted, "", "stopped while simulating");
  }
  return {};
}

}  // namespace

Result<DemoRecording> write_demo_recording(const sim::SimOptions& options,
                                           const std::string& folder,
                                           const DemoProgress& progress) {
  Result<std::unique_ptr<sim::Simulation>> sim = sim::make_simulation(options);
  if (!sim) return tl::make_unexpected(sim.error());
  std::error_code error;
  std::filesystem::create_directories(folder + "/truth", error);
  Result<io::AtomicFile> file = io::AtomicFile::create(folder + "/v1.mcap");
  if (!file) return tl::make_unexpected(file.error());
  DemoRecording made;
  made.fleet_file = folder + "/fleet.yaml";
  made.duration_s = seconds_between((*sim)->t_begin(), (*sim)->t_end());
  McapRecorder recorder(std::move(*file));
  Status status = recorder.open();
  if (status) status = record(**sim, progress, recorder, made.truth);
  if (status) status = recorder.close();
  if (status) {
    status = write_fleet(made.fleet_file, (*sim)->calibration_nominal(), options.with_imu);
  }
  if (status) status = write_truth(folder + "/truth/v1.tum", made.truth);
  if (!status) return tl::make_unexpected(status.error());
  return made;
}

}  // namespace rali::cli
