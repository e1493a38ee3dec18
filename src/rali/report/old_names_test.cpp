#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "rali/report/internal/test_run.hpp"
#include "rali/report/read_run.hpp"

namespace rali::report {
namespace {

/// Rewrites a file with the names of version 0.1.
void rename_in(const io::TestFolder& folder, const std::string& file,
               const std::vector<std::pair<std::string, std::string>>& names) {
  std::string text = folder.read(file);
  for (const auto& [name, old_name] : names) {
    const std::size_t at = text.find(name);
    ASSERT_NE(at, std::string::npos) << file << " has no " << name;
    for (std::size_t i = at; i != std::string::npos; i = text.find(name, i + old_name.size())) {
      text.replace(i, name.size(), old_name);
    }
  }
  folder.write(file, text);
}

TEST(OldRun, is_read_like_a_run_with_current_names) {
  const io::TestFolder today, old;
  TestRun run;
  run.vehicles = test_names(2);
  run.fleet = run.truth = true;
  write_test_run(today, run);
  write_test_run(old, run);
  rename_in(old, "metrics.json",
            {{"\"scans\"", "\"sweeps\""},
             {"\"scans_dropped\"", "\"sweeps_dropped\""},
             {"\"degenerate_fraction\"", "\"blind_share\""},
             {"\"degenerate_constrained_fraction\"", "\"blind_held_share\""},
             {"\"t_start_s\"", "\"t_begin_s\""}});
  rename_in(old, "degeneracy/v2.csv",
            {{"sigma_degenerate_m", "sigma_blind_m"},
             {",degenerate,", ",blind,"},
             {"constrained_by", "held_by"}});
  rename_in(old, "evaluation.json",
            {{"\"degenerate\"", "\"blind\""}, {"\"fraction_within_95\"", "\"share_within_95\""}});
  const auto a = read_run(today.path()), b = read_run(old.path());
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->duration_s, b->duration_s);
  ASSERT_EQ(b->vehicles.size(), 2U);
  const VehicleView &x = a->vehicles[1], &y = b->vehicles[1];
  EXPECT_TRUE(y.numbers.scans && y.numbers.degenerate_fraction &&
              y.numbers.degenerate_held_fraction);
  EXPECT_EQ(x.numbers.scans, y.numbers.scans);
  EXPECT_EQ(x.numbers.degenerate_fraction, y.numbers.degenerate_fraction);
  ASSERT_EQ(x.degenerate.size(), y.degenerate.size());
  ASSERT_EQ(x.degeneracy.size(), y.degeneracy.size());
  EXPECT_EQ(x.degeneracy[90].held_by, y.degeneracy[90].held_by);
  ASSERT_EQ(a->evaluation.size(), b->evaluation.size());
  for (std::size_t i = 0; i < a->evaluation.size(); ++i) {
    EXPECT_EQ(a->evaluation[i].key, b->evaluation[i].key);
  }
}

TEST(OldRun, keeps_a_vehicle_name_that_equals_an_old_key) {
  const io::TestFolder folder;
  TestRun run;
  run.vehicles = {"blind"};
  run.truth = true;
  write_test_run(folder, run);
  const auto read = read_run(folder.path());
  ASSERT_TRUE(read);
  bool found = false;
  for (const Measured& m : read->evaluation) {
    found |= m.key == "vehicles.blind.trajectory.ape_m.rmse";
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace rali::report
