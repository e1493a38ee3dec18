#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>

#include "arguments.hpp"
#include "common/command_line.hpp"
#include "common/document.hpp"
#include "pair_chain.hpp"
#include "slam_table.hpp"

namespace rali::ranges_bench {
namespace {

std::filesystem::path data_folder(const Arguments& a) {
  if (!a.data_dir.empty()) return a.data_dir;
  const char* from_user = std::getenv("RALI_DATA_DIR");
  return from_user != nullptr ? from_user : RALI_DATA_DIR;
}

bool wanted(const Arguments& a, const std::string& name) {
  return name.find(a.only) != std::string::npos;
}

/// Returns false and prints a clear message if the folder does not exist.
bool there(const std::filesystem::path& folder) {
  if (std::filesystem::is_directory(folder)) return true;
  fmt::print(stderr, "NO DATA, NOT MEASURED: {} is not there; --data or RALI_DATA_DIR says where\n",
             folder.string());
  return false;
}

Result<std::string> pair_part(const Arguments& a, const std::filesystem::path& folder) {
  auto sets = read_pair_sets(folder);
  if (!sets) return tl::make_unexpected(sets.error());
  std::erase_if(*sets, [&a](const PairSet& set) { return !wanted(a, set.name); });
  return sets->empty() ? std::string() : pair_tables(*sets);
}

Result<std::string> slam_part(const Arguments& a, const std::filesystem::path& folder) {
  auto problems = read_problems(folder);
  if (!problems) return tl::make_unexpected(problems.error());
  std::vector<SlamScores> scores;
  for (const SlamProblem& problem : *problems) {
    if (!wanted(a, problem.name)) continue;
    auto s = run_problem(problem);
    if (!s) return tl::make_unexpected(s.error());
    fmt::print(stderr, "{}: {:.3f} m alone, {:.3f} m with ranges\n", s->name, s->ape_odometry_m,
               s->ape_batch_m);
    scores.push_back(std::move(*s));
  }
  return scores.empty() ? std::string() : slam_table(scores);
}

/// Exit code: 0 done, 1 a part could not be measured, 2 wrong arguments.
int main_with(const Arguments& a) {
  const std::filesystem::path data = data_folder(a);
  std::string text;
  bool all_done = true;
  const auto add = [&](const char* name, auto part) {
    const std::filesystem::path folder = data / name;
    if (!there(folder)) {
      all_done = false;
      return;
    }
    const Result<std::string> table = part(a, folder);
    if (!table) {
      fmt::print(stderr, "{}\n", table.error().message());
      all_done = false;
      return;
    }
    text += (text.empty() || table->empty() ? "" : "\n") + *table;
  };
  if (a.pairs) add("uwb_pairs", pair_part);
  if (a.slam) add("range_slam", slam_part);
  fmt::print("{}", text);
  if (a.into.empty() || !all_done) return all_done ? 0 : 1;
  const std::string command = bench::command_of("ranges", a.words, {"--data", "--into"});
  const Status written = bench::write_into(a.into, "ranges", command, text);
  return written ? 0 : bench::wrong(written);
}

}  // namespace
}  // namespace rali::ranges_bench

int main(int argc, char** argv) {
  const auto arguments = rali::ranges_bench::parse_arguments(argc, argv);
  return arguments ? rali::ranges_bench::main_with(*arguments) : arguments.error();
}
