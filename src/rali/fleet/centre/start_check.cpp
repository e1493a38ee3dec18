#include "rali/fleet/centre/start_check.hpp"

#include <cmath>

#include "rali/fleet/path/level.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {

using geometry::SE3;

RejectedStart off_start(std::span<const VehiclePath> paths, const StartPrior& start,
                        const SE3& T_map_odom_relative, const SE3& T_map_odom_path) {
  const auto level = [&](std::size_t path) {
    const VehiclePath& p = paths[path];
    return level_start(p.nodes().front().step->T_odom_body, p.up_odom());
  };
  const SE3 found = (T_map_odom_relative * level(start.relative_to)).inverse() * T_map_odom_path *
                    level(start.path);
  RejectedStart off{paths[start.relative_to].vehicle(), paths[start.path].vehicle()};
  off.off_m = (found.p - start.T_relative_path.p).norm();
  off.off_rad = geometry::so3_log(start.T_relative_path.R.transpose() * found.R).norm();
  return off;
}

bool contradicts(const StartPrior& start, const RejectedStart& off, const PriorSettings& settings) {
  const double chi2 =
      std::pow(off.off_m / start.sigma_m, 2) + std::pow(off.off_rad / start.sigma_rad, 2);
  return !(chi2 < settings.wrong_chi2);
}

}  // namespace rali::fleet
