#include <gtest/gtest.h>

#include "rali/fleet/centre/round_centre.hpp"
#include "rali/fleet/centre/rounds_for_test.hpp"
#include "rali/wire/fleet/codec.hpp"

namespace rali::wire {
namespace {

using fleet::FleetForTest;
using fleet::RoundCentre;
using fleet::SeparatorPrior;

fleet::Envelope envelope_of(const SeparatorPrior& separator) {
  return {VehicleId{0}, std::nullopt, separator};
}

TEST(SeparatorCodec, the_new_anchor_estimates_the_same_poses_as_the_old_one) {
  SerialExecutor executor;
  fleet::RoundsForTest options;
  options.degenerate = true;
  FleetForTest team(options);
  RoundCentre old_anchor(fleet::exact_rounds(), team.knowledge());
  RoundCentre new_anchor(fleet::exact_rounds(), team.knowledge());
  const auto drive = [&] {
    for (const fleet::Fact& fact : team.round()) {
      old_anchor.add(fact);
      new_anchor.add(fact);
    }
  };
  for (int r = 0; r < 2; ++r) {
    drive();
    old_anchor.end_round(team.now(), executor);
  }
  const auto bytes = encode_envelope(envelope_of(*old_anchor.separator()));
  ASSERT_TRUE(bytes) << bytes.error().message();
  EXPECT_LT(bytes->size(), 60000U);
  const auto reported = decode_envelope(*bytes);
  ASSERT_TRUE(reported) << reported.error().message();
  EXPECT_EQ(*encode_envelope(*reported), *bytes);
  ASSERT_TRUE(new_anchor.take_over(std::get<SeparatorPrior>(reported->message),
                                   old_anchor.last().keyframes));
  drive();
  const auto& by_old = old_anchor.end_round(team.now(), executor).keyframes;
  const auto& by_new = new_anchor.end_round(team.now(), executor).keyframes;
  EXPECT_EQ(new_anchor.work().whole, 0U) << "it began anew";
  ASSERT_EQ(by_new.size(), by_old.size());
  for (const auto& [id, pose] : by_old) {
    // The order of sums differs: differences are rounding only.
    EXPECT_LT((by_new.at(id).T_map_body.p - pose.T_map_body.p).norm(), 1e-8) << id.seq;
    EXPECT_LT((by_new.at(id).covariance - pose.covariance).norm(), 1e-6 * pose.covariance.norm())
        << id.seq;
  }
}

TEST(SeparatorCodec, refuses_invalid_separator_priors) {
  SeparatorPrior separator;
  separator.paths.push_back({{VehicleId{1}, 0}, 3, {}, geometry::Mat6::Identity(), true});
  separator.nodes.push_back({{VehicleId{1}, 0}, 3, false, {}});
  separator.H = Eigen::MatrixXd::Identity(6, 6);
  separator.b = Eigen::VectorXd::Zero(6);
  EXPECT_TRUE(decode_envelope(*encode_envelope(envelope_of(separator))));
  SeparatorPrior bent = separator;
  bent.nodes[0].x.T_odom_body.R(0, 0) = 1.1;
  EXPECT_FALSE(decode_envelope(*encode_envelope(envelope_of(bent)))) << "no rotation";
  bent = separator;
  bent.b = Eigen::VectorXd::Zero(5);
  EXPECT_FALSE(decode_envelope(*encode_envelope(envelope_of(bent)))) << "one number short";
  bent = separator;
  bent.H(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(decode_envelope(*encode_envelope(envelope_of(bent))));
}

}  // namespace
}  // namespace rali::wire
