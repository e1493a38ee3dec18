#include "rali/net/internal/dds_domain.hpp"

#include <atomic>
#include <mutex>

namespace rali::net {
namespace {

constexpr dds_domainid_t kFirstNumber = 1000;  // outside the range that a program may use

/// Captures Cyclone's last error message, which otherwise goes to stderr. Its hook is global to the
/// process.
class Complaints {
 public:
  static Complaints& of_process() {
    static Complaints complaints;
    return complaints;
  }

  [[nodiscard]] std::string take() {
    const std::lock_guard lock(mutex_);
    return std::move(last_);
  }

 private:
  Complaints() { dds_set_log_sink(listen, this); }

  static void listen(void* self, const dds_log_data_t* data) {
    auto& complaints = *static_cast<Complaints*>(self);
    const std::lock_guard lock(complaints.mutex_);
    std::string text(data->message, data->size);
    while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
    complaints.last_ = std::move(text);
  }

  std::mutex mutex_;
  std::string last_;
};

dds_domainid_t next_number() {
  static std::atomic<dds_domainid_t> next{kFirstNumber};
  return next.fetch_add(1);
}

}  // namespace

Error dds_error(const std::string& where, const std::string& what, dds_return_t code) {
  const std::string reported = Complaints::of_process().take();
  return {ErrorCode::kMachine, what + ": " + (reported.empty() ? dds_strretcode(-code) : reported),
          where, ""};
}

Result<std::unique_ptr<DdsDomain>> DdsDomain::open(const std::string& config,
                                                   const dds_qos_t* participant_qos,
                                                   const std::string& where) {
  (void)Complaints::of_process().take();
  const dds_domainid_t number = next_number();
  const dds_entity_t domain = dds_create_domain(number, config.c_str());
  if (domain < 0) {
    Error error = dds_error(where, "the network cannot be opened", domain);
    error.remedy = "`ip address` lists the interfaces and addresses of this machine.";
    return tl::make_unexpected(std::move(error));
  }
  const dds_entity_t participant = dds_create_participant(number, participant_qos, nullptr);
  if (participant < 0) {
    Error error = dds_error(where, "no participant can be made", participant);
    error.remedy = "Another program may have the UDP port; `ss -ulpn` shows them.";
    (void)dds_delete(domain);
    return tl::make_unexpected(std::move(error));
  }
  return std::unique_ptr<DdsDomain>(new DdsDomain(domain, participant));
}

DdsDomain::~DdsDomain() {
  (void)dds_delete(participant_);
  (void)dds_delete(domain_);
}

}  // namespace rali::net
