// `bipc explain`: prints the page of a code, or the list of all codes with their titles.
#include <unistd.h>

#include <cctype>
#include <cstdio>

#include "compiler/diag/explain.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/driver/report.hpp"

namespace bip::driver {
namespace {

void print(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

int list_pages() {
  for (const ExplainPage& page : explain_pages()) {
    // The first line of a page is "# CODE: title".
    std::string_view title = page.text.substr(0, page.text.find('\n'));
    if (title.starts_with("# ")) title.remove_prefix(2);
    print(fmt::format("{}\n", title));
  }
  return kOk;
}

}  // namespace

int command_explain(const std::string& code, ColorChoice color) {
  if (code.empty()) return list_pages();
  std::string wanted = code;
  for (char& c : wanted) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  if (const ExplainPage* page = find_page(wanted)) {
    print(render_page(*page, wants_color(color, STDOUT_FILENO) ? Color::On : Color::Off));
    return kOk;
  }
  std::vector<std::string> known;
  for (const ExplainPage& page : explain_pages()) known.emplace_back(page.code);
  std::string message = fmt::format("bipc: no code `{}`\n", code);
  for (const std::string& name : similar_names(wanted, known))
    message += fmt::format("  = help: there is `{}`\n", name);
  message += "  = help: `bipc explain` lists all codes\n";
  std::fwrite(message.data(), 1, message.size(), stderr);
  return kUsage;
}

}  // namespace bip::driver
