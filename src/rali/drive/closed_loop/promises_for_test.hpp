#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "rali/drive/closed_loop/fleet_nodes.hpp"
#include "rali/fleet/facts/seq_set.hpp"

namespace rali::drive {

/// Promises that vehicles sent by radio, even if they failed later: votes, roles, facts that they
/// hold. Collects each broken promise.
class Promises {
 public:
  void on(std::size_t v, const fleet::NodeOutput& output) {
    const auto* envelope = std::get_if<fleet::Envelope>(&output);
    if (envelope == nullptr) return;
    if (const auto* inventory = std::get_if<fleet::Inventory>(&envelope->message)) {
      hold(v, *inventory);
    } else if (const auto* role = std::get_if<fleet::RoleMessage>(&envelope->message)) {
      on(v, *role);
    }
  }

  /// Facts named in a vehicle's inventory must stay in its store. @return their number
  std::size_t check_facts(std::size_t v, const fleet::FactStore& store) {
    std::size_t facts = 0;
    for (const auto& [stream, promised] : held_[v]) {
      facts += promised.size();
      const auto lacking = store.held(stream).first_lacking(promised, 0);
      if (lacking) {
        broken.push_back(fmt::format("v{} has lost fact {} of v{}, epoch {}", v + 1, *lacking,
                                     stream.vehicle.value + 1, stream.epoch));
      }
    }
    return facts;
  }

  std::vector<std::string> broken;
  std::size_t votes = 0, inventories = 0;

 private:
  void on(std::size_t v, const fleet::RoleMessage& m) {
    const VehicleId self{static_cast<std::uint16_t>(v)};
    switch (m.op) {
      case fleet::RoleOp::kGrant:
        return vote(v, m.term, m.candidate);
      case fleet::RoleOp::kPropose:
        return vote(v, m.term, self);  // a vehicle that stands for election votes for itself
      case fleet::RoleOp::kCommit:
      case fleet::RoleOp::kHeartbeat:
      case fleet::RoleOp::kSeal:
        if (anchors_.emplace(m.term, self).first->second != self) {
          broken.push_back(fmt::format("term {} has two anchors", m.term));
        }
        return;
      default:
        return;
    }
  }

  void vote(std::size_t v, std::uint64_t term, VehicleId candidate) {
    ++votes;
    if (votes_.emplace(std::pair(v, term), candidate).first->second != candidate) {
      broken.push_back(fmt::format("v{} has voted twice in term {}", v + 1, term));
    }
  }

  void hold(std::size_t v, const fleet::Inventory& inventory) {
    ++inventories;
    for (const fleet::StreamInventory& stream : inventory.streams) {
      const fleet::SeqSet named = fleet::SeqSet::from(stream);
      fleet::SeqSet& all = held_[v][stream.stream];
      for (auto seq = all.first_lacking(named, 0); seq; seq = all.first_lacking(named, *seq)) {
        all.insert(*seq);
      }
    }
  }

  std::map<std::pair<std::size_t, std::uint64_t>, VehicleId> votes_;
  std::map<std::uint64_t, VehicleId> anchors_;
  std::map<std::size_t, std::map<fleet::StreamKey, fleet::SeqSet>> held_;
};

}  // namespace rali::drive
