// `bipc completion SHELL`: what a shell proposes after `bipc`, read off the commands and options as CLI11 has them.
//
// Each script knows the commands, the options of each command, and the values of options that have a closed set of
// them; everything else is completed as a file or a folder. Nothing is listed here by hand, so that the scripts cannot
// be behind.
#include <cstdio>
#include <string_view>

#include "compiler/driver/cli_options.hpp"
#include "compiler/pipeline/exit_codes.hpp"

namespace bip::driver {
namespace {

enum class ValueKind : std::uint8_t { None, Choice, Folder, File, Other };

struct CompletedOption {
  std::vector<std::string> names;  // with their dashes
  std::string help;
  ValueKind kind = ValueKind::None;
  std::vector<std::string> choices;
};

std::vector<std::string> split_at(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

ValueKind kind_of_value(const CLI::Option& option) {
  if (option.get_expected_max() == 0) return ValueKind::None;
  const std::string type = option.get_type_name();
  if (type.find('|') != std::string::npos) return ValueKind::Choice;
  if (type == "DIR") return ValueKind::Folder;
  return type == "FILE" || type == "PATH" ? ValueKind::File : ValueKind::Other;
}

CompletedOption completed(const CLI::Option& option) {
  CompletedOption result;
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  result.help = option.get_description();
  result.kind = kind_of_value(option);
  if (result.kind == ValueKind::Choice) result.choices = split_at(option.get_type_name(), '|');
  return result;
}

std::vector<CompletedOption> options_of(const CLI::App& command) {
  std::vector<CompletedOption> options;
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_lnames().empty() || !option->get_snames().empty()) options.push_back(completed(*option));
  }
  return options;
}

std::string joined_by(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : std::string(between)) + word;
  return text;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CompletedOption& option : options_of(command)) {
    names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  return names;
}

// In single quotes of a shell; fish and zsh read it like bash.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

// The first argument of `bipc completion` and of `bipc explain` are no files, but those are rarely typed.
std::string bash_script(const CLI::App& app) {
  std::string text =
      "# bash completion of bipc, printed by `bipc completion bash`.\n"
      "_bipc() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} words=\n"
      "  # bash gives `--option=value` as three words.\n"
      "  if [[ $word == = ]]; then\n"
      "    word=\n"
      "  elif [[ $before == = ]]; then\n"
      "    before=${COMP_WORDS[COMP_CWORD-2]}\n"
      "  fi\n"
      "  if ((COMP_CWORD == 1)); then\n";
  text += fmt::format("    COMPREPLY=($(compgen -W {} -- \"$word\"))\n    return\n  fi\n",
                      quoted(joined_by(command_names(app), " ") + " " + joined_by(option_names(app), " ")));
  text += "  case $command:$before in\n";
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    for (const CompletedOption& option : options_of(*command)) {
      if (option.kind != ValueKind::Choice && option.kind != ValueKind::Folder) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) patterns.push_back(command->get_name() + ":" + name);
      const std::string action =
          option.kind == ValueKind::Folder
              ? std::string("COMPREPLY=($(compgen -d -- \"$word\"))")
              : fmt::format("COMPREPLY=($(compgen -W {} -- \"$word\"))", quoted(joined_by(option.choices, " ")));
      text += fmt::format("    {}) {}; return ;;\n", joined_by(patterns, "|"), action);
    }
  }
  text += "  esac\n  case $command in\n";
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    text += fmt::format("    {}) words={} ;;\n", command->get_name(), quoted(joined_by(option_names(*command), " ")));
  }
  return text +
         "  esac\n"
         "  if [[ $word == -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
         "  else\n"
         "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
         "  fi\n"
         "}\n"
         "complete -o filenames -o bashdefault -F _bipc bipc\n";
}

// zsh reads `[`, `]` and `:` in a specification, so help has them escaped.
std::string zsh_help(const std::string& help) {
  std::string out;
  for (const char c : help) out += c == '[' || c == ']' || c == ':' ? std::string("\\") + c : std::string(1, c);
  return out;
}

