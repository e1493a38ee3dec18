#include "rali/drive/fleet_loop.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "rali/drive/tbb_executor.hpp"
#include "rali/io/files/test_folder.hpp"

namespace rali::drive {
namespace {

using ranging::RangeReason;
using sensor::RangeSample;

vehicle::Event imu_at(double t_s) {
  sensor::ImuSample sample;
  sample.t = Time::from_s(t_s);
  return sample;
}

RangeSample range(double t_s, int from, int to, double range_m = 5.0) {
  RangeSample sample;
  sample.t = Time::from_s(t_s);
  sample.from = VehicleId{static_cast<std::uint16_t>(from)};
  sample.to = VehicleId{static_cast<std::uint16_t>(to)};
  sample.range_m = range_m;
  return sample;
}

class ListedEvents final : public ReportedSource {
 public:
  std::vector<vehicle::Event> events;
  bool fails = false;  ///< at the end

  Result<std::optional<vehicle::Event>> next() override {
    if (at_ < events.size()) return std::optional(events[at_++]);
    if (fails) return fail(ErrorCode::kInput, "v.bag", "is cut");
    return std::optional<vehicle::Event>();
  }

  double progress() const override { return 0.5; }

  const InputReport& report() const override { return report_; }

 private:
  InputReport report_;
  std::size_t at_ = 0;
};

class NoSink final : public ProgressSink {
 public:
  void progress(const Progress& /*progress*/) override {}

  void finding(const Finding& /*finding*/) override {}
};

std::string word_of(const vehicle::Event& event) {
  if (const auto* imu = std::get_if<sensor::ImuSample>(&event)) {
    return "imu " + std::to_string(imu->t.ns / 1'000'000);
  }
  if (const auto* r = std::get_if<RangeSample>(&event)) {
    return "range " + std::to_string(r->t.ns / 1'000'000);
  }
  if (const auto* peer = std::get_if<vehicle::PeerStatus>(&event)) {
    return "peer " + std::to_string(peer->vehicle.value) + (peer->at_rest ? " rests" : " moves");
  }
  return std::holds_alternative<vehicle::EndOfData>(event) ? "end" : "other";
}

/// A fleet whose vehicles only record their events; "0 imu 1000" in `reported`.
struct Fleet {
  explicit Fleet(std::size_t n) : sources(n), log(names(n)) {
    options.antennas.assign(n, 1);
    for (std::size_t i = 0; i < n; ++i) {
      Result<VehicleRun> run = VehicleRun::start(names(n)[i], folder.path(), nullptr);
      EXPECT_TRUE(run);
      runs.push_back(std::move(*run));
    }
  }

  static std::vector<std::string> names(std::size_t n) {
    std::vector<std::string> list;
    for (std::size_t i = 0; i < n; ++i) list.push_back("v" + std::to_string(i + 1));
    return list;
  }

  void run(FleetLoopOptions loop = {}) {
    std::vector<FleetMember> members(sources.size());
    for (std::size_t i = 0; i < sources.size(); ++i) {
      members[i].source = &sources[i];
      members[i].run = &runs[i];
      members[i].step = [this, i](const vehicle::Event& event, Executor& /*executor*/,
                                  vehicle::OutputList& out) {
        note(i, word_of(event));
        if (answers) answers(i, event, out);
      };
    }
    const std::unique_ptr<Executor> executor = make_executor(threads);
    NoSink sink;
    run_fleet(members, ranges, options, loop, *executor, log, nullptr, sink, stop);
    for (const FleetMember& member : members) ends.push_back(member.end);
  }

  [[nodiscard]] std::size_t count(RangeReason reason) const {
    return log.tally().by_reason[static_cast<std::size_t>(reason)];
  }

