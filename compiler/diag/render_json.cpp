// One JSON object per line and diagnostic, with keys in a fixed order. Lines and columns start at 1, columns count
// bytes, offsets are bytes from 0; ends are exclusive. Text that is not UTF-8 is replaced.
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/diag/render.hpp"

namespace bip::diag {
namespace {

using Json = nlohmann::ordered_json;

Json range_of(SourceRange range, const SourceMap& sources) {
  if (!range.is_valid()) return nullptr;
  const Loc begin = sources.loc(range.file, range.begin);
  const Loc end = sources.loc(range.file, range.end);
  return {{"file", sources.name(range.file)}, {"line", begin.line},    {"column", begin.column}, {"end_line", end.line},
          {"end_column", end.column},         {"offset", range.begin}, {"end_offset", range.end}};
}

}  // namespace

void render_json(std::string& out, const Diagnostic& d, const SourceMap& sources) {
  Json object;
  object["severity"] = severity_name(d.severity);
  object["code"] = info(d.kind).code;
  object["name"] = info(d.kind).slug;
  object["message"] = d.message;
  object["range"] = range_of(d.range, sources);
  if (!d.label.empty()) object["label"] = d.label;
  Json labels = Json::array();
  for (const Label& label : d.labels)
    labels.push_back({{"range", range_of(label.range, sources)}, {"text", label.text}});
  object["labels"] = std::move(labels);
  object["notes"] = d.notes;
  Json helps = Json::array();
  for (const Help& help : d.helps) {
    Json entry{{"text", help.text}};
    if (help.replace.is_valid()) entry["edit"] = {{"range", range_of(help.replace, sources)}, {"with", help.with}};
    helps.push_back(std::move(entry));
  }
  object["helps"] = std::move(helps);
  out += with_hidden_escaped(json_line(object));
  out += '\n';
}

}  // namespace bip::diag
