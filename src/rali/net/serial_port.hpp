#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/base/time.hpp"

namespace rali::net {

/// Bytes of one read of a port.
struct SerialBytes {
  Time t;  ///< when they were read, by the clock of this machine (UTC)
  std::vector<std::byte> bytes;
};

/// A serial port that is read only: raw, 8 data bits, no parity, one stop bit, no flow control.
class SerialPort {
 public:
  /// @param baud 115200, 230400, 460800, 921600, 1000000, 1500000, 2000000 or 3000000
  /// Errors: kUsage (another speed), kMachine (no such device, no permission, no terminal).
  [[nodiscard]] static Result<SerialPort> open(const std::string& path, int baud = 921600);

  SerialPort(SerialPort&& other) noexcept;
  SerialPort& operator=(SerialPort&& other) noexcept;
  ~SerialPort();

  /// Available bytes, at most 4096; waits at most `timeout` for the first.
  /// Errors: kMachine (the device is gone).
  [[nodiscard]] Result<SerialBytes> read(Duration timeout);

 private:
  SerialPort(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {}

  int descriptor_ = -1;
  std::string path_;
};

}  // namespace rali::net
