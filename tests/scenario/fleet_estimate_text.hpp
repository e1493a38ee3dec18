#pragma once

#include <string>

#include <fmt/format.h>

#include "rali/fleet/centre/estimate.hpp"

namespace rali {

inline std::string text_of(const geometry::SE3& T) {
  std::string text;
  for (int i = 0; i < 9; ++i) text += fmt::format("{:a} ", T.R(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) text += fmt::format("{:a} ", T.p[i]);
  return text;
}

/// All of an estimate to the last bit: equal texts, equal estimates.
inline std::string text_of(const fleet::FleetEstimate& estimate) {
  std::string text;
  for (const auto& group : estimate.groups) {
    text += "group";
    for (const VehicleId id : group) text += fmt::format(" {}", id.value);
    text += '\n';
  }
  for (const fleet::VehicleFrame& f : estimate.frames) {
    text += fmt::format("frame {} {} {:a} {:a} {} {} {}\n", f.vehicle.value, f.group, f.sigma_m,
                        f.sigma_rad, f.decided_by ? decided_by_text(*f.decided_by) : "",
                        f.waits_for, text_of(f.T_map_odom));
  }
  for (const auto& [id, k] : estimate.keyframes) {
    text += fmt::format("{} {} {} {}", id.vehicle.value, id.seq, k.t.ns, text_of(k.T_map_body));
    for (int i = 0; i < 36; ++i) text += fmt::format("{:a} ", k.covariance(i / 6, i % 6));
    text += '\n';
  }
  for (const fleet::LoopVerdict& l : estimate.loops) {
    text += fmt::format("loop {} {} {} {} {:a} {}\n", l.from.seq, l.to.seq, l.accepted, l.reason,
                        l.shift_m, text_of(l.T_from_to));
  }
  for (const fleet::PairBias& b : estimate.biases) {
    text += fmt::format("bias {} {} {:a} {:a} {} {}\n", b.a.value, b.b.value, b.bias_m, b.sigma_m,
                        b.ranges, b.used);
  }
  for (const fleet::UsedRange& r : estimate.ranges) {
    text += fmt::format("range {} {:a} {:a}\n", r.t.ns, r.range_m, r.sigma_m);
  }
  return text;
}

}  // namespace rali
