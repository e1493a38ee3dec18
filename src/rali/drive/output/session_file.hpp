#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/output/pose_files.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/sensor/lidar_scan.hpp"
#include "rali/wire/messages.hpp"

namespace rali::drive {

/// session.mcap: the run for viewers (Foxglove, Lichtblick, PlotJuggler). Frames follow REP-105:
/// map -> <v>/odom -> <v>/base_link -> <v>/lidar. The odometry is as published at the time; map ->
/// <v>/odom is written at the end: at every scan the chain then gives the final pose, of all
/// vehicles in one frame where they could be joined. Messages are therefore not in the order of
/// their stamps; readers use the index. One in five scans is kept, as measured.
class SessionFile {
 public:
  ~SessionFile();

  /// Errors: kMachine.
  [[nodiscard]] static Result<std::unique_ptr<SessionFile>> create(const std::string& out_dir);

  /// Pose of the LiDAR in this vehicle's body; written with its first scan.
  void set_lidar(const std::string& vehicle, const geometry::SE3& T_body_lidar);
  [[nodiscard]] Status add_scan(const std::string& vehicle, const sensor::LidarScan& scan);
  /// A pose as published at the time. Keeps 104 bytes of each until the end.
  [[nodiscard]] Status add_pose(const std::string& vehicle, const PoseRecord& pose);
  /// The whole path in its final frame, and its degenerate parts.
  /// @param poses as many as were added, with the same stamps
  [[nodiscard]] Status add_path(const std::string& vehicle, const std::vector<PoseRecord>& poses,
                                const geometry::SE3& T_map_local);

  [[nodiscard]] Status add_cloud(const std::string& topic, const wire::CloudView& cloud);
  [[nodiscard]] Status add_markers(const std::string& topic, Time t,
                                   const wire::MarkerArray& markers);

  /// Writes the summary and gives the file its name.
  [[nodiscard]] Status finish();

 private:
  explicit SessionFile(io::AtomicFile file);

  [[nodiscard]] Status write_frames(const std::string& vehicle,
                                    const std::vector<PoseRecord>& poses,
                                    const geometry::SE3& T_map_local);
  [[nodiscard]] Status diagnose(const std::string& vehicle, const PoseRecord& pose);
  [[nodiscard]] Status write(const std::string& topic, const std::string& type, Time t,
                             const wire::Bytes& bytes);

  io::FileSink sink_;
  io::McapWriter mcap_;
  std::map<std::string, std::uint16_t> schemas_, channels_;
  std::map<std::string, std::uint64_t> scans_;
  std::map<std::string, Time> t_diagnosed_;
  std::map<std::string, geometry::SE3> T_body_lidar_;
  std::map<std::string, std::vector<std::pair<Time, geometry::SE3>>> reported_;  ///< T_odom_body
};

}  // namespace rali::drive
