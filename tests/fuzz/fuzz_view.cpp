// Any messages as those of a viewer: no crash, no hang, no more memory than the limits allow. Bytes
// 0xFF separate the messages; the same bytes are read as a command and as an address.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "rali/base/assert.hpp"
#include "rali/view/internal/access.hpp"
#include "rali/view/internal/viewer_channels.hpp"
#include "rali/view/view_client.hpp"

namespace {

using namespace rali::view;

void publish(Exchange& exchange, Hub& hub, std::uint32_t channel, std::size_t bytes) {
  auto frame = std::make_shared<Frame>();
  *frame = {channel, rali::Time{7}, std::vector<std::uint8_t>(bytes)};
  exchange.inbox.push(std::move(frame));
  hub.take_over();
}

void view(std::string_view text) {
  Exchange exchange(1000);
  Hub hub(exchange, "", 1000);
  exchange.new_channels = {{1, {"/a", "json", "", "", "", true}},
                           {2, {"/b", "json", "", "", "", false}}};
  hub.take_over();
  publish(exchange, hub, 1, 10);
  ViewerChannels viewer(hub);
  while (!text.empty() && !viewer.too_many_bad()) {
    const std::size_t end = std::min(text.find('\xFF'), text.size());
    const auto answers = viewer.take(text.substr(0, end), text.front() == '\0');
    RALI_ASSERT(answers.size() <= 1);
    text.remove_prefix(std::min(end + 1, text.size()));
    for (std::uint32_t channel : {1U, 2U}) {
      auto frame = std::make_shared<Frame>();
      *frame = {channel, rali::Time{8}, std::vector<std::uint8_t>(300)};
      viewer.offer(frame);
    }
    RALI_ASSERT(viewer.subscriptions() <= 2 && viewer.waiting().bytes() <= 1000);
  }
  while (viewer.next()) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  view(text);
  const auto order = parse_order(text);
  if (order) RALI_ASSERT(!order->command.empty() && order->vehicle.size() <= kVehicleNameMax);
  const std::string_view name = choose_subprotocol(text);
  RALI_ASSERT(name.empty() || text.find(name) != std::string_view::npos);
  RALI_ASSERT(access_of({.from_loopback = false,
                         .websocket = true,
                         .target = text,
                         .authorization = text,
                         .host = text,
                         .origin = text},
                        "a token that no input holds: \xC3\x28") != Access::kGranted ||
              text.find("a token that no input holds: \xC3\x28") != std::string_view::npos);
  const auto address = parse_view_address(text.substr(0, 300));
  if (address) RALI_ASSERT(!address->host.empty() && address->port > 0);
  return 0;
}
