#include "rali/vehicle/vehicle.hpp"

#include <deque>
#include <limits>
#include <utility>

#include "rali/degeneracy/information.hpp"
#include "rali/fleet/facts/keyframe_number.hpp"
#include "rali/fleet/path/level.hpp"
#include "rali/odometry/make_odometry.hpp"
#include "rali/ranging/range_model.hpp"
#include "rali/vehicle/fact_writer.hpp"
#include "rali/vehicle/noise_tally.hpp"
#include "rali/vehicle/odom_frame.hpp"
#include "rali/vehicle/paper_detector.hpp"
#include "rali/vehicle/paper_range_stage.hpp"
#include "rali/vehicle/pose_report.hpp"
#include "rali/vehicle/range_stage.hpp"

namespace rali::vehicle {

using sensor::ImuSample;
using sensor::LidarScan;

/// Holds scans back until the inertial data reach their end, then runs the stages on them.
class Vehicle::Impl {
 public:
  Impl(VehicleId self, const VehicleSettings& settings)
      : settings_(settings),
        self_(self),
        first_keyframe_(fleet::first_keyframe_of(settings.facts.epoch)),
        odometry_(
            odometry::make_odometry(settings.odometry, settings.calibration, settings.has_imu)),
        paper_(settings),
        ranges_(self, settings),
        path_(settings),
        facts_(self, settings),
        categories_(settings.odometry.robust.aware) {
    if (settings.odometry.preset != odometry::Preset::kPaper) return;
    paper_ranges_ = std::make_unique<PaperRangeStage>(self, settings);
    odometry_->correct_keyframes_by(paper_ranges_.get());
  }

  void on(const ImuSample& sample, Executor& executor, OutputList& out) {
    if (sample.t <= t_imu_) return;  // the driver counts late samples
    if (!sample.gyro_radps.allFinite() || !sample.accel_mps2.allFinite()) {
      if (!broken_imu_reported_) out.emplace_back(broken(sample));
      broken_imu_reported_ = true;
      return;
    }
    t_imu_ = sample.t;
    odometry_->add_imu(sample);
    path_.add(sample);
    run_waiting(executor, out, false);
  }

  void on(const std::shared_ptr<const LidarScan>& scan, Executor& executor, OutputList& out) {
    if (!scan || scan->t_end <= t_scan_) {
      out.emplace_back(refused(scan));
      return;
    }
    t_scan_ = scan->t_end;
    waiting_.push_back(scan);
    run_waiting(executor, out, false);
  }

  void on(const EndOfData& /*end*/, Executor& executor, OutputList& out) {
    run_waiting(executor, out, true);
    if (paper_ranges_) paper_ranges_->flush(out);
    ranges_.flush(out);
    FindingList findings;
    odometry_->finish(findings);
    report(std::move(findings), out);
    facts_.flush(out);
    out.emplace_back(GravityEstimate{self_, t_scan_, odometry_->gravity_odom(),
                                     odometry_->gravity_covariance()});
  }

  void on(const sensor::RangeSample& sample, Executor& /*executor*/, OutputList& out) {
    if (paper_ranges_) {
      // Without scans no range gets a pose: only the last seconds can be of use.
      constexpr std::size_t kReceivedMax = 10'000;
      if (received_.size() >= kReceivedMax) received_.pop_front();
      received_.push_back(sample);
      return paper_ranges_->add(sample, out);
    }
    ranges_.add(sample, out);
  }

  void on(const PeerStatus& status, Executor& /*executor*/, OutputList& /*out*/) {
    if (paper_ranges_) return paper_ranges_->on(status);
    ranges_.on(status);
  }

  // The strength of the data link ends rounds of the fleet: no single vehicle decides that.
  void on(const sensor::RadioSample& /*sample*/, Executor& /*executor*/, OutputList& /*out*/) {}

