// Formatting by the printer of `bipc fmt`, and the edits that diagnostics suggest.
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "tools/lsp/features.hpp"

namespace bip::lsp {

Reply formatting(Workspace& w, const Document& d) {
  Json edits = Json::array();
  if (d.path.ends_with(".bsys")) return edits;
  // What could not be read would be lost; the diagnostics say what that is.
  const std::optional<std::string> text = w.formatted(d.uri);
  if (!text || *text == d.text.str()) return edits;
  const auto end = static_cast<std::uint32_t>(d.text.str().size());
  edits.push_back(
      {{"range",
        {{"start", json_of(d.text.position(0, w.encoding))}, {"end", json_of(d.text.position(end, w.encoding))}}},
       {"newText", *text}});
  return edits;
}

Reply code_actions(Workspace& w, const Document& d, std::uint32_t begin, std::uint32_t end) {
  Json actions = Json::array(), pages = Json::array();
  std::set<Diag> explained;
  for (const Diagnostic* from : d.findings.diagnostics) {
    if (from->range.file != d.findings.file || from->range.end < begin || from->range.begin > end) continue;
    if (w.client_explains && !explained.contains(from->kind)) {
      explained.insert(from->kind);
      const std::string code(info(from->kind).code);
      Json command{{"title", "explain " + code}, {"command", "bip.explain"}, {"arguments", {code}}};
      pages.push_back({{"title", "explain " + code}, {"kind", "quickfix"}, {"command", std::move(command)}});
    }
    for (const Help& help : from->helps) {
      if (!help.replace.is_valid() || help.replace.file != d.findings.file) continue;
      Json edit{{"range", w.range(d.findings, help.replace)}, {"newText", help.with}};
      Json changes = Json::object();
      changes[d.uri].push_back(std::move(edit));
      actions.push_back({{"title", help.text}, {"kind", "quickfix"}, {"edit", {{"changes", std::move(changes)}}}});
    }
  }
  // An edit is wanted more often than its reason.
  for (Json& page : pages) actions.push_back(std::move(page));
  return actions;
}

}  // namespace bip::lsp
