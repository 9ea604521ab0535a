// See verdict_table.hpp.
#include "compiler/driver/verdict_table.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

}  // namespace

std::string verdict_table(const std::vector<NamedVerdict>& verdicts) {
  std::size_t width = 0;
  for (const NamedVerdict& row : verdicts) width = std::max(width, row.name.size());
  std::string table, details;
  std::vector<std::string> notes;
  for (const NamedVerdict& row : verdicts) {
    const std::string answer = row.verdict.text_with_figures();
    const std::vector<std::string> lines = lines_of(answer);
    BIP_ASSERT(!lines.empty(), "a verdict says something");
    // The verdict follows the steps of a run: of a violation, or of what is possible.
    const auto verdict = std::find_if(lines.begin(), lines.end(), [](const std::string& line) {
      return line.find("[V0") != std::string::npos || line.starts_with("holds: ");
    });
    const bool has_run = verdict != lines.end() && verdict != lines.begin();
    const std::string& said = verdict != lines.end() ? *verdict : lines.front();
    table += fmt::format("{:<{}}  {}\n", row.name, width, said);
    if (row.verdict.exit_code != pipeline::kOk) {
      details += fmt::format("\n{}\n{}", row.name, answer);
      continue;
    }
    for (std::size_t k = 1; k < lines.size(); ++k) {
      // A run that shows what is possible is for `--property` alone.
      if (has_run && !lines[k].starts_with("note: ")) continue;
      const bool is_new = std::find(notes.begin(), notes.end(), lines[k]) == notes.end();
      if (is_new) notes.push_back(lines[k]);
    }
  }
  std::string text = table + details;
  if (!notes.empty() && !details.empty()) text += '\n';
  for (const std::string& note : notes) text += note + '\n';
  return text;
}

std::string verdict_table_json(const std::vector<NamedVerdict>& verdicts) {
  nlohmann::ordered_json json{
      {"format", "bipc-verdicts"}, {"version", 1}, {"verdicts", nlohmann::ordered_json::array()}};
  for (const NamedVerdict& row : verdicts) {
    nlohmann::ordered_json named{{"name", row.name}};
    named.update(row.verdict.json);
    named.erase("format");
    named.erase("version");
    json["verdicts"].push_back(std::move(named));
  }
  return json_line(json) + '\n';
}

int worst_exit_code(const std::vector<NamedVerdict>& verdicts) {
  int code = pipeline::kOk;
  for (const NamedVerdict& row : verdicts) {
    const int own = row.verdict.exit_code;
    if (code == pipeline::kOk || (code == pipeline::kUnknown && own != pipeline::kOk)) code = own;
  }
  return code;
}

}  // namespace bip::driver
