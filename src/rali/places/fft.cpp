#include "rali/places/fft.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "rali/base/assert.hpp"

namespace rali::places {

Fft2::Fft2(std::size_t side) : side_(side), reversed_(side, 0) {
  RALI_ASSERT(side >= 2 && (side & (side - 1)) == 0);
  for (std::size_t half = 1; half < side; half *= 2) {
    for (std::size_t k = 0; k < half; ++k) {
      const double angle = -std::numbers::pi * static_cast<double>(k) / static_cast<double>(half);
      turns_.emplace_back(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    }
  }
  for (std::size_t i = 1, j = 0; i < side; ++i) {
    std::size_t bit = side / 2;
    for (; (j & bit) != 0; bit /= 2) j ^= bit;
    j ^= bit;
    reversed_[i] = j;
  }
}

void Fft2::row(Complex* x) const {
  for (std::size_t i = 0; i < side_; ++i) {
    if (i < reversed_[i]) std::swap(x[i], x[reversed_[i]]);
  }
  const Complex* turn = turns_.data();
  for (std::size_t half = 1; half < side_; turn += half, half *= 2) {
    for (std::size_t base = 0; base < side_; base += 2 * half) {
      for (std::size_t k = 0; k < half; ++k) {
        const float wr = turn[k].real();
        const float wi = turn[k].imag();
        Complex& low = x[base + k];
        Complex& high = x[base + k + half];
        // By hand: the library's product also checks for infinities.
        const Complex t(wr * high.real() - wi * high.imag(), wr * high.imag() + wi * high.real());
        high = low - t;
        low += t;
      }
    }
  }
}

void Fft2::transpose(std::vector<Complex>& p) {
  constexpr std::size_t kBlock = 16;
  for (std::size_t by = 0; by < side_; by += kBlock) {
    for (std::size_t bx = by; bx < side_; bx += kBlock) {
      for (std::size_t y = by; y < std::min(side_, by + kBlock); ++y) {
        for (std::size_t x = std::max(bx, y + 1); x < std::min(side_, bx + kBlock); ++x) {
          std::swap(p[y * side_ + x], p[x * side_ + y]);
        }
      }
    }
  }
}

void Fft2::forward(std::vector<Complex>& picture) {
  RALI_ASSERT(picture.size() == side_ * side_);
  for (std::size_t y = 0; y < side_; ++y) row(picture.data() + y * side_);
  transpose(picture);
  for (std::size_t y = 0; y < side_; ++y) row(picture.data() + y * side_);
}

void Fft2::back(std::vector<Complex>& picture) {
  for (Complex& c : picture) c = std::conj(c);
  forward(picture);
  for (Complex& c : picture) c = std::conj(c);
}

}  // namespace rali::places
