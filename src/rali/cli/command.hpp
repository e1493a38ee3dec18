#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "rali/base/result.hpp"
#include "rali/cli/exit_codes.hpp"
#include "rali/cli/session.hpp"

namespace rali::cli {

/// The exit code of an error; `kInterrupted` is the signal's own code.
[[nodiscard]] int exit_code_of(const Error& error, int signal_number);

/// Target of an option's value. bool: a flag; vectors: repeatable.
using OptionTarget = std::variant<bool*, int*, double*, std::string*, std::vector<std::string>*>;

/// One option of a command. Parsing, help, docs/reference/cli.md and completion are made from it.
struct Option {
  std::string names;  ///< "-o,--out"
  std::string value;  ///< "DIR"; empty for a flag
  std::string help;   ///< what it does, with unit
  OptionTarget target;
  bool rare = false;                 ///< only in --help-all
  std::vector<std::string> choices;  ///< the only words allowed; empty: any
};

/// A positional argument.
struct Positional {
  std::string name;  ///< "INPUT"
  std::string help;
  std::vector<std::string>* target = nullptr;
  int at_least = 1;
  int at_most = 1000;
  std::vector<std::string> choices;
};

/// One command of `rali`. Created for each call; options point into it.
class Command {
 public:
  virtual ~Command() = default;
  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual std::string summary() const = 0;  ///< one line, without a full stop
  [[nodiscard]] virtual std::vector<std::string> examples() const = 0;  ///< two
  [[nodiscard]] virtual std::string exit_codes() const = 0;             ///< one line
  [[nodiscard]] virtual Positional positional() = 0;
  [[nodiscard]] virtual std::vector<Option> options() = 0;

  /// Whether --json is an option: stdout is then exactly one JSON document.
  [[nodiscard]] virtual bool json() const { return false; }

  /// Hidden commands work but are not listed.
  [[nodiscard]] virtual bool hidden() const { return false; }

  /// @return the exit code. Errors are printed by the caller as `rali: error: ...`.
  [[nodiscard]] virtual Result<int> run(Session& session) = 0;
};

using CommandList = std::vector<std::unique_ptr<Command>>;

}  // namespace rali::cli
