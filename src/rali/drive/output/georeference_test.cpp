#include "rali/drive/output/georeference.hpp"

#include <gtest/gtest.h>

#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

using geometry::Vec3;

const io::RadioNames kNames = {{"v1", {VehicleId{0}, 0}}, {"v2", {VehicleId{1}, 0}}};

std::vector<MarkPair> pairs_of(const SiteFrame& truth) {
  std::vector<MarkPair> pairs;
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(40, 5, 0.3), Vec3(20, -15, -0.2), Vec3(5, 30, 0)}) {
    pairs.push_back({"v1", Time::from_s(1.0), p, truth.site_of(p), 0.02});
  }
  return pairs;
}

// Coordinates of a national grid: their 4000 km must not cost millimetres.
TEST(Georeference, finds_yaw_and_translation_of_a_site) {
  SiteFrame truth;
  truth.yaw_rad = 2.1;
  truth.p_site_map_m = Vec3(691607.25, 5335806.5, 515.125);
  const auto site = solve_site(pairs_of(truth));
  ASSERT_TRUE(site) << site.error().message();
  EXPECT_NEAR(site->yaw_rad, 2.1, 1e-9);
  EXPECT_LT((site->p_site_map_m - truth.p_site_map_m).norm(), 1e-6);
  EXPECT_LT(site->rms_m, 1e-6);
  EXPECT_NEAR(site->yaw_sigma_rad, 0.02 / 50.0, 2e-4);
}

TEST(Georeference, a_wrong_mark_has_the_largest_residual) {
  SiteFrame truth;
  auto pairs = pairs_of(truth);
  pairs[2].p_site_m.z() += 1.0;
  const auto site = solve_site(pairs);
  ASSERT_TRUE(site);
  EXPECT_NEAR(site->residuals[2].residual_site_m.z(), -0.75, 1e-6);
  EXPECT_NEAR(site->residuals[0].residual_site_m.z(), 0.25, 1e-6);
}

TEST(Georeference, weights_marks_by_their_sigma) {
  SiteFrame truth;
  auto pairs = pairs_of(truth);
  pairs[2].p_site_m.z() += 1.0;
  pairs[2].sigma_m = 20.0;
  const auto site = solve_site(pairs);
  ASSERT_TRUE(site);
  EXPECT_NEAR(site->residuals[0].residual_site_m.z(), 0.0, 1e-4);
}

TEST(Georeference, refuses_marks_too_close_together_for_a_heading) {
  std::vector<MarkPair> pairs;
  for (int i = 0; i < 3; ++i) {
    const Vec3 p(0.1 * i, 0.0, 0.0);
    pairs.push_back({"v1", Time::from_s(i), p, p, 0.05});
  }
  const auto site = solve_site(pairs);
  ASSERT_FALSE(site);
  EXPECT_NE(site.error().what.find("too close together"), std::string::npos);
  EXPECT_FALSE(solve_site(std::span(pairs).first(2)));
}

TEST(Georeference, reports_errors_in_marks_with_file_and_line) {
  const io::TestFolder folder;
  const std::string header = "vehicle,stamp_s,x_m,y_m,z_m,sigma_m\n";
  const std::string rows = "v1,10,691607.25,5335806.5,515,0.02\nv2,11.5,1,2,3,0.05\n";
  const auto marks =
      read_marks_csv(folder.write("a.csv", header + rows + "v1,12,1,1,1,0.1\n"), kNames);
  ASSERT_TRUE(marks) << marks.error().message();
  EXPECT_EQ((*marks)[1].vehicle, VehicleId{1});
  EXPECT_EQ((*marks)[1].t, Time::from_s(11.5));
  EXPECT_EQ((*marks)[0].p_site_m.y(), 5335806.5);
  const auto error_of = [&](const std::string& text) {
    const auto refused = read_marks_csv(folder.write("b.csv", text), kNames);
    return refused ? std::string("none") : refused.error().message();
  };
  EXPECT_NE(error_of(header + rows).find("has 2 marks; a georeference needs 3"), std::string::npos);
  EXPECT_NE(error_of(header + "v7,10,1,1,1,0.1\n").find("b.csv:2: 'v7' is no vehicle"),
            std::string::npos);
  EXPECT_NE(error_of(header + "v1,10,1,1,1,0\n").find("sigma_m"), std::string::npos);
}

}  // namespace
}  // namespace rali::drive
