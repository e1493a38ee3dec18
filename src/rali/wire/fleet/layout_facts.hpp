#pragma once

#include "rali/fleet/facts/facts.hpp"
#include "rali/fleet/facts/quantise.hpp"
#include "rali/wire/fleet/pack.hpp"

/// Sections and fields of facts; `Body` is BodyWriter with a const fact, or BodyReader. Ranges and
/// points have codecs of their own. A released tag keeps its meaning and its fields permanently.
namespace rali::wire {

template <class Body, class Start>
void layout_epoch_start(Body& body, Start& start) {
  body.section(1, [&](auto& a) {
    a.text(start.name, fleet::kNameMax);
    a.list(start.antennas_body_m, fleet::kAntennasMax,
           [](auto& b, auto& antenna) { b.double3(antenna); });
  });
}

template <class Archive, class Factor>
void layout_inertial(Archive& a, Factor& f) {
  a.real(f.duration_s);
  a.rotation(f.dR);
  a.float3(f.dv_mps);
  a.float3(f.dp_m);
  a.float3(f.gyro_bias_radps);
  a.float3(f.accel_bias_mps2);
  a.scaled(f.d_rotation_d_gyro);
  a.scaled(f.d_velocity_d_gyro);
  a.scaled(f.d_velocity_d_accel);
  a.scaled(f.d_position_d_gyro);
  a.scaled(f.d_position_d_accel);
  a.template covariance<9>(f.covariance);
  a.as_float(f.gyro_walk_radps_rts);
  a.as_float(f.accel_walk_mps2_rts);
  a.rotation(f.T_body_imu.R);
  a.float3(f.T_body_imu.p);
}

template <class Body, class Step>
void layout_increment(Body& body, Step& step) {
  body.section(1, [&](auto& a) {
    a.varint(step.node);
    a.maybe(step.keyframe, [](auto& b, auto& keyframe) { b.varint(keyframe); });
    a.flag(step.begins);
    a.flag(step.at_rest);
    a.flag(step.degenerate);
    a.flag(step.levelled);
    a.pose(step.T_odom_body);
    a.float3(step.v_odom_mps);
    a.float3(step.gyro_bias_radps);
    a.float3(step.accel_bias_mps2);
    a.float3(step.g_odom_mps2);
  });
  body.section(2, [&](auto& a) {
    a.template covariance<6>(step.covariance);
    a.information(step.lidar_information);
  });
  body.section(3, [&](auto& a) {
    a.maybe(step.inertial, [&](auto& b, auto& factor) {
      layout_inertial(b, factor);
      // Gravity usually equals the node's own: omitting it saves 12 of 600 bytes.
      std::optional<geometry::Vec3> other;
      if (!b.kReads && factor.g_odom_mps2 != step.g_odom_mps2) other = factor.g_odom_mps2;
      b.maybe(other, [](auto& c, auto& g) { c.float3(g); });
      if constexpr (std::decay_t<decltype(b)>::kReads) {
        factor.g_odom_mps2 = other.value_or(step.g_odom_mps2);
      }
    });
  });
  body.optional_section(4, step.level_sigma_rad > 0.0,
                        [&](auto& a) { a.as_float(step.level_sigma_rad); });
  body.optional_section(5, step.force_sigma_mps2 > 0.0,
                        [&](auto& a) { a.as_float(step.force_sigma_mps2); });
}

template <class Archive, class Id>
void layout_keyframe_id(Archive& a, Id& id) {
  a.varint(id.vehicle.value);
  a.varint(id.seq);
}

template <class Body, class LoopType>
void layout_loop(Body& body, LoopType& loop) {
  body.section(1, [&](auto& a) {
    layout_keyframe_id(a, loop.from);
    a.varint(loop.from_epoch);
    layout_keyframe_id(a, loop.to);
    a.varint(loop.to_epoch);
    a.pose(loop.T_from_to);
    a.information(loop.information);
    a.as_float(loop.overlap);
    a.as_float(loop.rms_m);
  });
}

}  // namespace rali::wire
