#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "rali/base/result.hpp"

namespace rali::bench {

/// Reads the text of an option. Its error is printed, and the program ends.
using Setter = std::function<Status(const std::string& text)>;

/// An option whose text `set` reads.
CLI::Option* add_text(CLI::App& app, const std::string& name, Setter set, const std::string& help);

/// An option that may be repeated; `set` reads one text after the other.
CLI::Option* add_texts(CLI::App& app, const std::string& name, Setter set, const std::string& help);

/// --into FILE:NAME: where a table of `program` goes besides stdout.
CLI::Option* add_into(CLI::App& app, const std::string& program, std::string& into);

/// --seeds 1,2,5-8.
CLI::Option* add_seeds(CLI::App& app, std::vector<std::uint64_t>& seeds);

/// @return nothing if the program shall run; else its exit code: 0 after --help, 2 where the
///         arguments are wrong (a sentence on stderr).
[[nodiscard]] std::optional<int> ended_by(CLI::App& app, int argc, const char* const* argv);

/// Prints why options do not fit together. @return the exit code of wrong arguments.
[[nodiscard]] int wrong(const Status& status);

}  // namespace rali::bench
