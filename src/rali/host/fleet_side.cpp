#include "rali/host/fleet_side.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "rali/host/mode_words.hpp"
#include "rali/wire/encode.hpp"

namespace rali::host {
namespace {

constexpr double kFrame_s = 0.5, kDelta_s = 2.0, kGrid_s = 5.0, kCloud_s = 30.0, kPaths_s = 10.0;
constexpr double kRole_s = 1.0;
constexpr std::size_t kFindingsShown = 32, kRangesShown = 64;

wire::DiagnosticStatus status_of_line(const DiagnosticLine& line, const std::string& vehicle) {
  wire::DiagnosticStatus status;
  status.level = static_cast<wire::DiagnosticStatus::Level>(line.level);
  status.name = vehicle + '/' + line.name;
  status.message = line.message;
  status.hardware_id = vehicle;
  if (!line.remedy.empty()) status.values.emplace_back("remedy", line.remedy);
  if (line.age_s) status.values.emplace_back("age_s", fmt::format("{:.1f}", *line.age_s));
  return status;
}

}  // namespace

FleetSide::FleetSide(FleetSideSetup setup, HostTime now)
    : setup_(std::move(setup)),
      outputs_(setup_.agent.names[setup_.agent.self.value]),
      start_boot_(now.boot),
      offset_(now.wall - now.boot),
      picture_(std::make_unique<MapPicture>(setup_.grid)) {
  next_frame_ = next_delta_ = next_frontiers_ = next_grid_ = next_cloud_ = next_paths_ =
      next_role_ = now.boot;
}

/// @param ahead stamps of the sensors minus the wall clock
void FleetSide::start_agent(HostTime now, Duration ahead) {
  offset_ = now.wall - now.boot + ahead;
  agent_ = std::make_unique<Agent>(setup_.agent, agent_time(now));
  setup_.agent.start.facts.clear();  // the node has them
}

void FleetSide::take(ToAgent news, HostTime now, FleetSideOutputs& out) {
  if (const auto* clock = std::get_if<ClockNews>(&news)) {
    if (!agent_) start_agent(now, clock->ahead);
  } else if (auto* sensors = std::get_if<SensorNews>(&news)) {
    sensors_ = std::move(*sensors);
  } else if (agent_) {
    const Time t = agent_time(now);
    if (const auto* range = std::get_if<RangeNews>(&news)) {
      agent_->take(range->sample, t, agent_out_);
    } else if (const auto* goals = std::get_if<GoalNews>(&news)) {
      agent_->take(goals->status);
    } else {
      take_output(std::get<VehicleNews>(news).output, t, now, out);
    }
    sort_out(now, out);
  }
}

void FleetSide::take_output(const vehicle::Output& output, Time t, HostTime now,
                            FleetSideOutputs& /*out*/) {
  if (const auto* pose = std::get_if<vehicle::PoseEstimate>(&output)) {
    const bool degenerate = pose->degeneracy.degenerate;
    if (!degenerate) degenerate_since_.reset();
    if (degenerate && !degenerate_since_) degenerate_since_ = now.boot;
    const geometry::Vec3& p = pose->T_odom_body.p;
    constexpr double kStep_m = 0.1;  // less is noise at standstill
    if (!p_last_) p_last_ = p;
    if ((p - *p_last_).norm() >= kStep_m) {
      distance_m_ += (p - *p_last_).norm();
      p_last_ = p;
    }
  } else if (const auto* use = std::get_if<ranging::RangeUse>(&output)) {
    ranges_.push_back({*use, now.boot});
    if (ranges_.size() > kRangesShown) ranges_.pop_front();
  }
  agent_->take(output, t, agent_out_);
}

void FleetSide::receive(VehicleId from, std::span<const std::byte> bytes, HostTime now,
                        FleetSideOutputs& out) {
  if (!agent_) return;
  agent_->receive(from, bytes, agent_time(now), agent_out_);
  sort_out(now, out);
}

void FleetSide::take(const fleet::NodeEvent& from_disk, HostTime now, FleetSideOutputs& out) {
  if (!agent_) return;
  const Time t = agent_time(now);
  if (const auto* kept = std::get_if<fleet::Persisted>(&from_disk)) {
    agent_->take(*kept, t, agent_out_);
  } else if (const auto* failed = std::get_if<fleet::PersistFailed>(&from_disk)) {
    agent_->take(*failed, t, agent_out_);
  }
  sort_out(now, out);
}

void FleetSide::take(const fleet::JobDone& done, HostTime now, FleetSideOutputs& out) {
  if (!agent_) return;
  agent_->take(done, agent_time(now), agent_out_);
  sort_out(now, out);
}

void FleetSide::take(const view::OperatorRequest& request, HostTime now, FleetSideOutputs& out) {
  if (!agent_) return;
  using Kind = fleet::OperatorOrder::Kind;
  const auto& names = setup_.agent.names;
  const auto named = std::find(names.begin(), names.end(), request.vehicle);
  std::optional<fleet::OperatorOrder> order;
  if (request.command == "end-round") order = fleet::OperatorOrder{Kind::kEndRound, {}};
  if (request.command == "finish") order = fleet::OperatorOrder{Kind::kFinish, {}};
  if (request.command == "assume-lost" && named != names.end()) {
    const auto number = static_cast<std::uint16_t>(named - names.begin());
    order = fleet::OperatorOrder{Kind::kAssumeLost, VehicleId{number}};
  }
  Finding finding;
  finding.id = "live.order";
  finding.severity = order ? Severity::kInfo : Severity::kWarning;
  finding.t = agent_time(now);
  finding.text = fmt::format("{} of the operator: {}{}{}", order ? "order" : "unknown order",
                             request.command, request.vehicle.empty() ? "" : " ", request.vehicle);
  agent_out_.emplace_back(std::move(finding));
  if (order) agent_->take(*order, agent_time(now), agent_out_);
  sort_out(now, out);
}

/// Passes outputs for the odometry on and keeps those to be shown.
void FleetSide::sort_out(HostTime now, FleetSideOutputs& out) {
  for (AgentOutput& output : agent_out_) {
    if (auto* peer = std::get_if<PeerReport>(&output)) {
      out.sensors.emplace_back(std::move(peer->status));
      continue;
    }
    if (const auto* finding = std::get_if<Finding>(&output)) {
      findings_.push_back({*finding, now.boot});
      if (findings_.size() > kFindingsShown) findings_.pop_front();
    }
    out.agent.push_back(std::move(output));
  }
  agent_out_.clear();
}

bool FleetSide::due(Time& next, double period_s, Time now) const {
  if (now < next) return false;
  next = now + Duration::from_s(period_s);
  return true;
}

void FleetSide::tick(HostTime now, FleetSideOutputs& out) {
  if (!agent_) {
    const bool waited = seconds_between(start_boot_, now.boot) >= setup_.sensors_wait_s;
    if (!waited) return;
    start_agent(now, {});
  }
  const Time t = agent_time(now);
  const auto revision = agent_->goals() ? agent_->goals()->revision : 0;
  agent_->tick(t, agent_out_);
  sort_out(now, out);
  goals_changed_ |= agent_->goals() && agent_->goals()->revision != revision;
  if (due(next_frame_, kFrame_s, now.boot)) {
    out.sensors.emplace_back(FrameNews{agent_->node().T_map_odom()});
  }
  publish_goal(t, out);
  if (picture_ && due(next_delta_, kDelta_s, now.boot)) order_picture(t, now, out);
  if (agent_->goals() && due(next_frontiers_, kGrid_s, now.boot)) {
    out.publish.push_back(outputs_.frontiers(*agent_->goals(), t));
  }
  if (due(next_role_, kRole_s, now.boot)) out.publish.push_back(outputs_.role(role_text(), t));
}

void FleetSide::order_picture(Time t, HostTime now, FleetSideOutputs& out) {
  PictureOrder order;
  order.t = t;
  order.news = map_news_.read(agent_->node());
  order.grid = due(next_grid_, kGrid_s, now.boot);
  order.cloud = now.boot >= next_cloud_;
  order.paths = due(next_paths_, kPaths_s, now.boot);
  out.picture = std::make_shared<PictureJob>(std::move(picture_), shown_, std::move(order),
                                             setup_.agent.names);
}

void FleetSide::take_picture(fleet::Job* done, HostTime now, FleetSideOutputs& out) {
  auto* job = dynamic_cast<PictureJob*>(done);
  if (job == nullptr) {
    picture_ = std::make_unique<MapPicture>(setup_.grid);
    map_news_ = {};
    return;
  }
  picture_ = job->take_picture();
  shown_ = std::move(job->shown);
  if (job->cloud_made) next_cloud_ = now.boot + Duration::from_s(kCloud_s);
  for (RosOut& message : job->publish) out.publish.push_back(std::move(message));
  for (std::string& json : job->paths) out.paths.push_back(std::move(json));
}

void FleetSide::publish_goal(Time t, FleetSideOutputs& out) {
  const fleet::DriveOrder& order = agent_->node().order();
  const auto T_map_local = agent_->node().T_map_odom();
  if (goal_reported_ == order.number || !agent_->pose() || !T_map_local) return;
  goal_reported_ = order.number;
  const geometry::SE3 T_map_body = *T_map_local * agent_->pose()->T_local_body;
  out.publish.push_back(outputs_.goal(order, T_map_body, t));
}

void FleetSide::publish_diagnostics(const std::vector<DiagnosticLine>& lines, HostTime now,
                                    FleetSideOutputs& out) const {
  const std::string& vehicle = setup_.agent.names[setup_.agent.self.value];
  std::vector<wire::DiagnosticStatus> status;
  for (const DiagnosticLine& line : lines) status.push_back(status_of_line(line, vehicle));
  out.publish.push_back(outputs_.diagnostics(std::move(status), agent_time(now)));
}

std::string FleetSide::role_text() const {
  const auto& names = setup_.agent.names;
  const auto anchor = agent_->anchor();
  return fmt::format("{} {} term {} anchor {}", names[agent_->self().value],
                     mode_word(agent_->node().mode()), agent_->node().term(),
                     anchor ? names[anchor->value] : "none");
}

}  // namespace rali::host
