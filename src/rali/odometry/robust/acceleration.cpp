#include "rali/odometry/robust/acceleration.hpp"

#include <cmath>

namespace rali::odometry {

using geometry::Vec3;

namespace {

constexpr double kSpan_s = 1.0;
constexpr double kSpanMax_s = 1.6;  // longer: scans are missing

}  // namespace

void AccelerationWatch::add(Time t, const geometry::SE3& step) {
  T_ = path_.empty() ? geometry::SE3{} : T_ * step;
  path_.push_back({t, T_.p});
  while (path_.size() > 2 && seconds_between(path_[1].t, t) > 2.0 * kSpanMax_s) path_.pop_front();
}

std::optional<double> AccelerationWatch::mean_mps2() const {
  if (path_.empty()) return std::nullopt;
  const auto before = [this](const Point& later) -> const Point* {
    for (auto p = path_.rbegin(); p != path_.rend(); ++p) {
      if (seconds_between(p->t, later.t) > kSpan_s - 1e-3) return &*p;
    }
    return nullptr;
  };
  const Point& end = path_.back();
  const Point* const middle = before(end);
  const Point* const begin = middle != nullptr ? before(*middle) : nullptr;
  if (begin == nullptr) return std::nullopt;
  const double first_s = seconds_between(begin->t, middle->t);
  const double second_s = seconds_between(middle->t, end.t);
  if (first_s > kSpanMax_s || second_s > kSpanMax_s) return std::nullopt;
  const Vec3 change = (end.p - middle->p) / second_s - (middle->p - begin->p) / first_s;
  return change.norm() / (0.5 * (first_s + second_s));
}

Vec3 unexplained_shift(const Vec3& shift_m, const geometry::Mat3& covariance_m2) {
  constexpr double kSigmas = 3.0;
  const double length_m = shift_m.norm();
  if (!(length_m > 0.0)) return Vec3::Zero();
  const Vec3 along = shift_m / length_m;
  const double explained_m = kSigmas * std::sqrt(std::max(0.0, along.dot(covariance_m2 * along)));
  return std::max(0.0, length_m - explained_m) * along;
}

}  // namespace rali::odometry
