// Preintegration against a recorded trajectory: 237 s at 100 Hz (data pack,
// lio_samples/continuous).
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "rali/imu/preintegration.hpp"

namespace rali::imu {
namespace {

using geometry::Vec3;

struct TrajectoryPose {
  Time t;
  Vec3 p = Vec3::Zero();
  geometry::Mat3 R = geometry::Mat3::Identity();
};

std::filesystem::path data_folder() {
  const char* from_user = std::getenv("RALI_DATA_DIR");
  return std::filesystem::path(from_user ? from_user : RALI_DATA_DIR) / "lio_samples/continuous";
}

// Times have nine decimals, more than a double of seconds since 1970 holds.
Time parse_time(const std::string& text) {
  const std::size_t dot = text.find('.');
  std::string fraction = dot == std::string::npos ? "" : text.substr(dot + 1);
  fraction.resize(9, '0');
  return Time::from_ns(std::stoll(text.substr(0, dot)) * 1'000'000'000LL + std::stoll(fraction));
}

std::vector<sensor::ImuSample> read_imu(const std::filesystem::path& file) {
  std::vector<sensor::ImuSample> out;
  std::ifstream in(file);
  std::string time;
  Vec3 a;
  Vec3 w;
  while (in >> time >> a.x() >> a.y() >> a.z() >> w.x() >> w.y() >> w.z()) {
    out.push_back({parse_time(time), w, a});
  }
  return out;
}

std::vector<TrajectoryPose> read_trajectory(const std::filesystem::path& file) {
  std::vector<TrajectoryPose> out;
  std::ifstream in(file);
  std::string time;
  Vec3 p;
  Eigen::Quaterniond q;
  while (in >> time >> p.x() >> p.y() >> p.z() >> q.x() >> q.y() >> q.z() >> q.w()) {
    out.push_back({parse_time(time), p, q.normalized().toRotationMatrix()});
  }
  return out;
}

// Five-point central difference: the slope of the quartic through the poses around k. A jerk biases
// the three-point slope, not this one.
Vec3 velocity_at(const std::vector<TrajectoryPose>& poses, std::size_t k) {
  const double h = seconds_between(poses[k - 2].t, poses[k + 2].t) / 4.0;
  return (8.0 * (poses[k + 1].p - poses[k - 1].p) - (poses[k + 2].p - poses[k - 2].p)) / (12.0 * h);
}

TEST(PreintegrationData, predicts_one_second_of_a_recorded_trajectory_with_5_cm_median_error) {
  const auto imu = read_imu(data_folder() / "imu.txt");
  const auto poses = read_trajectory(data_folder() / "traj.txt");
  if (imu.empty() || poses.empty()) {
    GTEST_SKIP() << "NO DATA: " << data_folder() << " not found; set RALI_DATA_DIR";
  }
  std::vector<double> errors_m;
  std::vector<double> errors_rad;
  for (std::size_t k = 12; k + 12 < poses.size(); k += 10) {
    const TrajectoryPose& from = poses[k];
    const TrajectoryPose& to = poses[k + 10];
    const auto first = std::upper_bound(imu.begin(), imu.end(), from.t,
                                        [](Time t, const auto& sample) { return t < sample.t; });
    const auto last = std::lower_bound(imu.begin(), imu.end(), to.t,
                                       [](const auto& sample, Time t) { return sample.t < t; });
    if (first == imu.begin() || last == imu.end()) continue;
    Preintegration pre({}, {1.7e-4, 2e-3});
    pre.add_stream({&*(first - 1), static_cast<std::size_t>(last - first) + 1}, from.t, to.t);
    const InertialState end =
        pre.predict({from.R, from.p, velocity_at(poses, k)}, Vec3(0.0, 0.0, -9.808), {});
    errors_m.push_back((end.p_odom_m - to.p).norm());
    errors_rad.push_back(geometry::so3_log(to.R.transpose() * end.R_odom_imu).norm());
  }
  ASSERT_GT(errors_m.size(), 200U);
  const auto median = [](std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  const double median_m = median(errors_m);
  const double median_deg = median(errors_rad) * 180.0 / M_PI;
  std::printf("[   DATA   ] %zu windows of 1 s: median error %.4f m, %.3f deg, worst %.4f m\n",
              errors_m.size(), median_m, median_deg,
              *std::max_element(errors_m.begin(), errors_m.end()));
  EXPECT_LT(median_m, 0.05);
  EXPECT_LT(median_deg, 0.5);
}

}  // namespace
}  // namespace rali::imu