  io::TestFolder folder;
  std::vector<ListedEvents> sources;
  std::vector<VehicleRun> runs;
  std::vector<RangeSample> ranges;
  RangeOptions options;
  RangeLog log;
  std::function<void(std::size_t, const vehicle::Event&, vehicle::OutputList&)> answers;
  std::atomic<bool> stop{false};
  int threads = 1;
  std::vector<std::string> reported;
  std::function<void(std::size_t, const std::string&)> note = [this](std::size_t i,
                                                                     const std::string& word) {
    reported.push_back(std::to_string(i) + ' ' + word);
  };
  std::vector<LoopEnd> ends;
};

using Words = std::vector<std::string>;

TEST(FleetLoop, processes_events_of_all_vehicles_in_time_order) {
  Fleet fleet(2);
  fleet.sources[0].events = {imu_at(1.0), imu_at(3.0)};
  fleet.sources[1].events = {imu_at(1.0), imu_at(2.0), imu_at(4.0)};
  fleet.run();
  EXPECT_EQ(fleet.reported, (Words{"0 imu 1000", "1 imu 1000", "1 imu 2000", "0 imu 3000", "0 end",
                                   "1 imu 4000", "1 end"}));
}

TEST(FleetLoop, reading_ahead_changes_nothing) {
  Words reported;
  for (const bool read_ahead : {false, true}) {
    Fleet fleet(2);
    for (int i = 0; i < 50; ++i) {
      fleet.sources[0].events.push_back(imu_at(1.0 + 0.010 * i));
      fleet.sources[1].events.push_back(imu_at(1.2 + 0.007 * i));
      fleet.ranges.push_back(range(0.9 + 0.015 * i, i % 2, 1 - i % 2));
    }
    fleet.run({read_ahead, false, false});
    if (!read_ahead) reported = fleet.reported;
    EXPECT_EQ(fleet.reported, reported);
    EXPECT_GT(fleet.log.tally().total, 40U);
  }
}

TEST(FleetLoop, delivers_a_range_in_time_order_to_its_two_ends_only) {
  Fleet fleet(3);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(2.0)};
  fleet.ranges = {range(1.5, 2, 0)};
  fleet.run();
  const Words middle(fleet.reported.begin() + 3, fleet.reported.begin() + 5);
  EXPECT_EQ(middle, (Words{"0 range 1500", "2 range 1500"}));
  EXPECT_EQ(std::count(fleet.reported.begin(), fleet.reported.end(), "1 range 1500"), 0);
}

TEST(FleetLoop, a_range_of_one_recording_reaches_the_other_vehicle_too) {
  Fleet fleet(2);
  fleet.sources[0].events = {imu_at(1.0), range(1.2, 0, 1), imu_at(2.0)};
  fleet.sources[1].events = {imu_at(1.1), imu_at(1.3), imu_at(2.1)};
  fleet.run();
  EXPECT_EQ(fleet.reported, (Words{"0 imu 1000", "1 imu 1100", "0 range 1200", "1 range 1200",
                                   "1 imu 1300", "0 imu 2000", "0 end", "1 imu 2100", "1 end"}));
}

TEST(FleetLoop, delivers_a_peer_status_to_other_vehicles_with_the_next_slice) {
  Fleet fleet(3);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0)};
  fleet.sources[0].events = {imu_at(0.5)};
  fleet.sources[2].events = {imu_at(1.0), imu_at(1.05), imu_at(1.2)};
  fleet.answers = [](std::size_t i, const vehicle::Event& event, vehicle::OutputList& out) {
    if (i != 1 || !std::holds_alternative<sensor::ImuSample>(event)) return;
    out.emplace_back(vehicle::PeerStatus{VehicleId{1}, Time::from_s(1.0), true});
  };
  fleet.run();
  EXPECT_EQ(fleet.reported, (Words{"0 imu 500", "0 end", "1 imu 1000", "1 end", "2 imu 1000",
                                   "2 imu 1050", "2 peer 1 rests", "2 imu 1200", "2 end"}))
      << "who has ended is told nothing";
}

// A run must not depend on the number of threads.
TEST(FleetLoop, vehicles_receive_the_same_events_with_any_number_of_threads) {
  std::vector<Words> serial;
  for (const int threads : {1, 4}) {
    Fleet fleet(3);
    for (int i = 0; i < 200; ++i) {
      for (ListedEvents& source : fleet.sources) source.events.push_back(imu_at(1.0 + 0.013 * i));
      if (i % 3 == 0) fleet.ranges.push_back(range(1.0 + 0.014 * i, i % 2, 2));
    }
    std::vector<Words> by_vehicle(3);  // each written by one thread at a time
    fleet.note = [&](std::size_t i, const std::string& word) { by_vehicle[i].push_back(word); };
    fleet.answers = [](std::size_t i, const vehicle::Event& event, vehicle::OutputList& out) {
      const auto* imu = std::get_if<sensor::ImuSample>(&event);
      if (imu == nullptr || imu->t.ns % 5 != 0) return;
      out.emplace_back(vehicle::PeerStatus{VehicleId{static_cast<std::uint16_t>(i)}, imu->t, true});
    };
    fleet.threads = threads;
    fleet.run();
    if (threads == 1) serial = by_vehicle;
    EXPECT_EQ(by_vehicle, serial);
    EXPECT_GT(by_vehicle[2].size(), 300U);
    EXPECT_EQ(fleet.log.tally().total, 67U);
  }
}

TEST(FleetLoop, a_vehicle_that_fails_does_not_stop_the_others) {
  Fleet fleet(2);
  fleet.sources[0].events = {imu_at(1.0)};
  fleet.sources[0].fails = true;
  fleet.sources[1].events = {imu_at(1.5), imu_at(2.0)};
  fleet.ranges = {range(1.7, 0, 1)};
  fleet.run();
  EXPECT_TRUE(fleet.ends[0].error);
  EXPECT_FALSE(fleet.ends[1].error);
  EXPECT_EQ(fleet.reported,
            (Words{"0 imu 1000", "0 end", "1 imu 1500", "1 range 1700", "1 imu 2000", "1 end"}));
}

