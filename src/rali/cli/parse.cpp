#include "rali/cli/parse.hpp"

#include <algorithm>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/config/suggest.hpp"

namespace rali::cli {
namespace {

/// "--out" of "-o,--out".
std::string long_name(const std::string& names) {
  const std::size_t comma = names.rfind(',');
  return comma == std::string::npos ? names : names.substr(comma + 1);
}

void add_option(CLI::App& app, const Option& option) {
  CLI::Option* added = nullptr;
  if (auto* const* flag = std::get_if<bool*>(&option.target)) {
    added = app.add_flag(option.names, **flag);
  } else if (auto* const* text = std::get_if<std::string*>(&option.target)) {
    added = app.add_option(option.names, **text);
  } else if (auto* const* number = std::get_if<double*>(&option.target)) {
    added = app.add_option(option.names, **number);
  } else if (auto* const* list = std::get_if<std::vector<std::string>*>(&option.target)) {
    added = app.add_option(option.names, **list);
    added->allow_extra_args(false);  // one value each time it is given
  } else if (auto* const* whole = std::get_if<int*>(&option.target)) {
    added = option.value.empty() ? app.add_flag(option.names, **whole)
                                 : app.add_option(option.names, **whole);
  }
  if (!option.choices.empty()) {
    added->check([choices = option.choices](const std::string& word) -> std::string {
      if (std::find(choices.begin(), choices.end(), word) != choices.end()) return {};
      return fmt::format("'{}' is none of {}", word, fmt::join(choices, ", "));
    });
  }
}

std::string unknown_option(const std::string& word, const std::vector<Option>& options) {
  std::vector<std::string> names;
  for (const Option& option : options) names.push_back(long_name(option.names));
  names.emplace_back("--help");
  names.emplace_back("--help-all");
  const std::string nearest = config::nearest_name(word.substr(0, word.find('=')), names);
  return nearest.empty() ? "" : fmt::format("Did you mean {}?", nearest);
}

/// CLI11's message as one sentence.
std::string one_sentence(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

/// The parser's messages are for programmers; these say what to change.
std::string sentence_of(const CLI::ParseError& error) {
  const std::string text = one_sentence(error.what());
  const std::string_view no_number = "Could not convert: ";
  if (text.starts_with(no_number)) return text.substr(no_number.size()) + " is no whole number";
  const std::size_t too_many = text.find(": At Most 1 required but received ");
  if (too_many != std::string::npos) return text.substr(0, too_many) + " is given more than once";
  const std::size_t no_value = text.find(": 1 required ");
  if (no_value != std::string::npos) return text.substr(0, no_value) + " needs a value";
  return text;
}

}  // namespace

std::vector<Option> all_options(Command& command, CommonOptions& common) {
  std::vector<Option> options = command.options();
  if (command.json()) {
    options.push_back({"--json", "", "stdout is one JSON document", &common.json, false, {}});
  }
  options.push_back({"-q,--quiet", "", "errors only", &common.quiet, false, {}});
  options.push_back({"-v,--verbose", "", "print more", &common.verbose, false, {}});
  options.push_back({"--progress",
                     "KIND",
                     "progress on stderr: auto, json (one object a line), off",
                     &common.progress,
                     true,
                     {"auto", "json", "off"}});
  options.push_back(
      {"--log", "FILE", "write what stderr gets to a file too", &common.log, true, {}});
  return options;
}

Result<Parsed> parse_words(Command& command, CommonOptions& common,
                           const std::vector<std::string>& words) {
  const std::string where = "rali " + command.name();
  const std::string remedy = fmt::format("See `{} -h`.", where);
  CLI::App app;
  app.set_help_flag();  // replaced by the one from the option table
  bool help = false, help_all = false;
  app.add_flag("-h,--help", help);
  app.add_flag("--help-all", help_all);
  const std::vector<Option> options = all_options(command, common);
  for (const Option& option : options) add_option(app, option);
  const Positional positional = command.positional();
  std::vector<std::string> inputs;
  if (!positional.name.empty()) {
    app.add_option(positional.name, inputs)->expected(0, positional.at_most);
  }
  app.allow_extras();
  try {
    std::vector<std::string> reversed(words.rbegin(), words.rend());
    app.parse(std::move(reversed));
  } catch (const CLI::ParseError& e) {
    return fail(ErrorCode::kUsage, where, sentence_of(e), remedy);
  }
  if (help_all) return Parsed::kHelpAll;
  if (help) return Parsed::kHelp;
  for (const std::string& extra : app.remaining()) {
    if (extra.empty()) continue;
    const std::string hint = unknown_option(extra, options);
    return fail(
        ErrorCode::kUsage, where,
        fmt::format("{} '{}'", extra.front() == '-' ? "unknown option" : "one word too many:",
                    extra.substr(0, 80)),
        hint.empty() ? remedy : hint);
  }
  if (inputs.size() < static_cast<std::size_t>(positional.at_least)) {
    return fail(ErrorCode::kUsage, where, fmt::format("{} is missing", positional.name), remedy);
  }
  for (const std::string& input : inputs) {
    const auto& choices = positional.choices;
    if (choices.empty() || std::find(choices.begin(), choices.end(), input) != choices.end())
      continue;
    return fail(ErrorCode::kUsage, where,
                fmt::format("'{}' is none of {}", input, fmt::join(choices, ", ")));
  }
  if (positional.target != nullptr) *positional.target = std::move(inputs);
  return Parsed::kRun;
}

}  // namespace rali::cli
