// The fleet link over a bad radio: scenarios N1, N2, N4 and N8 of the design, a long interruption,
// a one-way link. RALI_SOAK in the environment makes them longer.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <new>
#include <thread>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "emulated_radio.hpp"
#include "rali/net/dds_fleet_link.hpp"

namespace rali::net {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kVehicles = 3;
constexpr std::size_t kNotesMax = 20'000;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int soak_factor() { return std::getenv("RALI_SOAK") == nullptr ? 1 : 10; }

/// A receipt, reported to the test by a vehicle's process: receiver, sender and times.
struct Note {
  std::size_t at = 0, from = 0;
  double sent_s = 0.0, arrived_s = 0.0;
  std::size_t bytes = 0;
};

struct Board {
  std::atomic<bool> go{false}, stop{false};
  std::atomic<int> joined[kVehicles]{};  ///< vehicles that each one sees
  std::atomic<std::size_t> notes{0};
  std::atomic<std::uint64_t> refused[kVehicles]{};
  Note note[kNotesMax];
};

/// First the time of sending, then arbitrary content.
Bytes timed_message(std::size_t size) {
  Bytes out(std::max(size, sizeof(double)));
  const double t_s = now_s();
  std::memcpy(out.data(), &t_s, sizeof(t_s));
  return out;
}

/// Longest delay of a runnable thread by this machine: latency bounds are extended by it.
class PauseWatch {
 public:
  PauseWatch()
      : thread_([this](const std::stop_token& stop) {
          for (double last_s = now_s(); !stop.stop_requested();) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            const double t_s = now_s();
            longest_s_ = std::max(longest_s_.load(), t_s - last_s);
            last_s = t_s;
          }
        }) {}

  [[nodiscard]] double longest_s() const { return longest_s_; }

 private:
  std::atomic<double> longest_s_{0.0};
  std::jthread thread_;
};

class FleetOverRadio : public ::testing::Test {
 protected:
  using Script = std::function<void(FleetLink&, double since_s)>;  ///< called every millisecond

  void SetUp() override {
    std::string why_not;
    radio_ = EmulatedRadio::create(kVehicles, why_not);
    if (!radio_) GTEST_SKIP() << "LINK TESTS ARE SKIPPED: " << why_not;
    void* memory =
        ::mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(memory, MAP_FAILED);
    board_ = new (memory) Board;
  }

  void TearDown() override {
    for (const pid_t vehicle : processes_) {
      ::kill(vehicle, SIGKILL);
      ::waitpid(vehicle, nullptr, 0);
    }
    if (board_ != nullptr) ::munmap(board_, sizeof(Board));
  }

  /// Starts a process for each vehicle, then the radio. A script starts after go() is called.
  void start(const std::vector<Script>& scripts) {
    for (std::size_t i = 0; i < kVehicles; ++i) {
      const pid_t child = ::fork();
      if (child == 0) {
        drive(i, i < scripts.size() ? scripts[i] : Script{});
        ::_exit(0);
      }
      processes_.push_back(child);
    }
    radio_->start();
  }

  void go() { board_->go = true; }

  [[nodiscard]] bool all_joined(double limit_s) const {
    return wait_until(limit_s, [&] {
      return std::all_of(std::begin(board_->joined), std::end(board_->joined),
                         [](const auto& n) { return n == int{kVehicles} - 1; });
    });
  }

