#pragma once

#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "rali/base/result.hpp"

namespace rali::cli {

/// This program as a child process that does not outlive the object: it is asked to end, and killed
/// if it does not.
class ChildProcess {
 public:
  /// @param words as on the command line, without the name of the program
  /// @param log   file that receives all its output
  /// Errors: kMachine.
  [[nodiscard]] static Result<ChildProcess> start(const std::vector<std::string>& words,
                                                  const std::string& log);

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  /// Exit code once it has ended; 128 + n if signal n ended it.
  [[nodiscard]] std::optional<int> ended();

  /// Sends SIGINT, so that it finishes its current work.
  void ask_to_end() const;

  /// Waits until it has ended; kills it after `seconds`. @return as ended()
  int wait(double seconds);

  [[nodiscard]] const std::string& log() const { return log_; }

 private:
  ChildProcess(pid_t pid, std::string log) : pid_(pid), log_(std::move(log)) {}

  pid_t pid_ = -1;  ///< -1: moved away
  std::string log_;
  std::optional<int> code_;
};

/// The last lines of a log, for an error. Empty if there is none.
[[nodiscard]] std::string last_lines(const std::string& file, std::size_t lines);

}  // namespace rali::cli
