// Inlay hints: what a text leaves out. Names of parameters before arguments, how many interactions a connector has, and
// with which value data without an initial one begin.
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/lsp/features.hpp"
#include "tools/lsp/words.hpp"

namespace bip::lsp {
namespace {

using index::Index;
using index::Symbol;
using index::SymbolId;
using index::SymbolKind;

struct Argument {
  std::uint32_t begin = 0, end = 0;
};
struct Arguments {
  std::vector<Argument> list;
  std::uint32_t end = 0;  // behind the closing parenthesis; 0: there are none
};

// Of `(a, b)` or `[3](a, b)` at the begin of the text, which is at the offset. nullopt: the text ends before that is
// known.
std::optional<Arguments> arguments_in(std::string_view text, std::uint32_t offset) {
  Arguments found;
  const Words words = cut_into_words(text);
  int parentheses = 0, brackets = 0;
  Argument next;
  bool is_begun = false;
  for (const Word& word : words.list) {
    const std::uint32_t at = offset + word.begin;
    const bool is_outer = parentheses == 1 && brackets == 0;
    if (word.text == "[") ++brackets;
    if (word.text == "]") --brackets;
    if (parentheses == 0 && brackets == 0 && word.text != "(" && word.text != "]") return Arguments();
    if (word.text == "(" && ++parentheses == 1) continue;
    if (word.text == ")") --parentheses;
    if (parentheses == 0 && word.text != ")") continue;
    if ((is_outer && word.text == ",") || parentheses == 0) {
      if (is_begun) found.list.push_back(next);
      is_begun = false;
      if (parentheses == 0) {
        found.end = at + 1;
        return found;
      }
      continue;
    }
    if (!std::exchange(is_begun, true)) next.begin = at;
    next.end = at + static_cast<std::uint32_t>(word.text.size());
  }
  return std::nullopt;
}

// From behind a name on. Most lists of arguments are short.
Arguments arguments_from(std::string_view text, std::uint32_t begin) {
  constexpr std::size_t kFirstLookedAt = 128, kMostLookedAt = 4096;
  for (std::size_t length = kFirstLookedAt; length <= kMostLookedAt; length *= 2) {
    if (const std::optional<Arguments> found = arguments_in(text.substr(begin, length), begin)) return *found;
  }
  return {};
}

// `left.put` says what it is for if the parameter is `put`.
bool says_name(std::string_view argument, std::string_view name) {
  return argument == name || (argument.ends_with(name) && argument[argument.size() - name.size() - 1] == '.');
}

class HintCollector {
 public:
  HintCollector(const Workspace& w, const Document& d) : workspace_(w), document_(d), index_(d.analysis.index) {}

  void add_instance(const Symbol& s) {
    if (!s.type.is_valid()) return;
    const Symbol& type = index_.symbols[s.type];
    const std::string_view text = document_.text.str();
    const Arguments arguments = arguments_from(text, s.name_range.end);
    std::size_t k = 0;
    for (const SymbolId member : type.members) {
      const Symbol& parameter = index_.symbols[member];
      if (parameter.kind != SymbolKind::Parameter || k >= arguments.list.size()) continue;
      const Argument& argument = arguments.list[k++];
      // `a.*` and `a[*]` stand for any number of arguments.
      const std::string_view shown = text.substr(argument.begin, argument.end - argument.begin);
      if (shown.find('*') != std::string_view::npos) break;
      if (!says_name(shown, parameter.name)) add(argument.begin, std::string(parameter.name) + ":", Kind::Parameter);
    }
    if (s.kind == SymbolKind::Connector && arguments.end != 0) add_interactions(type, arguments.end);
  }

  void add_value(const Symbol& s) {
    const std::string_view text = document_.text.str();
    const std::size_t next = text.find_first_not_of(" \t\r\n", s.name_range.end);
    if (next != std::string_view::npos && text[next] == '=') return;
    const char* value = s.type_text == "int"      ? "= 0"
                        : s.type_text == "bool"   ? "= false"
                        : s.type_text == "float"  ? "= 0.0"
                        : s.type_text == "string" ? "= \"\""
                                                  : nullptr;
    if (value != nullptr) add(s.name_range.end, value, Kind::Value);
  }

  [[nodiscard]] Json take() { return std::move(out_); }

 private:
  enum class Kind : std::uint8_t { Parameter, Value };

  void add_interactions(const Symbol& type, std::uint32_t at) {
    const double count = type.interactions;
    if (count < 1) return;
    add(at,
        count == 1     ? "1 interaction"
        : count < 1e15 ? std::to_string(static_cast<std::uint64_t>(count)) + " interactions"
                       : "more than 10^15 interactions",
        Kind::Value);
  }
  void add(std::uint32_t at, const std::string& label, Kind kind) {
    Json hint{{"position", json_of(document_.text.position(at, workspace_.encoding))}, {"label", label}};
    if (kind == Kind::Parameter) hint["kind"] = 2;
    hint[kind == Kind::Parameter ? "paddingRight" : "paddingLeft"] = true;
    out_.push_back(std::move(hint));
  }

  const Workspace& workspace_;
  const Document& document_;
  const Index& index_;
  Json out_ = Json::array();
};

}  // namespace

Reply inlay_hints(Workspace& w, const Document& d, std::uint32_t begin, std::uint32_t end) {
  HintCollector hints(w, d);
  const Index& index = d.analysis.index;
  for (std::uint32_t row = 0; row < index.symbols.size(); ++row) {
    const Symbol& s = index.symbols[SymbolId(row)];
    if (s.name_range.file != d.analysis.file || !d.analysis.file.is_valid()) continue;
    if (s.name_range.end < begin || s.name_range.begin > end) continue;
    if (s.kind == SymbolKind::Component || s.kind == SymbolKind::Connector) hints.add_instance(s);
    const bool is_of_atom = s.parent.is_valid() && index.symbols[s.parent].kind == SymbolKind::AtomType;
    if (s.kind == SymbolKind::Data && is_of_atom) hints.add_value(s);
  }
  return hints.take();
}

}  // namespace bip::lsp
