#pragma once

#include <span>
#include <vector>

#include "rali/places/submap.hpp"

namespace rali::places {

/// Height band above the ground that makes the image of a place from above.
struct BandSettings {
  double low_m = 0.2;
  double high_m = 2.0;
  double range_m = 25.0;  ///< horizontally, from the middle

  template <class V>
  void visit(V& v) {
    v("low_m", low_m, -5.0, 20.0, "points from so far above the ground");
    v("high_m", high_m, -4.0, 50.0, "points up to so far above the ground");
    v("range_m", range_m, 2.0, 100.0, "points so far from the middle");
  }
};

/// An occupied cell of the picture.
struct Mark {
  float x_m = 0.0F, y_m = 0.0F;  ///< its centre, in ref
  float weight = 0.0F;           ///< in (0, 1]
};

/// Cells of the height band with points, in order of (y, x). The weight grows with the number of
/// points up to 1, so that dense near cells do not outweigh far ones.
[[nodiscard]] std::vector<Mark> marks_of(const Submap& submap, double cell_m,
                                         const BandSettings& band);

/// A picture to look marks up in: each mark is spread over its neighbours, so that an error of one
/// cell matters little.
class Picture {
 public:
  Picture(std::span<const Mark> marks, double cell_m);

  /// 0 outside.
  [[nodiscard]] float at(double x_m, double y_m) const {
    const double x = (x_m - low_.x()) * inverse_;
    const double y = (y_m - low_.y()) * inverse_;
    if (!(x >= 0.0) || !(y >= 0.0) || x >= nx_ || y >= ny_) return 0.0F;
    return cells_[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx_) +
                  static_cast<std::size_t>(x)];
  }

  [[nodiscard]] int nx() const { return nx_; }

  [[nodiscard]] int ny() const { return ny_; }

  [[nodiscard]] const geometry::Vec2& low_m() const { return low_; }

  [[nodiscard]] std::span<const float> cells() const { return cells_; }

 private:
  geometry::Vec2 low_ = geometry::Vec2::Zero();
  double inverse_ = 1.0;
  int nx_ = 0, ny_ = 0;
  std::vector<float> cells_;
};

/// Fraction of the marks' weight on marks of the picture when turned by `yaw_rad` and shifted.
[[nodiscard]] double correlation(const Picture& picture, std::span<const Mark> marks,
                                 double yaw_rad, const geometry::Vec2& shift_m);

}  // namespace rali::places
