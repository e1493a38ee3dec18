#include "rali/odometry/paper/submap.hpp"

#include <algorithm>
#include <cmath>

namespace rali::odometry::paper {

using geometry::SE3;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

constexpr int kNeighboursMin = 3;  // algorithms.md 2.1

}  // namespace

Submap::Submap(double radius_m, double normal_max_rad, int keyframes, int kept_max)
    : radius_m_(radius_m),
      cos_normal_max_(static_cast<float>(std::cos(normal_max_rad))),
      selected_max_(static_cast<std::size_t>(keyframes)),
      kept_max_(static_cast<std::size_t>(kept_max)) {}

void Submap::add_keyframe(const SE3& T_odom_body, std::vector<PointNormal> features_body) {
  keyframes_.push_back({next_number_++, T_odom_body, std::move(features_body)});
  if (keyframes_.size() > kept_max_) {
    keyframes_.pop_front();
    ++forgotten_;
  }
}

void Submap::move_newest(std::span<const SE3> poses) {
  const std::size_t n = std::min(poses.size(), keyframes_.size());
  for (std::size_t i = 0; i < n; ++i) {
    SE3& T = keyframes_[keyframes_.size() - n + i].T_odom_body;
    const SE3& T_new = poses[poses.size() - n + i];
    if (T.R == T_new.R && T.p == T_new.p) continue;
    T = T_new;
    selected_.clear();  // the grid is rebuilt
  }
}

void Submap::select_near(const Vec3& p_odom) {
  distances_.clear();
  for (const StoredKeyframe& k : keyframes_) {
    distances_.emplace_back((k.T_odom_body.p - p_odom).squaredNorm(), k.number);
  }
  if (distances_.size() > selected_max_) {
    std::nth_element(distances_.begin(),
                     distances_.begin() + static_cast<std::ptrdiff_t>(selected_max_),
                     distances_.end());
    distances_.resize(selected_max_);
  }
  wanted_.clear();
  for (const auto& entry : distances_) wanted_.push_back(entry.second);
  std::sort(wanted_.begin(), wanted_.end());
  if (wanted_ == selected_) return;
  selected_ = wanted_;
  rebuild();
}

void Submap::rebuild() {
  gathered_.clear();
  if (!selected_.empty()) {
    const std::uint64_t first = keyframes_.front().number;
    origin_odom_ = keyframes_[selected_.back() - first].T_odom_body.p;
    for (const std::uint64_t number : selected_) {
      const StoredKeyframe& k = keyframes_[number - first];
      const Eigen::Matrix3f R = k.T_odom_body.R.cast<float>();
      const Vec3f p = (k.T_odom_body.p - origin_odom_).cast<float>();
      for (const PointNormal& f : k.features_body) gathered_.push_back({R * f.p + p, R * f.n});
    }
  }
  grid_.build(gathered_, static_cast<float>(radius_m_));
}

bool Submap::plane_at(const Vec3& p_odom, const Vec3& n_odom, LocalPlane& out) const {
  const Vec3f query = (p_odom - origin_odom_).cast<float>();
  const Vec3f n_query = n_odom.cast<float>();
  Vec3f sum_p = Vec3f::Zero();  // relative to the query: sums of small numbers
  Vec3f sum_n = Vec3f::Zero();
  int count = 0;
  grid_.for_each_within(query, [&](const PointNormal& neighbour) {
    const float cosine = neighbour.n.dot(n_query);
    if (std::abs(cosine) < cos_normal_max_) return;
    sum_p += neighbour.p - query;
    sum_n += cosine < 0.0F ? Vec3f(-neighbour.n) : neighbour.n;
    ++count;
  });
  if (count < kNeighboursMin) return false;
  const double length = static_cast<double>(sum_n.norm());
  if (!(length > 1e-6)) return false;
  out.centre_odom = p_odom + sum_p.cast<double>() / count;
  out.n_odom = sum_n.cast<double>() / length;
  out.neighbours = count;
  // Resultant length of unit vectors: 1 - |sum|/N is half the sum of the variances of both tilts.
  out.normal_variance = std::max(0.0, 1.0 - length / count) / count;
  return true;
}

void Submap::clear() {
  keyframes_.clear();
  selected_.clear();
  rebuild();
}

}  // namespace rali::odometry::paper
