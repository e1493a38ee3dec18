// The state table in README.md is the machine's behaviour: generated here, compared with the file.
#include <fstream>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rali/fleet/roles/role_vehicle_for_test.hpp"

namespace rali::fleet {
namespace {

using test::anchor_of_three;
using test::at;
using test::id;
using test::tag_of_three;
using test::Vehicle;

const char* name_of(RoleOp op) {
  constexpr const char* kNames[] = {"?",        "heartbeat", "ack",   "finished", "seal",
                                    "handover", "propose",   "grant", "refuse",   "commit"};
  return kNames[static_cast<std::size_t>(op)];
}

const char* name_of(RoleMode mode) {
  constexpr const char* kNames[] = {"TAG", "CANDIDATE", "ANCHOR", "SEALED"};
  return kNames[static_cast<std::size_t>(mode)];
}

/// v1 as tag of term 1 whose anchor v0 has sealed.
Vehicle tag_after_seal() {
  Vehicle v = tag_of_three();
  v.receive(0.5, 0, RoleOp::kSeal, 1);
  return v;
}

/// v1 as candidate of term 2.
Vehicle candidate_of_three() {
  Vehicle v = tag_after_seal();
  v.receive(1.0, 0, RoleOp::kHandover, 2, 1);
  return v;
}

/// v0 as sealed anchor of term 1 that has named v1.
Vehicle sealed_of_three() {
  Vehicle v = anchor_of_three();
  v.give(0.5, RoleEndRound{});
  v.give(0.6, RoleChoice{{id(1)}});
  return v;
}

std::string cell(Vehicle v, int peer, RoleOp op, std::uint64_t term, int candidate) {
  const RoleStep step = v.receive(1.5, peer, op, term, candidate, 1.0);
  std::string text = name_of(step.state.mode);
  for (const RoleSend& s : step.messages) text += fmt::format(", {}", name_of(s.message.op));
  if (step.save) text += " (saved)";
  return text;
}

struct Row {
  const char* event;
  RoleOp op;
  int terms_up;       ///< term of the message above the vehicle's own
  bool for_receiver;  ///< the named candidate is the receiver, else the sender
};

constexpr Row kRows[] = {
    {"heartbeat of a lower term", RoleOp::kHeartbeat, -1, false},
    {"commit of a higher term", RoleOp::kCommit, 1, false},
    {"seal of a higher term", RoleOp::kSeal, 1, false},
    {"propose of a lower term", RoleOp::kPropose, -1, false},
    {"propose of a higher term", RoleOp::kPropose, 1, false},
    {"grant of the own term", RoleOp::kGrant, 0, true},
    {"grant of a lower term", RoleOp::kGrant, -1, true},
    {"refuse, higher term", RoleOp::kRefuse, 1, true},
    {"handover of a higher term", RoleOp::kHandover, 1, true},
    {"handover of the own term", RoleOp::kHandover, 0, true},
};

std::string table() {
  const Vehicle vehicles[] = {tag_of_three(), tag_after_seal(), candidate_of_three(),
                              anchor_of_three(), sealed_of_three()};
  std::string text = "| message from v2 | TAG | TAG, seal heard | CANDIDATE | ANCHOR | SEALED |\n";
  text += "|---|---|---|---|---|---|\n";
  for (const Row& row : kRows) {
    text += fmt::format("| {} |", row.event);
    for (const Vehicle& v : vehicles) {
      const auto own = static_cast<std::int64_t>(v.state.durable.term);
      const auto term = static_cast<std::uint64_t>(own + row.terms_up);
      const int candidate = row.for_receiver ? v.state.self.value : 2;
      text += fmt::format(" {} |", cell(v, 2, row.op, term, candidate));
    }
    text += "\n";
  }
  return text;
}

TEST(RoleStateTable, in_the_readme_matches_the_state_machine) {
  std::ifstream file(std::string(RALI_SOURCE_DIR) + "/src/rali/fleet/roles/README.md");
  std::stringstream readme;
  readme << file.rdbuf();
  EXPECT_NE(readme.str().find(table()), std::string::npos) << "should be\n" << table();
}

}  // namespace
}  // namespace rali::fleet
