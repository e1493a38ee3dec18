#include "rali/cli/commands/doctor.hpp"

#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "rali/config/load_fleet.hpp"
#include "rali/drive/open_events.hpp"
#include "rali/drive/tbb_executor.hpp"
#include "rali/inspect/doctor.hpp"
#include "rali/io/files/atomic_file.hpp"
#include "rali/jobs/input_checks.hpp"
#include "rali/jobs/range_job.hpp"

namespace rali::cli {
namespace {

std::string word_or_empty(const std::string& word) { return word == "auto" ? "" : word; }

/// Topics of ranges that fleet.yaml names, with the names of its radios.
std::vector<inspect::RangeTopicNames> range_topics(const config::RangesConfig& ranges) {
  std::vector<inspect::RangeTopicNames> topics;
  for (const config::RangeSource& source : ranges.sources) {
    if (source.topic.empty()) continue;
    inspect::RangeTopicNames names{source.topic, {}};
    for (const auto& [number, radio] : source.ids) names.names[number] = radio.vehicle;
    topics.push_back(std::move(names));
  }
  return topics;
}

/// The doctor's options for a vehicle of fleet.yaml.
inspect::DoctorOptions options_of(const config::VehicleConfig& vehicle) {
  inspect::DoctorOptions options;
  options.imu_file = vehicle.imu.file;
  options.vehicle = vehicle.name;
  options.lidar_topic = word_or_empty(vehicle.lidar.topic);
  options.imu_topic = word_or_empty(vehicle.imu.topic);
  options.cloud = vehicle.lidar.cloud;
  if (vehicle.lidar.T_body_lidar.source == config::Extrinsics::Source::kGiven) {
    options.T_body_lidar = vehicle.lidar.T_body_lidar.T;
  }
  if (vehicle.imu.T_body_imu.source == config::Extrinsics::Source::kGiven) {
    options.T_body_imu = vehicle.imu.T_body_imu.T;
  }
  return options;
}

class DoctorCommand final : public Command {
 public:
  [[nodiscard]] std::string name() const override { return "doctor"; }

  [[nodiscard]] std::string summary() const override {
    return "is this recording fit, what is wrong, what to do";
  }

  [[nodiscard]] std::vector<std::string> examples() const override {
    return {"rali doctor run1.bag", "rali doctor v1.mcap v2.mcap --write fleet.yaml"};
  }

  [[nodiscard]] std::string exit_codes() const override {
    return "0 fine or warnings, 1 an error that spoils the map, 2 not readable";
  }

  [[nodiscard]] bool json() const override { return true; }

  [[nodiscard]] Positional positional() override {
    return {"INPUT", "recordings, folders of scans, or one fleet.yaml", &inputs_, 1, 64, {}};
  }

  [[nodiscard]] std::vector<Option> options() override {
    return {
        {"--seconds", "S", "data that is checked [s] (default 120); 0: all", &seconds_, false, {}},
        {"--write",
         "FILE",
         "write a first fleet.yaml with everything detected",
         &write_,
         false,
         {}},
        {"-o,--out", "DIR", "write doctor.json there", &out_dir_, false, {}},
        {"--lidar-topic", "TOPIC", "cloud topic, if there are several", &lidar_topic_, false, {}},
        {"--imu-topic", "TOPIC", "IMU topic, if there are several", &imu_topic_, false, {}},
        {"--ranges", "FILE", "CSV of ranges to check too", &ranges_, false, {}},
        {"--threads", "N", "0: one per core; results do not depend on it", &threads_, true, {}},
    };
  }

  [[nodiscard]] Result<int> run(Session& session) override;

 private:
  struct Plan {
    std::vector<inspect::DoctorOptions> recordings;
    inspect::RangeInputs ranges;
    std::vector<std::string> notices;  ///< about settings with old names
  };

  [[nodiscard]] Result<config::FleetConfig> load(bool yaml) const;
  [[nodiscard]] static Status check(const config::FleetConfig& fleet);
  [[nodiscard]] Result<Plan> plan() const;
  [[nodiscard]] Status write_files(const inspect::DoctorResult& result,
                                   const inspect::RangeInputs& inputs,
                                   const inspect::RangeStudy& ranges) const;

