// See help_formatter.hpp.
#include "compiler/driver/help_formatter.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

constexpr const char* kRareGroup = "Options that are needed rarely";

// Of any command: about the compiler itself, its cache and machine, or for tools that read what bipc prints.
constexpr const char* kRare[] = {"--backend",
                                 "--cache",
                                 "--cache-size",
                                 "--color",
                                 "--diagnostics",
                                 "--disable-maximal-progress",
                                 "--emit",
                                 "--first-enabled",
                                 "--log",
                                 "--max-instances",
                                 "--memory",
                                 "--no-cache",
                                 "--no-cpp",
                                 "--no-reuse",
                                 "--on-loss",
                                 "--print-after",
                                 "--profile-json",
                                 "--real-time-priority",
                                 "--relaxed",
                                 "--time-passes",
                                 "--verify-each",
                                 "-O",
                                 "-g"};

bool is_rare(const CLI::Option& option) {
  return std::any_of(std::begin(kRare), std::end(kRare), [&](const char* name) { return option.check_name(name); });
}

class HelpFormatter : public CLI::Formatter {
 public:
  [[nodiscard]] std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    std::string text = CLI::Formatter::make_help(app, std::move(name), mode);
    const std::vector<const CLI::Option*> rare =
        app->get_options([](const CLI::Option* option) { return option->get_group() == kRareGroup; });
    if (mode == CLI::AppFormatMode::All || rare.empty()) return text;
    const std::string hidden = make_group(kRareGroup, false, rare);
    const std::size_t at = text.find(hidden);
    BIP_ASSERT(at != std::string::npos, "the help of `{}` has all groups", app->get_name());
    if (at == std::string::npos) return text;
    return text.replace(
        at, hidden.size(),
        fmt::format("`--help-all` shows {} more option{}, needed rarely.\n", rare.size(), rare.size() == 1 ? "" : "s"));
  }
};

}  // namespace

void hide_rare_options(CLI::App& app) {
  const auto formatter = std::make_shared<HelpFormatter>();
  // As the formatter that it replaces.
  formatter->column_width(app.get_formatter()->get_column_width());
  for (CLI::App* command : app.get_subcommands(nullptr)) {
    command->formatter(formatter);
    for (CLI::Option* option : command->get_options()) {
      const bool is_its_purpose = command->get_name() == "emit" && option->check_name("--emit");
      if (is_rare(*option) && !is_its_purpose) option->group(kRareGroup);
    }
  }
}

}  // namespace bip::driver
