#include "rali/net/internal/node_info.hpp"

#include <span>

#include "rali/wire/byte_writer.hpp"

namespace rali::net {
namespace {

/// char[16] or char[24], zero-padded after the 16 bytes of DDS.
void put_gid(wire::ByteWriter& out, const Gid& gid, int gid_bytes) {
  for (int i = 0; i < gid_bytes; ++i) {
    const auto at = static_cast<std::size_t>(i);
    out.put(at < gid.size() ? gid[at] : std::uint8_t{0});
  }
}

void put_gids(wire::ByteWriter& out, const std::vector<Gid>& gids, int gid_bytes) {
  out.sequence(gids.size());
  for (const Gid& gid : gids) put_gid(out, gid, gid_bytes);
}

}  // namespace

std::vector<std::uint8_t> encode_node_info(const NodeInfo& info, int gid_bytes) {
  wire::ByteWriter out(wire::Encoding::kCdr);
  put_gid(out, info.participant, gid_bytes);
  out.sequence(1);  // nodes
  out.string(info.node_namespace);
  out.string(info.node_name);
  put_gids(out, info.readers, gid_bytes);
  put_gids(out, info.writers, gid_bytes);
  const wire::Bytes bytes = out.take();
  const auto* raw = reinterpret_cast<const std::uint8_t*>(bytes.data());
  return {raw, raw + bytes.size()};
}

}  // namespace rali::net