  std::vector<std::string> inputs_;
  double seconds_ = 120.0;
  std::string write_, out_dir_, lidar_topic_, imu_topic_, ranges_;
  int threads_ = 0;
};

Result<config::FleetConfig> DoctorCommand::load(bool yaml) const {
  config::Overrides overrides;
  if (!ranges_.empty()) {
    overrides.assignments.push_back(
        fmt::format("ranges.sources=[{{file: {}}}]", config::yaml_quoted(ranges_)));
  }
  return yaml ? config::load_fleet(inputs_.front(), overrides)
              : config::fleet_of_recordings(inputs_, overrides);
}

/// Errors that rali map reports before reading are reported here with the same sentence.
Status DoctorCommand::check(const config::FleetConfig& fleet) {
  if (Status status = jobs::check_side_files(fleet); !status) return status;
  const Result<drive::RangeOptions> ranges = jobs::range_options(fleet);
  if (!ranges) return tl::make_unexpected(ranges.error());
  if (Status status = jobs::check_recordings(fleet); !status) return status;
  for (const config::VehicleConfig& vehicle : fleet.vehicles) {
    const Result<bool> scans = drive::is_scan_folder(vehicle.recordings, vehicle.imu.file);
    if (!scans) return tl::make_unexpected(scans.error());
  }
  return {};
}

Result<DoctorCommand::Plan> DoctorCommand::plan() const {
  const std::string extension = std::filesystem::path(inputs_.front()).extension().string();
  const bool yaml = inputs_.size() == 1 && (extension == ".yaml" || extension == ".yml");
  const Result<config::FleetConfig> fleet = load(yaml);
  if (!fleet) return tl::make_unexpected(fleet.error());
  if (const Status status = check(*fleet); !status) return tl::make_unexpected(status.error());
  Plan plan;
  plan.notices = fleet->notices;
  plan.ranges.separate = fleet->clock == config::Clock::kSeparate;
  if (const Result<drive::RangeOptions> options = jobs::range_options(*fleet); options) {
    plan.ranges.serial = *options;
  }
  for (const config::RangeSource& source : fleet->ranges.sources) {
    if (!source.file.empty()) plan.ranges.files.push_back({source.file, {}});
    if (!source.topic.empty()) plan.ranges.topics.push_back(source.topic);
  }
  for (const config::VehicleConfig& vehicle : fleet->vehicles) {
    if (yaml) plan.ranges.vehicles.push_back(vehicle.name);
    inspect::DoctorOptions options = options_of(vehicle);
    options.seconds = seconds_;
    if (yaml) options.range_topics = range_topics(fleet->ranges);
    if (!lidar_topic_.empty()) options.lidar_topic = lidar_topic_;
    if (!imu_topic_.empty()) options.imu_topic = imu_topic_;
    if (!out_dir_.empty()) options.out_dir = out_dir_;
    for (const std::string& recording : vehicle.recordings) {
      options.path = recording;
      plan.recordings.push_back(options);
    }
  }
  return plan;
}

Status DoctorCommand::write_files(const inspect::DoctorResult& result,
                                  const inspect::RangeInputs& inputs,
                                  const inspect::RangeStudy& ranges) const {
  if (!write_.empty()) {
    std::error_code unreadable;
    if (std::filesystem::exists(write_, unreadable)) {
      return fail(ErrorCode::kUsage, write_, "the file exists", "Choose another name.");
    }
    const Status status = io::write_file_atomic(
        write_, inspect::doctor_fleet_yaml(result.recordings, inputs, ranges));
    if (!status) return status;
  }
  if (out_dir_.empty()) return {};
  std::error_code error;
  std::filesystem::create_directories(out_dir_, error);
  if (error) return fail(ErrorCode::kMachine, out_dir_, "the folder cannot be made", "");
  return io::write_file_atomic((std::filesystem::path(out_dir_) / "doctor.json").string(),
                               inspect::doctor_json(result));
}

Result<int> DoctorCommand::run(Session& session) {
  const Result<Plan> plan = this->plan();
  if (!plan) return tl::make_unexpected(plan.error());
  for (const std::string& notice : plan->notices) session.warning(printable(notice) + '.');
  const std::unique_ptr<Executor> executor = drive::make_executor(threads_);
  const bool text = !session.options.json;
  inspect::DoctorResult result;
  inspect::RangeStudy ranges;
  bool spoilt = false;
  for (const inspect::DoctorOptions& job : plan->recordings) {
    session.detail(fmt::format("checking {}", job.path));
    Result<inspect::DoctorReport> report = inspect::examine(job, *executor, ranges);
    if (!report) return tl::make_unexpected(report.error());
    if (text) session.result(inspect::doctor_text(*report));
    spoilt |= inspect::has_error(report->findings);
    result.recordings.push_back(std::move(*report));
  }
  Result<FindingList> of_ranges = inspect::examine_ranges(plan->ranges, result.recordings, ranges);
  if (!of_ranges) return tl::make_unexpected(of_ranges.error());
  result.ranges = std::move(*of_ranges);
  spoilt |= inspect::has_error(result.ranges);
  session.result(text ? inspect::ranges_text(result.ranges) : inspect::doctor_json(result));
  if (const Status status = write_files(result, plan->ranges, ranges); !status)
    return tl::make_unexpected(status.error());
  return spoilt ? kExitBelowAsked : kExitDone;
}

}  // namespace

std::unique_ptr<Command> make_doctor_command() { return std::make_unique<DoctorCommand>(); }

}  // namespace rali::cli
