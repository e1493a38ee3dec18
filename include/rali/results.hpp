#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "rali/error.hpp"
#include "rali/types.hpp"

namespace rali {

/// A trajectory: one pose per scan, at the time of its last point.
struct Trajectory {
  std::vector<std::int64_t> stamp_ns;
  std::vector<Pose3> poses;              ///< T_map_body of trajectory/, T_odom_body of odometry/
  std::vector<Covariance6> covariances;  ///< NaN where unknown; empty: no .cov.csv beside it
  std::vector<std::string> header;       ///< comment lines without "#"

  [[nodiscard]] std::size_t size() const { return poses.size(); }
};

/// Reads a TUM file and the .cov.csv beside it, if there is one. Throws InputError with file and
/// line.
[[nodiscard]] Trajectory read_trajectory(const std::string& path);

/// A point cloud. Arrays have one value per point, or are empty where the file has no such field.
struct MapCloud {
  std::vector<float> xyz_m;  ///< x y z of the first point, of the second, ...
  std::vector<float> intensity;
  std::vector<float> sigma_m;         ///< expected position error
  std::vector<std::uint16_t> seen;    ///< keyframes that saw the point
  std::vector<std::uint8_t> vehicle;  ///< number of the vehicle that observed it first

  [[nodiscard]] std::size_t size() const { return xyz_m.size() / 3; }
};

/// Reads map.pcd or map.ply, or any other PCD, PLY or KITTI .bin. Throws InputError.
[[nodiscard]] MapCloud read_map(const std::string& path);

/// ranges.csv of a run, or a hand-written one: column by column. NaN: unknown.
struct RangeTable {
  std::vector<std::int64_t> stamp_ns;
  std::vector<std::string> from, to;
  std::vector<double> range_m, predicted_m, residual_m, sigma_m, bias_m;
  std::vector<double> p_los;        ///< probability of line of sight
  std::vector<std::uint8_t> used;   ///< 1 or 0
  std::vector<std::string> reason;  ///< "used", or why not

  [[nodiscard]] std::size_t size() const { return stamp_ns.size(); }
};

/// Throws InputError with file and line (no file, a column of stamp_s, from, to, range_m missing).
[[nodiscard]] RangeTable read_ranges(const std::string& path);

}  // namespace rali
