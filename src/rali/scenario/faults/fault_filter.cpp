#include "rali/scenario/faults/fault_filter.hpp"

#include <algorithm>
#include <limits>

namespace rali::scenario {

using sensor::ImuSample;
using sensor::LidarScan;
using sensor::RadioSample;
using sensor::RangeSample;

namespace {

using ScanPtr = std::shared_ptr<const LidarScan>;

Time stamp_of(const ImuSample& imu) { return imu.t; }

Time stamp_of(const ScanPtr& scan) { return scan->t_start; }

Time stamp_of(const RangeSample& range) { return range.t; }

Time stamp_of(const RadioSample& radio) { return radio.t; }

ScanPtr with_nan(const LidarScan& scan, Rng& chance) {
  auto spoilt = std::make_shared<LidarScan>(scan);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < spoilt->size(); ++i) {
    if (chance.uniform() >= kFaultNanFraction) continue;
    spoilt->x_m[i] = spoilt->y_m[i] = spoilt->z_m[i] = kNan;
  }
  return spoilt;
}

ScanPtr covered(const LidarScan& scan, Rng& chance) {
  auto spoilt = std::make_shared<LidarScan>(scan);
  for (std::size_t i = 0; i < spoilt->size(); ++i) {
    const double depth_m = cover_depth_m(chance);
    const Eigen::Vector3d p_m(spoilt->x_m[i], spoilt->y_m[i], spoilt->z_m[i]);
    const auto shorter = static_cast<float>(std::min(1.0, depth_m / p_m.norm()));
    spoilt->x_m[i] *= shorter;
    spoilt->y_m[i] *= shorter;
    spoilt->z_m[i] *= shorter;
  }
  return spoilt;
}

ScanPtr without_times(const LidarScan& scan) {
  auto spoilt = std::make_shared<LidarScan>(scan);
  std::fill(spoilt->dt_s.begin(), spoilt->dt_s.end(), 0.0F);
  spoilt->has_point_times = false;
  return spoilt;
}

ScanPtr shifted(const LidarScan& scan, Duration by) {
  auto spoilt = std::make_shared<LidarScan>(scan);
  spoilt->t_start = spoilt->t_start + by;
  spoilt->t_end = spoilt->t_end + by;
  return spoilt;
}

bool has_end(VehicleId a, VehicleId b, int vehicle) {
  return static_cast<int>(a.value) == vehicle || static_cast<int>(b.value) == vehicle;
}

}  // namespace

FaultFilter::FaultFilter(std::vector<Fault> faults, Time start, std::uint64_t seed)
    : faults_(std::move(faults)), start_(start) {
  for (std::size_t i = 0; i < faults_.size(); ++i) {
    chance_.emplace_back(seed, "fault " + fault_text(faults_[i]));
  }
}

bool FaultFilter::active(const Fault& fault, int vehicle, Time t) const {
  const double t_s = seconds_between(start_, t);
  return fault.vehicle == vehicle && t_s >= fault.t0_s && t_s < fault.t1_s;
}

bool FaultFilter::spoil(std::size_t i, int vehicle, ImuSample& imu, Time t) {
  const Fault& fault = faults_[i];
  if (!active(fault, vehicle, t)) return true;
  switch (fault.kind) {
    case FaultKind::kDrop:
      return chance_[i].uniform() >= kFaultDropFraction;
    case FaultKind::kGap:
      return false;
    case FaultKind::kClockJump:
      imu.t = imu.t + Duration::from_s(kFaultClockJump_s);
      return true;
    case FaultKind::kImuScale:
      imu.gyro_radps *= kFaultImuScale;
      imu.accel_mps2 *= kFaultImuScale;
      return true;
    case FaultKind::kImuSaturate:
      imu.gyro_radps =
          imu.gyro_radps.cwiseMax(-kFaultGyroLimit_radps).cwiseMin(kFaultGyroLimit_radps);
      imu.accel_mps2 =
          imu.accel_mps2.cwiseMax(-kFaultAccelLimit_mps2).cwiseMin(kFaultAccelLimit_mps2);
      return true;
    default:
      return true;
  }
}

bool FaultFilter::spoil(std::size_t i, int vehicle, ScanPtr& scan, Time t) {
  const Fault& fault = faults_[i];
  if (!active(fault, vehicle, t)) return true;
  switch (fault.kind) {
    case FaultKind::kDrop:
      return chance_[i].uniform() >= kFaultDropFraction;
    case FaultKind::kGap:
      return false;
    case FaultKind::kClockJump:
      scan = shifted(*scan, Duration::from_s(kFaultClockJump_s));
      return true;
    case FaultKind::kNan:
      scan = with_nan(*scan, chance_[i]);
      return true;
    case FaultKind::kCover:
      scan = covered(*scan, chance_[i]);
      return true;
    case FaultKind::kTimeField:
      scan = without_times(*scan);
      return true;
    default:
      return true;
  }
}

bool FaultFilter::spoil(std::size_t i, int vehicle, RangeSample& range, Time t) {
  const Fault& fault = faults_[i];
  // The measuring vehicle gives the stamp, but both ends affect the range.
  if (fault.kind == FaultKind::kClockJump && active(fault, vehicle, t)) {
    range.t = range.t + Duration::from_s(kFaultClockJump_s);
  }
  if (!has_end(range.from, range.to, fault.vehicle) || !active(fault, fault.vehicle, t))
    return true;
  if (fault.kind == FaultKind::kUwbBias) range.range_m += kFaultUwbBias_m;
  return fault.kind != FaultKind::kUwbOff;
}

bool FaultFilter::spoil(std::size_t i, int vehicle, RadioSample& radio, Time t) {
  const Fault& fault = faults_[i];
  if (fault.kind == FaultKind::kClockJump && active(fault, vehicle, t)) {
    radio.t = radio.t + Duration::from_s(kFaultClockJump_s);
  }
  if (!has_end(radio.from, radio.to, fault.vehicle) || !active(fault, fault.vehicle, t))
    return true;
  return fault.kind != FaultKind::kRadioLoss;
}

std::optional<sim::FleetMessage> FaultFilter::apply(sim::FleetMessage message) {
  const bool kept = std::visit(
      [&](auto& data) {
        const Time t = stamp_of(data);  // the true one: a clock jump must not shift the windows
        for (std::size_t i = 0; i < faults_.size(); ++i) {
          if (!spoil(i, message.vehicle, data, t)) return false;
        }
        return true;
      },
      message.data);
  if (!kept) return std::nullopt;
  return message;
}

std::optional<Time> FaultFilter::cut_at(int vehicle) const {
  std::optional<Time> first;
  for (const Fault& fault : faults_) {
    if (fault.kind != FaultKind::kCutFile || fault.vehicle != vehicle) continue;
    const Time t = start_ + Duration::from_s(fault.t0_s);
    if (!first || t < *first) first = t;
  }
  return first;
}

}  // namespace rali::scenario
