#include "rali/cli/completion.hpp"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

#include "rali/cli/parse.hpp"
#include "rali/cli/zsh_completion.hpp"

namespace rali::cli {
namespace {

/// All completions after `rali CMD`, long options first.
std::string completion_words(Command& command) {
  CommonOptions common;
  std::string words;
  for (const Option& option : all_options(command, common)) {
    std::istringstream names(option.names);
    for (std::string name; std::getline(names, name, ',');) words += name + ' ';
  }
  for (const std::string& choice : command.positional().choices) words += choice + ' ';
  return words + "--help --help-all";
}

std::string names_of(const CommandList& commands) {
  std::string names;
  for (const auto& command : commands) {
    if (!command->hidden()) names += (names.empty() ? "" : " ") + command->name();
  }
  return names;
}

/// Completions of the options with fixed choices, as branches of `case "$prev"`.
std::string bash_values(Command& command) {
  CommonOptions common;
  std::string text;
  for (const Option& option : all_options(command, common)) {
    if (option.choices.empty()) continue;
    std::string names = option.names;
    std::replace(names.begin(), names.end(), ',', '|');
    text += fmt::format("        {}) COMPREPLY=( $(compgen -W \"{}\" -- \"$cur\") ); return ;;\n",
                        names, fmt::join(option.choices, " "));
  }
  return text.empty() ? text : "      case \"$prev\" in\n" + text + "      esac ;;\n";
}

std::string bash_completion(const CommandList& commands) {
  std::string text =
      "# bash completion of rali; load it with: source <(rali completion bash)\n"
      "_rali() {\n"
      "  local cur=\"${COMP_WORDS[COMP_CWORD]}\" prev=\"${COMP_WORDS[COMP_CWORD-1]}\" words=\"\"\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n";
  text += fmt::format("    words=\"{} --help --version\"\n  else\n", names_of(commands));
  text += "    case \"${COMP_WORDS[1]}\" in\n";
  for (const auto& command : commands) {
    if (command->hidden()) continue;
    const std::string values = bash_values(*command);
    text += fmt::format("      {}) words=\"{}\"{}\n", command->name(), completion_words(*command),
                        values.empty() ? " ;;" : '\n' + values.substr(0, values.size() - 1));
  }
  return text +
         "    esac\n  fi\n"
         "  COMPREPLY=( $(compgen -W \"$words\" -- \"$cur\") )\n"
         "  case \"$cur\" in -*) ;; *) COMPREPLY+=( $(compgen -f -- \"$cur\") ) ;; esac\n"
         "}\ncomplete -o filenames -F _rali rali\n";
}

std::string fish_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text)
    out += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + '\'';
}

std::string fish_completion(const CommandList& commands) {
  std::string text = "# fish completion of rali; load it with: rali completion fish | source\n";
  for (const auto& command : commands) {
    if (command->hidden()) continue;
    text += fmt::format("complete -c rali -n __fish_use_subcommand -a {} -d {}\n", command->name(),
                        fish_quoted(command->summary()));
    CommonOptions common;
    for (const Option& option : all_options(*command, common)) {
      text += fmt::format("complete -c rali -n '__fish_seen_subcommand_from {}'", command->name());
      std::istringstream names(option.names);
      for (std::string name; std::getline(names, name, ',');) {
        text += name.compare(0, 2, "--") == 0 ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      if (!option.value.empty()) text += " -r";
      if (!option.choices.empty()) {
        text += fmt::format(" -f -a {}",
                            fish_quoted(fmt::format("{}", fmt::join(option.choices, " "))));
      }
      text += " -d " + fish_quoted(option.help) + '\n';
    }
  }
  return text;
}

}  // namespace

std::string completion_script(const std::string& shell, const CommandList& commands) {
  if (shell == "bash") return bash_completion(commands);
  if (shell == "fish") return fish_completion(commands);
  if (shell == "zsh") return zsh_completion(commands);
  return {};
}

}  // namespace rali::cli
