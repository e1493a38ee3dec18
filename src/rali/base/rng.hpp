#pragma once

#include <cstdint>
#include <string_view>

namespace rali {

/// Random numbers with the same sequence on every machine (xoshiro256++, seeded by SplitMix64).
/// One stream per consumer, made from a seed and the consumer's name, so that a new consumer does
/// not shift the numbers of the others.
class Rng {
 public:
  explicit Rng(std::uint64_t seed, std::string_view stream = {});

  [[nodiscard]] std::uint64_t next();

  /// Uniform in [0, 1).
  [[nodiscard]] double uniform();
  /// Uniform in [lo, hi).
  [[nodiscard]] double uniform(double lo, double hi);
  /// Normal with mean 0 and standard deviation 1 (Box-Muller, own code: <random>'s differs
  /// between libraries).
  [[nodiscard]] double normal();
  /// Uniform integer in [0, n).
  [[nodiscard]] std::uint64_t below(std::uint64_t n);

 private:
  std::uint64_t state_[4];
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace rali
