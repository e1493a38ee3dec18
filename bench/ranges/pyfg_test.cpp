#include "pyfg.hpp"

#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "number_rows.hpp"

namespace rali::ranges_bench {
namespace {

const std::string kPlanar =
    "VERTEX_SE2 0.0 A0 0 0 0\n"
    "VERTEX_SE2 1.5 A1 1 2 1.5707963267948966\n"
    "VERTEX_XY L0 3 4\n"
    "EDGE_SE2 1.5 A0 A1 1 2 1.5707963267948966 0.01 0.001 0 0.02 0 0.0004\n"
    "EDGE_SE2_XY 0.0 A0 L0 1 2 1 0 1\n"
    "EDGE_RANGE 0.1 A0 L0 5 0.25\n";

std::string error_of(const std::string& text) {
  const auto file = parse_pyfg(text, "f");
  return file ? "" : file.error().message();
}

TEST(Pyfg, planar_lines_are_lifted_with_covariance_in_our_order) {
  const auto file = parse_pyfg(kPlanar, "f");
  ASSERT_TRUE(file);
  EXPECT_TRUE(file->planar);
  EXPECT_EQ(file->left_out, 1u);
  ASSERT_EQ(file->poses.size(), 2u);
  EXPECT_EQ(file->poses.at({'A', 1}).t.ns, 1500000000);
  EXPECT_TRUE(file->poses.at({'A', 1}).T.R.col(0).isApprox(geometry::Vec3::UnitY()));
  EXPECT_EQ(file->landmarks_m.at({'L', 0}), geometry::Vec3(3.0, 4.0, 0.0));
  const geometry::Mat6& C = file->steps.at(0).covariance;
  EXPECT_DOUBLE_EQ(C(2, 2), 0.0004);  // yaw
  EXPECT_DOUBLE_EQ(C(3, 3), 0.01);    // x
  EXPECT_DOUBLE_EQ(C(3, 4), 0.001);   // x with y
  EXPECT_DOUBLE_EQ(C(4, 4), 0.02);    // y
  EXPECT_DOUBLE_EQ(C(0, 0), kPlanarSigma * kPlanarSigma);
  EXPECT_DOUBLE_EQ(file->ranges.at(0).range_m, 5.0);
  EXPECT_DOUBLE_EQ(file->ranges.at(0).variance_m2, 0.25);
}

TEST(Pyfg, spatial_covariance_has_its_halves_exchanged) {
  std::string step = "EDGE_SE3:QUAT 1 B3 B4 1 2 3 0 0 0 1";
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) step += r == c ? " " + std::to_string(r + 1) : " 0";
  }
  const auto file = parse_pyfg(
      "VERTEX_SE3:QUAT 0 B3 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 B4 0 0 0 0 0 0.6 0.8\n" + step, "f");
  ASSERT_TRUE(file) << file.error().message();
  EXPECT_FALSE(file->planar);
  const geometry::Mat6& C = file->steps.at(0).covariance;
  EXPECT_DOUBLE_EQ(C(3, 3), 1.0);  // x
  EXPECT_DOUBLE_EQ(C(5, 5), 3.0);  // z
  EXPECT_DOUBLE_EQ(C(0, 0), 4.0);  // about x
  EXPECT_NEAR(file->poses.at({'B', 4}).T.R(1, 0), 0.96, 1e-12);
}

TEST(Pyfg, damaged_lines_are_refused_with_their_place) {
  EXPECT_NE(error_of("VERTEX_SE2 0 A0 0 0\n").find("f:1: VERTEX_SE2 has 5 words"),
            std::string::npos);
  EXPECT_NE(error_of("\nVERTEX_SE2 0 A0 0 nan 0\n").find("f:2: \"nan\""), std::string::npos);
  EXPECT_NE(error_of("VERTEX_SE2 0 A0 0 1x 0\n").find("1x"), std::string::npos);
  EXPECT_NE(error_of("VERTEX_SE2 0 7 0 0 0\n").find("\"7\" is no name"), std::string::npos);
  EXPECT_NE(error_of("VERTEX_SE2 0 A99999999999 0 0 0\n").find("no name"), std::string::npos);
  EXPECT_NE(error_of("VERTEX_SE3:QUAT 0 A0 0 0 0 0 0 0 0\n").find("quaternion"), std::string::npos);
  EXPECT_NE(error_of(kPlanar + "VERTEX_SE2 0 A0 0 0 0\n").find("twice"), std::string::npos);
  EXPECT_NE(error_of(kPlanar + "VERTEX_XYZ L1 0 0 0\n").find("mixed"), std::string::npos);
  EXPECT_NE(error_of(kPlanar + "EDGE_RANGE 0 A0 L9 5 1\n").find("not there"), std::string::npos);
  EXPECT_NE(error_of(kPlanar + "EDGE_RANGE 0 A0 L0 5 0\n").find("variance"), std::string::npos);
  EXPECT_NE(error_of(kPlanar + "EDGE_SE2 0 A0 A1 0 0 0 -1 0 0 1 0 1\n").find("covariance"),
            std::string::npos);
  EXPECT_NE(error_of("").find("no pose"), std::string::npos);
}

// A reader that crashes on a truncated file would end the whole benchmark.
TEST(Pyfg, truncated_at_every_byte_it_answers) {
  for (std::size_t n = 0; n < kPlanar.size(); ++n) {
    const auto file = parse_pyfg(kPlanar.substr(0, n), "f");
    if (!file) {
      EXPECT_FALSE(file.error().what.empty());
    }
  }
  const std::string bytes("\0\xff\xfe VERTEX_SE2 \x80\n\r\n \t\n", 22);
  EXPECT_FALSE(parse_pyfg(bytes, "f"));
}

TEST(NumberRows, numbers_words_and_empty_cells_are_told_apart) {
  EXPECT_DOUBLE_EQ(number_of(" 6.5e-004 "), 6.5e-4);
  EXPECT_DOUBLE_EQ(number_of("+2"), 2.0);
  EXPECT_EQ(number_of("-inf"), -std::numeric_limits<double>::infinity());
  for (const char* word : {"", " ", "1 2", "x", "1,5"}) EXPECT_NE(number_of(word), number_of(word));
  EXPECT_EQ(split("a,,b", ',').size(), 3u);
  EXPECT_EQ(split("  a \t b  ", ' ').size(), 2u);
}

}  // namespace
}  // namespace rali::ranges_bench
