#include "document.hpp"

#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace rali::ranges_bench {

std::string command_of(const std::vector<std::string>& words) {
  std::vector<std::string> kept{"ranges"};
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--data" || words[i] == "--into") {
      ++i;
    } else {
      kept.push_back(words[i]);
    }
  }
  return fmt::format("{}", fmt::join(kept, " "));
}

Status write_into(const std::string& into, const std::string& text) {
  const std::size_t colon = into.rfind(':');
  const std::string path = into.substr(0, colon);
  const std::string name = colon == std::string::npos ? "" : into.substr(colon + 1);
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorCode::kInput, path, "this file cannot be read");
  const std::string old{std::istreambuf_iterator<char>(in), {}};
  const std::string begin = fmt::format("<!-- ranges {} -->\n", name);
  const std::size_t from = old.find(begin);
  const std::size_t to = from == std::string::npos ? from : old.find("<!-- end -->", from);
  if (to == std::string::npos) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("the lines '<!-- ranges {} -->' and '<!-- end -->' are not in it", name),
        "Put them where the tables shall stand.");
  }
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << old.substr(0, from + begin.size()) << '\n' << text << '\n' << old.substr(to);
  out.flush();
  if (!out) return fail(ErrorCode::kInput, path, "this file cannot be written");
  return {};
}

}  // namespace rali::ranges_bench