TEST(FleetLoop, ranges_outside_the_data_are_reported_without_a_pose) {
  Fleet fleet(2);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(2.0)};
  fleet.ranges = {range(0.5, 0, 1), range(9.0, 0, 1)};
  fleet.run();
  EXPECT_EQ(fleet.log.tally().total, 2U);
  EXPECT_EQ(fleet.count(RangeReason::kNoPose), 2U);
}

TEST(FleetLoop, refuses_invalid_unknown_and_late_ranges_before_the_vehicles) {
  Fleet fleet(2);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(2.0)};
  fleet.options.limits_m = {0.2, 200.0};
  RangeSample second_antenna = range(1.4, 0, 1);
  second_antenna.to_antenna = 1;  // each has only one
  fleet.ranges = {range(1.1, 0, 1, 0.1), range(1.2, 0, 1, 201.0), range(1.3, 0, 7), second_antenna};
  fleet.sources[0].events.push_back(range(0.2, 0, 1));  // 1.8 s late
  fleet.run();
  EXPECT_EQ(fleet.count(RangeReason::kOutOfLimits), 2U);
  EXPECT_EQ(fleet.count(RangeReason::kUnknownId), 2U);
  EXPECT_EQ(fleet.count(RangeReason::kLate), 1U);
  for (const std::string& word : fleet.reported) EXPECT_EQ(word.find("range"), std::string::npos);
}

TEST(FleetLoop, both_directions_of_one_exchange_are_one_range_and_one_duplicate) {
  Fleet fleet(2);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(3.0)};
  // The first exchange shows that both directions arrive; from then on their mean is passed on.
  fleet.ranges = {range(1.100, 0, 1, 5.0), range(1.104, 1, 0, 5.1), range(2.000, 0, 1, 6.0),
                  range(2.004, 1, 0, 6.1), range(2.004, 1, 0, 6.1)};
  fleet.run();
  EXPECT_EQ(fleet.count(RangeReason::kDuplicate), 3U);
  EXPECT_EQ(std::count(fleet.reported.begin(), fleet.reported.end(), "0 range 2002"), 1);
  EXPECT_EQ(fleet.log.tally().total, 5U) << "each stands in the table";
}

TEST(FleetLoop, without_a_common_clock_delivers_no_ranges_and_no_peer_status) {
  Fleet fleet(2);
  fleet.sources[0].events = {imu_at(1.0)};
  fleet.sources[1].events = {imu_at(90000.0)};
  fleet.ranges = {range(1.0, 0, 1)};
  fleet.answers = [](std::size_t /*i*/, const vehicle::Event& /*e*/, vehicle::OutputList& out) {
    out.emplace_back(vehicle::PeerStatus{});
  };
  fleet.run({false, false, true});
  EXPECT_EQ(fleet.reported, (Words{"0 imu 1000", "0 end", "1 imu 90000000", "1 end"}));
  EXPECT_EQ(fleet.count(RangeReason::kNoPose), 1U);
}

TEST(FleetLoop, a_strict_run_ends_only_the_diverged_vehicle) {
  Fleet fleet(2);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(2.0)};
  fleet.answers = [](std::size_t i, const vehicle::Event& event, vehicle::OutputList& out) {
    vehicle::PoseEstimate pose;
    pose.t = Time::from_s(1.0);
    pose.quality = vehicle::PoseQuality::kDiverged;
    if (i == 0 && std::holds_alternative<sensor::ImuSample>(event)) out.emplace_back(pose);
  };
  fleet.run({false, true, false});
  EXPECT_EQ(fleet.reported, (Words{"0 imu 1000", "0 end", "1 imu 1000", "1 imu 2000", "1 end"}));
}

TEST(FleetLoop, a_stop_finishes_every_vehicle) {
  Fleet fleet(2);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(2.0)};
  fleet.stop = true;
  fleet.run();
  EXPECT_EQ(fleet.reported, (Words{"0 end", "1 end"}));
  EXPECT_TRUE(fleet.ends[0].interrupted && fleet.ends[1].interrupted);
}

TEST(FleetLoop, keeps_the_result_of_the_vehicle_that_used_a_range) {
  Fleet fleet(2);
  for (ListedEvents& source : fleet.sources) source.events = {imu_at(1.0), imu_at(3.0)};
  fleet.ranges = {range(2.0, 0, 1)};
  fleet.answers = [](std::size_t i, const vehicle::Event& event, vehicle::OutputList& out) {
    const auto* sample = std::get_if<RangeSample>(&event);
    if (sample == nullptr) return;
    ranging::RangeUse use;
    use.sample = *sample;
    use.reason = i == 1 ? RangeReason::kUsed : RangeReason::kOutlier;
    out.emplace_back(use);
  };
  fleet.run();
  EXPECT_EQ(fleet.log.tally().used(), 1U);
  EXPECT_EQ(fleet.log.tally().total, 1U);
  EXPECT_EQ(fleet.runs[0].ranges(), 1U);
  EXPECT_EQ(fleet.runs[1].ranges_used(), 1U);
}

}  // namespace
}  // namespace rali::drive
