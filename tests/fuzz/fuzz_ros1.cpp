// Any text as the definition of a ROS 1 type (up to the first NUL), any bytes behind it as a
// message of that type. Also as CDR with its stamps shifted there and back.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "rali/wire/ros1_to_cdr.hpp"
#include "rali/wire/shift_stamps.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace rali;
  const auto* end = std::find(data, data + size, std::uint8_t{0});
  const std::string_view definition(reinterpret_cast<const char*>(data),
                                    static_cast<std::size_t>(end - data));
  const std::size_t rest = size - definition.size();
  const auto message = std::as_bytes(std::span(data + definition.size(), rest)).subspan(rest > 0);
  const auto convert = wire::Ros1ToCdr::make("p/A", definition);
  if (convert) {
    const auto cdr = convert->convert(message);
    // Each byte of a message needs at most eight with padding, and an empty one takes one byte.
    if (cdr && cdr->size() > 64 + 16 * message.size()) std::abort();
  }
  for (const auto kind : {wire::MessageKind::kTf, wire::MessageKind::kLivoxCustom,
                          wire::MessageKind::kImu, wire::MessageKind::kLinktrack}) {
    wire::Bytes shifted(message.begin(), message.end());
    static_cast<void>(wire::shift_stamps(kind, "p/LinktrackNodeframe2",
                                         Duration::from_ns(1'500'000'000), shifted));
    if (shifted.size() != message.size()) std::abort();
  }
  return 0;
}
