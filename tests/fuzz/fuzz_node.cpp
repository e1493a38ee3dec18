// A vehicle of a fleet of three receives anything that a link can carry: well-formed messages in
// any order, with any content, from any sender. It must neither crash nor hang, and its messages
// must be readable by others.
//
// Input: a sequence of (1 byte: kind; 2 bytes: length or tenths of a second; bytes). The checksum
// of a message is corrected.
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "message_bytes.hpp"
#include "rali/base/assert.hpp"
#include "rali/fleet/node/node.hpp"
#include "rali/wire/fleet/codec.hpp"

namespace {

using namespace rali;

constexpr std::size_t kStepsMax = 400;

/// Vehicle v1 of three, at standstill with a known pose.
class Hearer {
 public:
  Hearer() : node_(VehicleId{1}, {VehicleId{1}, VehicleId{2}, VehicleId{3}}, settings(), {}, now_) {
    fleet::OwnPose pose;
    pose.t = now_;
    pose.at_rest = pose.levelled = true;
    give(pose);
    wait(5.0);  // it requests votes
  }

  void wait(double s) {
    now_ = now_ + Duration::from_s(s);
    fleet::OwnPose pose;
    pose.t = now_;
    pose.at_rest = pose.levelled = true;
    give(pose);
    give(fleet::NodeTick{});
  }

  void receive(std::span<const std::byte> raw) {
    const auto envelope = wire::decode_envelope(fuzz::with_checksum(raw));
    if (envelope) give(*envelope);
  }

  /// Both others vote for it.
  void elect() {
    for (const VehicleId voter : {VehicleId{2}, VehicleId{3}}) {
      fleet::RoleMessage vote;
      vote.op = fleet::RoleOp::kGrant;
      vote.term = node_.term();
      vote.candidate = VehicleId{1};
      vote.t_echo = vote.t_received = now_;
      give(fleet::Envelope{voter, VehicleId{1}, vote});
    }
  }

 private:
  static fleet::NodeSettings settings() {
    fleet::NodeSettings s;
    s.fleet.loops.use = false;  // registration of points is fuzzed by its own target
    return s;
  }

  void give(const fleet::NodeEvent& event) {
    fleet::NodeOutputs out;
    node_.step(event, now_, out);
    for (const fleet::NodeOutput& o : out) {
      if (const auto* order = std::get_if<fleet::RunJob>(&o)) {
        const std::atomic<bool> never = false;
        order->job->run(executor_, never);
        give(fleet::JobDone{order->number, order->job});
      }
      const auto* reported = std::get_if<fleet::Envelope>(&o);
      if (reported == nullptr) continue;
      const auto bytes = wire::encode_envelope(*reported);
      RALI_ASSERT(bytes.has_value());
      RALI_ASSERT(wire::decode_envelope(*bytes).has_value());
    }
    for (const geometry::Vec3& place : node_.order().places_map_m) RALI_ASSERT(place.allFinite());
  }

  Time now_ = Time::from_s(1000.0);
  SerialExecutor executor_;
  fleet::Node node_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::span<const std::byte> rest = std::as_bytes(std::span(data, size));
  Hearer hearer;
  for (std::size_t step = 0; step < kStepsMax && rest.size() >= 3; ++step) {
    const auto what = std::to_integer<unsigned>(rest[0]);
    rest = rest.subspan(1);
    const std::size_t number = fuzz::take_number(rest);
    if (what % 8 == 0) {
      hearer.wait(0.1 * static_cast<double>(number % 256));
    } else if (what % 8 == 1) {
      hearer.elect();
    } else {
      hearer.receive(fuzz::take_bytes(rest, number));
    }
  }
  hearer.wait(1.0);
  return 0;
}
