#pragma once

#include <string>
#include <utility>

#include "rali/io/containers/byte_sink.hpp"
#include "rali/io/files/atomic_file.hpp"

namespace rali::io {

/// A recording that appears under its name once it is complete.
class FileSink final : public ByteSink {
 public:
  explicit FileSink(AtomicFile file) : file_(std::move(file)) {}

  Status write(std::span<const std::byte> bytes) override { return file_.write(bytes); }

  Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes) override {
    return file_.overwrite(offset, bytes);
  }

  [[nodiscard]] Status commit() { return file_.commit(); }

 private:
  AtomicFile file_;
};

}  // namespace rali::io
