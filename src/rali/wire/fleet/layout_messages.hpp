#pragma once

#include "rali/fleet/messages/messages.hpp"
#include "rali/wire/fleet/pack.hpp"
#include "rali/wire/fleet/table_block.hpp"

/// Sections and fields of soft messages; `Body` is BodyWriter with a const message, or BodyReader.
namespace rali::wire {

inline constexpr std::size_t kStreamsMax = 1024, kGapsMax = 4096, kWantsMax = 4096;
inline constexpr std::size_t kFrontiersMax = 4096, kGoalsMax = 1024;
inline constexpr std::size_t kReasonMax = 240;
inline constexpr std::size_t kSeenMax = 64;

template <class Archive, class Key>
void layout_stream(Archive& a, Key& key) {
  a.varint(key.vehicle.value);
  a.varint(key.epoch);
}

template <class Archive, class Interval>
void layout_interval(Archive& a, Interval& interval) {
  a.varint(interval.first);
  if constexpr (Archive::kReads) {
    std::uint32_t more = 0;
    a.varint(more);
    interval.last = interval.first + more;
    if (interval.last < interval.first) a.fail_with("holds an interval that ends before it begins");
  } else {
    a.varint(interval.last - interval.first);
  }
}

template <class Archive, class Of>
void layout_inventory_fields(Archive& a, Of& inventory) {
  a.varint(inventory.number);
  a.varint(inventory.free_bytes);
  a.list(inventory.streams, kStreamsMax, [](auto& b, auto& stream) {
    layout_stream(b, stream.stream);
    b.varint(stream.end);
    b.list(stream.gaps, kGapsMax, [](auto& c, auto& gap) { layout_interval(c, gap); });
  });
}

template <class Body, class Of>
void layout_inventory(Body& body, Of& inventory) {
  body.section(1, [&](auto& a) { layout_inventory_fields(a, inventory); });
}

template <class Body, class Of>
void layout_request(Body& body, Of& request) {
  body.section(1, [&](auto& a) {
    a.varint(request.number);
    a.varint(request.window_bytes);
    a.flag(request.without_points);
    a.list(request.wants, kWantsMax, [](auto& b, auto& want) {
      layout_stream(b, want.stream);
      layout_interval(b, want.numbers);
      b.number(want.priority);
    });
  });
}

template <class Body, class Of>
void layout_withheld(Body& body, Of& withheld) {
  body.section(1, [&](auto& a) {
    layout_stream(a, withheld.stream);
    a.list(withheld.numbers, kWantsMax, [](auto& b, auto& n) { layout_interval(b, n); });
  });
}

template <class Body, class Of>
void layout_role(Body& body, Of& role) {
  body.section(1, [&](auto& a) {
    a.choice(role.op, fleet::RoleOp::kCommit);
    a.varint(role.term);
    a.varint(role.number);
    a.varint(role.candidate.value);
    a.varint(role.revision);
    a.number(role.lease.ns);
    a.number(role.t_send.ns);
  });
  const bool stamps = role.t_echo.ns != 0 || role.t_received.ns != 0;
  body.optional_section(2, stamps, [&](auto& a) {
    a.number(role.t_echo.ns);
    a.number(role.t_received.ns);
  });
  const bool stands = role.reason != fleet::FinishReason::kNone ||
                      !role.T_odom_body.p.isZero(0.0) || !role.T_odom_body.R.isIdentity(0.0);
  body.optional_section(3, stands, [&](auto& a) {
    a.choice(role.reason, fleet::FinishReason::kOperator);
    a.pose(role.T_odom_body);
  });
  body.optional_section(4, !(role.inventory == fleet::Inventory{}),
                        [&](auto& a) { layout_inventory_fields(a, role.inventory); });
}

template <class Body, class Of>
void layout_status(Body& body, Of& status) {
  body.section(1, [&](auto& a) {
    a.varint(status.epoch);
    a.varint(status.term);
    a.choice(status.mode, fleet::Mode::kHolding);
    a.text(status.waits_for, kReasonMax);
    a.as_float(status.battery_fraction);
    a.pose(status.T_odom_body);
    a.as_float(status.sigma_m);
    a.maybe(status.degenerate_azimuth_rad, [](auto& b, auto& azimuth) { b.as_float(azimuth); });
    a.flag(status.at_rest);
    a.as_float(status.rssi_dbm);
    a.number(status.t_send.ns);
  });
  body.optional_section(2, status.drive_end.has_value(), [&](auto& a) {
    a.maybe(status.drive_end, [](auto& b, auto& end) {
      b.choice(end.state, fleet::DriveState::kGivenUp);
      b.float3(end.goal_map_m);
    });
  });
}

template <class Archive, class Pose>
void layout_peer_pose(Archive& a, Pose& pose) {
  a.pose(pose.T_start_body);
  a.template covariance<3>(pose.position_covariance_m2);
  a.maybe(pose.walls, [](auto& b, auto& walls) {
    b.float3(walls.axis);
    b.as_float(walls.left_m);
    b.as_float(walls.right_m);
  });
  a.list(pose.seen, kSeenMax, [](auto& b, auto& peer) {
    b.varint(peer.vehicle.value);
    b.number(peer.antenna);
    b.float3(peer.apart_start_m);
    b.template covariance<3>(peer.covariance_m2);
  });
}

/// The vehicle's id is in the envelope.
template <class Body, class Of>
void layout_peer(Body& body, Of& peer) {
  body.section(1, [&](auto& a) {
    a.number(peer.t.ns);
    a.flag(peer.at_rest);
    a.maybe(peer.pose, [](auto& b, auto& pose) { layout_peer_pose(b, pose); });
  });
}

template <class Body, class Of>
void layout_goals(Body& body, Of& goals) {
  body.section(1, [&](auto& a) {
    a.varint(goals.term);
    a.varint(goals.revision);
    a.varint(goals.group);
    a.list(goals.frontiers, kFrontiersMax, [](auto& b, auto& frontier) {
      b.float3(frontier.centre_map_m);
      b.as_float(frontier.size);
    });
    a.list(goals.goals, kGoalsMax, [](auto& b, auto& goal) {
      b.varint(goal.vehicle.value);
      b.float3(goal.place_map_m);
      b.maybe(goal.frontier, [](auto& c, auto& index) { c.varint(index); });
    });
  });
  body.optional_section(2, goals.memory.last_id > 0, [&](auto& a) {
    a.varint(goals.memory.last_id);
    a.list(goals.memory.named, kFrontiersMax, [](auto& b, auto& frontier) {
      b.varint(frontier.id);
      b.as_float(frontier.centre_map_m.x());
      b.as_float(frontier.centre_map_m.y());
      b.as_float(frontier.size);
      b.varint(frontier.visits);
    });
  });
  body.optional_section(3, !goals.memory.no_path.empty(), [&](auto& a) {
    a.list(goals.memory.no_path, kFrontiersMax, [](auto& b, auto& place) {
      b.varint(place.vehicle.value);
      b.as_float(place.place_map_m.x());
      b.as_float(place.place_map_m.y());
    });
  });
}

}  // namespace rali::wire
