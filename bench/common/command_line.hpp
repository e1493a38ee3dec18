#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "rali/base/result.hpp"

namespace rali::bench {

/// Parses the text of an option. On an error it is printed and the program ends.
using Setter = std::function<Status(const std::string& text)>;

/// An option whose text is parsed by `set`.
CLI::Option* add_text(CLI::App& app, const std::string& name, Setter set, const std::string& help);

/// An option that may be repeated; `set` parses one text after the other.
CLI::Option* add_texts(CLI::App& app, const std::string& name, Setter set, const std::string& help);

/// --into FILE:NAME: additional output of a table of `program`, besides stdout.
CLI::Option* add_into(CLI::App& app, const std::string& program, std::string& into);

/// --seeds 1,2,5-8.
CLI::Option* add_seeds(CLI::App& app, std::vector<std::uint64_t>& seeds);

/// @return nothing if the program shall run; else its exit code: 0 after --help, 2 if the arguments
/// are wrong (a sentence on stderr).
[[nodiscard]] std::optional<int> ended_by(CLI::App& app, int argc, const char* const* argv);

/// Prints why options are incompatible. @return the exit code for wrong arguments
[[nodiscard]] int wrong(const Status& status);

}  // namespace rali::bench
