#include "rali/fleet/facts/rounding.hpp"

#include <cmath>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"
#include "rali/geometry/so3.hpp"

namespace rali::fleet {
namespace {

using geometry::Mat3;
using geometry::Mat6;
using geometry::Vec3;

Mat3 random_rotation(Rng& rng) {
  return geometry::so3_exp(Vec3(rng.normal(), rng.normal(), rng.normal()));
}

TEST(Rounding, a_quarter_turn_about_z_has_the_hand_computed_quaternion_code) {
  const RotationCode code = rotation_code(geometry::rotation_from_rpy(0.0, 0.0, M_PI / 2), 15);
  // q = (0.70711, 0, 0, 0.70711): of equal parts the first is omitted; 0.70711 * 32768 = 23170.5.
  EXPECT_EQ(code.largest == 0 ? code.parts[2] : code.parts[0], 23170);
}

TEST(Rounding, a_decoded_rotation_differs_by_less_than_the_quantisation_steps) {
  Rng rng(1);
  for (int k = 0; k < 2000; ++k) {
    const Mat3 R = random_rotation(rng);
    for (const int bits : {15, 18, 31}) {
      const Mat3 back = rotation_of(rotation_code(R, bits), bits);
      EXPECT_LT(geometry::so3_log(back.transpose() * R).norm(), 4.0 * std::ldexp(1.0, -bits));
    }
  }
}

TEST(Rounding, re_encoding_a_decoded_rotation_gives_the_same_code_even_at_ties) {
  Rng rng(2);
  for (int k = 0; k < 3000; ++k) {
    Mat3 R = random_rotation(rng);
    // Exact and nearly exact quarter turns about axes: two or four parts are equal in size.
    if (k % 2 == 0) {
      const auto turn = [&rng] { return M_PI / 2 * static_cast<double>(rng.below(4)); };
      R = geometry::rotation_from_rpy(turn(), turn(), turn());
      if (k % 4 == 0) R = R * geometry::so3_exp(1e-9 * Vec3(rng.normal(), rng.normal(), 1.0));
    }
    for (const int bits : {15, 18, 31}) {
      const RotationCode code = rotation_code(R, bits);
      EXPECT_EQ(rotation_code(rotation_of(code, bits), bits), code);
    }
  }
}

TEST(Rounding, a_covariance_keeps_variances_and_correlation) {
  Mat6 covariance = Mat6::Identity();
  covariance(0, 0) = 4.0;
  covariance(3, 3) = 1e-10;
  covariance(0, 3) = covariance(3, 0) = 0.5 * 2.0 * 1e-5;
  const CovarianceCode<6> code = covariance_code<6>(covariance);
  EXPECT_FLOAT_EQ(code.sigma[0], 2.0F);
  EXPECT_EQ(code.correlation[3], 4194304);  // (3, 0) is the fourth; 0.5 * 8388607, rounded
  const Mat6 back = covariance_of<6>(code);
  EXPECT_NEAR(back(0, 3) / covariance(0, 3), 1.0, 1e-6);
  EXPECT_NEAR(back(3, 3) / 1e-10, 1.0, 1e-6);
  EXPECT_EQ(back, covariance_of<6>(covariance_code<6>(back)));
}

TEST(Rounding, a_covariance_stays_positive_close_to_full_correlation) {
  // Variances 1e6 and 1e-6 with correlation 1 - 1e-6: the determinant of the two is 2e-6, which a
  // step of 1.2e-7 of the correlation changes by 2.4e-7 at most.
  SquareMatrix<9> covariance = SquareMatrix<9>::Identity();
  covariance(0, 0) = 1e6;
  covariance(1, 1) = 1e-6;
  covariance(0, 1) = covariance(1, 0) = 1.0 - 1e-6;
  const SquareMatrix<9> back = covariance_of<9>(covariance_code<9>(covariance));
  const double determinant = back(0, 0) * back(1, 1) - back(0, 1) * back(1, 0);
  EXPECT_NEAR(determinant, 2e-6, 5e-7);
}

TEST(Rounding, a_degenerate_direction_of_information_stays_degenerate) {
  // 1e6 / m^2 in five directions of a rotated frame, none in the sixth.
  Rng rng(3);
  Mat6 random;
  for (int i = 0; i < 36; ++i) random(i / 6, i % 6) = rng.normal();
  const Mat6 Q = Eigen::HouseholderQR<Mat6>(random).householderQ();
  geometry::Vec6 eigenvalues = geometry::Vec6::Constant(1e6);
  eigenvalues[0] = 0.0;
  const Mat6 information = Q * eigenvalues.asDiagonal() * Q.transpose();
  const Mat6 rounded = rounded_information(information);
  const geometry::Vec6 degenerate = Q.col(0);
  EXPECT_LT(std::abs(degenerate.dot(rounded * degenerate)), 1e-4);
  EXPECT_EQ(rounded, rounded_information(rounded));
  EXPECT_EQ(rounded, Mat6(rounded.transpose()));
}

TEST(Rounding, doubles_are_rounded_to_32_and_48_bits_even_in_adjacent_pairs) {
  struct Pair {
    double a = 1e-5, b = 1e-4;
  } pair;

  pair.a = rounded_float(pair.a);
  pair.b = rounded_float(pair.b);
  EXPECT_EQ(pair.a, static_cast<double>(1e-5F));
  EXPECT_EQ(pair.b, static_cast<double>(1e-4F));
  EXPECT_EQ(rounded48(1.0 + std::ldexp(1.0, -36)), 1.0 + std::ldexp(1.0, -36));
  EXPECT_EQ(rounded48(1.0 + std::ldexp(1.0, -38)), 1.0);
}

}  // namespace
}  // namespace rali::fleet
