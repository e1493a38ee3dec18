#pragma once

#include <memory>
#include <string>
#include <vector>

#include "rali/fleet/facts/facts_for_test.hpp"
#include "rali/fleet/messages/messages.hpp"

namespace rali::wire {

inline fleet::Envelope fact_envelope(fleet::FactBody body) {
  const VehicleId author{3};
  fleet::Fact fact{{author, 7, 1234}, Time::from_ns(1700000000123456789), std::move(body)};
  return {VehicleId{2}, VehicleId{1},
          fleet::FactMessage{std::make_shared<const fleet::Fact>(std::move(fact))}};
}

inline fleet::Inventory some_inventory() {
  return {
      5, 64000000, {{{VehicleId{1}, 0}, 400, {{3, 5}, {300, 398}}}, {{VehicleId{2}, 9}, 1, {}}}};
}

inline fleet::Table some_table(Rng& rng, int poses) {
  fleet::Table table;
  table.term = 3;
  table.revision = 17;
  table.base_revision = 16;
  table.part = 1;
  table.last_part = false;
  table.hash = 0x123456789ABCDEF0ULL;
  table.frames.push_back(
      {{VehicleId{1}, 0}, 1, fleet::random_pose(rng), {0.2, 0.1, 0.0, 0.3, 0.01}});
  for (int k = 0; k < poses; ++k) {
    fleet::TablePose pose;
    pose.stream = {VehicleId{static_cast<std::uint16_t>(1 + k / 40)}, 2};
    pose.keyframe = static_cast<std::uint32_t>(100 + k % 40);
    pose.T_map_body.p = {1.0 * (k % 40) + 0.1234, 0.3 * rng.normal(), 0.01 * rng.normal()};
    pose.T_map_body.R = geometry::rotation_from_rpy(0.01, 0.0, 0.05 * k);
    pose.sigma = {0.2, 0.02, 1.0, 0.05, 0.003};
    table.poses.push_back(pose);
  }
  return table;
}

inline fleet::RoleMessage some_role() {
  fleet::RoleMessage role;
  role.op = fleet::RoleOp::kHeartbeat;
  role.term = 4;
  role.number = 99;
  role.candidate = VehicleId{2};
  role.revision = 8;
  role.lease = Duration::from_s(5.0);
  role.t_send = Time::from_s(123.456);
  return role;
}

/// A peer at standstill in a passage with two others.
inline fleet::PeerStatus some_peer(Rng& rng) {
  fleet::PeerStatus peer{VehicleId{1}, Time::from_s(5.0), true, fleet::PeerPose{}};
  peer.pose->T_start_body = fleet::random_pose(rng);
  peer.pose->position_covariance_m2 = fleet::random_covariance<3>(rng);
  peer.pose->walls = ranging::PassageWalls{geometry::Vec3::UnitY(), 1.5, 2.25};
  peer.pose->seen = {
      {VehicleId{2}, 1, {0.5, -1.25, 0.125}, fleet::random_covariance<3>(rng)},
      {VehicleId{3}, 0, {-7.0, 0.5, 0.0}, geometry::Mat3::Zero()},
  };
  return peer;
}

/// One of each kind of message, facts first.
inline std::vector<fleet::Envelope> all_messages() {
  Rng rng(11);
  std::vector<fleet::Envelope> all;
  for (int k = 0; k < fleet::kBodies; ++k) {
    all.push_back(fact_envelope(fleet::random_body(rng, k, VehicleId{3})));
  }
  const auto add = [&all](fleet::Message message) {
    all.push_back({VehicleId{1}, std::nullopt, std::move(message)});
  };
  fleet::SeparatorPrior separator;
  separator.term = 3;
  separator.until = Time::from_s(77.0);
  separator.paths.push_back(
      {{VehicleId{1}, 2}, 300, fleet::random_pose(rng), fleet::random_covariance<6>(rng), false});
  separator.nodes.push_back({{VehicleId{1}, 2}, 300, true, {fleet::random_pose(rng), {}, {}, {}}});
  separator.biases.push_back({VehicleId{1}, VehicleId{2}, 0, 1, 0.04, 300, 290, 1.5});
  separator.tau_s = 0.001;
  separator.H = Eigen::MatrixXd::Identity(17, 17);
  separator.b = Eigen::VectorXd::LinSpaced(17, -1.0, 1.0);
  add(separator);
  add(fleet::PeerStatus{VehicleId{1}, Time::from_s(4.0), false});
  add(some_peer(rng));
  add(some_inventory());
  add(fleet::Request{
      7, 65536, true, {{{VehicleId{1}, 0}, {3, 5}, 1}, {{VehicleId{1}, 0}, {300, 300}, 0}}});
  add(fleet::Withheld{{VehicleId{3}, 1}, {{7, 7}, {9, 12}}});
  add(some_table(rng, 60));
  add(some_role());
  fleet::RoleMessage finished = some_role();
  finished.op = fleet::RoleOp::kFinished;
  finished.reason = fleet::FinishReason::kDistance;
  finished.T_odom_body = fleet::random_pose(rng);
  finished.inventory = some_inventory();
  add(finished);
  fleet::RoleMessage ack = some_role();
  ack.op = fleet::RoleOp::kAck;
  ack.t_echo = Time::from_s(123.0);
  ack.t_received = Time::from_s(123.1);
  add(ack);
  fleet::VehicleStatus status;
  status.term = 4;
  status.mode = fleet::Mode::kUnplaced;
  status.waits_for = "v2: left/right of v1 unknown. Move v2 off its line by 1 m";
  status.T_odom_body = fleet::random_pose(rng);
  status.sigma_m = 0.25;
  status.degenerate_azimuth_rad = 1.0;
  status.at_rest = true;
  status.rssi_dbm = -80.5;
  status.t_send = Time::from_s(5.0);
  status.drive_end = {fleet::DriveState::kBlocked, {9.0, 6.0, 0.5}};
  add(status);
  fleet::GoalList goals{4, 8, 1, {{{30.0, 0.5, 0.0}, 9.0}, {{10.0, 12.0, 0.0}, 4.0}}, {}, {}};
  goals.goals = {{VehicleId{2}, {9.0, 6.0, 0.0}, 1}, {VehicleId{3}, {1.0, 2.0, 0.0}, std::nullopt}};
  goals.memory = {{{7, {30.0, 0.5}, 9.0, 0}, {3, {-5.0, -0.5}, 30.0, 2}},
                  300,
                  {{VehicleId{2}, {30.0, 0.5}}, {VehicleId{0}, {-1.0, 4.5}}}};
  add(goals);
  return all;
}

}  // namespace rali::wire
