#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "rali/base/test_folder.hpp"
#include "rali/factlog/record.hpp"

namespace rali::factlog {

inline Bytes bytes_in(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  Bytes out;
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
  return out;
}

inline void write_bytes(const std::string& path, const Bytes& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
}

/// A body that differs between records.
inline Bytes body_of(std::uint32_t seq, std::size_t bytes) {
  Bytes body;
  for (std::size_t k = 0; k < bytes; ++k) {
    body.push_back(static_cast<std::byte>((seq * 31U + k * 7U) & 0xFFU));
  }
  return body;
}

inline RecordKey key_of(std::uint32_t seq) { return {VehicleId{3}, 2, seq}; }

}  // namespace rali::factlog
