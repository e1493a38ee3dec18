#include "rali/fleet/messages/kind.hpp"

namespace rali::fleet {

namespace {

struct OfBody {
  Kind operator()(const EpochStart&) const { return Kind::kEpochStart; }

  Kind operator()(const Increment&) const { return Kind::kIncrement; }

  Kind operator()(const RangeBlock&) const { return Kind::kRanges; }

  Kind operator()(const KeyframePoints& points) const {
    return points.refinement ? Kind::kFinePoints : Kind::kCoarsePoints;
  }

  Kind operator()(const Loop&) const { return Kind::kLoop; }

  Kind operator()(const UnreadBody& body) const { return static_cast<Kind>(body.kind); }
};

struct OfMessage {
  Kind operator()(const FactMessage& message) const { return kind_of(*message.fact); }

  Kind operator()(const Inventory&) const { return Kind::kInventory; }

  Kind operator()(const Request&) const { return Kind::kRequest; }

  Kind operator()(const Withheld&) const { return Kind::kWithheld; }

  Kind operator()(const Table&) const { return Kind::kTable; }

  Kind operator()(const RoleMessage&) const { return Kind::kRole; }

  Kind operator()(const VehicleStatus&) const { return Kind::kStatus; }

  Kind operator()(const GoalList&) const { return Kind::kGoals; }

  Kind operator()(const SeparatorPrior&) const { return Kind::kSeparator; }

  Kind operator()(const PeerStatus&) const { return Kind::kPeer; }
};

}  // namespace

Kind kind_of(const Fact& fact) { return std::visit(OfBody{}, fact.body); }

Kind kind_of(const Message& message) { return std::visit(OfMessage{}, message); }

std::string_view name_of(Kind kind) {
  switch (kind) {
    case Kind::kCoarsePoints:
      return "points";
    case Kind::kFinePoints:
      return "fine points";
    case Kind::kIncrement:
      return "increment";
    case Kind::kRanges:
      return "ranges";
    case Kind::kLoop:
      return "loop";
    case Kind::kEpochStart:
      return "epoch start";
    case Kind::kInventory:
      return "inventory";
    case Kind::kRequest:
      return "request";
    case Kind::kTable:
      return "table";
    case Kind::kRole:
      return "role";
    case Kind::kStatus:
      return "status";
    case Kind::kGoals:
      return "goals";
    case Kind::kWithheld:
      return "withheld";
    case Kind::kSeparator:
      return "boundary";
    case Kind::kPeer:
      return "peer";
  }
  return "kind";
}

void TrafficCount::add(Kind kind, std::size_t bytes) {
  Row& row = of_kind[static_cast<std::size_t>(kind) % kMessageKinds];
  ++row.messages;
  row.bytes += bytes;
}

void TrafficCount::add(const TrafficCount& other) {
  for (std::size_t k = 0; k < of_kind.size(); ++k) {
    of_kind[k].messages += other.of_kind[k].messages;
    of_kind[k].bytes += other.of_kind[k].bytes;
  }
}

TrafficCount::Row TrafficCount::total() const {
  Row sum;
  for (const Row& row : of_kind) {
    sum.messages += row.messages;
    sum.bytes += row.bytes;
  }
  return sum;
}

}  // namespace rali::fleet
