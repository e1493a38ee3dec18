#include "rali/wire/fleet/codec.hpp"

#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "rali/fleet/facts/quantise.hpp"
#include "rali/wire/fleet/crc32c.hpp"
#include "rali/wire/fleet/layout_facts.hpp"
#include "rali/wire/fleet/layout_messages.hpp"
#include "rali/wire/fleet/layout_separator_prior.hpp"
#include "rali/wire/fleet/point_block.hpp"
#include "rali/wire/fleet/range_block.hpp"

namespace rali::wire {

namespace {

using fleet::Kind;

constexpr std::uint16_t kToAll = 0xFFFF;
// version, kind, from, to
constexpr std::size_t kCrcAt = 6;
constexpr std::size_t kCrcBytes = 4;

std::uint32_t checksum(std::span<const std::byte> bytes) {
  return crc32c(bytes.subspan(kCrcAt + kCrcBytes), crc32c(bytes.first(kCrcAt)));
}

struct WriteBody {
  BodyWriter& body;

  void operator()(const fleet::EpochStart& v) const { layout_epoch_start(body, v); }

  void operator()(const fleet::Increment& v) const { layout_increment(body, v); }

  void operator()(const fleet::RangeBlock& v) const { write_range_block(body, v); }

  void operator()(const fleet::KeyframePoints& v) const { write_point_block(body, v); }

  void operator()(const fleet::Loop& v) const { layout_loop(body, v); }

  void operator()(const fleet::UnreadBody&) const {}

  void operator()(const fleet::FactMessage&) const {}

  void operator()(const fleet::Inventory& v) const { layout_inventory(body, v); }

  void operator()(const fleet::Request& v) const { layout_request(body, v); }

  void operator()(const fleet::Withheld& v) const { layout_withheld(body, v); }

  void operator()(const fleet::Table& v) const { write_table(body, v); }

  void operator()(const fleet::RoleMessage& v) const { layout_role(body, v); }

  void operator()(const fleet::VehicleStatus& v) const { layout_status(body, v); }

  void operator()(const fleet::GoalList& v) const { layout_goals(body, v); }

  void operator()(const fleet::SeparatorPrior& v) const { layout_separator_prior(body, v); }

