#include "rali/report/data/columns.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace rali::report {
namespace {

/// Ten poses per second along x at 1 m/s; a degeneracy row for each.
VehicleView drive(int poses) {
  VehicleView v;
  for (int i = 0; i < poses; ++i) {
    v.path.push_back({0.1 * i, {0.1 * i, 0.0, 0.0}});
    DegeneracyPoint d;
    d.t_s = 0.1 * i;
    d.off_m = 0.02;
    v.degeneracy.push_back(d);
  }
  return v;
}

const std::vector<float>& column(const Columns& columns, std::string_view name) {
  static const std::vector<float> kAbsent;
  for (const Column& c : columns.list) {
    if (c.name == name) return c.values;
  }
  return kAbsent;
}

TEST(Columns, join_rows_of_different_files_by_stamp) {
  VehicleView v = drive(30);
  v.sigmas.push_back({1.0, 0.25, {}});
  v.sigmas.push_back({1.05, 0.75, {}});  // of no pose
  const Columns columns = columns_of(v);
  ASSERT_EQ(columns.rows(), 30U);
  EXPECT_EQ(column(columns, "sigma")[10], 0.25F);
  EXPECT_TRUE(std::isnan(column(columns, "sigma")[11]));
  EXPECT_NEAR(column(columns, "speed")[15], 1.0F, 1e-5F);
  EXPECT_NEAR(column(columns, "distance")[20], 2.0F, 1e-5F);
  EXPECT_TRUE(column(columns, "ape").empty()) << "what no row has is left out";
}

TEST(Columns, keep_peaks_and_single_bad_scans_when_thinned) {
  VehicleView v = drive(100'000);
  v.path[54'321].p_m.z() = 1.0;
  v.degeneracy[12'345].off_m = 7.0;
  v.degeneracy[12'345].held_by = HeldBy::kNothing;
  v.degeneracy[12'345].sight = Sight::kNone;
  v.degeneracy[12'345].degenerate = true;
  Columns columns = columns_of(v);
  thin(columns, 2000);
  ASSERT_LE(columns.rows(), 2000U);
  for (const Column& c : columns.list) EXPECT_EQ(c.values.size(), columns.rows()) << c.name;
  const std::vector<float>& off = column(columns, "off");
  EXPECT_EQ(*std::max_element(off.begin(), off.end()), 7.0F);
  const auto bad = std::count(columns.state.begin(), columns.state.end(), 3 | 2 << 2 | 16);
  EXPECT_EQ(bad, 2) << "both rows of its stretch";
  const std::vector<float>& t = column(columns, "t");
  EXPECT_TRUE(std::is_sorted(t.begin(), t.end()));
}

TEST(Columns, mark_standstill) {
  VehicleView v = drive(60);
  for (std::size_t i = 30; i < 60; ++i) v.path[i].p_m = v.path[29].p_m;
  const Columns columns = columns_of(v);
  EXPECT_EQ(columns.state[10] & kStandsBit, 0);
  EXPECT_EQ(columns.state[50] & kStandsBit, kStandsBit);
}

TEST(Columns, clamp_the_error_to_sigma_ratio_at_100) {
  VehicleView v = drive(3);
  ErrorPoint e;
  e.t_s = 0.1;
  e.nees = 6e10;
  v.errors.push_back(e);
  EXPECT_EQ(column(columns_of(v), "ratio")[1], 100.0F);
}

TEST(Columns, of_an_empty_vehicle_are_empty) { EXPECT_EQ(columns_of(VehicleView{}).rows(), 0U); }

}  // namespace
}  // namespace rali::report
