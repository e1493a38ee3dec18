#include "rali/geometry/so3.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "rali/base/rng.hpp"

namespace rali::geometry {
namespace {

constexpr double kPi = std::numbers::pi;

Vec3 random_unit(Rng& rng) { return Vec3(rng.normal(), rng.normal(), rng.normal()).normalized(); }

void expect_rotation(const Mat3& R) {
  EXPECT_LT((R.transpose() * R - Mat3::Identity()).norm(), 1e-12);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
}

// Angles where series and closed forms switch, and both ends of the range.
const double kAngles[] = {0.0, 1e-300, 1e-12, 1e-8, 0.99e-4, 1.01e-4,    0.99e-2,    1.01e-2,
                          0.3, 1.0,    2.0,   3.0,  3.141,   kPi - 1e-6, kPi - 1e-10};

TEST(So3, exp_gives_the_rotation_of_the_axis_and_angle) {
  Rng rng(1, "exp");
  for (const double angle : kAngles) {
    const Vec3 axis = random_unit(rng);
    const Mat3 expected = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    const Mat3 R = so3_exp(angle * axis);
    EXPECT_LT((R - expected).norm(), 2e-15) << angle;
    expect_rotation(R);
  }
}

TEST(So3, exp_turns_x_to_y_in_a_quarter_turn_about_z) {
  const Vec3 y = so3_exp(Vec3(0.0, 0.0, kPi / 2)) * Vec3::UnitX();
  EXPECT_LT((y - Vec3::UnitY()).norm(), 1e-15);
}

TEST(So3, log_undoes_exp_from_zero_to_nearly_pi) {
  Rng rng(2, "log");
  for (const double angle : kAngles) {
    for (int k = 0; k < 20; ++k) {
      const Vec3 phi = angle * random_unit(rng);
      EXPECT_LT((so3_log(so3_exp(phi)) - phi).norm(), 1e-14 + 4e-15 * angle) << angle;
    }
  }
}

TEST(So3, log_of_a_half_turn_has_length_pi_about_the_axis) {
  Rng rng(3, "half");
  for (int k = 0; k < 100; ++k) {
    const Vec3 axis = k < 3 ? Vec3(Mat3::Identity().col(k)) : random_unit(rng);
    const Vec3 phi = so3_log(so3_exp(kPi * axis));
    EXPECT_NEAR(phi.norm(), kPi, 1e-14);
    EXPECT_NEAR(std::abs(phi.normalized().dot(axis)), 1.0, 1e-14);  // either sign is right
  }
}

TEST(So3, log_beyond_pi_gives_the_shorter_rotation) {
  const Vec3 phi = so3_log(so3_exp(Vec3(0.0, 0.0, kPi + 0.1)));
  EXPECT_LT((phi - Vec3(0.0, 0.0, 0.1 - kPi)).norm(), 1e-14);
}

TEST(So3, group_laws_hold) {
  Rng rng(4, "group");
  for (int k = 0; k < 50; ++k) {
    const Mat3 A = so3_exp(rng.uniform(0.0, 3.0) * random_unit(rng));
    const Vec3 phi = rng.uniform(0.0, 3.0) * random_unit(rng);
    const Mat3 B = so3_exp(phi);
    expect_rotation(A * B);
    EXPECT_LT((B * so3_exp(-phi) - Mat3::Identity()).norm(), 1e-14);
    EXPECT_LT((so3_exp(0.3 * phi) * so3_exp(0.7 * phi) - B).norm(), 1e-14);
    EXPECT_LT((A * B * A.transpose() - so3_exp(A * phi)).norm(), 2e-14);  // adjoint
    EXPECT_LT((skew(phi) * Vec3(A.col(0)) - phi.cross(Vec3(A.col(0)))).norm(), 1e-15);
  }
}

// Central differences of Exp(phi)^T Exp(phi + d).
Mat3 numerical_right_jacobian(const Vec3& phi) {
  constexpr double kStep = 1e-5;
  Mat3 J;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = kStep * Vec3::Unit(k);
    const Mat3 R = so3_exp(phi).transpose();
    J.col(k) = (so3_log(R * so3_exp(phi + d)) - so3_log(R * so3_exp(phi - d))) / (2.0 * kStep);
  }
  return J;
}

TEST(So3, right_jacobian_agrees_with_central_differences_everywhere) {
  Rng rng(5, "jr");
  for (const double angle : kAngles) {
    for (int k = 0; k < 5; ++k) {
      const Vec3 phi = angle * random_unit(rng);
      EXPECT_LT((so3_right_jacobian(phi) - numerical_right_jacobian(phi)).norm(), 3e-10) << angle;
    }
  }
}

TEST(So3, inverse_right_jacobian_is_the_inverse) {
  Rng rng(6, "jri");
  for (const double angle : kAngles) {
    const Vec3 phi = angle * random_unit(rng);
    const Mat3 product = so3_right_jacobian(phi) * so3_right_jacobian_inverse(phi);
    EXPECT_LT((product - Mat3::Identity()).norm(), 1e-12) << angle;
  }
  const Vec3 beyond_pi(0.0, 4.0, 0.0);
  const Mat3 product = so3_right_jacobian(beyond_pi) * so3_right_jacobian_inverse(beyond_pi);
  EXPECT_LT((product - Mat3::Identity()).norm(), 1e-12);
}

TEST(So3, normalising_restores_a_rotation_matrix) {
  Rng rng(7, "norm");
  const Mat3 R = so3_exp(Vec3(0.4, -1.0, 2.0));
  Mat3 dirty = R;
  for (int k = 0; k < 9; ++k) dirty.data()[k] += 1e-6 * rng.normal();
  const Mat3 clean = so3_normalised(dirty);
  expect_rotation(clean);
  EXPECT_LT((clean - R).norm(), 5e-6);
}

TEST(So3, rotation_between_is_the_smallest_one) {
  Rng rng(8, "between");
  for (int k = 0; k < 50; ++k) {
    const Vec3 a = 3.0 * random_unit(rng);
    const Vec3 b = 0.1 * random_unit(rng);
    const Mat3 R = rotation_between(a, b);
    expect_rotation(R);
    EXPECT_LT((R * a.normalized() - b.normalized()).norm(), 1e-12);
    const double angle = std::atan2(a.cross(b).norm(), a.dot(b));
    EXPECT_NEAR(so3_log(R).norm(), angle, 1e-13);
  }
}

TEST(So3, rotation_between_parallel_opposite_and_zero_vectors_is_a_rotation) {
  EXPECT_LT((rotation_between(Vec3::UnitZ(), 9.81 * Vec3::UnitZ()) - Mat3::Identity()).norm(),
            1e-15);
  const Mat3 half = rotation_between(Vec3(1.0, 2.0, 3.0), Vec3(-1.0, -2.0, -3.0));
  expect_rotation(half);
  EXPECT_LT((half * Vec3(1.0, 2.0, 3.0) + Vec3(1.0, 2.0, 3.0)).norm(), 1e-13);
  EXPECT_TRUE(rotation_between(Vec3::Zero(), Vec3::UnitZ()).allFinite());
}

TEST(So3, roll_pitch_yaw_are_about_fixed_x_y_z_in_this_order) {
  const Mat3 R = rotation_from_rpy(0.1, -0.2, 0.7);
  const Mat3 expected =
      so3_exp(Vec3(0.0, 0.0, 0.7)) * so3_exp(Vec3(0.0, -0.2, 0.0)) * so3_exp(Vec3(0.1, 0.0, 0.0));
  EXPECT_LT((R - expected).norm(), 1e-15);
  EXPECT_LT((rpy_from_rotation(R) - Vec3(0.1, -0.2, 0.7)).norm(), 1e-15);
  // Gimbal lock: the angles are not unique, but their rotation must be.
  const Mat3 lock = rotation_from_rpy(0.3, kPi / 2, 0.5);
  const Vec3 rpy = rpy_from_rotation(lock);
  EXPECT_LT((rotation_from_rpy(rpy.x(), rpy.y(), rpy.z()) - lock).norm(), 1e-12);
}

}  // namespace
}  // namespace rali::geometry
