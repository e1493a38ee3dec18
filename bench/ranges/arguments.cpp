#include "arguments.hpp"

#include <fmt/format.h>

namespace rali::ranges_bench {

Result<Arguments> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  a.words.assign(argv + 1, argv + argc);
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      a.help = true;
      return a;
    }
    if (name == "--pairs") {
      a.slam = false;
      continue;
    }
    if (name == "--slam") {
      a.pairs = false;
      continue;
    }
    const bool known = name == "--data" || name == "--only" || name == "--into";
    if (!known) {
      return fail(ErrorCode::kUsage, {}, fmt::format("there is no option \"{}\"", name),
                  "--help lists the options.");
    }
    if (i + 1 == argc) return fail(ErrorCode::kUsage, name, "this option needs a value");
    (name == "--data" ? a.data_dir : name == "--only" ? a.only : a.into) = argv[++i];
  }
  if (!a.pairs && !a.slam) {
    return fail(ErrorCode::kUsage, {}, "--pairs and --slam leave nothing together");
  }
  return a;
}

std::string help_text() {
  return "ranges: recorded ranges through room ranging and the local graph, as tables\n"
         "  --data DIR        holds uwb_pairs and range_slam; default: RALI_DATA_DIR\n"
         "  --pairs           only pairs of antennas with true distances\n"
         "  --slam            only tracks with odometry and ranges\n"
         "  --only TEXT       sets and tracks with this in their name\n"
         "  --into FILE:NAME  the tables also between '<!-- ranges NAME -->' and '<!-- end -->'\n"
         "                    of a Markdown file\n";
}

}  // namespace rali::ranges_bench
