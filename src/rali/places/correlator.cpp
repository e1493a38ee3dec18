#include "rali/places/correlator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace rali::places {

using geometry::Vec2;

namespace {

constexpr std::size_t kSidesMax = 512;
constexpr std::size_t kPerYaw = 40;    // peaks kept per yaw
constexpr float kPeakFraction = 0.3F;  // of the best one; less is no peak

/// Farthest mark from the middle, in cells.
std::size_t reach_of(std::span<const Mark> marks, double cell_m) {
  double reach_m = 0.0;
  for (const Mark& m : marks) {
    reach_m = std::max(reach_m, std::hypot(static_cast<double>(m.x_m), static_cast<double>(m.y_m)));
  }
  return std::min(kSidesMax / 2 - 2, static_cast<std::size_t>(reach_m / cell_m) + 1);
}

std::size_t side_for(const Picture& picture, std::size_t reach) {
  const std::size_t cells =
      static_cast<std::size_t>(std::max(picture.nx(), picture.ny())) + 2 * reach + 2;
  std::size_t side = 32;
  while (side < cells && side < kSidesMax) side *= 2;
  return side;
}

double weight_of(std::span<const Mark> marks) {
  double all = 0.0;
  for (const Mark& m : marks) all += static_cast<double>(m.weight);
  return std::max(all, 1e-9);
}

/// Turns marks: f(x, y, weight) in whole cells from the middle.
template <class F>
void for_turned(std::span<const Mark> marks, double cell_m, double yaw_rad, const F& f) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  for (const Mark& m : marks) {
    const double x = static_cast<double>(m.x_m), y = static_cast<double>(m.y_m);
    f(static_cast<int>(std::lround((c * x - s * y) / cell_m)),
      static_cast<int>(std::lround((s * x + c * y) / cell_m)), m.weight);
  }
}

/// Whether value(x, y) is at least that of each of its eight neighbours.
template <class Value>
bool is_peak(const Value& value, int x, int y) {
  const float v = value(x, y);
  for (int k = 0; k < 9; ++k) {
    if (k != 4 && !(value(x + k % 3 - 1, y + k / 3 - 1) <= v)) return false;
  }
  return true;
}

/// The best few, in order.
void append_best(std::vector<Place> found, std::vector<Place>& out) {
  const std::size_t keep = std::min(kPerYaw, found.size());
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(keep), found.end(),
                    [](const Place& a, const Place& b) {
                      if (a.correlation != b.correlation) return a.correlation > b.correlation;
                      return std::make_pair(a.shift_m.x(), a.shift_m.y()) <
                             std::make_pair(b.shift_m.x(), b.shift_m.y());
                    });
  out.insert(out.end(), found.begin(), found.begin() + static_cast<std::ptrdiff_t>(keep));
}

}  // namespace

Correlator::Correlator(const Picture& picture, std::span<const Mark> marks, double cell_m)
    : cell_m_(cell_m),
      marks_(marks),
      reach_(reach_of(marks, cell_m)),
      low_(picture.low_m()),
      fft_(side_for(picture, reach_)),
      mask_(fft_.side() - 1),
      picture_(fft_.side() * fft_.side()),
      work_(fft_.side() * fft_.side()) {
  const double n = static_cast<double>(fft_.side());
  scale_ = 1.0 / (n * n * weight_of(marks));
  for (std::size_t y = 0; y < static_cast<std::size_t>(picture.ny()); ++y) {
    for (std::size_t x = 0; x < static_cast<std::size_t>(picture.nx()); ++x) {
      picture_[(y & mask_) * fft_.side() + (x & mask_)] +=
          picture.cells()[y * static_cast<std::size_t>(picture.nx()) + x];
    }
  }
  fft_.forward(picture_);
}

/// Draws the turned marks around the picture's corner; negative coordinates wrap to its far end.
void Correlator::draw(double yaw_rad, bool imaginary) {
  const int reach = static_cast<int>(reach_);
  for_turned(marks_, cell_m_, yaw_rad, [&](int x, int y, float weight) {
    if (std::abs(x) > reach || std::abs(y) > reach) return;
    Fft2::Complex& cell = work_[(static_cast<std::size_t>(y) & mask_) * fft_.side() +
                                (static_cast<std::size_t>(x) & mask_)];
    cell += imaginary ? Fft2::Complex(0.0F, weight) : Fft2::Complex(weight, 0.0F);
  });
}

void Correlator::peaks(double yaw_rad, bool imaginary, std::vector<Place>& out) const {
  std::vector<Place> found;
  const std::size_t n = fft_.side();
  float best = 0.0F;
  for (std::size_t i = 0; i < work_.size(); ++i) {
    best = std::max(best, imaginary ? work_[i].imag() : work_[i].real());
  }
  const auto at = [&](int x, int y) {
    return value(static_cast<std::size_t>(x), static_cast<std::size_t>(y), imaginary);
  };
  for (int y = 0; y < static_cast<int>(n); ++y) {
    for (int x = 0; x < static_cast<int>(n); ++x) {
      const float v = at(x, y);
      if (v < kPeakFraction * best || !is_peak(at, x, y)) continue;
      const Vec2 cells(cells_of(static_cast<std::size_t>(x)),
                       cells_of(static_cast<std::size_t>(y)));
      found.push_back(
          {yaw_rad, low_ + cell_m_ * Vec2(cells.array() + 0.5), static_cast<double>(v) * scale_});
    }
  }
  append_best(std::move(found), out);
}