  void operator()(const fleet::PeerStatus& v) const { layout_peer(body, v); }
};

template <class Header, class Key, class Stamp>
void layout_fact_key(Header& a, Key& key, Stamp& t) {
  a.number(key.vehicle.value);
  a.number(key.epoch);
  a.number(key.seq);
  a.number(t.ns);
}

Result<Bytes> body_of(const fleet::Message& message, PackWriter& header) {
  BodyWriter body;
  if (const auto* reported_message = std::get_if<fleet::FactMessage>(&message)) {
    const Result<fleet::Fact> fact = fleet::quantised(*reported_message->fact);
    if (!fact) return tl::make_unexpected(fact.error());
    layout_fact_key(header, fact->key, fact->t);
    std::visit(WriteBody{body}, fact->body);
    body.append(std::as_bytes(std::span(fact->unread)));
  } else {
    std::visit(WriteBody{body}, message);
  }
  return body.take();
}

tl::unexpected<Error> damaged(std::string what) {
  return fail(ErrorCode::kInput, "message between vehicles", std::move(what),
              "It is dropped; its content is requested again.");
}

/// Reads the body of a known kind as T.
template <class T, class Read>
Result<T> read_as(BodyReader& body, Read&& read) {
  T value;
  read(body, value);
  if (!body.ok()) return damaged(body.fault());
  return value;
}

Result<fleet::FactBody> read_fact_body(Kind kind, BodyReader& body) {
  switch (kind) {
    case Kind::kEpochStart:
      return read_as<fleet::EpochStart>(body, [](auto& b, auto& v) { layout_epoch_start(b, v); });
    case Kind::kIncrement:
      return read_as<fleet::Increment>(body, [](auto& b, auto& v) { layout_increment(b, v); });
    case Kind::kRanges:
      return read_as<fleet::RangeBlock>(body, [](auto& b, auto& v) { read_range_block(b, v); });
    case Kind::kCoarsePoints:
    case Kind::kFinePoints: {
      auto points =
          read_as<fleet::KeyframePoints>(body, [](auto& b, auto& v) { read_point_block(b, v); });
      if (points && points->refinement != (kind == Kind::kFinePoints)) {
        return damaged("has points of another kind than it says");
      }
      return points;
    }
    case Kind::kLoop:
      return read_as<fleet::Loop>(body, [](auto& b, auto& v) { layout_loop(b, v); });
    default:
      return fleet::FactBody{fleet::UnreadBody{static_cast<std::uint8_t>(kind)}};
  }
}

Result<fleet::Message> read_fact(Kind kind, PackReader& header) {
  fleet::Fact fact;
  layout_fact_key(header, fact.key, fact.t);
  if (!header.ok()) return damaged(header.fault());
  BodyReader body(header.rest());
  if (!body.ok()) return damaged(body.fault());
  Result<fleet::FactBody> content = read_fact_body(kind, body);
  if (!content) return tl::make_unexpected(std::move(content.error()));
  fact.body = std::move(*content);
  fact.unread = body.unread();
  // A well-formed fact may still be out of bounds; quantising never changes one that was quantised.
  Result<fleet::Fact> checked = fleet::quantised(fact);
  if (!checked) return tl::make_unexpected(std::move(checked.error()));
  return fleet::Message{
      fleet::FactMessage{std::make_shared<const fleet::Fact>(std::move(*checked))}};
}

Result<fleet::Message> read_soft(Kind kind, PackReader& header) {
  BodyReader body(header.rest());
  if (!body.ok()) return damaged(body.fault());
  switch (kind) {
    case Kind::kInventory:
      return read_as<fleet::Inventory>(body, [](auto& b, auto& v) { layout_inventory(b, v); });
    case Kind::kRequest:
      return read_as<fleet::Request>(body, [](auto& b, auto& v) { layout_request(b, v); });
    case Kind::kWithheld:
      return read_as<fleet::Withheld>(body, [](auto& b, auto& v) { layout_withheld(b, v); });
    case Kind::kTable:
      return read_as<fleet::Table>(body, [](auto& b, auto& v) { read_table(b, v); });
    case Kind::kRole: {
      auto role = read_as<fleet::RoleMessage>(body, [](auto& b, auto& v) { layout_role(b, v); });
      if (role && static_cast<std::uint8_t>(role->op) == 0) return damaged("has no role operation");
      return role;
    }
    case Kind::kStatus:
      return read_as<fleet::VehicleStatus>(body, [](auto& b, auto& v) { layout_status(b, v); });
    case Kind::kGoals:
      return read_as<fleet::GoalList>(body, [](auto& b, auto& v) { layout_goals(b, v); });
    case Kind::kSeparator:
      return read_as<fleet::SeparatorPrior>(body,
                                            [](auto& b, auto& v) { layout_separator_prior(b, v); });
    case Kind::kPeer:
      return read_as<fleet::PeerStatus>(body, [](auto& b, auto& v) { layout_peer(b, v); });
    default:
      return fail(ErrorCode::kNoAnswer, "message between vehicles",
                  fmt::format("is of the unknown kind {}", static_cast<unsigned>(kind)),
                  "A newer program sent it; update this one.");
  }
}

}  // namespace

Result<Bytes> encode_envelope(const fleet::Envelope& envelope) {
  PackWriter out;
  out.number(kEnvelopeVersion);
  out.number(static_cast<std::uint8_t>(fleet::kind_of(envelope.message)));
  out.number(envelope.from.value);
  out.number(envelope.to ? envelope.to->value : kToAll);
  out.number(std::uint32_t{0});
  const Result<Bytes> body = body_of(envelope.message, out);
  if (!body) return body;
  if (body->size() > kBodyMax) {
    return fail(ErrorCode::kInput, "message between vehicles",
                fmt::format("has {} bytes; {} may be sent", body->size(), kBodyMax));
  }
  out.bytes(*body);
  Bytes bytes = out.take();
  const std::uint32_t sum = checksum(bytes);
  for (std::size_t k = 0; k < kCrcBytes; ++k) {
    bytes[kCrcAt + k] = static_cast<std::byte>(sum >> (8 * k) & 0xFFU);
  }
  return bytes;
}

Result<fleet::Envelope> decode_envelope(std::span<const std::byte> bytes) {
  PackReader header(bytes);
  std::uint8_t version = 0, kind = 0;
  std::uint16_t from = 0, to = 0;
  std::uint32_t sum = 0;
  header.number(version);
  header.number(kind);
  header.number(from);
  header.number(to);
  header.number(sum);
  if (!header.ok()) return damaged(header.fault());
  if (sum != checksum(bytes)) return damaged("was damaged on its way (checksum)");
  if (version != kEnvelopeVersion) {
    return fail(ErrorCode::kNoAnswer, "message between vehicles",
                fmt::format("is of version {}; {} is known", version, kEnvelopeVersion),
                "Run one version of RaLI on all vehicles.");
  }
  constexpr std::size_t kFactKeyBytes = 18;
  if (bytes.size() > kCrcAt + kCrcBytes + kFactKeyBytes + kBodyMax) {
    return damaged("is longer than any message");
  }
  Result<fleet::Message> message = kind < fleet::kFactKinds
                                       ? read_fact(static_cast<Kind>(kind), header)
                                       : read_soft(static_cast<Kind>(kind), header);
  if (!message) return tl::make_unexpected(std::move(message.error()));
  fleet::Envelope envelope{VehicleId{from}, std::nullopt, std::move(*message)};
  if (to != kToAll) envelope.to = VehicleId{to};
  if (auto* peer = std::get_if<fleet::PeerStatus>(&envelope.message)) peer->vehicle = envelope.from;
  return envelope;
}

fleet::Kind envelope_kind(std::span<const std::byte> bytes) {
  return bytes.size() < 2 ? Kind{} : static_cast<Kind>(std::to_integer<std::uint8_t>(bytes[1]));
}

}  // namespace rali::wire