  [[nodiscard]] std::optional<RangeStampOffset> range_stamp_offset() const {
    const odometry::AugmentedFilter* filter = odometry_->augmented_filter();
    const int state = ranges_.stamp_offset_state();
    if (filter == nullptr || state < 0) return std::nullopt;
    const odometry::AugmentedStates& augmented = filter->augmented();
    return RangeStampOffset{augmented.mean[state], std::sqrt(augmented.covariance(state, state))};
  }

  [[nodiscard]] imu::MeasuredNoise measured_noise() const { return noise_.mean(); }

  [[nodiscard]] std::uint64_t state_hash() const { return odometry_->state_hash(); }

 private:
  [[nodiscard]] Finding refused(const std::shared_ptr<const LidarScan>& scan) const {
    Finding f;
    f.id = "vehicle.late_scan";
    f.t = scan ? scan->t_end : t_scan_;
    f.vehicle = settings_.name;
    f.text = "a scan that ends before the one already processed was refused";
    return f;
  }

  /// Reported once per vehicle: a broken sensor fails 200 times a second.
  [[nodiscard]] Finding broken(const ImuSample& sample) const {
    Finding f;
    f.id = "vehicle.broken_imu";
    f.t = sample.t;
    f.vehicle = settings_.name;
    f.text = "an inertial sample that is not a number was refused, more such samples will be too";
    return f;
  }

  /// Reported once: the next number is that of the first keyframe after a restart.
  [[nodiscard]] Finding no_more_keyframes(Time t) const {
    Finding f;
    f.id = "vehicle.keyframes_full";
    f.severity = Severity::kError;
    f.t = t;
    f.vehicle = settings_.name;
    f.text = "all keyframe numbers of this start are used";
    f.effect = "no more keyframes are added to the map";
    f.remedy = "Restart the vehicle's software.";
    return f;
  }

  void report(FindingList findings, OutputList& out) const {
    for (Finding& f : findings) {
      f.vehicle = settings_.name;
      out.emplace_back(std::move(f));
    }
  }

  void run_waiting(Executor& executor, OutputList& out, bool all) {
    const Duration patience = Duration::from_s(settings_.imu_wait_s);
    while (!waiting_.empty()) {
      const Time t_end = waiting_.front()->t_end;
      const bool covered = !settings_.has_imu || t_imu_ >= t_end;
      if (!covered && !all && t_scan_ - t_end < patience) return;
      const std::shared_ptr<const LidarScan> scan = waiting_.front();
      waiting_.pop_front();
      run(*scan, executor, out);
    }
  }

  void run(const LidarScan& scan, Executor& executor, OutputList& out) {
    if (paper_ranges_) paper_ranges_->before_scan(scan.t_end, out);
    RangeEffect effect = ranges_.run(scan.t_end, odometry_->augmented_filter(),
                                     odometry_->gravity_odom(), first_pose_, out);
    const std::shared_ptr<const LidarScan> masked = without_peers_in(scan);
    const LidarScan& seen = masked ? *masked : scan;
    FindingList findings;
    const odometry::ScanResult result = odometry_->process(seen, executor, findings);
    report(std::move(findings), out);
    noise_.add(result.measured_noise);
    if (result.state == odometry::TrackState::kWaiting) return;
    if (paper_ranges_) effect = paper_ranges_->after_scan(result, out);
    PoseEstimate pose = pose_of(self_, result);
    pose.seeks_gravity = settings_.has_imu && !result.inertial;
    if (result.inertial) {
      pose.level_sigma_rad =
          level_sigma_rad(odometry_->gravity_odom(), odometry_->gravity_covariance());
    }
    pose.T_odom_body = odom_.follow(result);
    pose.correction_m = effect.shift_m;
    pose.range_from = effect.from;
    if (!first_pose_) first_pose_ = result.T_odom_body;
    pose.degeneracy = degeneracy_of(result, settings_.odometry, odometry_->gravity_odom(), axes_);
    pose.degeneracy.paper = paper_.degree(seen, result, odometry_->gravity_odom());
    // The first scan of a map has nothing to be compared with: that is no degeneracy.
    const bool compared = result.matches > 0 || result.state == odometry::TrackState::kPredicted;
    if (compared) {
      categories_.apply(pose.degeneracy);
    } else {
      pose.degeneracy.sigma_degenerate_m = std::numeric_limits<double>::infinity();
    }
    watch_path(result.t, compared && pose.degeneracy.degenerate);
    out.emplace_back(pose);
    std::optional<KeyframeId> keyframe;
    if (result.keyframe && keyframes_ == fleet::kKeyframesPerEpoch) {
      if (!std::exchange(keyframes_full_reported_, true))
        out.emplace_back(no_more_keyframes(result.t));
    } else if (result.keyframe) {
      keyframe = KeyframeId{self_, first_keyframe_ + keyframes_++};
      out.emplace_back(KeyframeAdded{*keyframe, result.keyframe});
    }
    record(result, keyframe, pose, out);
    out.emplace_back(status_of(result));
  }