  [[nodiscard]] static bool wait_until(double limit_s, const std::function<bool()>& condition) {
    const double end_s = now_s() + limit_s;
    while (!condition()) {
      if (now_s() > end_s) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }

  static void sleep(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

  [[nodiscard]] std::vector<Note> notes(std::size_t at, std::size_t from,
                                        std::size_t bytes_min = 0) const {
    std::vector<Note> out;
    const std::size_t n = std::min(board_->notes.load(), kNotesMax);
    for (std::size_t i = 0; i < n; ++i) {
      const Note& note = board_->note[i];
      if (note.at == at && note.from == from && note.bytes >= bytes_min) out.push_back(note);
    }
    return out;
  }

  [[nodiscard]] static std::vector<double> latencies_ms(const std::vector<Note>& notes) {
    std::vector<double> out;
    for (const Note& note : notes) out.push_back(1e3 * (note.arrived_s - note.sent_s));
    std::sort(out.begin(), out.end());
    return out;
  }

  [[nodiscard]] static double longest_gap_s(const std::vector<Note>& notes) {
    double gap_s = 0.0;
    for (std::size_t i = 1; i < notes.size(); ++i) {
      gap_s = std::max(gap_s, notes[i].arrived_s - notes[i - 1].arrived_s);
    }
    return gap_s;
  }

  std::unique_ptr<EmulatedRadio> radio_;
  Board* board_ = nullptr;

 private:
  /// Main function of a vehicle's process.
  void drive(std::size_t self, const Script& script) {
    if (!radio_->enter(self)) return;
    FleetLinkOptions options;
    options.self = VehicleId{static_cast<std::uint16_t>(self)};
    options.epoch = 1;
    options.address = EmulatedRadio::address(self);
    options.key.bytes.fill(0x42);
    for (std::size_t i = 0; i < kVehicles; ++i) {
      if (i == self) continue;
      options.peers.push_back(
          {VehicleId{static_cast<std::uint16_t>(i)}, EmulatedRadio::address(i), 0});
    }
    const auto link = open_dds_fleet_link(options);
    if (!link) return;
    double start_s = 0.0;
    while (!board_->stop) {
      (void)(*link)->wait(Duration::from_s(0.001));
      receive(self, **link);
      if (!script || !board_->go) continue;
      if (start_s <= 0.0) start_s = now_s();
      script(**link, now_s() - start_s);
    }
  }

  void receive(std::size_t self, FleetLink& link) {
    for (const Arrived& one : link.take()) {
      const std::size_t i = board_->notes.fetch_add(1);
      if (i >= kNotesMax || one.bytes.size() < sizeof(double)) continue;
      Note& note = board_->note[i];
      std::memcpy(&note.sent_s, one.bytes.data(), sizeof(double));
      note.arrived_s = now_s();
      note.from = one.from.value;
      note.at = self;
      note.bytes = one.bytes.size();
    }
    int joined = 0;
    std::uint64_t refused = 0;
    for (const LinkCounts& row : link.counts()) {
      joined += row.matched ? 1 : 0;
      refused += row.refused;
    }
    board_->joined[self] = joined;
    board_->refused[self] = refused;
  }

  std::vector<pid_t> processes_;
};

constexpr VehicleId kV1{1}, kV2{2};

/// Sends at a steady rate until `n` messages are accepted; refused ones are sent again.
class Pace {
 public:
  Pace(double period_s, int n) : period_s_(period_s), n_(n) {}

  void operator()(double since_s, const std::function<bool()>& send) {
    while (sent_ < n_ && since_s >= period_s_ * sent_ && send()) ++sent_;
  }

 private:
  double period_s_;
  int n_, sent_ = 0;
};

TEST_F(FleetOverRadio, vehicles_find_each_other_within_a_second) {
  radio_->set_all({0.0, 0.005});
  const double start_s = now_s();
  start({});
  EXPECT_TRUE(all_joined(10.0));
  const double took_s = now_s() - start_s;
  EXPECT_LT(took_s, 1.0);
  std::printf("[ figures  ] all of three see each other after %.2f s\n", took_s);
}

TEST_F(FleetOverRadio, vehicles_find_each_other_within_3_s_at_20_percent_loss) {
  radio_->set_all({0.2, 0.005});
  const double start_s = now_s();
  start({});
  EXPECT_TRUE(all_joined(10.0));
  const double took_s = now_s() - start_s;
  EXPECT_LT(took_s, 3.0);
  std::printf("[ figures  ] all of three see each other after %.2f s\n", took_s);
}

TEST_F(FleetOverRadio, all_200_kb_messages_arrive_at_20_percent_loss) {
  const int n = 10 * soak_factor();
  radio_->set_all({0.2, 0.005, 0.0, 20e6 / 8.0});
  Pace pace(0.5, n);
  start({[&](FleetLink& link, double since_s) {
    pace(since_s, [&] { return link.send(kV1, Urgency::kBulk, timed_message(200'000)); });
  }});
  ASSERT_TRUE(all_joined(10.0));
  go();
  EXPECT_TRUE(wait_until(0.5 * n + 10.0,
                         [&] { return notes(1, 0).size() == static_cast<std::size_t>(n); }));
  const auto ms = latencies_ms(notes(1, 0));
  ASSERT_EQ(ms.size(), static_cast<std::size_t>(n));
  EXPECT_LT(ms[ms.size() / 2], 600.0);
  std::printf("[ figures  ] 200 kB: min %.0f, median %.0f, max %.0f ms\n", ms.front(),
              ms[ms.size() / 2], ms.back());
}

TEST_F(FleetOverRadio, a_disconnected_vehicle_does_not_delay_messages_to_others) {
  const int n = 120 * soak_factor();
  radio_->set_all({0.02, 0.005, 0.0, 20e6 / 8.0});
  Pace to_v1(0.05, n), to_v2(0.05, n);
  start({[&](FleetLink& link, double since_s) {
    to_v2(since_s, [&] {
      (void)link.send(kV2, Urgency::kBulk, timed_message(20'000));
      return true;  // refused messages are not sent again
    });
    to_v1(since_s, [&] { return link.send(kV1, Urgency::kBulk, timed_message(20'000)); });
  }});
  ASSERT_TRUE(all_joined(10.0));
  const PauseWatch pause;
  go();
  sleep(1.0);
  radio_->set(0, 2, {0.0, 0.0, 0.0, 0.0, 0, true});
  radio_->set(2, 0, {0.0, 0.0, 0.0, 0.0, 0, true});
  EXPECT_TRUE(wait_until(0.05 * n + 10.0,
                         [&] { return notes(1, 0).size() == static_cast<std::size_t>(n); }));
  EXPECT_LT(longest_gap_s(notes(1, 0)), 1.0 + pause.longest_s());
  EXPECT_GT(board_->refused[0].load(), 0U) << "the queue to the one that is cut off is bounded";
  std::printf("[ figures  ] longest gap at the other one %.2f s, of the machine %.2f s\n",
              longest_gap_s(notes(1, 0)), pause.longest_s());
}

TEST_F(FleetOverRadio, vehicles_reconnect_after_an_interruption_longer_than_the_lease) {
  radio_->set_all({0.02, 0.005});
  Pace pace(0.1, 100'000);
  start({[&](FleetLink& link, double since_s) {
    pace(since_s, [&] {
      (void)link.send(kV1, Urgency::kBulk, timed_message(2'000));
      return true;
    });
  }});
  ASSERT_TRUE(all_joined(10.0));
  go();
  EXPECT_TRUE(wait_until(5.0, [&] { return !notes(1, 0).empty(); }));
  LinkModel cut;
  cut.cut = true;
  radio_->set_all(cut);
  EXPECT_TRUE(wait_until(15.0, [&] { return board_->joined[0] == 0 && board_->joined[1] == 0; }))
      << "the lease is 8 s";
  radio_->set_all({0.02, 0.005});
  const double healed_s = now_s();
  const std::size_t before = notes(1, 0).size();
  EXPECT_TRUE(wait_until(10.0, [&] { return notes(1, 0).size() > before + 5; }));
  std::printf("[ figures  ] messages flow %.2f s after healing\n", now_s() - healed_s);
  EXPECT_LT(now_s() - healed_s, 5.0);
}

TEST_F(FleetOverRadio, 95_percent_of_heartbeats_arrive_within_500_ms_on_a_saturated_link) {
  radio_->set_all({0.05, 0.005, 0.0, 5e6 / 8.0});
  Pace bulk(0.001, 1'000'000), beat(0.1, 1'000'000);
  start({[&](FleetLink& link, double since_s) {
    beat(since_s, [&] { return link.send(std::nullopt, Urgency::kRole, timed_message(64)); });
    bulk(since_s, [&] { return link.send(kV1, Urgency::kBulk, timed_message(20'000)); });
  }});
  ASSERT_TRUE(all_joined(10.0));
  go();
  sleep(6.0 * soak_factor());
  const auto bulk_notes = notes(1, 0, 20'000);
  std::vector<Note> beats = notes(1, 0);
  std::erase_if(beats, [](const Note& note) { return note.bytes > 64; });
  const auto ms = latencies_ms(beats);
  ASSERT_GT(ms.size(), 40U);
  EXPECT_GT(bulk_notes.size(), 30U) << "the line is busy";
  EXPECT_LT(ms[ms.size() * 95 / 100], 500.0);
  std::printf("[ figures  ] heartbeat: median %.0f, max %.0f ms; bulk %.2f MB/s\n",
              ms[ms.size() / 2], ms.back(),
              0.02 * static_cast<double>(bulk_notes.size()) / (6.0 * soak_factor()));
}

/// Requests for what waits in the radio's queue would fill the line with repetitions: 0.08 MB/s.
TEST_F(FleetOverRadio, large_messages_use_a_third_of_a_saturated_slow_link) {
  radio_->set_all({0.05, 0.005, 0.0, 5e6 / 8.0});
  Pace bulk(0.001, 1'000'000);
  start({[&](FleetLink& link, double since_s) {
    bulk(since_s, [&] { return link.send(kV1, Urgency::kBulk, timed_message(200'000)); });
  }});
  ASSERT_TRUE(all_joined(10.0));
  go();
  const double took_s = 8.0 * soak_factor();
  sleep(took_s);
  const double arrived_MBps = 0.2 * static_cast<double>(notes(1, 0, 200'000).size()) / took_s;
  EXPECT_GT(arrived_MBps, 0.625 / 3.0);
  std::printf("[ figures  ] %.2f of 0.625 MB/s\n", arrived_MBps);
}

TEST_F(FleetOverRadio, messages_to_one_vehicle_are_not_sent_to_the_others) {
  radio_->set_all({});
  Pace pace(0.01, 100);
  start({[&](FleetLink& link, double since_s) {
    pace(since_s, [&] { return link.send(kV1, Urgency::kBulk, timed_message(20'000)); });
  }});
  ASSERT_TRUE(all_joined(10.0));
  const auto before = radio_->traffic(0, 2).bytes_out;
  go();
  EXPECT_TRUE(wait_until(20.0, [&] { return notes(1, 0).size() == 100; }));
  EXPECT_GT(radio_->traffic(0, 1).bytes_out, 2'000'000U);
  EXPECT_LT(radio_->traffic(0, 2).bytes_out - before, 100'000U);
}

}  // namespace
}  // namespace rali::net
