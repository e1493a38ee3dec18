#pragma once

#include <map>
#include <memory>
#include <string>

#include "rali/base/result.hpp"
#include "rali/io/containers/mcap_writer.hpp"
#include "rali/io/files/file_sink.hpp"
#include "rali/net/ros_bus.hpp"

namespace rali::host {

/// Records raw sensor messages for a later `rali map`: DIR/<vehicle>.mcap.
class RecordWriter {
 public:
  /// Errors: kMachine; kUsage if the recording already exists.
  [[nodiscard]] static Result<std::unique_ptr<RecordWriter>> create(const std::string& folder,
                                                                    const std::string& vehicle);

  [[nodiscard]] Status write(const net::RosTopic& topic, Time t_arrival,
                             std::span<const std::byte> cdr);

  [[nodiscard]] Status finish();

 private:
  explicit RecordWriter(io::AtomicFile file);

  io::FileSink sink_;
  io::McapWriter mcap_;
  std::map<std::string, std::uint16_t> schemas_, channels_;
};

}  // namespace rali::host