  /// Preset `paper` has no filter that gives poses between scans: those of ranges are interpolated
  /// from one to the next.
  std::vector<fleet::RangeEntry> received_until(const odometry::ScanResult& result) {
    std::vector<fleet::RangeEntry> entries;
    while (!received_.empty() && received_.front().t <= result.t) {
      const sensor::RangeSample& r = received_.front();
      if (last_ && r.t > last_->t) {
        const double fraction = (r.t - last_->t).s() / (result.t - last_->t).s();
        fleet::RangeEntry entry{
            r.t,
            r.from,
            r.to,
            r.from_antenna,
            r.to_antenna,
            r.range_m,
            ranging::sigma_of(r.range_m, settings_.ranging.limits, r.sigma_m),
            geometry::interpolate(last_->T_odom_body, result.T_odom_body, fraction),
            result.at_rest};
        entries.push_back(entry);
      }
      received_.pop_front();
    }
    last_ = PathEnd{result.t, result.T_odom_body};
    return entries;
  }

  /// The status that is broadcast after each scan.
  [[nodiscard]] PeerStatus status_of(const odometry::ScanResult& result) const {
    PeerStatus status{self_, result.t, result.at_rest, std::nullopt};
    const bool known = result.inertial && result.state != odometry::TrackState::kDiverged;
    if (!known) return status;
    const geometry::SE3 T_start_odom =
        fleet::level_start(*first_pose_, -odometry_->gravity_odom().normalized()).inverse();
    const geometry::Mat3 P = result.covariance.bottomRightCorner<3, 3>();
    status.pose = {T_start_odom * result.T_odom_body,
                   T_start_odom.R * P * T_start_odom.R.transpose()};
    const odometry::AugmentedFilter* filter = odometry_->augmented_filter();
    if (result.at_rest && filter != nullptr) {
      status.pose->walls = ranges_.walls(*filter, result.T_odom_body);
      if (auto& walls = status.pose->walls) walls->axis = T_start_odom.R * walls->axis;
      status.pose->seen = ranges_.seen(*filter, result.T_odom_body);
      for (SeenPeer& peer : status.pose->seen) {
        peer.apart_start_m = T_start_odom.R * peer.apart_start_m;
        peer.covariance_m2 = T_start_odom.R * peer.covariance_m2 * T_start_odom.R.transpose();
      }
    }
    return status;
  }

  void record(const odometry::ScanResult& result, const std::optional<KeyframeId>& keyframe,
              const PoseEstimate& pose, OutputList& out) {
    // A new map starts where the old one was lost: the graph has no factor across.
    if (result.state == odometry::TrackState::kDiverged) {
      path_.cut();
      return;
    }
    const std::optional<PathNode> node = path_.add(result, keyframe, pose.degeneracy.degenerate,
                                                   odometry_->gravity_odom(), pose.level_sigma_rad);
    facts_.add(result.t, node, result.keyframe.get(),
               paper_ranges_ ? received_until(result) : ranges_.entries(), out);
  }

