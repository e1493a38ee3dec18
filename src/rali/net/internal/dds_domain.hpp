#pragma once

#include <memory>
#include <string>

#include <dds/dds.h>

#include "rali/base/result.hpp"

namespace rali::net {

struct QosDelete {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};

using QosPtr = std::unique_ptr<dds_qos_t, QosDelete>;

struct ListenerDelete {
  void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};

using ListenerPtr = std::unique_ptr<dds_listener_t, ListenerDelete>;

/// A domain of Cyclone with one participant. Each has its own number within the process, so that
/// several with different settings may be the same domain on the network.
class DdsDomain {
 public:
  /// @param config text of cyclone_config  @param where for errors
  /// Errors: kMachine, with Cyclone's message.
  [[nodiscard]] static Result<std::unique_ptr<DdsDomain>> open(const std::string& config,
                                                               const dds_qos_t* participant_qos,
                                                               const std::string& where);
  ~DdsDomain();
  DdsDomain(const DdsDomain&) = delete;
  DdsDomain& operator=(const DdsDomain&) = delete;

  [[nodiscard]] dds_entity_t participant() const { return participant_; }

 private:
  DdsDomain(dds_entity_t domain, dds_entity_t participant)
      : domain_(domain), participant_(participant) {}

  dds_entity_t domain_, participant_;
};

/// An Error (kMachine) for a return value of Cyclone.
[[nodiscard]] Error dds_error(const std::string& where, const std::string& what, dds_return_t code);

}  // namespace rali::net
