#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "rali/net/internal/blob.hpp"
#include "rali/net/internal/dds_domain.hpp"

namespace rali::net {

/// Tests may run at the same time: each process takes a domain of its own, below 100, so that its
/// fixed ports are below the ephemeral ones. A lock keeps it until the process ends.
inline int domain_for_test() {
  static const int kDomain = [] {
    for (int domain = 1; domain < 100; ++domain) {
      const auto path =
          std::filesystem::temp_directory_path() / ("rali_test_domain_" + std::to_string(domain));
      const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) == 0) return domain;
      if (file >= 0) ::close(file);
    }
    return 100;
  }();
  return kDomain;
}

inline double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Polls the condition for at most `limit_s`. @return whether it holds
inline bool holds_within(double limit_s, const std::function<bool()>& condition) {
  const double end_s = seconds_now() + limit_s;
  while (!condition()) {
    if (seconds_now() > end_s) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// A participant of the same domain that ignores our protocol.
class OutsiderForTest {
 public:
  OutsiderForTest(const std::string& config, std::string topic, std::string type)
      : topic_name_(std::move(topic)) {
    auto domain = DdsDomain::open(config, nullptr, "outsider");
    if (!domain) {
      error_ = domain.error().message();
      return;
    }
    domain_ = std::move(*domain);
    topic_ = create_blob_topic(domain_->participant(), topic_name_, type, std::size_t{64} << 20,
                               std::make_shared<BlobCounts>(), &type_);
  }

  [[nodiscard]] const std::string& error() const { return error_; }

  void open_writer(const QosPtr& qos) {
    writer_ = dds_create_writer(domain_->participant(), topic_, qos.get(), nullptr);
  }

  void open_reader(const QosPtr& qos) {
    reader_ = dds_create_reader(domain_->participant(), topic_, qos.get(), nullptr);
  }

  [[nodiscard]] bool is_matched() const {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
  }

  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) const {
    return write_blob(writer_, type_, bytes) == DDS_RETCODE_OK;
  }

  [[nodiscard]] std::vector<std::vector<std::uint8_t>> take() const {
    std::vector<std::vector<std::uint8_t>> out;
    take_blobs(reader_, [&](std::span<const std::uint8_t> bytes) {
      out.emplace_back(bytes.begin(), bytes.end());
    });
    return out;
  }

  [[nodiscard]] dds_entity_t participant() const { return domain_->participant(); }

 private:
  std::string error_, topic_name_;
  std::unique_ptr<DdsDomain> domain_;
  const ddsi_sertype* type_ = nullptr;
  dds_entity_t topic_ = 0, writer_ = 0, reader_ = 0;
};

inline QosPtr qos_for_test(bool is_reliable, const char* partition = nullptr) {
  QosPtr qos(dds_create_qos());
  dds_qset_reliability(
      qos.get(), is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 100);
  if (partition != nullptr) dds_qset_partition1(qos.get(), partition);
  return qos;
}

}  // namespace rali::net
