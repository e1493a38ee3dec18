#include "rali/base/rng.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include "rali/base/assert.hpp"

namespace rali {
namespace {

std::uint64_t split_mix(std::uint64_t& x) {
  x += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = x;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

Rng::Rng(std::uint64_t seed, std::string_view stream) : state_{} {
  std::uint64_t x = seed;
  for (const char c : stream) {  // FNV-1a over the name, folded into the seed
    x ^= static_cast<unsigned char>(c);
    x *= 0x100000001b3ULL;
  }
  for (std::uint64_t& s : state_) s = split_mix(x);
}

std::uint64_t Rng::next() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Rng::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double Rng::uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }

double Rng::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double u = 1.0 - uniform();  // in (0, 1]
  const double r = std::sqrt(-2.0 * std::log(u));
  const double phi = 2.0 * std::numbers::pi * uniform();
  spare_ = r * std::sin(phi);
  has_spare_ = true;
  return r * std::cos(phi);
}

std::uint64_t Rng::below(std::uint64_t n) {
  RALI_ASSERT(n > 0);
  const std::uint64_t limit = n * (UINT64_MAX / n);  // multiples of n only: no bias
  std::uint64_t x = next();
  while (x >= limit) x = next();
  return x % n;
}

}  // namespace rali