std::string zsh_value(const CompletedOption& option) {
  switch (option.kind) {
    case ValueKind::None: return {};
    case ValueKind::Choice: return fmt::format(":value:({})", joined_by(option.choices, " "));
    case ValueKind::Folder: return ":folder:_files -/";
    case ValueKind::File: return ":file:_files";
    case ValueKind::Other: return ":value: ";
  }
  return {};
}

std::string zsh_options(const CLI::App& command) {
  std::string text;
  for (const CompletedOption& option : options_of(command)) {
    for (const std::string& name : option.names) {
      // -O2 and -Idir are written without a blank, --option=value with or without one.
      const char* joins = option.kind == ValueKind::None ? "" : name.starts_with("--") ? "=" : "+";
      text +=
          " \\\n        " + quoted(fmt::format("*{}{}[{}]{}", name, joins, zsh_help(option.help), zsh_value(option)));
    }
  }
  return text;
}

std::string zsh_script(const CLI::App& app) {
  std::string text =
      "#compdef bipc\n"
      "# zsh completion of bipc, printed by `bipc completion zsh`.\n"
      "_bipc() {\n"
      "  local -a commands\n"
      "  commands=(\n";
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    text += "    " + quoted(command->get_name() + ":" + zsh_help(command->get_description())) + "\n";
  }
  text +=
      "  )\n"
      "  if ((CURRENT == 2)) && [[ $PREFIX != -* ]]; then\n"
      "    _describe command commands\n"
      "    return\n"
      "  fi\n"
      "  local command=$words[2]\n"
      "  if ((CURRENT > 2)); then\n"
      "    shift words\n"
      "    ((CURRENT--))\n"
      "  fi\n"
      "  case $command in\n";
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    text += fmt::format("    {})\n      _arguments{} \\\n        '*:file:_files' ;;\n", command->get_name(),
                        zsh_options(*command));
  }
  text += fmt::format("    *)\n      _arguments{} \\\n        '*:file:_files' ;;\n", zsh_options(app));
  return text + "  esac\n}\n_bipc \"$@\"\n";
}

std::string fish_option(const CompletedOption& option) {
  std::string text;
  for (const std::string& name : option.names) {
    if (name.starts_with("--")) {
      text += " -l " + name.substr(2);
    } else {
      text += (name.size() == 2 ? " -s " : " -o ") + name.substr(1);
    }
  }
  switch (option.kind) {
    case ValueKind::None: break;
    case ValueKind::Choice: text += " -x -a " + quoted(joined_by(option.choices, " ")); break;
    case ValueKind::Folder: text += " -x -a '(__fish_complete_directories)'"; break;
    case ValueKind::File: text += " -r -F"; break;
    case ValueKind::Other: text += " -x"; break;
  }
  return text + " -d " + quoted(option.help);
}

std::string fish_script(const CLI::App& app) {
  std::string text = "# fish completion of bipc, printed by `bipc completion fish`.\n";
  for (const CompletedOption& option : options_of(app)) {
    text += "complete -c bipc -n __fish_use_subcommand" + fish_option(option) + "\n";
  }
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    text += fmt::format("complete -c bipc -n __fish_use_subcommand -f -a {} -d {}\n", command->get_name(),
                        quoted(command->get_description()));
  }
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    for (const CompletedOption& option : options_of(*command)) {
      text += fmt::format("complete -c bipc -n '__fish_seen_subcommand_from {}'{}\n", command->get_name(),
                          fish_option(option));
    }
  }
  return text;
}

std::string script_for(Shell shell, const CLI::App& app) {
  switch (shell) {
    case Shell::Bash: return bash_script(app);
    case Shell::Zsh: return zsh_script(app);
    case Shell::Fish: return fish_script(app);
  }
  return {};
}

}  // namespace

int command_completion(const CLI::App& app, Shell shell) {
  const std::string text = script_for(shell, app);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kOk;
}

}  // namespace bip::driver
