#pragma once

#include <stdexcept>
#include <string>

namespace rali {

/// Base class of the library's exceptions. what() is the whole sentence that the command line
/// prints: "WHERE: PROBLEM. REMEDY". A bug in the library itself is a std::logic_error instead.
class Exception : public std::runtime_error {
 public:
  Exception(std::string where, std::string problem, std::string remedy);
  ~Exception() override;

  /// file:line, file, key or topic; may be empty.
  [[nodiscard]] const std::string& where() const noexcept { return where_; }

  /// One sentence without its full stop.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }

  /// What to do; may be empty.
  [[nodiscard]] const std::string& remedy() const noexcept { return remedy_; }

 private:
  std::string where_, problem_, remedy_;
};

/// Unreadable, damaged or unsuitable input; nothing was computed from it.
class InputError : public Exception {
 public:
  using Exception::Exception;
  ~InputError() override;
};

/// Settings or arguments that are unknown or not allowed.
class SettingsError : public InputError {
 public:
  using InputError::InputError;
  ~SettingsError() override;
};

/// Nothing is wrong, but the question has no answer here (a ground truth without common times).
class NoAnswerError : public Exception {
 public:
  using Exception::Exception;
  ~NoAnswerError() override;
};

/// A failure of the machine: disk full, no permission, no memory. Completed files are kept.
class MachineError : public Exception {
 public:
  using Exception::Exception;
  ~MachineError() override;
};

}  // namespace rali
