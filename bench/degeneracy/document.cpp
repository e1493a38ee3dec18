#include "document.hpp"

#include <fstream>
#include <iterator>

#include <fmt/format.h>

namespace rali::blindness {

std::string command_of(const std::vector<std::string>& words) {
  std::string out = "degeneracy";
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--json" || words[i] == "--into") {
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

Status write_into(const std::string& target, const std::string& text) {
  const std::size_t colon = target.rfind(':');
  if (colon == std::string::npos) {
    return fail(ErrorCode::kUsage, "--into", "is not FILE:NAME");
  }
  const std::string path = target.substr(0, colon);
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorCode::kInput, path, "this file cannot be read");
  const std::string old{std::istreambuf_iterator<char>(in), {}};
  const std::string begin = fmt::format("<!-- degeneracy {} -->\n", target.substr(colon + 1));
  const std::size_t from = old.find(begin);
  const std::size_t to = from == std::string::npos ? from : old.find("<!-- end -->", from);
  if (to == std::string::npos) {
    return fail(ErrorCode::kInput, path,
                fmt::format("the lines '{}' and '<!-- end -->' are not in it",
                            begin.substr(0, begin.size() - 1)),
                "Put them where the tables shall stand.");
  }
  return write_file(path, old.substr(0, from + begin.size()) + "\n" + text + "\n" + old.substr(to));
}

}  // namespace rali::blindness
