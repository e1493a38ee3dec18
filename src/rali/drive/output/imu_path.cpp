#include "rali/drive/output/imu_path.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "rali/io/files/tum.hpp"

namespace rali::drive {
namespace {

const geometry::Vec3 kGravity_mps2(0.0, 0.0, -9.80665);
constexpr double kScanGap_s = 1.0;
constexpr double kSampleGap_s = 0.1;

using Samples = std::span<const sensor::ImuSample>;

/// Motion since the first scan from the samples alone, starting at zero velocity.
struct Integral {
  geometry::Mat3 R = geometry::Mat3::Identity();  ///< of the IMU at the first scan
  geometry::Vec3 v_map_mps = geometry::Vec3::Zero();
  geometry::Vec3 p_map_m = geometry::Vec3::Zero();

  /// @param R_map_imu at the first scan
  void add(const geometry::Mat3& R_map_imu, const geometry::Vec3& gyro_radps,
           const geometry::Vec3& accel_mps2, double dt_s) {
    const geometry::Mat3 half = R * geometry::so3_exp(0.5 * dt_s * gyro_radps);
    const geometry::Vec3 a = R_map_imu * (half * accel_mps2) + kGravity_mps2;
    p_map_m += dt_s * v_map_mps + 0.5 * dt_s * dt_s * a;
    v_map_mps += dt_s * a;
    R = R * geometry::so3_exp(dt_s * gyro_radps);
  }
};

/// The samples around one interval between scans and their integrals.
class Interval {
 public:
  /// @param first of `all` after t0; @param T0, T1 poses of the IMU in map at the scans
  Interval(Samples all, std::size_t first, Time t0, Time t1, const geometry::SE3& T0,
           const geometry::SE3& T1)
      : t0_(t0), dt_s_(seconds_between(t0, t1)), T0_(T0) {
    Integral sum;
    Time t = t0;
    bool gap = false;
    std::size_t i = first;
    for (; i < all.size() && all[i].t <= t1; ++i) {
      gap = gap || seconds_between(t, all[i].t) > kSampleGap_s;
      step(all, i, t, all[i].t, sum);
      at_.push_back(sum);
      t = all[i].t;
    }
    gap = gap || seconds_between(t, t1) > kSampleGap_s;
    if (gap) {
      sum = {};
      std::fill(at_.begin(), at_.end(), sum);
    } else {
      step(all, i < all.size() ? i : i - 1, t, t1, sum);
    }
    rotation_left_rad_ = geometry::so3_log((T0.R * sum.R).transpose() * T1.R);
    v_map_mps_ = (T1.p - T0.p - sum.p_map_m) / dt_s_;
  }

  [[nodiscard]] std::size_t size() const { return at_.size(); }

  /// Pose of the IMU in map at the k-th sample of the interval.
  [[nodiscard]] geometry::SE3 pose(std::size_t k, Time t) const {
    const double since_s = seconds_between(t0_, t);
    geometry::SE3 T;
    T.R = T0_.R * at_[k].R * geometry::so3_exp(since_s / dt_s_ * rotation_left_rad_);
    T.p = T0_.p + since_s * v_map_mps_ + at_[k].p_map_m;
    return T;
  }

 private:
  /// Integrates `from` to `to`, where `to` lies between the samples i - 1 and i.
  void step(Samples all, std::size_t i, Time from, Time to, Integral& sum) const {
    const sensor::ImuSample& before = all[i > 0 ? i - 1 : i];
    const double dt_s = seconds_between(from, to);
    if (!(dt_s > 0.0)) return;
    sum.add(T0_.R, 0.5 * (before.gyro_radps + all[i].gyro_radps),
            0.5 * (before.accel_mps2 + all[i].accel_mps2), dt_s);
  }

  Time t0_;
  double dt_s_;
  geometry::SE3 T0_;
  std::vector<Integral> at_;
  geometry::Vec3 rotation_left_rad_, v_map_mps_;
};

bool is_usable(const PoseRecord& a, const PoseRecord& b) {
  const double dt_s = seconds_between(a.t, b.t);
  return a.quality != vehicle::PoseQuality::kDiverged &&
         b.quality != vehicle::PoseQuality::kDiverged && dt_s > 0.0 && dt_s <= kScanGap_s;
}

}  // namespace

Status imu_rate_poses(const std::vector<PoseRecord>& poses, const geometry::SE3& T_map_local,
                      std::span<const sensor::ImuSample> samples, const geometry::SE3& T_body_imu,
                      const std::function<Status(const io::StampedPose&)>& put) {
  const geometry::SE3 T_imu_body = T_body_imu.inverse();
  std::size_t next = 0;
  for (std::size_t k = 0; k + 1 < poses.size(); ++k) {
    const PoseRecord &a = poses[k], &b = poses[k + 1];
    while (next < samples.size() && samples[next].t <= a.t) ++next;
    if (!is_usable(a, b) || next == samples.size()) continue;
    const Interval interval(samples, next, a.t, b.t, T_map_local * a.T_local_body * T_body_imu,
                            T_map_local * b.T_local_body * T_body_imu);
    for (std::size_t i = 0; i < interval.size(); ++i) {
      const Time t = samples[next + i].t;
      if (Status s = put({t, interval.pose(i, t) * T_imu_body}); !s) return s;
    }
  }
  return {};
}

Status write_imu_path(const std::string& path, const std::vector<PoseRecord>& poses,
                      const MapFrame& frame, const std::string& vehicle,
                      std::span<const sensor::ImuSample> samples, const geometry::SE3& T_body_imu) {
  std::vector<std::string> header = trajectory_header(frame, vehicle);
  for (std::string& line : header) {
    if (line.starts_with("stamp =")) line = "stamp = inertial sample [s]; x forward, y left, z up";
  }
  Result<io::TumWriter> file = io::TumWriter::create(path, header);
  if (!file) return tl::make_unexpected(file.error());
  const Status written = imu_rate_poses(poses, frame.T_map_local, samples, T_body_imu,
                                        [&](const io::StampedPose& pose) {
                                          return file->add({pose.t, pose.T * frame.T_body_point});
                                        });
  if (!written) return written;
  return file->finish();
}

}  // namespace rali::drive
