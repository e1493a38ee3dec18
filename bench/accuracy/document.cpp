#include "document.hpp"

#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "table.hpp"

namespace rali::accuracy {

std::string command_of(const std::vector<std::string>& words) {
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool silent = words[i] == "--cache" || words[i] == "--into" || words[i] == "--dump";
    if (silent) {
      ++i;
    } else {
      kept.push_back(words[i]);
    }
  }
  return fmt::format("accuracy {}", fmt::join(kept, " "));
}

std::string short_table(const std::vector<Scores>& runs) {
  return table_of(runs, {"APE rmse m", "APE max m", "z rmse m", "end m", "RPE 10 m m", "NEES 6",
                         "in 95 %", "CPU ms", "p99 ms", "peak MB"});
}

Status write_into(const std::string& path, const std::string& name, const std::string& text) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(ErrorCode::kInput, path, "this file cannot be read");
  const std::string old{std::istreambuf_iterator<char>(in), {}};
  const std::string begin = fmt::format("<!-- accuracy {} -->\n", name);
  const std::size_t from = old.find(begin);
  const std::size_t to = from == std::string::npos ? from : old.find("<!-- end -->", from);
  if (to == std::string::npos) {
    return fail(
        ErrorCode::kInput, path,
        fmt::format("the lines '<!-- accuracy {} -->' and '<!-- end -->' are not in it", name),
        "Put them where the table shall stand.");
  }
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << old.substr(0, from + begin.size()) << '\n' << text << '\n' << old.substr(to);
  out.flush();
  if (!out) return fail(ErrorCode::kInput, path, "this file cannot be written");
  return {};
}

}  // namespace rali::accuracy
