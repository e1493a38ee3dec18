#pragma once

#include <span>
#include <vector>

#include "rali/places/density.hpp"
#include "rali/places/fft.hpp"

namespace rali::places {

/// A yaw and a shift of marks, with their correlation with a picture.
struct Place {
  double yaw_rad = 0.0;
  geometry::Vec2 shift_m = geometry::Vec2::Zero();
  double correlation = 0.0;
};

/// Correlates rotated marks with one picture at all overlapping shifts, by FFT: two yaws per
/// transform, one in the real and one in the imaginary part.
class Correlator {
 public:
  Correlator(const Picture& picture, std::span<const Mark> marks, double cell_m);

  /// Appends the peaks of both yaws.
  void correlate(double yaw1_rad, double yaw2_rad, std::vector<Place>& out);

 private:
  void draw(double yaw_rad, bool imaginary);
  void peaks(double yaw_rad, bool imaginary, std::vector<Place>& out) const;

  [[nodiscard]] float value(std::size_t x, std::size_t y, bool imaginary) const {
    const Fft2::Complex& c = work_[(y & mask_) * fft_.side() + (x & mask_)];
    return imaginary ? c.imag() : c.real();
  }

  /// The transform is cyclic: negative shifts are at its far end.
  [[nodiscard]] double cells_of(std::size_t i) const {
    const double v = static_cast<double>(i);
    return i < fft_.side() - reach_ ? v : v - static_cast<double>(fft_.side());
  }

  double cell_m_;
  std::span<const Mark> marks_;
  std::size_t reach_;  ///< of the marks, in cells
  geometry::Vec2 low_;
  Fft2 fft_;
  std::size_t mask_;
  double scale_ = 1.0;  ///< from the transform's scale to a fraction of the marks
  std::vector<Fft2::Complex> picture_, work_;
};

/// A rectangle of shifts.
struct ShiftWindow {
  geometry::Vec2 low_m, high_m;

  /// Shifts in it, one per cell.
  [[nodiscard]] double count(double cell_m) const;
};

/// The same peaks for a small window of shifts, each summed directly. A shift at the window's edge
/// is a peak if it exceeds its neighbours inside and around the window.
void correlate_within(const Picture& picture, std::span<const Mark> marks, double cell_m,
                      double yaw_rad, const ShiftWindow& window, std::vector<Place>& out);

}  // namespace rali::places
