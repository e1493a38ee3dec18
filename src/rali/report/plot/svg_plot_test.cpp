#include "rali/report/plot/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "rali/report/plot/axis.hpp"

namespace rali::report {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Plot plot_of(std::vector<double> x, std::vector<double> y) {
  Plot plot;
  plot.series.push_back({"a", std::move(x), std::move(y), style_of(0)});
  return plot;
}

TEST(Ticks, are_round_numbers_within_the_range) {
  Range range;
  range.add(-0.3);
  range.add(9.7);
  EXPECT_EQ(tick_step(10.0, 5), 2.0);
  EXPECT_EQ(ticks_of(range, 5), (std::vector<double>{0.0, 2.0, 4.0, 6.0, 8.0}));
  EXPECT_EQ(tick_text(0.30000000000000004, 0.1), "0.3");
  EXPECT_EQ(tick_text(2000.0, 500.0), "2000");
}

TEST(Ticks, are_few_for_any_range) {
  for (const double width : {0.0, 1e-12, 1.0, 1e15, 1e300, kNaN}) {
    Range range;
    range.add(1.0);
    range.add(1.0 + width);
    EXPECT_LE(ticks_of(range, 8).size(), 37U) << width;
  }
}

TEST(Range, takes_no_value_that_is_none) {
  Range range;
  range.add(kNaN);
  range.add(std::numeric_limits<double>::infinity());
  EXPECT_TRUE(range.empty());
  range.add(2.0);
  EXPECT_EQ(range.low(), 2.0);
  EXPECT_EQ(range.high(), 2.0);
  EXPECT_GT(range.widened(0.1, 1.0).width(), 0.9);
}

TEST(Outline, keeps_single_peaks_and_gaps) {
  std::vector<double> values(100'000, 0.0);
  values[12'345] = 9.0;
  values[54'321] = -9.0;
  values[70'000] = kNaN;
  const std::vector<std::size_t> kept = outline(values, 700);
  EXPECT_LT(kept.size(), 2200U);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  for (const std::size_t i : {12'345U, 54'321U, 70'000U}) {
    EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), i)) << i;
  }
}

TEST(Plot, without_a_finite_value_is_nothing) {
  EXPECT_EQ(svg_of(Plot{}), "");
  EXPECT_EQ(svg_of(plot_of({0.0, 1.0}, {kNaN, kNaN})), "");
  Plot log = plot_of({0.0, 1.0}, {0.0, -1.0});
  log.log_y = true;
  EXPECT_EQ(svg_of(log), "");
}

TEST(Plot, breaks_its_line_where_a_value_is_missing) {
  const std::string svg = svg_of(plot_of({0, 1, 2, 3, 4}, {1, 2, kNaN, 2, 1}));
  const std::size_t begin = svg.find(" d=\"M", svg.find("class=\"s\""));
  const std::string path = svg.substr(begin, svg.find('"', begin + 4) - begin);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 2);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'L'), 2);
}

TEST(Plot, of_one_value_and_of_huge_values_is_finite) {
  for (const std::string& svg :
       {svg_of(plot_of({5.0}, {3.0})), svg_of(plot_of({0.0, 1e300}, {-1e300, 1e300})),
        svg_of(plot_of({0.0, 1.0}, {1e-300, 2e-300}))}) {
    EXPECT_NE(svg, "");
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
  }
}

TEST(Styles, of_ten_things_differ_in_colour_and_dashes_together) {
  for (std::size_t a = 0; a < 20; ++a) {
    for (std::size_t b = a + 1; b < 20; ++b) {
      const bool same =
          style_of(a).colour == style_of(b).colour && style_of(a).dash == style_of(b).dash;
      EXPECT_FALSE(same) << a << " and " << b;
    }
  }
}

TEST(ScaleColours, grow_lighter_evenly_so_that_grey_paper_shows_them) {
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

TEST(Plot, tells_series_of_dots_apart_by_their_shape) {
  Plot plot = plot_of({0.0, 10.0}, {1.0, 2.0});
  plot.series[0].dots = true;
  const std::string dots = svg_of(plot);
  plot.series[0].marker = Marker::kCross;
  const std::string crosses = svg_of(plot);
  EXPECT_EQ(dots.find("class=\"s shape\""), std::string::npos);
  EXPECT_NE(crosses.find("class=\"s shape\""), std::string::npos);
  EXPECT_NE(crosses.find("h0m-2.8-2.8"), std::string::npos);
}

TEST(Plot, shows_what_has_no_value_in_a_rail_and_names_it_once) {
  Plot plot = plot_of({0.0, 10.0}, {1.0, 2.0});
  plot.series[0].dots = true;
  Series bare = plot.series[0];
  bare.y.clear();
  bare.x = {5.0, kNaN, 99.0};  // the last lies outside of the axis
  bare.on_rail = true;
  plot.series.push_back(bare);
  plot.rail_label = "no residual";
  const std::string svg = svg_of(plot);
  const std::size_t rail = svg.find("class=\"on-rail\"");
  ASSERT_NE(rail, std::string::npos);
  const std::string path = svg.substr(rail, svg.find('>', rail) - rail);
  EXPECT_EQ(std::count(path.begin(), path.end(), 'M'), 1);
  EXPECT_EQ(svg.find(">a</text>"), svg.rfind(">a</text>"));
}

}  // namespace
}  // namespace rali::report
