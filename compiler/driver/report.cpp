// Prints diagnostics and the time table to standard error; standard output belongs to the command's product.
#include "compiler/driver/report.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "compiler/driver/exit_codes.hpp"

namespace bip::driver {
namespace {

void print(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

std::string time_table(const std::vector<PassTime>& times) {
  double total = 0;
  for (const PassTime& t : times) total += t.seconds;
  std::string table = fmt::format("{:<14} {:>10} {:>6}\n", "pass", "ms", "share");
  for (const PassTime& t : times) {
    table += fmt::format("{:<14} {:>10.3f} {:>5.1f}%\n", t.name, t.seconds * 1e3, total > 0 ? 100 * t.seconds / total : 0);
  }
  return table + fmt::format("{:<14} {:>10.3f}\n", "total", total * 1e3);
}

}  // namespace

bool wants_color(ColorChoice choice, int file_descriptor) {
  if (choice != ColorChoice::Auto) return choice == ColorChoice::Always;
  const char* no_color = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  if (no_color != nullptr && *no_color != '\0') return false;
  if (term == nullptr || std::string_view(term) == "dumb") return false;
  return ::isatty(file_descriptor) == 1;
}

int report(const Compilation& c) {
  RenderOptions options = c.options.render;
  options.color = wants_color(c.options.color, STDERR_FILENO);
  print(render(c.diags, c.sources, options));
  if (c.options.time_passes) print(time_table(c.times));
  if (c.diags.has_errors()) return kModelErrors;
  if (!c.options.warnings_are_errors || c.diags.warning_count() == 0) return kOk;
  if (options.format != DiagnosticFormat::Json) print("warnings count as errors here (--Werror)\n");
  return kModelErrors;
}

}  // namespace bip::driver
