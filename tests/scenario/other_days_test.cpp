// Two recordings of one yard, a day apart: `clock: separate` joins them by places alone.

#include <iomanip>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rali/cli/run_for_test.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::cli {
namespace {

constexpr double kDay_s = 86400.0;

/// A trajectory (TUM) with all stamps a day later.
std::string a_day_later(const std::string& tum) {
  std::istringstream lines(tum);
  std::ostringstream out;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.find(' ');
    if (line.starts_with('#')) {
      out << line << '\n';
    } else {
      out << std::fixed << std::setprecision(9) << std::stod(line.substr(0, space)) + kDay_s
          << line.substr(space) << '\n';
    }
  }
  return out.str();
}

TEST(OtherDays, are_joined_by_places_alone) {
  const io::TestFolder folder;
  const Outcome made = run_rali({"simulate", "yard", "-o", folder.path("sim"), "--vehicles", "2",
                                 "--duration", "60", "--seed", "5", "--no-priors", "-q"});
  ASSERT_EQ(made.code, kExitDone) << made.err;
  folder.write("sim/truth/v2.tum", a_day_later(folder.read("sim/truth/v2.tum")));
  const Outcome run =
      run_rali({"map", folder.path("sim/fleet.yaml"), "-o", folder.path("out"), "--set",
                "clock=separate", "--set", "vehicles.v2.clock_offset_s=86400", "-q", "--no-mcap",
                "--no-report", "--formats", "ply"});
  ASSERT_EQ(run.code, kExitDone) << run.err;
  const auto metrics = nlohmann::json::parse(folder.read("out/metrics.json"));
  EXPECT_EQ(metrics["fleet"]["groups"].size(), 1U);
  EXPECT_EQ(metrics["ranges"]["used"], 0) << "none between two days";
  const Outcome judged = run_rali({"evaluate", folder.path("out"), "--truth",
                                   folder.path("sim/truth"), "--limit", "ape_rmse_m=0.02", "-q"});
  EXPECT_EQ(judged.code, kExitDone) << "one alignment for both days\n" << judged.out << judged.err;
}

}  // namespace
}  // namespace rali::cli
