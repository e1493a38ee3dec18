#pragma once

#include <complex>
#include <vector>

namespace rali::places {

/// Fourier transform of a square picture whose side is a power of two (Cooley and Tukey 1965,
/// radix 2). Not scaled: forward and back multiply by side^2.
class Fft2 {
 public:
  using Complex = std::complex<float>;

  /// @param side a power of two, at least 2.
  explicit Fft2(std::size_t side);

  [[nodiscard]] std::size_t side() const { return side_; }

  /// In place, row by row. The result is transposed; a second transform restores the order.
  void forward(std::vector<Complex>& picture);
  void back(std::vector<Complex>& picture);

 private:
  void row(Complex* x) const;
  void transpose(std::vector<Complex>& picture);

  std::size_t side_;
  std::vector<Complex> turns_;         ///< twiddle factors of each stage, one after the other
  std::vector<std::size_t> reversed_;  ///< bit-reversed indices
};

}  // namespace rali::places
