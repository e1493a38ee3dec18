#include "recording.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "plan.hpp"
#include "rali/drive/input/event_outlet.hpp"
#include "rali/scenario/faults/fault.hpp"

namespace rali::campaign {

namespace {

bool within(const std::vector<Span>& spans, double t_s) {
  return std::any_of(spans.begin(), spans.end(), [t_s](const Span& s) { return s.contains(t_s); });
}

/// Dust around the LiDAR, as with `--fault cover`.
void cover(sim::RawScan& scan, double resolution_m, std::uint64_t seed) {
  Rng rng(seed, "dust");
  for (std::uint16_t& steps : scan.range_steps) {
    const double depth_steps = scenario::cover_depth_m(rng) / resolution_m;
    steps = static_cast<std::uint16_t>(std::min<double>(steps, depth_steps));
  }
}

/// Delivers the contents of a track through the last stage shared by all readers.
class TrackEvents final : public drive::ReportedSource {
 public:
  TrackEvents(std::shared_ptr<const Recording> recording, std::size_t vehicle,
              const drive::InputOptions& options)
      : recording_(std::move(recording)),
        track_(recording_->tracks()[vehicle]),
        offset_(Duration::from_s(options.lidar_time_offset.value_s)),
        outlet_(options) {
    report_.vehicle = options.vehicle;
    report_.has_imu = !track_.imu.empty();
    report_.lidar_topic = "/points";
    report_.imu_topic = report_.has_imu ? "/imu/data" : "";
    report_.T_body_lidar = track_.calibration.T_body_lidar;
    report_.T_body_imu = track_.calibration.T_body_imu;
    report_.T_body_lidar_origin = "settings";
    report_.lidar_time_offset = options.lidar_time_offset;
  }

  Result<std::optional<vehicle::Event>> next() override {
    while (!ended_) {
      if (std::optional<vehicle::Event> event = outlet_.pop(report_)) return event;
      if (next_scan_ == track_.scans.size() || outlet_.past_end()) {
        if (finished_) {
          ended_ = true;
          outlet_.close(report_);
          break;
        }
        push_imu_until(recording_->t_end() + Duration::from_s(1.0));
        outlet_.finish();
        finished_ = true;
        continue;
      }
      read_one();
    }
    return std::optional<vehicle::Event>();
  }

  [[nodiscard]] double progress() const override {
    return track_.scans.empty()
               ? 1.0
               : static_cast<double>(next_scan_) / static_cast<double>(track_.scans.size());
  }

  [[nodiscard]] const drive::InputReport& report() const override { return report_; }

 private:
  void read_one() {
    auto scan = std::make_shared<sensor::LidarScan>(*recording_->scan(track_.scans[next_scan_++]));
    scan->t_start = scan->t_start + offset_;
    scan->t_end = scan->t_end + offset_;
    push_imu_until(scan->t_end + Duration::from_s(0.1));
    outlet_.push(std::shared_ptr<const sensor::LidarScan>(std::move(scan)));
  }

  void push_imu_until(Time t) {
    while (next_imu_ < track_.imu.size() && track_.imu[next_imu_].t <= t) {
      outlet_.push(track_.imu[next_imu_++]);
    }
  }

