#include "rali/imu/motion_noise.hpp"

#include <algorithm>
#include <cmath>

#include "rali/geometry/so3.hpp"

namespace rali::imu {

using geometry::Mat3;
using geometry::Vec3;

namespace {

/// This many independent values give the noise to a factor of 1.5 (1 sigma): from then on it counts
/// as measured.
constexpr double kEnough = 3.0;

/// Combines two estimates of one quantity whose errors are factors: weighted mean of logarithms.
double log_mean(double a, double factor_a, double b, double factor_b) {
  const double wa = 1.0 / (std::log(factor_a) * std::log(factor_a));
  const double wb = 1.0 / (std::log(factor_b) * std::log(factor_b));
  return std::exp((wa * std::log(a) + wb * std::log(b)) / (wa + wb));
}

}  // namespace

NoiseDensity prior_noise(const NoiseDensity& claimed, const MotionNoiseSettings& s) {
  return {log_mean(claimed.gyro_radps_rthz, s.claimed_factor, s.gyro_typical_radps_rthz,
                   s.typical_factor),
          log_mean(claimed.accel_mps2_rthz, s.claimed_factor, s.accel_typical_mps2_rthz,
                   s.typical_factor)};
}

MotionNoise::MotionNoise(const NoiseDensity& claimed, const MotionNoiseSettings& settings)
    : settings_(settings),
      claimed_(claimed),
      prior_(prior_noise(claimed, settings)),
      density_(prior_) {}

void MotionNoise::Spread::add(const Vec3& difference, const Mat3& known, double dt_s,
                              double memory_s) {
  const double rank = known.trace();
  if (rank < 0.5) return;
  const double gain = dt_s / memory_s;
  const double g = std::max(gain, 1.0 / (weight / std::max(1.0, rank) + 1.0));
  lag_s += g * (dt_s - lag_s);
  const Vec3 seen = known * difference;
  const Vec3 off = seen - known * mean;
  mean += g * off;
  double square_now = off.squaredNorm() / rank;
  // A single jolt is not noise; many are.
  constexpr double kOutlier = 16.0;
  if (weight > 10.0) square_now = std::min(square_now, kOutlier * square);
  square += g * (square_now - square);
  weight = std::min(weight + rank, rank / gain);
}

/// The newest step at least lag_s before step `from`.
std::optional<std::size_t> MotionNoise::step_before(std::size_t from, double lag_s) const {
  for (std::size_t k = from; k-- > 0;) {
    if (seconds_between(steps_[k].t, steps_[from].t) > lag_s - 1e-3) return k;
  }
  return std::nullopt;
}

/// Compares the newest step with those one and two lags before.
void MotionNoise::compare(double lag_s, Spread& accel, Spread& gyro) {
  const std::size_t c = steps_.size() - 1;
  const auto b = step_before(c, lag_s);
  if (!b) return;
  const double dt_s = seconds_between(steps_[*b].t, steps_[c].t);

  // Integral between two steps: velocity and displacement when starting from zero velocity.
  struct Integral {
    Vec3 v = Vec3::Zero(), p = Vec3::Zero();
  };

  const auto integrate = [this](std::size_t from, std::size_t to) {
    Integral out;
    for (std::size_t k = from + 1; k <= to; ++k) {
      out.p += out.v * seconds_between(steps_[k - 1].t, steps_[k].t) + steps_[k].dp_m;
      out.v += steps_[k].dv_mps;
    }
    return out;
  };
  Mat3 dR = Mat3::Identity();
  for (std::size_t k = *b + 1; k <= c; ++k) dR = dR * steps_[k].dR;
  const Mat3 turned = steps_[*b].R_odom_body.transpose() * steps_[c].R_odom_body;
  const Mat3 rotation_known = steps_[c].rotation_known * steps_[*b].rotation_known;
  gyro.add(geometry::so3_log(dR.transpose() * turned),
           0.5 * (rotation_known + rotation_known.transpose()), dt_s, settings_.memory_s);
  const auto a = step_before(*b, lag_s);
  if (!a) return;
  const double before_s = seconds_between(steps_[*a].t, steps_[*b].t);
  if (before_s > 1.5 * dt_s || dt_s > 1.5 * before_s) return;
  const double ratio = dt_s / before_s;
  const Integral first = integrate(*a, *b);
  const Integral second = integrate(*b, c);
  const Vec3 seen = steps_[c].p_odom_m - steps_[*b].p_odom_m -
                    ratio * (steps_[*b].p_odom_m - steps_[*a].p_odom_m);
  const Vec3 inertial = second.p + first.v * dt_s - ratio * first.p;
  // In the body frame, where biases are constant; only where all three positions are observable.
  const Mat3 known = steps_[c].known * steps_[*b].known * steps_[*a].known;
  const Mat3& R = steps_[c].R_odom_body;
  accel.add(R.transpose() * (seen - inertial),
            R.transpose() * (0.5 * (known + known.transpose())) * R, dt_s, settings_.memory_s);
}

double MotionNoise::combined(double prior, const Measured& measured, double floor) const {
  if (measured.count <= 0.0) return prior;
  // A mean square of n values has a relative sigma of sqrt(2 / n) in its logarithm; the logarithm
  // of its root has half of that.
  const double w_measured = 2.0 * measured.count;
  const double w_prior =
      1.0 / (std::log(settings_.typical_factor) * std::log(settings_.typical_factor));
  const double value = std::max(measured.value, floor);
  const double mean =
      std::exp((w_prior * std::log(prior) + w_measured * std::log(value)) / (w_prior + w_measured));
  // With few observable directions the mean stays a quarter below the measured value if the prior
  // is a tenth of it. Too little noise degrades the pose, too much hardly matters: a low claim
  // counts only until the noise is measured.
  return measured.count < kEnough ? mean : std::max(mean, value);
}

MeasuredNoise MotionNoise::measured() const {
  MeasuredNoise out;
  if (gyro_.count >= kEnough) out.gyro_radps_rthz = density_.gyro_radps_rthz;
  if (accel_.count >= kEnough) out.accel_mps2_rthz = density_.accel_mps2_rthz;
  return out;
}

void MotionNoise::add(const MotionStep& step) {
  steps_.push_back(step);
  const double keep_s = 2.5 * settings_.long_s + 0.5;
  while (seconds_between(steps_.front().t, step.t) > keep_s) steps_.pop_front();
  compare(settings_.short_s, accel_spread_[0], gyro_spread_[0]);
  compare(settings_.long_s, accel_spread_[1], gyro_spread_[1]);
  // Overlapping values within one long lag count as one value.
  const double dt_s =
      steps_.size() > 1 ? seconds_between(steps_[steps_.size() - 2].t, step.t) : settings_.long_s;
  const auto independent = [dt_s](const Spread& s) {
    return s.lag_s > 0.0 ? s.weight * std::min(1.0, dt_s / s.lag_s) : 0.0;
  };
  // Second differences over a lag T: 2/3 q^2 T^3 from white acceleration, plus LiDAR noise that
  // does not grow with T. Rotations over T: q^2 T.
  const auto cube = [](double x) { return x * x * x; };
  const double a_span = cube(accel_spread_[1].lag_s) - cube(accel_spread_[0].lag_s);
  const double g_span = gyro_spread_[1].lag_s - gyro_spread_[0].lag_s;
  const auto root_of_growth = [](const std::array<Spread, 2>& s, double span) {
    return span > 0.0 ? std::sqrt(std::max(0.0, s[1].square - s[0].square) / span) : 0.0;
  };
  accel_ = {std::sqrt(1.5) * root_of_growth(accel_spread_, a_span), independent(accel_spread_[1])};
  gyro_ = {root_of_growth(gyro_spread_, g_span), independent(gyro_spread_[1])};
  // Below a tenth of the typical value, the noise of the LiDAR hides that of the inertial sensor.
  constexpr double kTellable = 0.1;
  density_.accel_mps2_rthz =
      combined(prior_.accel_mps2_rthz, accel_, kTellable * settings_.accel_typical_mps2_rthz);
  density_.gyro_radps_rthz =
      combined(prior_.gyro_radps_rthz, gyro_, kTellable * settings_.gyro_typical_radps_rthz);
}

}  // namespace rali::imu
