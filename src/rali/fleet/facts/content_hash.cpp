#include <bit>

#include "rali/fleet/facts/quantise.hpp"

namespace rali::fleet {

namespace {

using geometry::SE3;

/// FNV-1a over 64-bit words, with a final mix so that low bits depend on all.
class Hash {
 public:
  void add(std::uint64_t word) { state_ = (state_ ^ word) * 0x100000001B3ULL ^ state_ >> 29; }

  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }

  template <class Derived>
  void add(const Eigen::MatrixBase<Derived>& m) {
    for (Eigen::Index i = 0; i < m.rows(); ++i) {
      for (Eigen::Index j = 0; j < m.cols(); ++j) add(m(i, j));
    }
  }

  void add(const SE3& T) {
    add(T.R);
    add(T.p);
  }

  template <class T>
  void add_list(const std::vector<T>& list) {
    add(std::uint64_t{list.size()});
    for (const T& value : list) {
      if constexpr (std::is_integral_v<T>) {
        add(static_cast<std::uint64_t>(value));
      } else {
        add(value);
      }
    }
  }

  [[nodiscard]] std::uint64_t value() const {
    std::uint64_t v = state_;
    v = (v ^ v >> 33) * 0xFF51AFD7ED558CCDULL;
    v = (v ^ v >> 33) * 0xC4CEB9FE1A85EC53ULL;
    return v ^ v >> 33;
  }

 private:
  std::uint64_t state_ = 0xCBF29CE484222325ULL;
};

std::uint64_t word(bool a, bool b = false, bool c = false, bool d = false) {
  return std::uint64_t{a} | std::uint64_t{b} << 1 | std::uint64_t{c} << 2 | std::uint64_t{d} << 3;
}

std::uint64_t word(const KeyframeId& id) { return std::uint64_t{id.vehicle.value} << 32 | id.seq; }

void add(Hash& h, const EpochStart& start) {
  h.add_list(std::vector<std::uint8_t>(start.name.begin(), start.name.end()));
  h.add_list(start.antennas_body_m);
}

void add(Hash& h, const Increment& step) {
  h.add(std::uint64_t{step.node});
  h.add(step.keyframe ? std::uint64_t{*step.keyframe} : ~std::uint64_t{0});
  h.add(word(step.begins, step.at_rest, step.degenerate, step.levelled));
  h.add(step.T_odom_body);
  h.add(step.v_odom_mps);
  h.add(step.gyro_bias_radps);
  h.add(step.accel_bias_mps2);
  h.add(step.force_sigma_mps2);
  h.add(step.g_odom_mps2);
  h.add(step.level_sigma_rad);
  h.add(step.covariance);
  h.add(step.lidar_information);
  h.add(word(step.inertial.has_value()));
  if (!step.inertial) return;
  const graph::InertialFactor& f = *step.inertial;
  h.add(f.duration_s);
  h.add(f.dR);
  h.add(f.dv_mps);
  h.add(f.dp_m);
  h.add(f.gyro_bias_radps);
  h.add(f.accel_bias_mps2);
  h.add(f.d_rotation_d_gyro);
  h.add(f.d_velocity_d_gyro);
  h.add(f.d_velocity_d_accel);
  h.add(f.d_position_d_gyro);
  h.add(f.d_position_d_accel);
  h.add(f.covariance);
  h.add(f.gyro_walk_radps_rts);
  h.add(f.accel_walk_mps2_rts);
  h.add(f.g_odom_mps2);
  h.add(f.T_body_imu);
}

void add(Hash& h, const RangeBlock& block) {
  h.add(std::uint64_t{block.ranges.size()});
  for (const RangeEntry& range : block.ranges) {
    h.add(static_cast<std::uint64_t>(range.t.ns));
    h.add(std::uint64_t{range.from.value} << 32 | std::uint64_t{range.to.value} << 16 |
          std::uint64_t{range.from_antenna} << 8 | range.to_antenna);
    h.add(range.range_m);
    h.add(range.sigma_m);
    h.add(range.T_odom_body);
    h.add(word(range.at_rest));
  }
}

void add(Hash& h, const KeyframePoints& points) {
  h.add(std::uint64_t{points.keyframe});
  h.add(points.T_body_lidar);
  h.add(std::uint64_t{points.size()});
  h.add(word(points.points.has_intensity()));
  h.add_list(points.points.bytes());
  h.add(word(points.refinement));
}

void add(Hash& h, const Loop& loop) {
  h.add(word(loop.from));
  h.add(word(loop.to));
  h.add(std::uint64_t{loop.from_epoch} << 32 | loop.to_epoch);
  h.add(loop.T_from_to);
  h.add(loop.information);
  h.add(loop.overlap);
  h.add(loop.rms_m);
}

void add(Hash& h, const UnreadBody& body) { h.add(std::uint64_t{body.kind}); }

}  // namespace

std::uint64_t content_hash(const Fact& fact) {
  Hash h;
  h.add(std::uint64_t{fact.key.vehicle.value} << 32 | fact.key.epoch);
  h.add(std::uint64_t{fact.key.seq});
  h.add(static_cast<std::uint64_t>(fact.t.ns));
  h.add(std::uint64_t{fact.body.index()});
  std::visit([&h](const auto& body) { add(h, body); }, fact.body);
  h.add_list(fact.unread);
  return h.value();
}

}  // namespace rali::fleet
