#include "rali/config/foreign_names.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

namespace rali::config {
namespace {

struct ForeignName {
  std::string_view name;  // lower case
  std::string_view remedy;
};

constexpr std::string_view kInvertLidar =
    "The key here is T_body_lidar, the pose of the LiDAR in the body: write the inverse of yours.";
constexpr std::string_view kKeepLidar =
    "The key here is T_body_lidar, the pose of the LiDAR in the body: same direction, do not "
    "invert.";
constexpr std::string_view kInvertImu =
    "The key here is T_body_imu, the pose of the IMU in the body: write the inverse of yours.";
constexpr std::string_view kKeepImu =
    "The key here is T_body_imu, the pose of the IMU in the body: same direction, do not invert.";
// LIO-SAM turns IMU vectors into the LiDAR's axes (issue 47 there), so it is T_lidar_imu.
constexpr std::string_view kLioSam =
    "In LIO-SAM it leads from the IMU to the LiDAR. The key here is T_body_lidar, the pose of the "
    "LiDAR in the body (= IMU): write the inverse, {xyz_m: -R^T t, matrix: R^T}.";
// FAST_LIO, Point-LIO, FAST-LIVO: pose of the LiDAR in the IMU frame.
constexpr std::string_view kFastLio =
    "In FAST_LIO it is the pose of the LiDAR in the IMU. The key here is T_body_lidar with xyz_m "
    "and matrix: same direction, do not invert.";
constexpr std::string_view kGuess =
    "The key here is T_body_lidar with p_body = T_body_lidar * p_lidar: invert yours if it maps "
    "body or IMU coordinates to the LiDAR.";

constexpr std::array kForeign{
    ForeignName{"t_lidar_body", kInvertLidar},
    ForeignName{"t_lidar_imu", kInvertLidar},
    ForeignName{"t_lidar_base", kInvertLidar},
    ForeignName{"t_lidar_base_link", kInvertLidar},
    ForeignName{"lidar_t_body", kInvertLidar},
    ForeignName{"lidar_t_imu", kInvertLidar},
    ForeignName{"t_l_i", kInvertLidar},
    ForeignName{"t_imu_to_lidar", kInvertLidar},
    ForeignName{"t_imu_lidar", kKeepLidar},
    ForeignName{"t_base_lidar", kKeepLidar},
    ForeignName{"t_base_link_lidar", kKeepLidar},
    ForeignName{"body_t_lidar", kKeepLidar},
    ForeignName{"imu_t_lidar", kKeepLidar},
    ForeignName{"t_i_l", kKeepLidar},
    ForeignName{"t_lidar_to_imu", kKeepLidar},
    ForeignName{"t_lidar_to_body", kKeepLidar},
    ForeignName{"t_imu_body", kInvertImu},
    ForeignName{"t_imu_base", kInvertImu},
    ForeignName{"t_base_imu", kKeepImu},
    ForeignName{"t_base_link_imu", kKeepImu},
    ForeignName{"extrinsicrot", kLioSam},
    ForeignName{"extrinsictrans", kLioSam},
    ForeignName{"extrinsicrpy", kLioSam},
    ForeignName{"extrinsic_t", kFastLio},
    ForeignName{"extrinsic_r", kFastLio},
    ForeignName{"extrinsic_rot", kGuess},
    ForeignName{"extrinsics", kGuess},
    ForeignName{"extrinsic", kGuess},
    ForeignName{"transform", kGuess},
    ForeignName{"lidar_to_imu", kKeepLidar},
    ForeignName{"imu_to_lidar", kInvertLidar},
};

}  // namespace

std::string foreign_name_remedy(std::string_view key) {
  std::string lower(key);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto* const found =
      std::find_if(kForeign.begin(), kForeign.end(),
                   [&](const ForeignName& foreign) { return foreign.name == lower; });
  return found == kForeign.end() ? std::string() : std::string(found->remedy);
}

}  // namespace rali::config
