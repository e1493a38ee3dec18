#include "common/words.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace rali::bench {

namespace {

constexpr std::size_t kSeedsMax = 1000;

Result<std::uint64_t> whole(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    return fail(ErrorCode::kUsage, {}, fmt::format("\"{}\" is no whole number", text));
  }
  return value;
}

}  // namespace

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> out;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end > begin) out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

Result<std::vector<std::uint64_t>> parse_seeds(const std::string& text) {
  std::vector<std::uint64_t> seeds;
  for (const std::string& part : split(text)) {
    const std::size_t dash = part.find('-');
    const auto first = whole(part.substr(0, dash));
    const auto last = dash == std::string::npos ? first : whole(part.substr(dash + 1));
    if (!first) return tl::make_unexpected(first.error());
    if (!last) return tl::make_unexpected(last.error());
    for (std::uint64_t s = *first; s <= *last && seeds.size() < kSeedsMax; ++s) seeds.push_back(s);
  }
  if (seeds.empty()) return fail(ErrorCode::kUsage, "--seeds", "there is no seed in the list");
  return seeds;
}

}  // namespace rali::bench
