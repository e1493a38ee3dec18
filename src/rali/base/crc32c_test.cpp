#include "rali/base/crc32c.hpp"

#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace rali {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST(Crc32c, of_123456789_matches_the_standard_check_value) {
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283U);
  EXPECT_EQ(crc32c({}), 0U);
}

// RFC 3720, B.4.
TEST(Crc32c, of_32_bytes_00_and_32_bytes_ff_matches_the_standard) {
  EXPECT_EQ(crc32c(std::vector<std::byte>(32, std::byte{0})), 0x8A9136AAU);
  EXPECT_EQ(crc32c(std::vector<std::byte>(32, std::byte{0xFF})), 0x62A8AB43U);
}

TEST(Crc32c, is_independent_of_how_the_input_is_split) {
  std::vector<std::byte> bytes;
  for (unsigned k = 0; k < 41; ++k) bytes.push_back(static_cast<std::byte>(k * 37U));
  const std::span<const std::byte> all(bytes);
  const std::uint32_t whole = crc32c(all);
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    EXPECT_EQ(crc32c(all.subspan(cut), crc32c(all.first(cut))), whole) << cut;
  }
}

}  // namespace
}  // namespace rali
