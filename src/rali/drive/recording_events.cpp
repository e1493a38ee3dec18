#include "rali/drive/recording_events.hpp"

#include <utility>

#include <fmt/format.h>

#include "rali/drive/input/event_outlet.hpp"
#include "rali/drive/input/message_reader.hpp"

namespace rali::drive {
namespace {

class RecordingEvents final : public ReportedSource {
 public:
  RecordingEvents(RecordingChain chain, RecordingProbe probe, InputOptions options,
                  InputReport report)
      : chain_(std::move(chain)),
        probe_(std::move(probe)),
        options_(std::move(options)),
        report_(std::move(report)),
        reader_(probe_, options_,
                [this](const RecordedMessage& message) {
                  return fmt::format("{}:offset {}", chain_.paths()[message.file], message.offset);
                }),
        outlet_(options_) {}

  Result<std::optional<vehicle::Event>> next() override {
    while (!ended_) {
      std::optional<vehicle::Event> event = outlet_.pop(report_);
      if (event) return event;
      if (exhausted_ || outlet_.past_end()) {
        end();
      } else if (!read_one() || (options_.strict && report_.gaps.damaged)) {
        exhausted_ = true;
        outlet_.finish();
      }
    }
    return std::optional<vehicle::Event>();
  }

  double progress() const override { return ended_ ? 1.0 : chain_.progress(); }

  const InputReport& report() const override { return report_; }

 private:
  bool read_one() {
    if (!probe_.messages.empty()) {
      const StoredMessage stored = std::move(probe_.messages.front());
      probe_.messages.pop_front();
      handle({stored.kind, stored.topic, stored.type, stored.encoding, stored.t_record, stored.data,
              stored.offset, stored.file});
      return true;
    }
    RecordedMessage message;
    if (!chain_.next(message, report_.gaps, report_.findings)) return false;
    handle(message);
    return true;
  }

  void handle(const RecordedMessage& message) {
    if (message.file != file_) {
      file_ = message.file;
      reader_.start_file(chain_.clock_was_set(message.file));
    }
    reader_.take(message, outlet_, report_);
  }

  void end() {
    ended_ = true;
    outlet_.close(report_);
  }

  RecordingChain chain_;
  RecordingProbe probe_;
  InputOptions options_;
  InputReport report_;
  MessageReader reader_;
  EventOutlet outlet_;
  std::optional<std::size_t> file_;  ///< of the last message
  bool exhausted_ = false, ended_ = false;
};

}  // namespace

Result<std::unique_ptr<ReportedSource>> open_recording_events(const std::vector<std::string>& paths,
                                                              const InputOptions& options) {
  Result<RecordingChain> chain = RecordingChain::open(paths, options);
  if (!chain) return tl::make_unexpected(chain.error());
  InputReport report;
  report.vehicle = options.vehicle;
  report.files = paths;
  report.lidar_time_offset = options.lidar_time_offset;
  report.clock_offset = options.clock_offset;
  Result<RecordingProbe> probe = probe_recording(*chain, options, report);
  if (!probe) return tl::make_unexpected(probe.error());
  return std::make_unique<RecordingEvents>(std::move(*chain), std::move(*probe), options,
                                           std::move(report));
}

}  // namespace rali::drive
