#include "common/document.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

namespace rali::bench {

std::string command_of(const std::string& program, const std::vector<std::string>& words,
                       const std::vector<std::string>& silent) {
  std::string out = program;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (std::find(silent.begin(), silent.end(), words[i]) != silent.end()) {
      ++i;
    } else {
      out += " " + words[i];
    }
  }
  return out;
}

Status write_file(const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << text;
  out.flush();
  if (!out) return fail(ErrorCode::kInput, path, "this file cannot be written");
  return {};
}

Status write_into(const std::string& into, const std::string& program, const std::string& command,
                  const std::string& tables) {
  const std::size_t colon = into.rfind(':');
  if (colon == std::string::npos) return fail(ErrorCode::kUsage, "--into", "is not FILE:NAME");
  const std::string path = into.substr(0, colon), name = into.substr(colon + 1);
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorCode::kInput, path, "this file cannot be read");
  const std::string old{std::istreambuf_iterator<char>(in), {}};
  const std::string begin = fmt::format("<!-- {} {} -->\n", program, name);
  const std::size_t from = old.find(begin);
  const std::size_t to = from == std::string::npos ? from : old.find("<!-- end -->", from);
  if (to == std::string::npos) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("the lines '<!-- {} {} -->' and '<!-- end -->' are not in it", program, name),
        "Put them where the table shall stand.");
  }
  const std::string text = fmt::format("\n    {}\n\n{}\n", command, tables);
  return write_file(path, old.substr(0, from + begin.size()) + text + old.substr(to));
}

}  // namespace rali::bench
