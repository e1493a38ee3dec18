#pragma once

#include <span>
#include <string>
#include <vector>

#include "rali/base/ids.hpp"
#include "rali/base/result.hpp"
#include "rali/base/time.hpp"
#include "rali/geometry/se3.hpp"
#include "rali/io/files/range_csv.hpp"

namespace rali::drive {

/// The vehicle's body origin was above a point with known site coordinates.
struct SiteMark {
  VehicleId vehicle;
  Time t;
  geometry::Vec3 p_site_m = geometry::Vec3::Zero();
  double sigma_m = 0.0;  ///< of each axis
};

/// Minimum number of marks for yaw and translation; fewer do not reveal their own errors.
inline constexpr std::size_t kMarksMin = 3;

/// Reads `vehicle,stamp_s,x_m,y_m,z_m,sigma_m`. Errors: kInput with file and line (a column
/// missing, no vehicle, no number, fewer than kMarksMin marks).
[[nodiscard]] Result<std::vector<SiteMark>> read_marks_csv(const std::string& path,
                                                           const io::RadioNames& names);

/// A mark and its position in the map.
struct MarkPair {
  std::string vehicle;
  Time t;
  geometry::Vec3 p_map_m = geometry::Vec3::Zero(), p_site_m = geometry::Vec3::Zero();
  double sigma_m = 0.0;
};

struct MarkResidual {
  std::string vehicle;
  Time t;
  geometry::Vec3 residual_site_m = geometry::Vec3::Zero();  ///< map position on the site minus mark
  double sigma_m = 0.0;
};

/// Pose of map on the site: p_site = Rz(yaw) p_map + p_site_map. Both are levelled by gravity.
struct SiteFrame {
  double yaw_rad = 0.0;
  geometry::Vec3 p_site_map_m = geometry::Vec3::Zero();
  double yaw_sigma_rad = 0.0;  ///< from the sigmas of the marks
  double rms_m = 0.0;          ///< of the residuals, 3-D
  std::vector<MarkResidual> residuals;

  [[nodiscard]] geometry::Vec3 site_of(const geometry::Vec3& p_map_m) const;
};

/// Weighted least squares over yaw and translation.
/// Errors: kNoAnswer (fewer than kMarksMin marks, or so close together that the heading sigma
/// exceeds 3 degrees).
[[nodiscard]] Result<SiteFrame> solve_site(std::span<const MarkPair> marks);

}  // namespace rali::drive