  std::shared_ptr<const Recording> recording_;
  const Track& track_;
  Duration offset_;
  drive::EventOutlet outlet_;
  drive::InputReport report_;
  std::size_t next_scan_ = 0, next_imu_ = 0;
  bool finished_ = false, ended_ = false;
};

}  // namespace

std::unique_ptr<drive::ReportedSource> Recording::play(std::shared_ptr<const Recording> recording,
                                                       std::size_t vehicle,
                                                       const drive::InputOptions& options) {
  return std::make_unique<TrackEvents>(std::move(recording), vehicle, options);
}

std::shared_ptr<const sensor::LidarScan> Recording::scan(const Track::Scan& scan) const {
  return sim::expand(scan.raw, model_, case_.setup.fleet.vehicle.ranging.resolution_m,
                     scan.t_start);
}

/// Start of the recording: with the simulation, or while the first vehicle drives or turns.
void Recording::begin(const sim::FleetSimulation& sim) {
  t_start_ = sim.t_start();
  t_end_ = sim.t_end();
  if (!case_.in_motion) return;
  Rng rng(case_.seed, "begin");
  const double span_s = seconds_between(t_start_, t_end_);
  const double from_s = rng.uniform(0.0, 0.4) * span_s;
  for (double t_s = from_s; t_s < 0.5 * span_s; t_s += 0.05) {
    const sim::MotionState state = sim.truth(0, t_start_ + Duration::from_s(t_s)).state;
    const bool turns = std::abs(state.omega_body_radps.z()) > 0.25;
    const bool drives = state.v_world_mps.norm() > 0.15;
    if (!(case_.in_turn ? turns : drives)) continue;
    t_start_ = t_start_ + Duration::from_s(t_s);
    return;
  }
  case_.in_motion = case_.in_turn = false;
  case_.features.erase("starts in motion");
  case_.features.erase("starts in a turn");
}

void Recording::take(sim::FleetSimulation& sim) {
  const Time t0 = sim.t_start();
  while (std::optional<sim::FleetMessage> message = sim.next()) {
    Track& track = tracks_[static_cast<std::size_t>(message->vehicle)];
    if (const auto* imu = std::get_if<sensor::ImuSample>(&message->data)) {
      const bool in = imu->t >= t_start_ && !within(case_.imu_missing, seconds_between(t0, imu->t));
      if (in) track.imu.push_back(*imu);
    } else if (const auto* scan =
                   std::get_if<std::shared_ptr<const sensor::LidarScan>>(&message->data)) {
      const Time t = (*scan)->t_start;
      const bool in = t >= t_start_ && !within(case_.lidar_missing, seconds_between(t0, t));
      if (!in) continue;
      track.scans.push_back({t, sim.last_raw_scan()});
      if (within(case_.lidar_covered, seconds_between(t0, t))) {
        cover(track.scans.back().raw, case_.setup.fleet.vehicle.ranging.resolution_m,
              case_.seed + track.scans.size());
      }
    } else if (const auto* range = std::get_if<sensor::RangeSample>(&message->data)) {
      if (range->t >= t_start_) ranges_.push_back(*range);
    }
  }
}

void Recording::add_truth(const sim::FleetSimulation& sim) {
  constexpr double kStep_s = 0.02;
  for (std::size_t v = 0; v < tracks_.size(); ++v) {
    geometry::Vec3 last;
    for (Time t = t_start_; t <= t_end_; t = t + Duration::from_s(kStep_s)) {
      const geometry::SE3 T = sim.truth(static_cast<int>(v), t).state.T_world_body;
      if (!tracks_[v].truth.empty()) tracks_[v].distance_m += (T.p - last).norm();
      last = T.p;
      tracks_[v].truth.push_back({t, T});
    }
  }
}

void Recording::spoil_ranges() {
  const RangeFaults& f = case_.ranges;
  Rng rng(case_.seed, "spoiled ranges");
  using Pair = std::tuple<VehicleId, VehicleId, std::uint8_t, std::uint8_t>;
  std::map<Pair, double> frozen_m;
  std::vector<sensor::RangeSample> out;
  for (sensor::RangeSample r : ranges_) {
    const double t_s = seconds_between(case_.setup.fleet.vehicle.start, r.t);
    if (within(f.missing, t_s)) continue;
    if (within(f.frozen, t_s)) {
      const Pair pair{r.from, r.to, r.from_antenna, r.to_antenna};
      r.range_m = frozen_m.emplace(pair, r.range_m).first->second;
    }
    if (within(f.biased, t_s)) r.range_m += f.biased_m;
    if (within(f.obstructed, t_s)) r.range_m -= f.obstructed_m * std::log(1.0 - rng.uniform());
    r.t = r.t + Duration::from_s(f.stamp_shift_s);
    out.push_back(r);
  }
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  ranges_ = std::move(out);
}

Result<std::shared_ptr<const Recording>> Recording::make(Case c, const Ranges& ranges) {
  Result<sim::World> world = planned_world(c, ranges);
  if (!world) return tl::make_unexpected(world.error());
  auto sim = sim::make_fleet_simulation(std::move(*world), c.setup.fleet);
  if (!sim) return tl::make_unexpected(sim.error());
  std::shared_ptr<Recording> out(new Recording(std::move(c)));
  out->begin(**sim);
  for (int v = 0; v < (*sim)->vehicles(); ++v) {
    Track track;
    track.name = fmt::format("v{}", v + 1);
    track.calibration = (*sim)->calibration_nominal(v);
    for (const sim::AntennaMount& mount : (*sim)->antennas(v)) {
      track.antennas_m.push_back(mount.p_nominal_m);
    }
    out->tracks_.push_back(std::move(track));
  }
  out->add_truth(**sim);
  out->take(**sim);
  out->spoil_ranges();
  out->world_ = (*sim)->world();
  return std::shared_ptr<const Recording>(std::move(out));
}

}  // namespace rali::campaign
