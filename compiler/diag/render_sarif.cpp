// SARIF 2.1.0 (OASIS, 2020), for code-review services and editors: one document per compilation.
//
// There is one rule per code that occurs, in order of code. Columns count UTF-16 units, as SARIF requires; offsets are
// bytes. Helps with an edit become fixes, notes and other helps lines of the message.
#include <map>
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/diag/render.hpp"

namespace bip::diag {
namespace {

using Json = nlohmann::ordered_json;

// A column in UTF-16 units, as SARIF counts them: bytes that begin a character, and characters beyond 16 bits twice.
std::uint32_t utf16_column(std::string_view line, std::uint32_t byte_column) {
  std::uint32_t column = 1;
  for (std::uint32_t i = 0; i + 1 < byte_column && i < line.size(); ++i) {
    const auto byte = static_cast<unsigned char>(line[i]);
    if ((byte & 0xC0u) != 0x80u) column += byte >= 0xF0u ? 2 : 1;
  }
  return column;
}

Json region_of(SourceRange range, const SourceMap& sources) {
  const Loc begin = sources.loc(range.file, range.begin);
  const Loc end = sources.loc(range.file, range.end);
  return {
      {"startLine", begin.line},   {"startColumn", utf16_column(sources.line(range.file, begin.line), begin.column)},
      {"endLine", end.line},       {"endColumn", utf16_column(sources.line(range.file, end.line), end.column)},
      {"byteOffset", range.begin}, {"byteLength", range.end - range.begin}};
}

Json artifact_of(SourceRange range, const SourceMap& sources) { return {{"uri", sources.name(range.file)}}; }

Json location_of(SourceRange range, const SourceMap& sources) {
  return {
      {"physicalLocation", {{"artifactLocation", artifact_of(range, sources)}, {"region", region_of(range, sources)}}}};
}

Json fix_of(const Help& help, const SourceMap& sources) {
  Json replacement{{"deletedRegion", region_of(help.replace, sources)}, {"insertedContent", {{"text", help.with}}}};
  Json change{{"artifactLocation", artifact_of(help.replace, sources)},
              {"replacements", Json::array({std::move(replacement)})}};
  return {{"description", {{"text", help.text}}}, {"artifactChanges", Json::array({std::move(change)})}};
}

Json result_of(const Diagnostic& d, std::size_t rule, const SourceMap& sources) {
  std::string text = d.message;
  if (!d.label.empty()) text += " (" + d.label + ")";
  for (const std::string& note : d.notes) text += "\nnote: " + note;
  for (const Help& help : d.helps) text += "\nhelp: " + help.text;
  Json result{{"ruleId", info(d.kind).code},
              {"ruleIndex", rule},
              {"level", severity_name(d.severity)},
              {"message", {{"text", text}}}};
  result["locations"] = Json::array();
  if (d.range.is_valid()) result["locations"].push_back(location_of(d.range, sources));
  Json related = Json::array();
  for (const Label& label : d.labels) {
    Json location = location_of(label.range, sources);
    location["message"] = {{"text", label.text}};
    related.push_back(std::move(location));
  }
  if (!related.empty()) result["relatedLocations"] = std::move(related);
  Json fixes = Json::array();
  for (const Help& help : d.helps) {
    if (help.replace.is_valid()) fixes.push_back(fix_of(help, sources));
  }
  if (!fixes.empty()) result["fixes"] = std::move(fixes);
  return result;
}

}  // namespace

std::string render_sarif(const std::vector<const Diagnostic*>& diags, const SourceMap& sources) {
  std::map<std::string_view, std::size_t> rows;
  for (const Diagnostic* d : diags) rows.emplace(info(d->kind).code, 0);
  Json rules = Json::array();
  for (auto& [code, row] : rows) {
    row = rules.size();
    const DiagInfo& kind = info(*find_diag(code));
    rules.push_back(
        {{"id", kind.code}, {"name", kind.slug}, {"defaultConfiguration", {{"level", severity_name(kind.severity)}}}});
  }
  Json results = Json::array();
  for (const Diagnostic* d : diags) results.push_back(result_of(*d, rows.at(info(d->kind).code), sources));
  Json document;
  document["$schema"] = "https://json.schemastore.org/sarif-2.1.0.json";
  document["version"] = "2.1.0";
  Json run;
  run["tool"] = {{"driver", {{"name", "bipc"}, {"rules", std::move(rules)}}}};
  run["columnKind"] = "utf16CodeUnits";
  run["results"] = std::move(results);
  document["runs"] = Json::array({std::move(run)});
  return with_hidden_escaped(indented_json(document)) + "\n";
}

}  // namespace bip::diag