  /// One degenerate scan is ignored: only several in a row count as a degenerate stretch.
  void watch_path(Time t, bool degenerate) {
    if (!degenerate) return degenerate_since_.reset();
    if (!degenerate_since_) degenerate_since_ = t;
    if ((t - *degenerate_since_).s() >= settings_.peer_mask.shell_after_s) t_degenerate_ = t;
  }

  /// The scan without the points on peers; null if none is left out.
  std::shared_ptr<const LidarScan> without_peers_in(const LidarScan& scan) {
    odometry::AugmentedFilter* filter = odometry_->augmented_filter();
    if (!settings_.peer_mask.use || filter == nullptr) return nullptr;
    const PeerMaskSettings& mask = settings_.peer_mask;
    const std::vector<KnownLandmark> places = ranges_.places(*filter, scan.t_end, mask.sigma_max_m);
    // A column that takes its own vehicles for static objects estimates no motion. Where the LiDAR
    // is not degenerate, the ring of walls at their range is worth more than their points can
    // spoil.
    std::vector<ReceivedPeer> received;
    if (t_degenerate_ && (scan.t_end - *t_degenerate_).s() < mask.shell_hold_s) {
      received = ranges_.unplaced(*filter, scan.t_end, mask.sigma_max_m);
    }
    if (places.empty() && received.empty()) return nullptr;
    const std::optional<odometry::Moment> now = filter->advance_to(scan.t_end);
    if (!now) return nullptr;
    const geometry::SE3& T_body_lidar = settings_.calibration.T_body_lidar;
    return without_peers(scan, now->T_odom_body * T_body_lidar, T_body_lidar, places, received,
                         -odometry_->gravity_odom().normalized(), mask);
  }

  VehicleSettings settings_;
  VehicleId self_;
  std::uint32_t first_keyframe_ = 0;  ///< number of the first one of this epoch
  std::unique_ptr<odometry::Odometry> odometry_;
  PaperDetector paper_;
  RangeStage ranges_;
  std::unique_ptr<PaperRangeStage> paper_ranges_;  ///< replaces it in preset `paper`
  PathRecorder path_;
  FactWriter facts_;
  std::optional<geometry::SE3> first_pose_;
  std::optional<Time> degenerate_since_;  ///< the first of the degenerate scans in a row
  std::optional<Time> t_degenerate_;      ///< the last one, if they lasted long enough

  struct PathEnd {
    Time t;
    geometry::SE3 T_odom_body;
  };

  std::optional<PathEnd> last_;               ///< of preset `paper`
  std::deque<sensor::RangeSample> received_;  ///< since then, by time
  OdomFrame odom_;
  NoiseTally noise_;
  degeneracy::CategoryFilter categories_;
  degeneracy::Axes axes_ = degeneracy::Axes::Identity();
  std::deque<std::shared_ptr<const LidarScan>> waiting_;
  Time t_imu_ = Time{std::numeric_limits<std::int64_t>::min()};
  Time t_scan_ = Time{std::numeric_limits<std::int64_t>::min()};
  std::uint32_t keyframes_ = 0;  ///< of this epoch
  bool keyframes_full_reported_ = false;
  bool broken_imu_reported_ = false;
};

Vehicle::Vehicle(VehicleId self, const VehicleSettings& settings)
    : impl_(std::make_unique<Impl>(self, settings)) {}

Vehicle::~Vehicle() = default;
Vehicle::Vehicle(Vehicle&&) noexcept = default;
Vehicle& Vehicle::operator=(Vehicle&&) noexcept = default;

void Vehicle::step(const Event& event, Executor& executor, OutputList& out) {
  std::visit([&](const auto& e) { impl_->on(e, executor, out); }, event);
}

std::optional<RangeStampOffset> Vehicle::range_stamp_offset() const {
  return impl_->range_stamp_offset();
}

imu::MeasuredNoise Vehicle::measured_noise() const { return impl_->measured_noise(); }

std::uint64_t Vehicle::state_hash() const { return impl_->state_hash(); }

}  // namespace rali::vehicle
