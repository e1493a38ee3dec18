#include "rali/scenario/recording/write_recording.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "rali/io/files/atomic_file.hpp"
#include "rali/io/files/csv_writer.hpp"
#include "rali/scenario/faults/fault_filter.hpp"
#include "rali/scenario/recording/fleet_yaml.hpp"
#include "rali/scenario/recording/truth_files.hpp"
#include "rali/scenario/vehicle_names.hpp"

namespace rali::scenario {

using sensor::ImuSample;
using sensor::RadioSample;
using sensor::RangeSample;

namespace {

using ScanPtr = std::shared_ptr<const sensor::LidarScan>;

/// Time at which a recorder gets a message: when the sensor has sent it, by a correct clock.
Time arrival_of(const sim::FleetMessage& message) {
  if (const auto* scan = std::get_if<ScanPtr>(&message.data)) return (*scan)->t_end;
  if (const auto* imu = std::get_if<ImuSample>(&message.data)) return imu->t;
  if (const auto* range = std::get_if<RangeSample>(&message.data)) return range->t;
  return std::get<RadioSample>(message.data).t;
}

/// All files of one recording whose size grows with the data.
class FleetRecorder {
 public:
  FleetRecorder(sim::FleetSimulation& sim, const RecordingOptions& options)
      : sim_(sim),
        options_(options),
        names_(vehicle_names(sim.vehicles())),
        filter_(options.faults, sim.t_start(), options.seed) {}

  Status open();
  Status add(sim::FleetMessage message);
  /// Completes all files at time `until`.
  Status finish(Time until);

  RecordingSummary summary;

 private:
  Status open_vehicles();
  Status open_tables();
  Status write(const ImuSample& imu, std::size_t v, Time t_record);
  Status write(const ScanPtr& scan, std::size_t v, Time t_record);
  Status write(const RangeSample& range, std::size_t v, Time t_record);
  Status write(const RadioSample& radio, std::size_t v, Time t_record);

  [[nodiscard]] bool several_antennas() const { return sim_.antennas(0).size() > 1; }

  sim::FleetSimulation& sim_;
  const RecordingOptions& options_;
  std::vector<std::string> names_;
  FaultFilter filter_;
  std::vector<std::unique_ptr<VehicleRecorder>> recorders_;
  std::optional<TruthFiles> truth_;
  std::optional<io::CsvWriter> ranges_, radio_;
};

Status FleetRecorder::open_vehicles() {
  for (std::size_t v = 0; v < names_.size(); ++v) {
    const std::optional<Time> cut_at = filter_.cut_at(static_cast<int>(v));
    auto recorder = VehicleRecorder::create(
        {options_.folder, names_[v], options_.format, options_.lidar, cut_at});
    if (!recorder) return tl::make_unexpected(recorder.error());
    recorders_.push_back(std::move(*recorder));
    VehicleSummary vehicle;
    vehicle.name = names_[v];
    vehicle.file = recording_name(names_[v], options_.format);
    vehicle.cut = cut_at && *cut_at < sim_.t_end();
    summary.vehicles.push_back(std::move(vehicle));
  }
  return {};
}

Status FleetRecorder::open_tables() {
  if (names_.size() < 2) return {};
  std::vector<std::string> columns{"stamp_s", "from",     "to",
                                   "range_m", "rssi_dbm", "first_path_dbm"};
  if (several_antennas()) {
    columns.emplace_back("from_antenna");
    columns.emplace_back("to_antenna");
  }
  auto ranges = io::CsvWriter::create(options_.folder + "/ranges.csv", columns);
  if (!ranges) return tl::make_unexpected(ranges.error());
  ranges_.emplace(std::move(*ranges));
  auto radio =
      io::CsvWriter::create(options_.folder + "/radio.csv", {"stamp_s", "from", "to", "rssi_dbm"});
  if (!radio) return tl::make_unexpected(radio.error());
  radio_.emplace(std::move(*radio));
  return {};
}

Status FleetRecorder::open() {
  summary.title = options_.title;
  summary.seed = options_.seed;
  summary.faults = options_.faults;
  summary.duration_s = seconds_between(sim_.t_start(), sim_.t_end());
  if (Status s = open_vehicles(); !s) return s;
  if (Status s = open_tables(); !s) return s;
  auto truth = TruthFiles::create(options_.folder + "/truth", names_, sim_);
  if (!truth) return tl::make_unexpected(truth.error());
  truth_.emplace(std::move(*truth));
  return {};
}

Status FleetRecorder::write(const ImuSample& imu, std::size_t v, Time t_record) {
  ++summary.vehicles[v].imu_samples;
  return recorders_[v]->add(imu, t_record);
}

Status FleetRecorder::write(const ScanPtr& scan, std::size_t v, Time t_record) {
  ++summary.vehicles[v].scans;
  summary.vehicles[v].points += scan->size();
  return recorders_[v]->add(*scan, t_record);
}

Status FleetRecorder::write(const RangeSample& range, std::size_t /*v*/, Time t_record) {
  ++summary.ranges;
  io::CsvRow row;
  row.stamp(range.t).text(names_[range.from.value]).text(names_[range.to.value]);
  row.fixed(range.range_m, 3).fixed(range.rssi_dbm, 1).fixed(range.first_path_dbm, 1);
  if (several_antennas()) row.integer(range.from_antenna).integer(range.to_antenna);
  return ranges_->add(row, t_record);
}

Status FleetRecorder::write(const RadioSample& radio, std::size_t /*v*/, Time t_record) {
  ++summary.radio_readings;
  io::CsvRow row;
  row.stamp(radio.t).text(names_[radio.from.value]).text(names_[radio.to.value]);
  row.fixed(radio.rssi_dbm, 1);
  return radio_->add(row, t_record);
}

Status FleetRecorder::add(sim::FleetMessage message) {
  const Time t = arrival_of(message);
  const auto v = static_cast<std::size_t>(message.vehicle);
  if (Status s = truth_->reach(t, sim_); !s) return s;
  const bool is_range = std::holds_alternative<RangeSample>(message.data);
  if (is_range) {
    const sim::RangeTruth& truth = sim_.last_range_truth();
    summary.ranges_obstructed += truth.obstructed ? 1 : 0;
    if (Status s = truth_->add(std::get<RangeSample>(message.data), truth); !s) return s;
  }
  const std::optional<sim::FleetMessage> kept = filter_.apply(std::move(message));
  if (!kept) {
    ++(is_range ? summary.ranges_spoilt : summary.vehicles[v].lost);
    return {};
  }
  return std::visit([&](const auto& data) { return write(data, v, t); }, kept->data);
}

Status FleetRecorder::finish(Time until) {
  summary.duration_s = seconds_between(sim_.t_start(), until);
  for (const auto& recorder : recorders_) {
    if (Status s = recorder->close(); !s) return s;
  }
  if (ranges_) {
    if (Status s = ranges_->finish(); !s) return s;
    if (Status s = radio_->finish(); !s) return s;
  }
  if (Status s = truth_->finish(until, sim_); !s) return s;
  for (std::size_t v = 0; v < names_.size(); ++v) summary.vehicles[v].path_m = truth_->path_m(v);
  const std::string yaml = fleet_yaml(sim_, names_, options_);
  if (Status s = io::write_file_atomic(options_.folder + "/fleet.yaml", yaml); !s) return s;
  if (options_.scene_yaml.empty()) return {};
  return io::write_file_atomic(options_.folder + "/scene.yaml", options_.scene_yaml);
}

Status record_all(sim::FleetSimulation& sim, FleetRecorder& recorder,
                  const RecordingProgress& progress) {
  const double span_s = seconds_between(sim.t_start(), sim.t_end());
  Time reported = sim.t_start();
  while (std::optional<sim::FleetMessage> message = sim.next()) {
    const Time t = arrival_of(*message);
    if (Status s = recorder.add(std::move(*message)); !s) return s;
    if (seconds_between(reported, t) < 0.1) continue;
    reported = t;
    if (progress(std::min(1.0, seconds_between(sim.t_start(), t) / span_s))) continue;
    recorder.summary.interrupted = true;
    return recorder.finish(t);
  }
  return recorder.finish(sim.t_end());
}

Status record_driven(sim::FleetSimulation& sim, FleetRecorder& recorder,
                     const RecordingDrive& drive) {
  const Result<bool> interrupted =
      drive([&](const sim::FleetMessage& message) { return recorder.add(message); });
  if (!interrupted) return tl::make_unexpected(interrupted.error());
  recorder.summary.interrupted = *interrupted;
  return recorder.finish(sim.t_end());
}

/// Text for a JSON string: control characters removed, quotes and backslashes escaped.
std::string json_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20U) continue;
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

/// Marks the folder as written by this program before it has contents, and as complete at the end.
Status write_mark(const std::string& folder, const std::string& json) {
  return io::write_file_atomic(folder + "/simulation.json", json);
}

}  // namespace