void Correlator::correlate(double yaw1_rad, double yaw2_rad, std::vector<Place>& out) {
  std::fill(work_.begin(), work_.end(), Fft2::Complex{});
  draw(yaw1_rad, false);
  draw(yaw2_rad, true);
  fft_.forward(work_);
  // Correlation of A with B1 + i B2 needs conj(F1) + i conj(F2): that of the mirrored picture,
  // whose transform at k is that of the picture at -k.
  const std::size_t n = fft_.side();
  std::vector<Fft2::Complex> product(work_.size());
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const Fft2::Complex f = picture_[y * n + x];
      const Fft2::Complex g = work_[((n - y) & mask_) * n + ((n - x) & mask_)];
      product[y * n + x] = {f.real() * g.real() - f.imag() * g.imag(),
                            f.real() * g.imag() + f.imag() * g.real()};
    }
  }
  work_.swap(product);
  fft_.back(work_);
  peaks(yaw1_rad, false, out);
  peaks(yaw2_rad, true, out);
}

double ShiftWindow::count(double cell_m) const {
  const Vec2 sides = (high_m - low_m) / cell_m;
  return (sides.x() + 1.0) * (sides.y() + 1.0);
}

namespace {

/// Correlation sums of a window of whole-cell shifts, with a margin of one cell around it.
class WindowSums {
 public:
  WindowSums(const Picture& picture, double cell_m, const ShiftWindow& window);

  /// A mark at this offset from the middle [cells].
  void add(int mark_x, int mark_y, float weight);

  [[nodiscard]] std::vector<Place> peaks(double yaw_rad, double scale) const;

 private:
  [[nodiscard]] float at(int x, int y) const {
    return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx_) +
                 static_cast<std::size_t>(x)];
  }

  const Picture& picture_;
  double cell_m_;
  int x0_, y0_;  ///< shift of the first one: the cell of the picture that the middle lies on
  int nx_, ny_;
  std::vector<float> sums_;
};

WindowSums::WindowSums(const Picture& picture, double cell_m, const ShiftWindow& window)
    : picture_(picture), cell_m_(cell_m) {
  const auto cell = [&](const Vec2& shift_m, int axis) {
    return static_cast<int>(std::floor((shift_m[axis] - picture.low_m()[axis]) / cell_m));
  };
  x0_ = cell(window.low_m, 0) - 1;
  y0_ = cell(window.low_m, 1) - 1;
  nx_ = cell(window.high_m, 0) + 2 - x0_;
  ny_ = cell(window.high_m, 1) + 2 - y0_;
  sums_.assign(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_), 0.0F);
}

void WindowSums::add(int mark_x, int mark_y, float weight) {
  const int px = x0_ + mark_x, py = y0_ + mark_y;  // in the picture, at the first shift
  const int first = std::max(0, -px), last = std::min(nx_, picture_.nx() - px);
  const int top = std::max(0, -py), bottom = std::min(ny_, picture_.ny() - py);
  for (int y = top; y < bottom; ++y) {
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(py + y) * picture_.nx() + px;
    float* sums = sums_.data() + static_cast<std::ptrdiff_t>(y) * nx_;
    for (int x = first; x < last; ++x) {
      sums[x] += weight * picture_.cells()[static_cast<std::size_t>(row + x)];
    }
  }
}

std::vector<Place> WindowSums::peaks(double yaw_rad, double scale) const {
  std::vector<Place> found;
  const float best = *std::max_element(sums_.begin(), sums_.end());
  if (!(best > 0.0F)) return found;
  const auto value = [this](int x, int y) { return at(x, y); };
  for (int y = 1; y + 1 < ny_; ++y) {
    for (int x = 1; x + 1 < nx_; ++x) {
      if (at(x, y) < kPeakFraction * best || !is_peak(value, x, y)) continue;
      const Vec2 shift_m = picture_.low_m() + cell_m_ * Vec2(x0_ + x + 0.5, y0_ + y + 0.5);
      found.push_back({yaw_rad, shift_m, static_cast<double>(at(x, y)) * scale});
    }
  }
  return found;
}

}  // namespace

void correlate_within(const Picture& picture, std::span<const Mark> marks, double cell_m,
                      double yaw_rad, const ShiftWindow& window, std::vector<Place>& out) {
  WindowSums sums(picture, cell_m, window);
  for_turned(marks, cell_m, yaw_rad, [&](int x, int y, float weight) { sums.add(x, y, weight); });
  append_best(sums.peaks(yaw_rad, 1.0 / weight_of(marks)), out);
}

}  // namespace rali::places
