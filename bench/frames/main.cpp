#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/document.hpp"
#include "parts.hpp"

namespace rali::frames_bench {
namespace {

constexpr const char* kHelp =
    "frames: frames between vehicles, as tables\n"
    "  geometries N      the geometries of algorithms_fleet 7.2, N runs each\n"
    "  starts N          N random starts of fleets, with and without prior\n"
    "  recorded          recorded fleets with unknown start frames\n"
    "  --data DIR        holds range_slam; default: RALI_DATA_DIR\n"
    "  --into FILE:NAME  the table also between '<!-- frames NAME -->' and '<!-- end -->'\n";

struct Arguments {
  std::string part, data_dir, into;
  int number = 0;
  std::vector<std::string> words;
};

Result<Arguments> parse(int argc, const char* const* argv) {
  Arguments a;
  a.words.assign(argv + 1, argv + argc);
  for (std::size_t i = 0; i < a.words.size(); ++i) {
    const std::string& word = a.words[i];
    const bool has_value = i + 1 < a.words.size();
    if (word == "recorded") {
      a.part = word;
    } else if ((word == "geometries" || word == "starts") && has_value) {
      a.part = word;
      a.number = std::atoi(a.words[++i].c_str());
      if (a.number < 1 || a.number > 100000) {
        return fail(ErrorCode::kUsage, word, "the number must be 1 to 100000");
      }
    } else if ((word == "--data" || word == "--into") && has_value) {
      (word == "--data" ? a.data_dir : a.into) = a.words[++i];
    } else {
      return fail(ErrorCode::kUsage, word, "this is no part or option, or lacks its value");
    }
  }
  if (a.part.empty()) return fail(ErrorCode::kUsage, {}, "say which part");
  return a;
}

Result<std::string> table(const Arguments& a) {
  if (a.part == "geometries") return geometry_table(a.number);
  if (a.part == "starts") return start_table(a.number);
  const char* from_user = std::getenv("RALI_DATA_DIR");
  const std::filesystem::path data = !a.data_dir.empty()    ? a.data_dir
                                     : from_user != nullptr ? from_user
                                                            : RALI_DATA_DIR;
  if (!std::filesystem::is_directory(data / "range_slam")) {
    return fail(ErrorCode::kInput, data.string(), "NO DATA, NOT MEASURED: range_slam is not there",
                "--data or RALI_DATA_DIR says where.");
  }
  return recorded_table(data / "range_slam");
}

int main_with(const Arguments& a) {
  const auto text = table(a);
  if (!text) {
    fmt::print(stderr, "{}\n", text.error().message());
    return 1;
  }
  fmt::print("{}", *text);
  if (a.into.empty()) return 0;
  const std::size_t colon = a.into.rfind(':');
  const std::string command = bench::command_of("frames", a.words, {"--data", "--into"});
  const Status written = bench::write_into(
      a.into.substr(0, colon), "frames", colon == std::string::npos ? "" : a.into.substr(colon + 1),
      fmt::format("    {}\n\n{}", command, *text));
  if (!written) fmt::print(stderr, "{}\n", written.error().message());
  return written ? 0 : 2;
}

}  // namespace
}  // namespace rali::frames_bench

int main(int argc, char** argv) {
  const auto arguments = rali::frames_bench::parse(argc, argv);
  if (!arguments) {
    fmt::print(stderr, "{}\n{}", arguments.error().message(), rali::frames_bench::kHelp);
    return 2;
  }
  return rali::frames_bench::main_with(*arguments);
}
