#include "rali/sensor/lidar_scan.hpp"

namespace rali::sensor {

void LidarScan::clear() {
  for (std::vector<float>* v : {&x_m, &y_m, &z_m, &intensity, &dt_s}) v->clear();
  ring.clear();
  t_start = t_end = Time{};
  has_point_times = has_rings = deskewed = false;
  rings = 0;
  dropped_nan = dropped_range = dropped_time = dropped_return = 0;
}

void LidarScan::reserve(std::size_t n) {
  for (std::vector<float>* v : {&x_m, &y_m, &z_m, &intensity, &dt_s}) v->reserve(n);
  ring.reserve(n);
}

void LidarScan::push_back(float px_m, float py_m, float pz_m, float intens, float dt,
                          std::uint16_t ring_index) {
  x_m.push_back(px_m);
  y_m.push_back(py_m);
  z_m.push_back(pz_m);
  intensity.push_back(intens);
  dt_s.push_back(dt);
  ring.push_back(ring_index);
}

}  // namespace rali::sensor
