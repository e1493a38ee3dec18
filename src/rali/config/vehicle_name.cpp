#include "rali/config/vehicle_name.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace rali::config {
namespace {

constexpr std::size_t kCharactersMax = 32;

/// One character: its bytes and its code point, 0 if they are not UTF-8.
struct Character {
  std::string_view bytes;
  std::uint32_t code = 0;
};

/// Shortest form only, no surrogates (RFC 3629).
std::uint32_t decoded(std::string_view bytes) {
  constexpr std::array<std::uint32_t, 5> kMin = {0, 0, 0x80, 0x800, 0x10000};
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  std::uint32_t code = byte(0) & (0xFFU >> (bytes.size() + 1));
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  return code < kMin[bytes.size()] || code > 0x10FFFF || surrogate ? 0 : code;
}

Character first_of(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  if (lead < 0x80) return {text.substr(0, 1), lead};
  const std::size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || size > text.size()) return {text.substr(0, 1), 0};
  const std::string_view bytes = text.substr(0, size);
  const std::uint32_t code = decoded(bytes);
  return code == 0 ? Character{text.substr(0, 1), 0} : Character{bytes, code};
}

/// Invisible, or a space of some kind.
bool is_unseen(std::uint32_t code) {
  struct Range {
    std::uint32_t first, last;
  };

  constexpr std::array<Range, 11> kUnseen = {{{0x80, 0xA0},
                                              {0xAD, 0xAD},
                                              {0x1680, 0x1680},
                                              {0x180E, 0x180E},
                                              {0x2000, 0x200F},
                                              {0x2028, 0x202F},
                                              {0x205F, 0x206F},
                                              {0x3000, 0x3000},
                                              {0xFEFF, 0xFEFF},
                                              {0xFFF0, 0xFFFF},
                                              {0xE0000, 0x10FFFF}}};
  return std::any_of(kUnseen.begin(), kUnseen.end(),
                     [code](const Range& r) { return code >= r.first && code <= r.last; });
}

bool may_stand(std::uint32_t code) {
  if (code >= 0x80) return !is_unseen(code);
  const auto c = static_cast<char>(code);
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

}  // namespace

bool is_vehicle_name(std::string_view name) {
  if (name.empty() || name.front() == '-') return false;
  std::size_t characters = 0;
  while (!name.empty()) {
    const Character c = first_of(name);
    if (c.code == 0 || !may_stand(c.code) || ++characters > kCharactersMax) return false;
    name.remove_prefix(c.bytes.size());
  }
  return true;
}

std::string vehicle_name_from(std::string_view text) {
  std::string name;
  for (std::size_t n = 0; !text.empty() && n < kCharactersMax; ++n) {
    const Character c = first_of(text);
    const bool stands = c.code != 0 && may_stand(c.code) && !(n == 0 && c.code == '-');
    name += stands ? c.bytes : std::string_view("_");
    text.remove_prefix(c.bytes.size());
  }
  return name.empty() ? "v1" : name;
}

}  // namespace rali::config
