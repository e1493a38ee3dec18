#include "rali/degeneracy/paper_degree.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::degeneracy {
namespace {

using geometry::Vec3;

const Vec3 kUp = Vec3::UnitZ();

/// The paper's rule as printed.
const PaperDegreeSettings kPrinted = PaperDegreeSettings{}.resolved(true);

void repeat(std::vector<Vec3>& out, int times, const Vec3& n) {
  out.insert(out.end(), static_cast<std::size_t>(times), n);
}

// Test T7 of the design. `minus_y` is the normal of the second wall.
std::vector<Vec3> corridor(const Vec3& minus_y = -Vec3::UnitY()) {
  std::vector<Vec3> out;
  repeat(out, 40, Vec3::UnitY());
  repeat(out, 40, minus_y);
  repeat(out, 16, Vec3::UnitZ());
  repeat(out, 2, Vec3::UnitX());
  repeat(out, 2, -Vec3::UnitX());
  return out;
}

double angle_to_axis(const Vec3& a, const Vec3& b) {
  return std::acos(std::min(1.0, std::abs(a.normalized().dot(b.normalized()))));
}

TEST(PaperDegree, of_a_corridor_worked_by_hand_is_3_36_along_x) {
  const PaperDegree d = paper_degree(corridor(), kUp, kPrinted);
  EXPECT_TRUE(d.known);
  EXPECT_EQ(d.normals, 100);
  EXPECT_NEAR(d.degree, 0.1344 / 0.04, 1e-12);
  EXPECT_FALSE(d.degenerate);
  EXPECT_LT(angle_to_axis(d.e3_body, Vec3::UnitX()), 1e-9);
  EXPECT_TRUE(d.direction_known);
  EXPECT_LT(angle_to_axis(d.direction_body, Vec3::UnitX()), 1e-9);
}

TEST(PaperDegree, from_second_moments_is_4_for_any_sign_of_the_normals) {
  PaperDegreeSettings free = kPrinted;
  free.normal_sign = NormalSign::kFree;
  EXPECT_NEAR(paper_degree(corridor(), kUp, free).degree, 4.0, 1e-12);
  EXPECT_NEAR(paper_degree(corridor(Vec3::UnitY()), kUp, free).degree, 4.0, 1e-12);
}

TEST(PaperDegree, changes_when_the_normals_of_one_wall_are_flipped) {
  const PaperDegree d = paper_degree(corridor(Vec3::UnitY()), kUp, kPrinted);
  EXPECT_NEAR(d.degree, 0.04 / 0.018562, 2e-4);
  EXPECT_TRUE(d.degenerate);
  EXPECT_LT(angle_to_axis(d.e3_body, Vec3(0.0, 0.671, 0.741)), 1e-3);
  // Projected on the horizontal plane it becomes the wall's normal: the best observable direction.
  EXPECT_TRUE(d.direction_known);
  EXPECT_LT(angle_to_axis(d.direction_body, Vec3::UnitY()), 1e-9);
}

TEST(PaperDegree, uses_the_configured_eigenvalue_ratio) {
  PaperDegreeSettings s = kPrinted;
  s.deg_ratio = DegreeRatio::kL1L3;
  EXPECT_NEAR(paper_degree(corridor(), kUp, s).degree, 20.0, 1e-12);
  s.deg_ratio = DegreeRatio::kL1L2;
  EXPECT_NEAR(paper_degree(corridor(), kUp, s).degree, 0.80 / 0.1344, 1e-12);
}

TEST(PaperDegree, is_degenerate_above_the_upper_threshold_when_one_is_set) {
  PaperDegreeSettings s = kPrinted;
  s.deg_below = 0.0;
  s.deg_above = 3.0;
  EXPECT_TRUE(paper_degree(corridor(), kUp, s).degenerate);
  s.deg_above = 3.5;
  EXPECT_FALSE(paper_degree(corridor(), kUp, s).degenerate);
}

TEST(PaperDegree, of_the_horizontal_block_does_not_depend_on_ground_normals) {
  // T7 without and with ground: 0.80/0.04 = 20 along y and x, independent of the vertical.
  PaperDegreeSettings s;
  s.deg_above = 15.0;
  const PaperDegree d = paper_degree(corridor(), kUp, s);
  EXPECT_NEAR(d.degree, 20.0, 1e-12);
  EXPECT_TRUE(d.degenerate);
  ASSERT_TRUE(d.direction_known);
  EXPECT_LT(angle_to_axis(d.direction_body, Vec3::UnitX()), 1e-9);
  // A closed room whose ground is out of view: the vertical is the weakest direction, but the room
  // is not degenerate.
  std::vector<Vec3> room;
  repeat(room, 50, Vec3::UnitX());
  repeat(room, 50, -Vec3::UnitX());
  repeat(room, 50, Vec3::UnitY());
  repeat(room, 50, -Vec3::UnitY());
  const PaperDegree seen = paper_degree(room, kUp, s);
  EXPECT_NEAR(seen.degree, 1.0, 1e-12);
  EXPECT_FALSE(seen.degenerate);
  // Without an up vector there is no horizontal block.
  EXPECT_FALSE(paper_degree(room, Vec3::Zero(), s).known);
}

TEST(PaperDegree, refuses_a_direction_that_is_nearly_vertical) {
  std::vector<Vec3> room;
  repeat(room, 50, Vec3::UnitX());
  repeat(room, 50, -Vec3::UnitX());
  repeat(room, 40, Vec3::UnitY());
  repeat(room, 40, -Vec3::UnitY());
  repeat(room, 2, Vec3::UnitZ());
  const PaperDegree d = paper_degree(room, kUp, kPrinted);
  EXPECT_LT(angle_to_axis(d.e3_body, Vec3::UnitZ()), 1e-9);
  EXPECT_FALSE(d.direction_known);
  PaperDegreeSettings s = kPrinted;
  s.deg_direction = DegreeDirection::kMinHorizontal;
  const PaperDegree flat = paper_degree(room, kUp, s);
  EXPECT_TRUE(flat.direction_known);
  EXPECT_LT(angle_to_axis(flat.direction_body, Vec3::UnitY()), 1e-9);
  s.deg_direction = DegreeDirection::kE3;
  EXPECT_LT(angle_to_axis(paper_degree(room, kUp, s).direction_body, Vec3::UnitZ()), 1e-9);
}

TEST(PaperDegree, is_unknown_and_degenerate_with_too_few_normals) {
  std::vector<Vec3> few(49, Vec3::UnitX());
  const PaperDegree d = paper_degree(few, kUp, kPrinted);
  EXPECT_FALSE(d.known);
  EXPECT_TRUE(d.degenerate);
  EXPECT_FALSE(d.direction_known);
  EXPECT_EQ(d.normals, 49);
  PaperDegreeSettings any = kPrinted;
  any.deg_min_normals = 0;
  EXPECT_TRUE(paper_degree(few, kUp, any).known);
  EXPECT_FALSE(paper_degree({}, kUp, any).known);
  EXPECT_TRUE(paper_degree({}, kUp, any).degenerate);
}

TEST(PaperDegree, of_a_single_plane_is_never_nan) {
  const std::vector<Vec3> plane(80, Vec3(0.6, 0.8, 0.0));
  for (const auto sign : {NormalSign::kGiven, NormalSign::kFree}) {
    for (const auto which : {DegreeRatio::kL2L3, DegreeRatio::kL1L3, DegreeRatio::kL1L2}) {
      PaperDegreeSettings s = kPrinted;
      s.normal_sign = sign;
      s.deg_ratio = which;
      EXPECT_FALSE(std::isnan(paper_degree(plane, kUp, s).degree));
    }
  }
}

TEST(PaperDegree, leaves_out_normals_that_are_not_numbers) {
  auto normals = corridor();
  normals.push_back(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  const PaperDegree d = paper_degree(normals, kUp, kPrinted);
  EXPECT_EQ(d.normals, 100);
  EXPECT_NEAR(d.degree, 3.36, 1e-12);
}

TEST(PaperDegree, has_no_horizontal_direction_without_an_up_vector) {
  EXPECT_FALSE(paper_degree(corridor(), Vec3::Zero(), kPrinted).direction_known);
  const Vec3 nan = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(paper_degree(corridor(), nan, kPrinted).direction_known);
}

TEST(PaperDegree, is_invariant_and_its_direction_rotates_with_the_body) {
  Rng rng(11);
  for (const auto which :
       {DegreeDirection::kE3Xy, DegreeDirection::kE3, DegreeDirection::kMinHorizontal}) {
    PaperDegreeSettings s = kPrinted;
    s.deg_direction = which;
    const PaperDegree before = paper_degree(corridor(), kUp, s);
    for (int trial = 0; trial < 10; ++trial) {
      const geometry::Mat3 R =
          geometry::so3_exp(2.0 * Vec3(rng.normal(), rng.normal(), rng.normal()));
      auto turned = corridor();
      for (Vec3& n : turned) n = R * n;
      const PaperDegree after = paper_degree(turned, R * kUp, s);
      EXPECT_NEAR(after.degree, before.degree, 1e-9);
      EXPECT_LT(angle_to_axis(after.direction_body, R * before.direction_body), 1e-6);
    }
  }
}

}  // namespace
}  // namespace rali::degeneracy