std::string summary_json(const RecordingSummary& s) {
  std::string vehicles;
  for (const VehicleSummary& v : s.vehicles) {
    vehicles += fmt::format(
        "{}    \"{}\": {{\"file\": \"{}\", \"scans\": {}, \"points\": {}, \"imu_samples\": {}, "
        "\"lost\": {}, \"distance_m\": {:.3f}, \"cut\": {}}}",
        vehicles.empty() ? "" : ",\n", v.name, v.file, v.scans, v.points, v.imu_samples, v.lost,
        v.path_m, v.cut);
  }
  std::string faults;
  for (const Fault& fault : s.faults) {
    faults += fmt::format("{}\"{}\"", faults.empty() ? "" : ", ", fault_text(fault));
  }
  return fmt::format(
      "{{\n  \"schema\": 1,\n  \"status\": \"{}\",\n  \"scene\": \"{}\",\n  \"seed\": {},\n"
      "  \"duration_s\": {:.3f},\n  \"vehicles\": {{\n{}\n  }},\n"
      "  \"ranges\": {{\"total\": {}, \"obstructed\": {}, \"taken_by_faults\": {}}},\n"
      "  \"radio_readings\": {},\n  \"faults\": [{}]\n}}\n",
      s.interrupted ? "interrupted" : "complete", json_text(s.title), s.seed, s.duration_s,
      vehicles, s.ranges, s.ranges_obstructed, s.ranges_spoilt, s.radio_readings, faults);
}

static Result<RecordingSummary> record(sim::FleetSimulation& sim, const RecordingOptions& options,
                                       const std::function<Status(FleetRecorder&)>& run) {
  FleetRecorder recorder(sim, options);
  Status status = write_mark(options.folder, "{\"schema\": 1, \"status\": \"running\"}\n");
  if (status) status = recorder.open();
  if (status) status = run(recorder);
  if (status) status = write_mark(options.folder, summary_json(recorder.summary));
  if (!status) return tl::make_unexpected(status.error());
  return std::move(recorder.summary);
}

Result<RecordingSummary> write_recording(sim::FleetSimulation& sim, const RecordingOptions& options,
                                         const RecordingProgress& progress) {
  return record(sim, options, [&](FleetRecorder& r) { return record_all(sim, r, progress); });
}

Result<RecordingSummary> record_drive(sim::FleetSimulation& sim, const RecordingOptions& options,
                                      const RecordingDrive& drive) {
  return record(sim, options, [&](FleetRecorder& r) { return record_driven(sim, r, drive); });
}

}  // namespace rali::scenario
