#include "arguments.hpp"

#include "common/command_line.hpp"

namespace rali::ranges_bench {

tl::expected<Arguments, int> parse_arguments(int argc, const char* const* argv) {
  Arguments a;
  a.words.assign(argv + 1, argv + argc);
  CLI::App app("ranges: recorded ranges through room ranging and the local graph, as tables");
  app.add_option("--data", a.data_dir, "holds uwb_pairs and range_slam; default: RALI_DATA_DIR");
  auto* pairs = app.add_flag_callback(
      "--pairs", [&a] { a.slam = false; }, "only pairs of antennas with true distances");
  app.add_flag_callback(
         "--slam", [&a] { a.pairs = false; }, "only tracks with odometry and ranges")
      ->excludes(pairs);
  app.add_option("--only", a.only, "sets and tracks with this in their name");
  bench::add_into(app, "ranges", a.into);
  if (const auto code = bench::ended_by(app, argc, argv)) return tl::make_unexpected(*code);
  return a;
}

}  // namespace rali::ranges_bench
