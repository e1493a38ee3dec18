#include "rali/drive/link/post.hpp"

#include <utility>

#include "rali/wire/fleet/codec.hpp"

namespace rali::drive {

Status post(Loopback& link, Time now, const fleet::Envelope& envelope) {
  Result<wire::Bytes> bytes = wire::encode_envelope(envelope);
  if (!bytes) return tl::make_unexpected(std::move(bytes.error()));
  link.send(now, envelope.from, envelope.to, std::move(*bytes));
  return {};
}

Mail collect(Loopback& link, Time now) {
  Mail mail;
  for (const Delivery& delivery : link.deliver(now)) {
    Result<fleet::Envelope> envelope = wire::decode_envelope(*delivery.bytes);
    if (!envelope) {
      ++mail.unreadable;
      continue;
    }
    mail.received.push_back({delivery.t, delivery.to, std::move(*envelope)});
  }
  return mail;
}

}  // namespace rali::drive
