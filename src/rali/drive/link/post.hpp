#pragma once

#include <vector>

#include "rali/base/result.hpp"
#include "rali/drive/link/loopback.hpp"
#include "rali/fleet/messages/messages.hpp"

namespace rali::drive {

/// Sends a message as encoded for a radio. Errors: those of wire::encode_envelope.
[[nodiscard]] Status post(Loopback& link, Time now, const fleet::Envelope& envelope);

/// A message that has arrived and was decoded.
struct Received {
  Time t;
  VehicleId to;
  fleet::Envelope envelope;
};

struct Mail {
  std::vector<Received> received;  ///< by time of arrival
  std::size_t unreadable = 0;      ///< damaged, or of a newer program: dropped
};

[[nodiscard]] Mail collect(Loopback& link, Time now);

}  // namespace rali::drive
