#include <chrono>
#include <thread>
#include <utility>

#include "rali/host/internal/live_host_impl.hpp"

// The threads of the disk, the recording, the poses and the serial port.
namespace rali::host {

void LiveHost::Impl::disk_loop(const std::atomic<bool>& end) {
  const auto write = [this](bool all) {
    for (const fleet::NodeOutput& output : to_disk_.take(all ? Duration{} : kDiskWait)) {
      parts_.state->take(output);
    }
    for (std::vector<std::byte>& seen : seen_to_disk_.take()) {
      parts_.state->keep_seen(std::move(seen));
    }
    for (fleet::NodeEvent& event : parts_.state->sync(host_now().boot, all)) {
      from_disk_.put(std::move(event));
    }
    for (Finding& finding : parts_.state->take_findings()) findings_.put(std::move(finding));
    disk_free_.store(parts_.state->free_bytes(), std::memory_order_relaxed);
    disk_waiting_.store(parts_.state->waiting(), std::memory_order_relaxed);
  };
  while (!end.load(std::memory_order_acquire)) write(false);
  write(true);
}

void LiveHost::Impl::record_loop(const std::atomic<bool>& end) {
  const auto write = [this](Duration wait) {
    for (const Recorded& message : to_record_.take(wait)) {
      if (record_failed_.load(std::memory_order_relaxed)) continue;
      const Status status = parts_.record->write(message.topic, message.t, as_message(message.cdr));
      if (status) continue;
      record_failed_.store(true, std::memory_order_relaxed);
      findings_.put(finding_of("live.recording", Severity::kError,
                               "the recording ends here: " + status.error().message(), "",
                               "Free space, and start again with another folder."));
    }
  };
  while (!end.load(std::memory_order_acquire)) write(kDiskWait);
  write({});
}

void LiveHost::Impl::poses_loop(const std::atomic<bool>& end) {
  const auto write = [this](Duration wait) {
    for (const io::StampedPose& pose : to_poses_.take(wait)) {
      if (poses_status_) poses_status_ = parts_.poses->add(pose);
    }
  };
  while (!end.load(std::memory_order_acquire)) write(kDiskWait);
  write({});
  const Status finished = parts_.poses->finish();
  if (poses_status_) poses_status_ = finished;
}

/// The vehicle continues without its radio; a device that is plugged in again is found.
void LiveHost::Impl::serial_loop(const std::atomic<bool>& end) {
  bool reported = false;
  while (!end.load(std::memory_order_acquire)) {
    Result<net::SerialBytes> bytes = parts_.serial->read(kDiskWait);
    if (bytes) {
      if (!bytes->bytes.empty()) from_serial_.put(std::move(*bytes));
      continue;
    }
    if (!std::exchange(reported, true)) {
      findings_.put(finding_of("live.serial_port", Severity::kError, bytes.error().message(), "",
                               "Plug the radio in and start rali run again."));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
}

}  // namespace rali::host
