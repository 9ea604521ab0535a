// Prints diagnostics and the time table to standard error; standard output belongs to the command's product.
#include "compiler/driver/report.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "bip/process.hpp"
#include "compiler/diag/explain.hpp"
#include "compiler/diag/render.hpp"
#include "compiler/pipeline/exit_codes.hpp"

namespace bip::driver {
namespace {

std::string time_table(const std::vector<PassTime>& times) {
  double total = 0;
  for (const PassTime& t : times) total += t.seconds;
  std::string table = fmt::format("{:<14} {:>10} {:>6}\n", "pass", "ms", "share");
  for (const PassTime& t : times) {
    table +=
        fmt::format("{:<14} {:>10.3f} {:>5.1f}%\n", t.name, t.seconds * 1e3, total > 0 ? 100 * t.seconds / total : 0);
  }
  return table + fmt::format("{:<14} {:>10.3f}\n", "total", total * 1e3);
}

// The page of the first error, else of the first warning.
std::string explained(const Compilation& c, Color color) {
  const Diagnostic* first = nullptr;
  for (const Diagnostic* d : c.diags.sorted()) {
    if (first == nullptr || d->severity < first->severity) first = d;
  }
  const ExplainPage* page = first == nullptr ? nullptr : find_page(info(first->kind).code);
  return page == nullptr ? "" : "\n" + render_page(*page, color);
}

// Why warnings end with an error; empty if they do not.
std::string fatal_warning(const Compilation& c) {
  const std::vector<std::string>& fatal = c.options.fatal_warnings;
  const bool all = c.options.warnings_are_errors || std::find(fatal.begin(), fatal.end(), "true") != fatal.end();
  if (all) return c.diags.warning_count() == 0 ? "" : "warnings count as errors here (--Werror)\n";
  for (const Diagnostic* d : c.diags.sorted()) {
    const char* code = info(d->kind).code;
    if (d->severity == Severity::Warning && std::find(fatal.begin(), fatal.end(), code) != fatal.end()) {
      return fmt::format("warning {} counts as an error here (--Werror={})\n", code, code);
    }
  }
  return {};
}

}  // namespace

void print_error_text(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stderr); }

bool wants_color(ColorChoice choice, int file_descriptor) {
  if (choice != ColorChoice::Auto) return choice == ColorChoice::Always;
  const char* no_color = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  if (no_color != nullptr && *no_color != '\0') return false;
  if (term == nullptr || std::string_view(term) == "dumb") return false;
  return ::isatty(file_descriptor) == 1;
}

static std::string printable_lines(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    out += diag::printable(text.substr(0, end)) + '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

void print_words(std::string_view text) {
  const std::string lines = printable_lines(text);
  std::fwrite(lines.data(), 1, lines.size(), stdout);
}
void print_error_words(std::string_view text) { print_error_text(printable_lines(text)); }

int usage_error(const std::string& problem, const std::string& help) {
  print_error_words("bipc: " + problem + (help.empty() ? "" : "\n  = help: " + help));
  return kUsage;
}

int report(const Compilation& c) {
  RenderOptions options = c.options.render;
  options.color = wants_color(c.options.color, STDERR_FILENO) ? Color::On : Color::Off;
  print_error_text(c.printed);
  print_error_text(render(c.diags, c.sources, options));
  if (c.options.time_passes) print_error_text(time_table(c.times));
  const bool is_for_people = options.format == DiagnosticFormat::Frame || options.format == DiagnosticFormat::Short;
  if (c.options.explain && is_for_people) print_error_text(explained(c, options.color));
  // A program that reads them must not take a part for the whole.
  if (!is_for_people && std::ferror(stderr) != 0) return kOutputLost;
  if (c.diags.has_errors()) return kModelErrors;
  const std::string reason = fatal_warning(c);
  if (reason.empty()) return kOk;
  if (is_for_people) print_error_text(reason);
  return kModelErrors;
}

}  // namespace bip::driver
