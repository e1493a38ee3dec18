#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/output/degenerate_hold.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/io/files/tum.hpp"
#include "rali/vehicle/event.hpp"

namespace rali::drive {

/// What stays in memory of each scan until the end of the run: 400 bytes, 14 MB per hour.
struct PoseRecord {
  Time t;
  geometry::SE3 T_local_body;
  geometry::Mat6 covariance = geometry::Mat6::Zero();  ///< of geometry::boxplus
  geometry::SE3 T_odom_body;                           ///< as published at the time
  vehicle::PoseQuality quality = vehicle::PoseQuality::kGood;
  bool degenerate = false;
  double sigma_degenerate_m = 0.0;  ///< infinity: unconstrained
  std::optional<double> degree;     ///< of degeneracy (paper); empty: too few normals
  geometry::Vec3 degenerate_odom = geometry::Vec3::Zero();  ///< least observable direction
  int worst_axis = -1;  ///< 0 axial, 1 lateral, 2 vertical; -1: not known
  degeneracy::Category category = degeneracy::Category::kFull;  ///< of the worst axis
  double correction_m = 0.0;            ///< shift of the pose by ranges since the last scan
  std::optional<VehicleId> range_from;  ///< whose range caused it
  HeldBy held_by = HeldBy::kLidar;
  bool tied = false;  ///< continuous with the previous pose, however long ago that was
};

/// Root of the expected squared 3-D position error; 0 if it is not finite.
[[nodiscard]] double position_sigma_m(const PoseRecord& pose);

[[nodiscard]] PoseRecord pose_record(const vehicle::PoseEstimate& pose);

/// Columns of a covariance file: stamp_s,c00..c55, the upper triangle in the order x y z rx ry rz
/// about the fixed axes of the outer frame.
[[nodiscard]] std::vector<std::string> covariance_columns();
[[nodiscard]] io::CsvRow covariance_row(Time t, const geometry::Mat6& cov_boxplus,
                                        const geometry::Mat3& R_outer_body);

/// <folder>/<v>.tum and .cov.csv: each pose as it was known when its scan was processed. Written to
/// disk at most 10 s of data late and in whole lines, so that <folder>/.<v>.tum.tmp stays readable
/// even after a kill.
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

/// Frame of a vehicle's results, and the point of the vehicle that the trajectory describes.
struct MapFrame {
  geometry::SE3 T_map_local;
  bool levelled = false;       ///< by gravity, of this vehicle or of one that shares the frame
  std::string point = "body";  ///< body, lidar or imu
  geometry::SE3 T_body_point;
};

/// Comment lines of trajectory/<v>.tum.
[[nodiscard]] std::vector<std::string> trajectory_header(const MapFrame& frame,
                                                         const std::string& vehicle);

/// Text of trajectory/<v>.tum: T_map_point of each pose, diverged stretches left out and listed.
[[nodiscard]] std::string trajectory_text(const std::vector<PoseRecord>& poses,
                                          const MapFrame& frame, const std::string& vehicle);
[[nodiscard]] std::string trajectory_covariance_text(const std::vector<PoseRecord>& poses,
                                                     const MapFrame& frame);

/// Text of degeneracy/<v>.csv, directions in map. sigma_m is the position sigma along the least
/// observable direction, whichever sensor constrains it.
/// @param vehicles names by number, for range_from
[[nodiscard]] std::string degeneracy_text(const std::vector<PoseRecord>& poses,
                                          const geometry::SE3& T_map_local,
                                          const std::vector<std::string>& vehicles);

/// Distance travelled [m], its degenerate part [m], and the part of that constrained by ranges [m];
/// diverged poses left out.
struct PathLength {
  double path_m = 0.0;
  double degenerate_m = 0.0;
  double held_m = 0.0;
};

[[nodiscard]] PathLength path_length(const std::vector<PoseRecord>& poses);

}  // namespace rali::drive
