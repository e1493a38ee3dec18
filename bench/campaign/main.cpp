// campaign --seeds 1-100 --out results.jsonl: one recording per seed is simulated, mapped and
// scored.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/command_line.hpp"
#include "common/words.hpp"
#include "mapping.hpp"
#include "rali/io/files/tum.hpp"
#include "record.hpp"

namespace rali::campaign {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string seeds = "1-10";
  std::string out = "campaign.jsonl";
  std::string block = "block";
  std::string build;
  std::string ranges = RALI_SOURCE_DIR "/bench/campaign/ranges.yaml";
  std::string keep;  ///< folder for the outputs of runs
  std::vector<std::string> assignments;
  std::string preset = "robust";
  int jobs = 2;
  int limit_s = 3600;
  bool table = false;
  bool describe = false;
};

double cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/// Vehicles may block each other; then the case is drawn again with another number.
Result<std::shared_ptr<const Recording>> recording_of(const Ranges& ranges, std::uint64_t seed) {
  constexpr std::uint64_t kTries = 20;
  Result<std::shared_ptr<const Recording>> last = fail(ErrorCode::kUsage, "", "no such case");
  for (std::uint64_t k = 0; k < kTries; ++k) {
    last = Recording::make(draw_case(ranges, seed + 1'000'000'007ULL * k), ranges);
    if (last) break;
  }
  return last;
}

/// Writes truth/<v>.tum to the kept outputs.
void write_truth(const Recording& recording, const std::string& folder) {
  fs::create_directories(folder + "/truth");
  for (const Track& track : recording.tracks()) {
    std::ofstream file(folder + "/truth/" + track.name + ".tum");
    for (const eval::StampedPose& p : track.truth) file << io::tum_line({p.t, p.T}) << '\n';
  }
}

RunRecord run_seed(const Arguments& a, const Ranges& ranges, std::uint64_t seed) {
  RunRecord record;
  record.seed = seed;
  record.block = a.block;
  record.build = a.build;
  record.ranges_hash = ranges.hash();
  const double start_s = cpu_s();
  const auto recording = recording_of(ranges, seed);
  if (!recording) {
    record.score.error = "no such case";
    return record;
  }
  const Case& c = (*recording)->description();
  record.scene = c.scene;
  record.plan = c.plan;
  record.priors = c.prior_kind;
  record.features.assign(c.features.begin(), c.features.end());
  record.vehicles = c.setup.fleet.vehicles;
  record.duration_s = seconds_between((*recording)->t_start(), (*recording)->t_end());
  record.cpu_simulated_s = cpu_s() - start_s;
  const fs::path folder =
      a.keep.empty() ? fs::temp_directory_path() / fmt::format("campaign_{}_{}", getpid(), seed)
                     : fs::path(a.keep) / fmt::format("{}", seed);
  fs::create_directories(folder);
  const auto summary = map_recording(*recording, {a.assignments, a.preset, folder.string()});
  record.cpu_mapped_s = cpu_s() - start_s - record.cpu_simulated_s;
  if (summary) {
    record.score = judge_run(**recording, *summary);
  } else {
    record.score.error = summary.error().message();
    record.score.solvable = judge_solvable(**recording);
  }
  if (!a.keep.empty()) write_truth(**recording, folder.string());
  if (a.keep.empty()) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  return record;
}

/// Runs each case in its own process, so that a crash is a result, too.
class Pool {
 public:
  Pool(const Arguments& arguments, const Ranges& ranges) : a_(arguments), ranges_(ranges) {}

  void run(const std::vector<std::uint64_t>& seeds) {
    std::size_t done = 0;
    for (const std::uint64_t seed : seeds) {
      while (running_.size() >= static_cast<std::size_t>(a_.jobs)) done += reap();
      start(seed);
      fmt::print(stderr, "\r{} of {} done", done, seeds.size());
    }
    while (!running_.empty()) done += reap();
    fmt::print(stderr, "\r{} of {} done\n", done, seeds.size());
  }

 private:
  struct Child {
    std::uint64_t seed;
    std::string file;
  };

  void start(std::uint64_t seed) {
    const std::string file = fmt::format("{}.{}.tmp", a_.out, seed);
    const pid_t pid = fork();
    if (pid == 0) {
      alarm(static_cast<unsigned>(a_.limit_s));
      const std::string line = to_json(run_seed(a_, ranges_, seed));
      std::ofstream(file) << line << '\n';
      _exit(0);
    }
    running_[pid] = {seed, file};
  }

  std::size_t reap() {
    int status = 0;
    const pid_t pid = wait(&status);
    const auto found = running_.find(pid);
    if (found == running_.end()) return 0;
    const Child child = found->second;
    running_.erase(found);
    std::string line;
    std::ifstream in(child.file);
    if (!std::getline(in, line)) {
      RunRecord record;
      record.seed = child.seed;
      record.block = a_.block;
      record.build = a_.build;
      record.ranges_hash = ranges_.hash();
      record.score.error = fmt::format("ended by signal {}", WTERMSIG(status));
      line = to_json(record);
    }
    std::ofstream(a_.out, std::ios::app) << line << '\n';
    std::error_code ignored;
    fs::remove(child.file, ignored);
    return 1;
  }

  const Arguments& a_;
  const Ranges& ranges_;
  std::map<pid_t, Child> running_;
};

int describe(const Arguments& a, const Ranges& ranges) {
  const auto seeds = bench::parse_seeds(a.seeds);
  if (!seeds) return 2;
  for (const std::uint64_t seed : *seeds) {
    const auto recording = recording_of(ranges, seed);
    if (!recording) {
      fmt::print("{}: {}\n", seed, recording.error().message());
      continue;
    }
    const Case& c = (*recording)->description();
    const Solvable solvable = judge_solvable(**recording);
    std::string features;
    for (const std::string& f : c.features) features += ", " + f;
    fmt::print("{}: {:.0f} s, alone {}, joint {}{}\n{}", seed, c.duration_s, solvable.alone,
               solvable.joint, features, fleet_text(**recording, a.preset));
    fmt::print("{}\n", scenario::dump_scene(c.setup, "."));
  }
  return 0;
}

int print_table(const Arguments& a) {
  const auto records = read_records(a.out);
  if (!records) {
    fmt::print(stderr, "campaign: {}\n", records.error().message());
    return 2;
  }
  fmt::print("{}", table_of(*records));
  return 0;
}

int run(const Arguments& a) {
  if (a.table) return print_table(a);
  const Result<Ranges> ranges = Ranges::load(a.ranges);
  const auto seeds = bench::parse_seeds(a.seeds);
  if (!ranges || !seeds) {
    fmt::print(stderr, "campaign: {}\n",
               !ranges ? ranges.error().message() : seeds.error().message());
    return 2;
  }
  if (a.describe) return describe(a, *ranges);
  std::set<std::uint64_t> done;
  if (const auto before = read_records(a.out)) {
    for (const RunRecord& r : *before) {
      if (r.block == a.block) done.insert(r.seed);
    }
  }
  std::vector<std::uint64_t> open;
  for (const std::uint64_t seed : *seeds) {
    if (!done.contains(seed)) open.push_back(seed);
  }
  constexpr double kCpuPerRun_s = 90.0;
  fmt::print(stderr, "{} runs, about {:.1f} CPU hours\n", open.size(),
             kCpuPerRun_s * static_cast<double>(open.size()) / 3600.0);
  Pool(a, *ranges).run(open);
  return print_table(a);
}

}  // namespace
}  // namespace rali::campaign

int main(int argc, char** argv) {
  rali::campaign::Arguments a;
  CLI::App app{"Simulates, maps and judges one recording per seed."};
  app.add_option("--seeds", a.seeds, "1,2,5-8");
  app.add_option("--out", a.out,
                 "results, one line per run; runs that are in it are not run again");
  app.add_option("--block", a.block, "name of this block of seeds");
  app.add_option("--build", a.build, "name of what is run");
  app.add_option("--ranges", a.ranges, "the generator's ranges");
  app.add_option("--keep", a.keep, "folder for the outputs of each run");
  app.add_option("--set", a.assignments, "settings of the mapping, KEY=VALUE");
  app.add_option("--preset", a.preset, "robust or paper");
  app.add_option("--jobs", a.jobs, "runs at a time");
  app.add_option("--limit", a.limit_s, "seconds after which a run counts as failed");
  app.add_flag("--table", a.table, "only prints the table of the results");
  app.add_flag("--describe", a.describe, "only says what the recordings are");
  if (const auto code = rali::bench::ended_by(app, argc, argv)) return *code;
  return rali::campaign::run(a);
}
