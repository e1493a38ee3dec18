#include "rali/drive/closed_loop/simulated_jobs.hpp"

#include <gtest/gtest.h>

#include "rali/drive/closed_loop/step_times.hpp"

namespace rali::drive {
namespace {

class Nothing final : public fleet::Job {
 public:
  explicit Nothing(const fleet::JobWork& work) : given_(work) {}

  void run(Executor& executor, const std::atomic<bool>& cancel) override {
    static_cast<void>(executor);
    static_cast<void>(cancel);
    work_ = given_;
  }

  [[nodiscard]] fleet::JobWork work() const override { return work_; }

 private:
  fleet::JobWork given_, work_;
};

fleet::RunJob order(std::uint64_t number, std::size_t nodes) {
  return {fleet::JobKind::kEstimate, number,
          std::make_shared<Nothing>(fleet::JobWork{.nodes = nodes})};
}

Time at(double t_s) { return Time::from_s(t_s); }

constexpr JobCost kCost{.job_s = 1.0, .node_s = 0.01, .submap_s = 0.0, .compared_s = 0.0};

TEST(SimulatedJobs, return_after_their_computation_time_shortest_first) {
  SerialExecutor executor;
  SimulatedJobs jobs({.cpu_factor = 2.0}, kCost);
  jobs.run(0, order(1, 100), at(10.0), executor);  // 2 (1 + 0.01 * 100) s
  jobs.run(1, order(1, 0), at(10.0), executor);
  EXPECT_TRUE(jobs.take(at(11.9)).empty());
  const auto done = jobs.take(at(14.0));
  ASSERT_EQ(done.size(), 2U);
  EXPECT_EQ(done[0].owner, 1U);
  EXPECT_EQ(done[1].owner, 0U);
  EXPECT_TRUE(jobs.take(at(100.0)).empty());
}

TEST(SimulatedJobs, a_cancelled_job_returns_at_once_and_no_other) {
  SerialExecutor executor;
  SimulatedJobs jobs({}, kCost);
  jobs.run(0, order(7, 0), at(10.0), executor);
  jobs.run(1, order(7, 0), at(10.0), executor);
  jobs.cancel(0, 7, at(10.2));
  jobs.cancel(0, 8, at(10.2));
  const auto done = jobs.take(at(10.3));
  ASSERT_EQ(done.size(), 1U);
  EXPECT_EQ(done[0].owner, 0U);
  EXPECT_EQ(done[0].event.number, 7U);
}

TEST(SimulatedJobs, of_a_stopped_process_never_return) {
  SerialExecutor executor;
  SimulatedJobs jobs({}, kCost);
  jobs.run(0, order(1, 0), at(10.0), executor);
  jobs.run(1, order(1, 0), at(10.0), executor);
  jobs.forget(0);
  const auto done = jobs.take(at(20.0));
  ASSERT_EQ(done.size(), 1U);
  EXPECT_EQ(done[0].owner, 1U);
}

TEST(StepTimes, quantiles_are_accurate_to_10_percent) {
  StepTimes times;
  for (int k = 1; k <= 1000; ++k) times.add(fleet::NodeTick{}, 1e-5 * k);
  times.add(fleet::ReceivedRadio{}, 0.5);
  const auto rows = times.rows();
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].event, "radio");
  EXPECT_EQ(rows[1].event, "tick");
  EXPECT_EQ(rows[1].times->count(), 1000U);
  EXPECT_NEAR(rows[1].times->quantile_s(0.5), 5e-3, 5e-4);
  EXPECT_NEAR(rows[1].times->quantile_s(0.999), 1e-2, 1e-3);
  EXPECT_EQ(rows[1].times->max_s(), 1e-2);
  EXPECT_EQ(times.lines().size(), 2U);
}

TEST(StepTimes, times_beyond_the_bins_are_counted) {
  TimeHistogram times;
  EXPECT_EQ(times.quantile_s(0.5), 0.0);
  times.add(0.0);
  times.add(1e4);
  EXPECT_EQ(times.count(), 2U);
  EXPECT_EQ(times.max_s(), 1e4);
  EXPECT_LE(times.quantile_s(0.5), 2e-6);
}

}  // namespace
}  // namespace rali::drive
