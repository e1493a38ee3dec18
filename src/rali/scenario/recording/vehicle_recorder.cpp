#include "rali/scenario/recording/vehicle_recorder.hpp"

#include "rali/scenario/recording/container.hpp"
#include "rali/wire/encode.hpp"

namespace rali::scenario {

LidarDriver driver_of(sim::Lidar lidar) {
  constexpr LidarDriver kVelodyne{"/velodyne_points", "velodyne", "", wire::CloudStyle::kVelodyne};
  constexpr LidarDriver kOuster{"/ouster/points", "os_lidar", "", wire::CloudStyle::kOuster};
  const auto named = [](LidarDriver driver, std::string_view model) {
    driver.model = model;
    return driver;
  };
  switch (lidar) {
    case sim::Lidar::kRs16:
      return {"/rslidar_points", "rslidar", "rs16", wire::CloudStyle::kRoboSense};
    case sim::Lidar::kVlp16:
      return named(kVelodyne, "vlp16");
    case sim::Lidar::kHdl32e:
      return named(kVelodyne, "hdl32e");
    case sim::Lidar::kHdl64e:
      return named(kVelodyne, "hdl64e");
    case sim::Lidar::kOs1_64:
      return named(kOuster, "os1_64");
    case sim::Lidar::kOs0_128:
      return named(kOuster, "os0_128");
    case sim::Lidar::kLivox:
      break;
  }
  return {"/livox/lidar", "livox_frame", "avia", wire::CloudStyle::kLivox};
}

std::string recording_name(const std::string& vehicle, RecordingFormat format) {
  if (format == RecordingFormat::kMcap) return vehicle + ".mcap";
  if (format == RecordingFormat::kBag) return vehicle + ".bag";
  return vehicle;
}

namespace {

class ContainerRecorder final : public VehicleRecorder {
 public:
  ContainerRecorder(std::unique_ptr<Container> container, const Options& options)
      : container_(std::move(container)),
        driver_(driver_of(options.lidar)),
        cut_at_(options.cut_at) {}

  Status open() {
    const auto lidar = container_->add_topic(std::string(driver_.topic), "sensor_msgs/PointCloud2");
    if (!lidar) return tl::make_unexpected(lidar.error());
    lidar_ = *lidar;
    const auto imu = container_->add_topic(std::string(kImuTopic), "sensor_msgs/Imu");
    if (!imu) return tl::make_unexpected(imu.error());
    imu_ = *imu;
    return {};
  }

  Status add(const sensor::ImuSample& sample, Time t_record) override {
    cut_before(t_record);
    return container_->write(imu_, t_record, wire::encode({sample, "imu"}, container_->encoding()));
  }

  Status add(const sensor::LidarScan& scan, Time t_record) override {
    cut_before(t_record);
    if (scan.has_point_times) return write_cloud(pack(scan), t_record);
    // Drivers that do not fill the field leave it zero, also for absolute times.
    sensor::LidarScan timeless = scan;
    timeless.t_start = timeless.t_end = Time{};
    wire::PackedCloud cloud = pack(timeless);
    cloud.view.stamp = scan.t_start;
    return write_cloud(cloud, t_record);
  }

  Status close() override { return container_->close(); }

 private:
  void cut_before(Time t) {
    if (!cut_at_ || t < *cut_at_) return;
    container_->cut();
    cut_at_.reset();
  }

  [[nodiscard]] wire::PackedCloud pack(const sensor::LidarScan& scan) const {
    return wire::pack_cloud(scan, std::string(driver_.frame), driver_.style);
  }

  Status write_cloud(const wire::PackedCloud& cloud, Time t_record) {
    return container_->write(lidar_, t_record, wire::encode(cloud.view, container_->encoding()));
  }

  std::unique_ptr<Container> container_;
  LidarDriver driver_;
  std::optional<Time> cut_at_;
  std::size_t lidar_ = 0, imu_ = 0;
};

}  // namespace

Result<std::unique_ptr<VehicleRecorder>> VehicleRecorder::create(const Options& options) {
  const std::string path = options.folder + "/" + recording_name(options.vehicle, options.format);
  auto container = Container::create(path, options.format);
  if (!container) return tl::make_unexpected(container.error());
  auto recorder = std::make_unique<ContainerRecorder>(std::move(*container), options);
  if (Status opened = recorder->open(); !opened) return tl::make_unexpected(opened.error());
  return recorder;
}

}  // namespace rali::scenario
