#include "rali/map/keyframe_view.hpp"

namespace rali::map {

bool is_usable(const KeyframeView& keyframe) {
  const std::size_t n = keyframe.x_m.size();
  const bool lengths = keyframe.y_m.size() == n && keyframe.z_m.size() == n &&
                       (keyframe.intensity.empty() || keyframe.intensity.size() == n) &&
                       (keyframe.ring.empty() || keyframe.ring.size() == n);
  return lengths && keyframe.T_map_body.R.allFinite() && keyframe.T_map_body.p.allFinite() &&
         keyframe.T_body_lidar.R.allFinite() && keyframe.T_body_lidar.p.allFinite() &&
         keyframe.covariance.allFinite();
}

}  // namespace rali::map
