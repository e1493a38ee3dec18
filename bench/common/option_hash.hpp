#pragma once

#include <cstdint>
#include <cstring>

#include "rali/base/settings.hpp"
#include "rali/sim/sim_options.hpp"

namespace rali::bench {

/// Hashes every option: other options give another file name.
class OptionHash {
 public:
  void add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 8; ++i) hash_ = (hash_ ^ ((bits >> (8 * i)) & 0xff)) * 0x100000001b3ULL;
  }

  void operator()(const char*, double value, double, double, const char*) { add(value); }

  void operator()(const char*, bool value, const char*) { add(value ? 1.0 : 0.0); }

  template <class E, std::size_t N>
  void choice(const char*, E value, const ChoiceNames<N>&, const char*) {
    add(static_cast<double>(value));
  }

  template <class G>
  void group(const char*, G& group, const char*) {
    group.visit(*this);
  }

  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

/// All options of a simulated vehicle.
inline void add_options(const sim::SimOptions& options, OptionHash& hash) {
  sim::SimOptions o = options;
  hash.add(static_cast<double>(o.scene));
  hash.add(static_cast<double>(o.seed));
  hash.add(static_cast<double>(o.lidar));
  hash.add(o.duration_s);
  hash.add(o.pedestrians);
  hash.add(o.with_imu ? 1.0 : 0.0);
  hash.add(o.imu_apart ? 1.0 : 0.0);
  hash.add(static_cast<double>(o.start.ns));
  hash.add(o.calibration_error_m);
  hash.add(o.calibration_error_deg);
  o.motion.visit(hash);
  o.ranging.visit(hash);
  o.imu.visit(hash);
}

}  // namespace rali::bench
