// Signature help: the parameters of a function that is called, or of the type that is instantiated, around a position.
#include <string_view>
#include <utility>
#include <vector>

#include "tools/lsp/features.hpp"
#include "tools/lsp/words.hpp"

namespace bip::lsp {
namespace {

using index::Symbol;
using index::SymbolId;
using index::SymbolKind;

// A call around the end of the words: where its name begins, and how many commas are before.
struct Call {
  std::uint32_t name = 0;
  std::uint32_t argument = 0;
};

std::optional<Call> call_around(const std::vector<Word>& words) {
  std::uint32_t argument = 0;
  int depth = 0;
  for (std::size_t k = words.size(); k-- > 0;) {
    const std::string_view text = words[k].text;
    if (text == ")" || text == "]") ++depth;
    else if (text == "[" && depth > 0) --depth;
    else if (text == "," && depth == 0) ++argument;
    else if (text == "(") {
      if (depth-- > 0) continue;
      // `f(`, `component T name(`, `component T name[3](`.
      std::size_t name = k;
      for (int brackets = 0; name-- > 0;) {
        if (words[name].text == "]") ++brackets;
        else if (words[name].text == "[") --brackets;
        else if (brackets == 0) break;
      }
      if (name >= words.size() || !is_name_character(words[name].text.front())) return std::nullopt;
      return Call{words[name].begin, argument};
    } else if (text == ";" || text == "{" || text == "}" || text == "end") return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

Reply signature_help(Workspace&, const Document& d, std::uint32_t offset) {
  constexpr std::uint32_t kMostLookedAt = 4096;
  if (!d.analysis.file.is_valid()) return Json(nullptr);
  const std::string_view text = d.text.str();
  const std::uint32_t begin = offset > kMostLookedAt ? offset - kMostLookedAt : 0;
  const Words words = cut_into_words(text.substr(begin, offset - begin));
  if (words.inside_comment || words.inside_string) return Json(nullptr);
  const std::optional<Call> call = call_around(words.list);
  if (!call) return Json(nullptr);
  const index::Index& index = d.analysis.index;
  const index::Use* use = index.use_at(d.analysis.file, begin + call->name);
  if (use == nullptr) return Json(nullptr);
  const Symbol* called = &index.symbols[use->symbol];
  const bool is_instance = called->kind == SymbolKind::Component || called->kind == SymbolKind::Connector;
  if (is_instance && called->type.is_valid()) called = &index.symbols[called->type];
  std::string label(called->name);
  label += '(';
  Json parameters = Json::array();
  for (const SymbolId m : called->members) {
    const Symbol& parameter = index.symbols[m];
    if (parameter.kind != SymbolKind::Parameter) continue;
    if (!parameters.empty()) label += ", ";
    const std::string shown =
        std::string(parameter.type_text) + (parameter.type_text.empty() ? "" : " ") + std::string(parameter.name);
    parameters.push_back({{"label", shown}});
    label += shown;
  }
  Json signature{{"label", label + ")"}, {"parameters", std::move(parameters)}};
  if (!called->doc.empty()) signature["documentation"] = called->doc;
  return Json{{"signatures", {std::move(signature)}}, {"activeSignature", 0}, {"activeParameter", call->argument}};
}

}  // namespace bip::lsp
