#include "rali/recording.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/api/convert.hpp"
#include "rali/api/errors.hpp"
#include "rali/api_io/fleet_config.hpp"
#include "rali/drive/member_job.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/ranges/range_files.hpp"
#include "rali/jobs/map_job.hpp"

namespace rali {
namespace {

using InnerScan = std::shared_ptr<const sensor::LidarScan>;

std::size_t index_of(const api::VehicleNames& names, const std::string& vehicle) {
  if (vehicle.empty() && names.size() == 1) return 0;
  const auto found = std::find(names.begin(), names.end(), vehicle);
  if (found == names.end()) {
    throw SettingsError("vehicle", fmt::format("'{}' is none of the fleet", vehicle),
                        fmt::format("Choose one of: {}.", fmt::join(names, ", ")));
  }
  return static_cast<std::size_t>(found - names.begin());
}

Time time_of(const vehicle::Event& event) {
  if (const auto* imu = std::get_if<sensor::ImuSample>(&event)) return imu->t;
  if (const auto* scan = std::get_if<InnerScan>(&event)) return (*scan)->t_end;
  if (const auto* range = std::get_if<sensor::RangeSample>(&event)) return range->t;
  return {};
}

}  // namespace

struct RecordingReader::Impl {
  Impl(const config::FleetConfig& fleet, const std::string& vehicle)
      : job(api::value_or_throw(jobs::make_map_job(fleet, {}))),
        names(drive::vehicle_names(job)),
        index(index_of(names, vehicle)),
        range_m(job.vehicles[index].input.cloud.range_m) {
    const auto ranges = std::make_shared<const drive::RangeOptions>(job.ranges);
    source = api::value_or_throw(drive::open_events(drive::member_job(job, index, ranges)));
    file_ranges = api::value_or_throw(drive::read_range_files(job.ranges)).samples;
    std::erase_if(file_ranges, [&](const sensor::RangeSample& r) { return !concerns(r); });
  }

  /// Whether the vehicle or one of its peers is an end of the range.
  [[nodiscard]] bool concerns(const sensor::RangeSample& range) const {
    const bool own = range.from.value == index || range.to.value == index;
    return own && drive::judge_range(range, job.ranges) == ranging::RangeReason::kNoPose;
  }

  void fetch() {
    while (!next && !ended) {
      std::optional<vehicle::Event> event = api::value_or_throw(source->next());
      const auto* range = event ? std::get_if<sensor::RangeSample>(&*event) : nullptr;
      if (range != nullptr && !concerns(*range)) continue;
      ended = !event;
      next = std::move(event);
    }
  }

  [[nodiscard]] std::optional<Event> take() {
    fetch();
    if (next_range < file_ranges.size() && (!next || file_ranges[next_range].t <= time_of(*next))) {
      return api::public_range(file_ranges[next_range++], names);
    }
    if (!next) {
      if (std::exchange(reported_end, true)) return std::nullopt;
      return EndOfData{};
    }
    const vehicle::Event event = *std::exchange(next, std::nullopt);
    if (const auto* imu = std::get_if<sensor::ImuSample>(&event)) {
      return ImuSample{imu->t.ns, imu->gyro_radps, imu->accel_mps2};
    }
    if (const auto* scan = std::get_if<InnerScan>(&event)) return api::public_scan(**scan);
    return api::public_range(std::get<sensor::RangeSample>(event), names);
  }

  drive::MapJob job;
  api::VehicleNames names;
  std::size_t index;
  std::array<double, 2> range_m;
  std::unique_ptr<drive::ReportedSource> source;
  std::vector<sensor::RangeSample> file_ranges;
  std::size_t next_range = 0;
  std::optional<vehicle::Event> next;
  bool ended = false, reported_end = false;
};

RecordingReader::RecordingReader(const FleetConfig& config, const std::string& vehicle)
    : impl_(std::make_unique<Impl>(config.impl().fleet, vehicle)) {}

RecordingReader::~RecordingReader() = default;
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;

std::optional<Event> RecordingReader::next() { return impl_->take(); }

VehicleOptions RecordingReader::vehicle_options() const {
  VehicleOptions options = api_io::public_options(
      drive::settings_with(impl_->job.vehicles[impl_->index].settings, impl_->source->report()));
  options.range_m = impl_->range_m;
  return options;
}

double RecordingReader::progress() const { return impl_->source->progress(); }

std::vector<RunFinding> RecordingReader::findings() const {
  const drive::InputReport& report = impl_->source->report();
  std::vector<RunFinding> findings;
  for (const Finding& finding : report.findings) {
    findings.push_back(api::public_finding(finding, report.vehicle));
  }
  return findings;
}

}  // namespace rali
