#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/output/blind_hold.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// What stays in memory of each sweep until the end of the run: 400 bytes, 14 MB per hour.
struct PoseRecord {
  Time t;
  geometry::SE3 T_local_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  geometry::SE3 T_odom_body;                           ///< as told at the time
  vehicle::PoseQuality quality = vehicle::PoseQuality::kGood;
  bool blind = false;
  double sigma_blind_m = 0.0;                          ///< infinity: not held at all
  std::optional<double> degree;                        ///< of the paper; empty: too few normals
  geometry::Vec3 blind_odom = geometry::Vec3::Zero();  ///< least known direction
  int worst_axis = -1;  ///< 0 axial, 1 lateral, 2 vertical; -1: not known
  degeneracy::Category category = degeneracy::Category::kFull;  ///< of the worst axis
  double correction_m = 0.0;            ///< what ranges moved the pose since the last sweep
  std::optional<VehicleId> range_from;  ///< whose range did
  HeldBy held_by = HeldBy::kLidar;
  bool tied = false;  ///< known to hang on the pose before, however long ago that was
};

/// Root of the expected squared 3-D position error; 0 where it is no number.
[[nodiscard]] double position_sigma_m(const PoseRecord& pose);

[[nodiscard]] PoseRecord pose_record(const vehicle::PoseEstimate& pose);

/// Columns of a covariance file: stamp_s,c00..c55, the upper triangle in the order x y z rx ry rz
/// about the fixed axes of the outer frame.
[[nodiscard]] std::vector<std::string> covariance_columns();
[[nodiscard]] io::CsvRow covariance_row(Time t, const geometry::Mat6& cov_boxplus,
                                        const geometry::Mat3& R_outer_body);

/// <folder>/<v>.tum and .cov.csv: each pose as it was known when its sweep was processed. Reaches
/// the disk at most 10 s of data late and in whole lines, so that even a kill leaves
/// <folder>/.<v>.tum.tmp readable.
class PoseFiles {
 public:
  /// @param folder "odometry" or "live"  @param frame of the poses  Errors: kMachine.
  [[nodiscard]] static Result<PoseFiles> create(const std::string& out_dir,
                                                const std::string& folder,
                                                const std::string& vehicle,
                                                const std::string& frame);
  /// @param covariance of geometry::boxplus
  [[nodiscard]] Status add(Time t, const geometry::SE3& T, const geometry::Mat6& covariance);
  [[nodiscard]] Status close();

 private:
  PoseFiles(io::TumWriter poses, io::CsvWriter covariances);

  io::TumWriter poses_;
  io::CsvWriter covariances_;
};

/// Where the results of a vehicle lie, and of which point of it the trajectory is.
struct MapFrame {
  geometry::SE3 T_map_local;
  bool levelled = false;       ///< by gravity, of this vehicle or of one that shares the frame
  std::string point = "body";  ///< body, lidar or imu
  geometry::SE3 T_body_point;
};

/// Comment lines of trajectory/<v>.tum.
[[nodiscard]] std::vector<std::string> trajectory_header(const MapFrame& frame,
                                                         const std::string& vehicle);

/// Text of trajectory/<v>.tum: T_map_point of each pose, diverged stretches left out and named.
[[nodiscard]] std::string trajectory_text(const std::vector<PoseRecord>& poses,
                                          const MapFrame& frame, const std::string& vehicle);
[[nodiscard]] std::string trajectory_covariance_text(const std::vector<PoseRecord>& poses,
                                                     const MapFrame& frame);

/// Text of degeneracy/<v>.csv, directions in map. sigma_m is that of the position along the least
/// known direction: how far off it may be there, whatever holds it.
/// @param vehicles names by number, for range_from
[[nodiscard]] std::string degeneracy_text(const std::vector<PoseRecord>& poses,
                                          const geometry::SE3& T_map_local,
                                          const std::vector<std::string>& vehicles);

/// Way travelled [m], what of it was blind [m], and what of that was held by ranges [m]; diverged
/// poses left out.
struct WayLength {
  double path_m = 0.0;
  double blind_m = 0.0;
  double held_m = 0.0;
};

[[nodiscard]] WayLength way_length(const std::vector<PoseRecord>& poses);

}  // namespace rali::drive
