#include "common/command_line.hpp"

#include <cstdio>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/words.hpp"

namespace rali::bench {
namespace {

constexpr int kWrongArguments = 2;

/// CLI11 expects a rejected value as an exception.
void read(const std::string& name, const Setter& set, const std::string& text) {
  if (const Status ok = set(text); !ok) throw CLI::ValidationError(name, ok.error().message());
}

}  // namespace

CLI::Option* add_text(CLI::App& app, const std::string& name, Setter set, const std::string& help) {
  return app.add_option_function<std::string>(
      name, [name, set = std::move(set)](const std::string& text) { read(name, set, text); }, help);
}

CLI::Option* add_texts(CLI::App& app, const std::string& name, Setter set,
                       const std::string& help) {
  return app.add_option_function<std::vector<std::string>>(
      name,
      [name, set = std::move(set)](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) read(name, set, text);
      },
      help);
}

CLI::Option* add_into(CLI::App& app, const std::string& program, std::string& into) {
  const std::string help = fmt::format(
      "FILE:NAME: the tables also between '<!-- {} NAME -->' and '<!-- end -->' of a Markdown file",
      program);
  return app.add_option("--into", into, help);
}

CLI::Option* add_seeds(CLI::App& app, std::vector<std::uint64_t>& seeds) {
  const std::string help = fmt::format("1,2,5-8; default: {}", fmt::join(seeds, ","));
  return add_text(
      app, "--seeds",
      [&seeds](const std::string& text) -> Status {
        auto read = parse_seeds(text);
        if (!read) return tl::make_unexpected(read.error());
        seeds = std::move(*read);
        return {};
      },
      help);
}

std::optional<int> ended_by(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kWrongArguments;
  }
}

int wrong(const Status& status) {
  fmt::print(stderr, "{}\n", status.error().message());
  return kWrongArguments;
}

}  // namespace rali::bench
