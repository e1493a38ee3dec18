#include "rali/cli/zsh_completion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "rali/cli/parse.hpp"

namespace rali::cli {
namespace {

/// Puts a backslash before each character of `special`, which separates parts of a specification.
std::string escaped(const std::string& text, std::string_view special) {
  std::string out;
  for (const char c : text) {
    if (c == '\\' || special.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

/// Quotes one word for the shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + '\'';
}

/// Completion of an option's value or a positional argument: ":DIR:_files -/".
std::string action(const std::string& name, const std::vector<std::string>& choices) {
  std::string what = "_files";
  if (!choices.empty()) {
    what = fmt::format("({})", fmt::join(choices, " "));
  } else if (name == "DIR") {
    what = "_files -/";
  } else if (name != "FILE" && name != "PATH" && !name.starts_with("IN") && name != "DIR...") {
    what = " ";
  }
  return fmt::format(":{}:{}", escaped(name, ":"), what);
}

bool is_repeatable(const Option& option) {
  return std::holds_alternative<std::vector<std::string>*>(option.target);
}

/// One argument of _arguments: '(-o --out)'{-o,--out}'[where the results go]:DIR:_files -/'.
std::string argument_of(const Option& option) {
  const std::size_t comma = option.names.find(',');
  std::string rest = fmt::format("[{}]", escaped(option.help, "[]:"));
  if (!option.value.empty()) rest += action(option.value, option.choices);
  if (comma == std::string::npos) {
    return quoted((is_repeatable(option) ? "*" : "") + option.names + rest);
  }
  const std::string brief = option.names.substr(0, comma), full = option.names.substr(comma + 1);
  const std::string before =
      is_repeatable(option) ? quoted("*") : quoted(fmt::format("({} {})", brief, full));
  return fmt::format("{}{{{},{}}}{}", before, brief, full, quoted(rest));
}

std::string branch_of(Command& command) {
  std::string text = fmt::format("    {})\n      _arguments", command.name());
  CommonOptions common;
  for (const Option& option : all_options(command, common)) {
    text += " \\\n        " + argument_of(option);
  }
  text += " \\\n        '(- *)'{-h,--help}'[the usual options]' '(- *)--help-all[all options]'";
  const Positional positional = command.positional();
  if (!positional.name.empty()) {
    const bool files = positional.choices.empty();
    text += " \\\n        " +
            quoted('*' + action(files ? "INPUT" : positional.name, positional.choices));
  }
  return text + " ;;\n";
}

}  // namespace

std::string zsh_completion(const CommandList& commands) {
  std::string names, branches;
  for (const auto& command : commands) {
    if (command->hidden()) continue;
    names +=
        fmt::format("      {}\n", quoted(escaped(command->name(), ":") + ':' + command->summary()));
    branches += branch_of(*command);
  }
  return "#compdef rali\n"
         "# zsh completion of rali: a file _rali in $fpath, or: source <(rali completion zsh)\n"
         "_rali() {\n"
         "  if (( CURRENT == 2 )); then\n"
         "    local -a commands=(\n" +
         names +
         "    )\n"
         "    _describe command commands\n"
         "    _arguments --help --version\n"
         "    return\n"
         "  fi\n"
         "  local command=$words[2]\n"
         "  shift words\n"
         "  (( CURRENT-- ))\n"
         "  case $command in\n" +
         branches +
         "  esac\n"
         "}\n"
         "if [[ $funcstack[1] == _rali ]]; then\n"
         "  _rali \"$@\"\n"
         "else\n"
         "  (( $+functions[compdef] )) || { autoload -U compinit && compinit }\n"
         "  compdef _rali rali\n"
         "fi\n";
}

}  // namespace rali::cli
