#include "rali/drive/fleet_loop.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <tuple>
#include <utility>
#include <variant>

#include "rali/drive/fleet_slice.hpp"
#include "rali/drive/live/live_map.hpp"
#include "rali/drive/loop_progress.hpp"
#include "rali/drive/ranges/range_files.hpp"
#include "rali/drive/read_ahead.hpp"
#include "rali/drive/run_findings.hpp"
#include "rali/ranging/exchange_pairer.hpp"

namespace rali::drive {
namespace {

using ScanEvent = std::shared_ptr<const sensor::LidarScan>;

/// When an event is due; a scan at its last point, since it is not complete earlier.
Time time_of(const vehicle::Event& event) {
  if (const auto* imu = std::get_if<sensor::ImuSample>(&event)) return imu->t;
  if (const auto* scan = std::get_if<ScanEvent>(&event)) return (*scan)->t_end;
  if (const auto* range = std::get_if<sensor::RangeSample>(&event)) return range->t;
  return {};
}

/// Order at equal times.
constexpr int kImuRank = 0, kRangeRank = 1, kScanRank = 2, kEndRank = 3;

int rank_of(const vehicle::Event& event) {
  if (std::holds_alternative<sensor::ImuSample>(event)) return kImuRank;
  return std::holds_alternative<ScanEvent>(event) ? kScanRank : kRangeRank;
}

/// One vehicle's progress through its data.
struct Track {
  FleetMember* member = nullptr;
  std::unique_ptr<ReadAhead> ahead;
  std::optional<vehicle::Event> next;  ///< empty: its source has ended
  Time t_last;                         ///< of the last event it read
  bool at_rest = false;                ///< by its last pose
  std::unique_ptr<LoopProgress> progress;
  std::size_t findings_shown = 0;

  [[nodiscard]] EventSource& events() const {
    return ahead ? static_cast<EventSource&>(*ahead) : *member->source;
  }
};

/// An event for a vehicle; a range to kBothEnds goes to both its vehicles.
struct Letter {
  std::size_t to;
  vehicle::Event event;
};

constexpr std::size_t kFiles = static_cast<std::size_t>(-1), kBothEnds = kFiles;

/// Reads the sources half a slot ahead of the vehicles. A range takes up to that long to be paired
/// with the other direction of its exchange, and the vehicles still receive everything in time
/// order.
class FleetLoop {
 public:
  FleetLoop(std::span<const sensor::RangeSample> ranges, const RangeOptions& range_options,
            const FleetLoopOptions& options, Executor& executor, RangeLog& log, LiveMap* live,
            ProgressSink& sink)
      : ranges_(ranges),
        range_options_(range_options),
        options_(options),
        executor_(executor),
        log_(log),
        live_(live),
        sink_(sink),
        half_slot_(Duration::from_s(0.5 * range_options.exchange.slot_s)),
        pairer_(range_options.exchange) {}

  void run(std::span<FleetMember> members, const std::atomic<bool>& stop);

 private:
  /// Time, rank, source, order of reading.
  using Key = std::tuple<Time, int, std::size_t, std::uint64_t>;

  void start(std::span<FleetMember> members);
  [[nodiscard]] std::optional<std::size_t> oldest() const;
  void fetch(std::size_t index);
  void pull(std::size_t source);
  void take_range(const sensor::RangeSample& sample);
  void settle();
  void put(std::size_t source, Time t, int rank, Letter letter);
  void hand_out(Time before);
  [[nodiscard]] std::vector<SliceStep> cut_slice(Time end);
  void work(std::vector<SliceStep> steps);
  void take(const SliceStep& step);
  void end(std::size_t index);
  void follow(std::size_t index, const vehicle::OutputList& outputs);
  void interrupt();
  [[nodiscard]] Status place_in_map(FleetMember& member, const vehicle::OutputList& outputs);
  void show_findings();

