#include "rali/report/internal/colours.hpp"

#include <gtest/gtest.h>

namespace rali::report {
namespace {

TEST(Styles, of_20_curves_differ_in_colour_or_dashes) {
  for (std::size_t a = 0; a < 20; ++a) {
    for (std::size_t b = a + 1; b < 20; ++b) {
      const bool same =
          style_of(a).colour == style_of(b).colour && style_of(a).dash == style_of(b).dash;
      EXPECT_FALSE(same) << a << " and " << b;
    }
  }
}

TEST(ScaleColours, increase_monotonically_in_luminance) {
  double before = -1.0;
  for (int i = 0; i <= 20; ++i) {
    const Rgb c = scale_colour(i / 20.0, false);
    const double light = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    EXPECT_GT(light, before) << i;
    before = light;
    EXPECT_EQ(scale_colour(1.0 - i / 20.0, true), c);
  }
  EXPECT_LT(before, 200.0) << "seen on white";
}

}  // namespace
}  // namespace rali::report
