#pragma once

#include <string>

#include <tl/expected.hpp>

namespace rali {

/// Kind of error; the command line maps it to an exit code.
enum class ErrorCode {
  kUsage,       ///< wrong arguments or settings
  kInput,       ///< unreadable, damaged or unsuitable input
  kNoAnswer,    ///< nothing wrong, but the question has no answer here
  kMachine,     ///< disk full, no permission, no memory
  kInterrupted  ///< stopped by the user
};

/// An error as the user reads it: `where: what. remedy`.
struct Error {
  ErrorCode code = ErrorCode::kInput;
  std::string what;    ///< one sentence without a full stop
  std::string where;   ///< file:line, file:offset N, key path or topic; may be empty
  std::string remedy;  ///< what to do, one sentence with its full stop; may be empty

  /// One sentence for the user: "WHERE: WHAT. REMEDY".
  [[nodiscard]] std::string message() const;
};

template <class T>
using Result = tl::expected<T, Error>;

using Status = Result<void>;

/// Shorthand for a failed Result.
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string where, std::string what,
                                                std::string remedy = {}) {
  return tl::make_unexpected(Error{code, std::move(what), std::move(where), std::move(remedy)});
}

}  // namespace rali