  std::span<FleetMember> members_;
  std::span<const sensor::RangeSample> ranges_;
  const RangeOptions& range_options_;
  FleetLoopOptions options_;
  Executor& executor_;
  RangeLog& log_;
  LiveMap* live_;
  ProgressSink& sink_;
  Duration half_slot_;
  ranging::ExchangePairer pairer_;
  std::vector<ranging::PairedRange> paired_;
  std::vector<Track> tracks_;
  std::size_t next_range_ = 0;
  std::optional<Time> newest_;  ///< of what was read
  std::map<Key, Letter> due_;   ///< read, not yet passed on
  std::uint64_t order_ = 0;
  std::vector<SliceStep> reports_;  ///< peer states of vehicles, for the next slice
  std::vector<bool> ended_;         ///< by vehicle: it has received EndOfData
  bool broken_ = false;             ///< the disk failed: nothing more can be written
};

void FleetLoop::start(std::span<FleetMember> members) {
  members_ = members;
  ended_.assign(members.size(), false);
  for (FleetMember& member : members) {
    Track track;
    track.member = &member;
    if (options_.read_ahead) track.ahead = std::make_unique<ReadAhead>(*member.source);
    track.progress = std::make_unique<LoopProgress>(sink_, *member.run);
    tracks_.push_back(std::move(track));
  }
  for (std::size_t i = 0; i < tracks_.size(); ++i) fetch(i);
}

/// Source of the event to be read next; kFiles for the ranges of files, empty at the end of all.
std::optional<std::size_t> FleetLoop::oldest() const {
  using Head = std::tuple<Time, int, std::size_t>;
  std::optional<Head> best;
  if (next_range_ < ranges_.size()) best = Head{ranges_[next_range_].t, kRangeRank, kFiles};
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (!tracks_[i].next) continue;
    const Head head{time_of(*tracks_[i].next), rank_of(*tracks_[i].next), i};
    if (!best || head < *best) best = head;
  }
  return best ? std::optional(std::get<2>(*best)) : std::nullopt;
}

/// Gets the vehicle's next event, or its end if there is none.
void FleetLoop::fetch(std::size_t index) {
  Track& track = tracks_[index];
  track.next.reset();
  if (ended_[index]) return;
  Result<std::optional<vehicle::Event>> next = track.events().next();
  if (!next) track.member->end.error = next.error();
  if (next && *next) {
    track.next = std::move(**next);
    track.t_last = std::max(track.t_last, time_of(*track.next));
    return;
  }
  put(index, track.t_last, kEndRank, {index, vehicle::EndOfData{}});
}

/// Reads one event; ranges are paired with their exchange.
void FleetLoop::pull(std::size_t source) {
  if (source == kFiles) return take_range(ranges_[next_range_++]);
  vehicle::Event event = std::move(*tracks_[source].next);
  if (const auto* range = std::get_if<sensor::RangeSample>(&event)) {
    take_range(*range);
  } else {
    const Time t = time_of(event);
    newest_ = t;
    pairer_.release(t, paired_);
    settle();
    const int rank = rank_of(event);
    put(source, t, rank, {source, std::move(event)});
  }
  fetch(source);
}

void FleetLoop::take_range(const sensor::RangeSample& sample) {
  ranging::RangeReason reason = judge_range(sample, range_options_);
  const bool late = newest_ && sample.t < *newest_;
  if (late && reason == ranging::RangeReason::kNoPose) reason = ranging::RangeReason::kLate;
  if (!late) newest_ = sample.t;
  if (reason != ranging::RangeReason::kNoPose || options_.separate) {
    return log_.add_refused(sample, reason);
  }
  pairer_.add(sample, paired_);
  settle();
}

/// Puts the ranges that the pairer has decided into order.
void FleetLoop::settle() {
  for (const ranging::PairedRange& range : paired_) {
    if (range.duplicate) {
      log_.add_refused(range.sample, ranging::RangeReason::kDuplicate);
    } else {
      put(kFiles, range.sample.t, kRangeRank, {kBothEnds, range.sample});
    }
  }
  paired_.clear();
}

void FleetLoop::put(std::size_t source, Time t, int rank, Letter letter) {
  due_.emplace(Key{t, rank, source, order_++}, std::move(letter));
}

/// Passes on the slices that end before a time: no more events of them can come.
void FleetLoop::hand_out(Time before) {
  while (!due_.empty() && !broken_) {
    const Time end = std::get<Time>(due_.begin()->first) + kSlice;
    if (end > before) return;
    work(cut_slice(end));
  }
}

/// Peer states of the previous slice come first, then events in time order; a range goes to both
/// its ends.
std::vector<SliceStep> FleetLoop::cut_slice(Time end) {
  std::vector<SliceStep> steps = std::exchange(reports_, {});
  const auto add = [&](std::size_t to, vehicle::Event event) {
    steps.push_back({to, std::move(event)});
  };
  while (!due_.empty() && std::get<Time>(due_.begin()->first) < end) {
    Letter letter = std::move(due_.begin()->second);
    due_.erase(due_.begin());
    if (letter.to != kBothEnds) {
      add(letter.to, std::move(letter.event));
      continue;
    }
    const auto sample = std::get<sensor::RangeSample>(letter.event);
    log_.add_handed(sample);
    add(sample.from.value, sample);
    add(sample.to.value, sample);
  }
  return steps;
}

void FleetLoop::work(std::vector<SliceStep> steps) {
  run_slice(members_, ended_, options_.strict, executor_, steps);
  for (const SliceStep& step : steps) {
    if (step.done && !broken_) take(step);
  }
}

/// Passes the outputs of one event to the disk, the map and the other vehicles.
void FleetLoop::take(const SliceStep& step) {
  Track& track = tracks_[step.vehicle];
  FleetMember& member = *track.member;
  Status taken = member.run->see(step.event);
  if (taken) taken = member.run->take(step.outputs, member.findings);
  if (taken) taken = place_in_map(member, step.outputs);
  show_findings();
  follow(step.vehicle, step.outputs);
  track.progress->report(track.events().progress(), step.last);
  if (step.last) {
    ended_[step.vehicle] = true;
    track.next.reset();
    track.ahead.reset();
  }
  if (taken) return;
  member.end.error = taken.error();
  broken_ = true;
}

/// Finishes the events that were passed on: the vehicle still processes waiting scans.
void FleetLoop::end(std::size_t index) { work({{index, vehicle::EndOfData{}}}); }

/// Shows the new findings of all vehicles: the facts of one may withdraw another from the map.
void FleetLoop::show_findings() {
  for (Track& track : tracks_) {
    const FindingList& findings = track.member->findings;
    while (track.findings_shown < findings.size()) sink_.finding(findings[track.findings_shown++]);
  }
}

/// Adds reported facts to the live map and publishes the pose in it.
Status FleetLoop::place_in_map(FleetMember& member, const vehicle::OutputList& outputs) {
  if (live_ == nullptr) return {};
  for (const vehicle::Output& output : outputs) {
    if (const auto* made = std::get_if<vehicle::FactMade>(&output)) live_->add(made->fact);
  }
  for (const vehicle::Output& output : outputs) {
    const auto* pose = std::get_if<vehicle::PoseEstimate>(&output);
    if (pose == nullptr) continue;
    live_->advance(pose->t, executor_);
    for (const Withdrawal& w : live_->take_withdrawals()) {
      FleetMember& withdrawn = *tracks_[w.vehicle.value].member;
      withdrawn.findings.push_back(withdrawal_finding(w, withdrawn.run->name()));
    }
    const std::optional<LivePose> live = live_->pose(*pose);
    if (!live) continue;
    if (Status s = member.run->take_live(*live, live_->step(*pose, *live)); !s) return s;
  }
  return {};
}

/// Passes outputs on to the other vehicles and to the table of ranges.
void FleetLoop::follow(std::size_t index, const vehicle::OutputList& outputs) {
  Track& track = tracks_[index];
  const VehicleId self{static_cast<std::uint16_t>(index)};
  for (const vehicle::Output& output : outputs) {
    if (const auto* use = std::get_if<ranging::RangeUse>(&output)) {
      log_.answer(*use, self, !track.at_rest);
    } else if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
      track.at_rest = pose->at_rest;
    } else if (const auto* status = std::get_if<vehicle::PeerStatus>(&output)) {
      for (std::size_t i = 0; i < tracks_.size() && !options_.separate; ++i) {
        if (i != index) reports_.push_back({i, *status});
      }
    }
  }
}

/// Finishes the events that were passed on; those only read are dropped.
void FleetLoop::interrupt() {
  for (std::size_t i = 0; i < tracks_.size() && !broken_; ++i) {
    if (ended_[i]) continue;
    tracks_[i].member->end.interrupted = true;
    end(i);
  }
}

void FleetLoop::run(std::span<FleetMember> members, const std::atomic<bool>& stop) {
  start(members);
  while (!broken_) {
    if (stop.load(std::memory_order_relaxed)) return interrupt();
    const std::optional<std::size_t> next = oldest();
    if (!next) break;
    pull(*next);
    if (newest_) hand_out(*newest_ - half_slot_);
  }
  pairer_.flush(paired_);
  settle();
  hand_out(Time::from_ns(std::numeric_limits<std::int64_t>::max()));
}

}  // namespace

void run_fleet(std::span<FleetMember> members, std::span<const sensor::RangeSample> ranges,
               const RangeOptions& range_options, const FleetLoopOptions& options,
               Executor& executor, RangeLog& log, LiveMap* live, ProgressSink& sink,
               const std::atomic<bool>& stop) {
  FleetLoop(ranges, range_options, options, executor, log, live, sink).run(members, stop);
}

}  // namespace rali::drive
