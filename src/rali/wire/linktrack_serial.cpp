#include "rali/wire/linktrack_serial.hpp"

#include <array>
#include <cstring>

// Layouts: Nooploop's "NLink protocol" and its public unpackers (nlink_unpack: header 0x55, a byte
// with the frame type, little endian; the last byte is the sum of all before it).
namespace rali::wire {
namespace {

using View = std::span<const std::byte>;

constexpr std::uint8_t kHeader = 0x55, kTagframe0 = 0x01;
constexpr std::size_t kTagframe0Bytes = 128, kLengthEnd = 4;
constexpr double kMetresPerCount = 0.001, kDbmPerCount = -0.5;

/// Layout of a frame with a list of nodes.
struct Layout {
  std::uint8_t function;
  std::size_t fixed_bytes;  ///< the last of them is the node count
  std::size_t node_bytes;
  std::size_t local_time, system_time;
  bool wide_ids;  ///< 32 bits
};

constexpr std::array<Layout, 3> kLayouts = {
    {{0x04, 119, 13, 102, 6, false}, {0x05, 21, 7, 6, 10, false}, {0x08, 24, 10, 9, 13, true}}};

/// Nodeframe0, 1, 4, 6: without ranges, but their length is needed to skip them.
constexpr std::array<std::uint8_t, 4> kOtherFunctions = {0x02, 0x03, 0x06, 0x07};

template <class T>
T at(View bytes, std::size_t offset) {
  T value{};
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

double signed_24(View bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    value |= std::to_integer<std::uint32_t>(bytes[offset + k]) << (8 * k);
  }
  const bool negative = (value & 0x800000U) != 0;
  return static_cast<double>(value) - (negative ? 16777216.0 : 0.0);
}

bool has_checksum(View frame) {
  std::uint8_t sum = 0;
  for (const std::byte b : frame.first(frame.size() - 1)) {
    sum = static_cast<std::uint8_t>(sum + std::to_integer<std::uint8_t>(b));
  }
  return sum == std::to_integer<std::uint8_t>(frame.back());
}

const Layout* layout_of(std::uint8_t function) {
  for (const Layout& layout : kLayouts) {
    if (layout.function == function) return &layout;
  }
  return nullptr;
}

bool is_other(std::uint8_t function) {
  for (const std::uint8_t other : kOtherFunctions) {
    if (function == other) return true;
  }
  return false;
}

void add_range(LinktrackFrame& frame, const LinktrackNode& node) {
  if (node.range_m > 0.0) {
    frame.nodes.push_back(node);
  } else {
    ++frame.zeros;
  }
}

double dbm(View bytes, std::size_t offset) {
  const auto count = at<std::uint8_t>(bytes, offset);
  return count == 0 ? 0.0 : kDbmPerCount * count;
}

LinktrackFrame nodes_of(View bytes, const Layout& layout) {
  LinktrackFrame frame;
  frame.role = at<std::uint8_t>(bytes, 4);
  frame.id = layout.wide_ids ? at<std::uint32_t>(bytes, 5) : at<std::uint8_t>(bytes, 5);
  frame.local_time_ms = at<std::uint32_t>(bytes, layout.local_time);
  frame.system_time_ms = at<std::uint32_t>(bytes, layout.system_time);
  const std::size_t count = at<std::uint8_t>(bytes, layout.fixed_bytes - 1);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t node_at = layout.fixed_bytes + i * layout.node_bytes;
    const std::size_t after_id = node_at + (layout.wide_ids ? 5 : 2);
    LinktrackNode node;
    node.role = at<std::uint8_t>(bytes, node_at);
    node.id = layout.wide_ids ? at<std::uint32_t>(bytes, node_at + 1)
                              : at<std::uint8_t>(bytes, node_at + 1);
    node.range_m = kMetresPerCount * signed_24(bytes, after_id);
    node.fp_rssi_dbm = dbm(bytes, after_id + 3);
    node.rx_rssi_dbm = dbm(bytes, after_id + 4);
    add_range(frame, node);
  }
  return frame;
}

LinktrackFrame tag_of(View bytes) {
  LinktrackFrame frame;
  frame.id = at<std::uint8_t>(bytes, 2);
  frame.role = at<std::uint8_t>(bytes, 3);
  frame.local_time_ms = at<std::uint32_t>(bytes, 108);
  frame.system_time_ms = at<std::uint32_t>(bytes, 112);
  for (std::uint32_t i = 0; i < 8; ++i) {
    LinktrackNode node;
    node.id = i;
    node.range_m = kMetresPerCount * signed_24(bytes, 22 + 3 * std::size_t{i});
    add_range(frame, node);
  }
  return frame;
}

enum class Verdict { kFrame, kIncomplete, kNone };

struct Candidate {
  Verdict verdict = Verdict::kNone;
  std::size_t bytes = 0;  ///< of the frame, once it is known
};

/// Whether a frame starts here, by its first bytes and lengths.
Candidate look(View rest) {
  if (at<std::uint8_t>(rest, 0) != kHeader) return {};
  if (rest.size() < kLengthEnd) return {Verdict::kIncomplete, 0};
  const auto function = at<std::uint8_t>(rest, 1);
  std::size_t bytes = kTagframe0Bytes;
  if (function != kTagframe0) {
    bytes = at<std::uint16_t>(rest, 2);
    const Layout* layout = layout_of(function);
    if (layout == nullptr && !is_other(function)) return {};
    if (bytes <= kLengthEnd) return {};
    if (layout != nullptr) {
      if (rest.size() < layout->fixed_bytes) return {Verdict::kIncomplete, 0};
      const std::size_t nodes = at<std::uint8_t>(rest, layout->fixed_bytes - 1);
      if (bytes != layout->fixed_bytes + nodes * layout->node_bytes + 1) return {};
    } else if (bytes > 4096) {
      return {};  // no frame of the protocol is that long
    }
  }
  return {rest.size() < bytes ? Verdict::kIncomplete : Verdict::kFrame, bytes};
}

}  // namespace

void LinktrackStream::push(std::span<const std::byte> bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
  at_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void LinktrackStream::skip_byte() {
  ++at_;
  ++tally_.bytes_skipped;
}

std::optional<LinktrackFrame> LinktrackStream::next(bool ended) {
  while (at_ < buffer_.size()) {
    const Candidate candidate = look(rest());
    if (candidate.verdict == Verdict::kIncomplete && !ended) return std::nullopt;
    if (candidate.verdict != Verdict::kFrame) {
      skip_byte();
      continue;
    }
    const View frame = rest().first(candidate.bytes);
    if (!has_checksum(frame)) {
      ++tally_.bad_checksums;
      skip_byte();
      continue;
    }
    const auto function = at<std::uint8_t>(frame, 1);
    const Layout* layout = layout_of(function);
    at_ += candidate.bytes;  // the bytes themselves stay until the next push
    if (layout == nullptr && function != kTagframe0) {
      ++tally_.other_frames;
      continue;
    }
    ++tally_.frames;
    return layout != nullptr ? nodes_of(frame, *layout) : tag_of(frame);
  }
  return std::nullopt;
}

}  // namespace rali::wire
