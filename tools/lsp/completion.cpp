// Completion: the names and the words of the language that may stand at the cursor.
//
// The context is computed from the words before the cursor, because the text there is usually incomplete; the names
// come from the index. While the file cannot be parsed, the names of its last parsed state are used.
#include <algorithm>
#include <set>

#include "tools/lsp/features.hpp"
#include "tools/lsp/words.hpp"

namespace bip::lsp {
namespace {

using index::Index;
using index::Symbol;
using index::SymbolId;
using index::SymbolKind;
using Kinds = std::vector<SymbolKind>;
using Texts = std::vector<std::string_view>;

enum class Region { File, Package, Connector, Atom, Compound, Action };

int item_kind(SymbolKind kind) {
  switch (kind) {
    case SymbolKind::Package: return 9;
    case SymbolKind::Constant: return 21;
    case SymbolKind::ExternType:
    case SymbolKind::PortType: return 22;
    case SymbolKind::ConnectorType: return 8;
    case SymbolKind::AtomType:
    case SymbolKind::CompoundType: return 7;
    case SymbolKind::Function: return 3;
    case SymbolKind::Port:
    case SymbolKind::ExportedPort: return 23;
    case SymbolKind::Place: return 20;
    case SymbolKind::Component: return 5;
    case SymbolKind::Connector: return 2;
    case SymbolKind::Parameter:
    case SymbolKind::Data:
    case SymbolKind::Clock:
    case SymbolKind::Priority:
    case SymbolKind::Invariant:
    case SymbolKind::LoopVariable:
    case SymbolKind::ExportedData: break;
  }
  return 6;
}

/// The construct that the end of the words is in.
Region region_of(const std::vector<Word>& words) {
  std::vector<Region> open{Region::File};
  const auto text = [&](std::size_t i) { return i < words.size() ? words[i].text : std::string_view(); };
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string_view w = words[i].text;
    const bool begins_type = text(i + 1) == "type";
    const bool at_file = open.back() == Region::File || open.back() == Region::Package;
    if (w == "{") open.push_back(Region::Action);
    if (w == "}" && open.back() == Region::Action) open.pop_back();
    if (open.back() == Region::Action) continue;
    if (w == "package" && at_file) open.push_back(Region::Package);
    if (begins_type && w == "connector") open.push_back(Region::Connector);
    if (begins_type && w == "atom") open.push_back(Region::Atom);
    if (begins_type && w == "compound") open.push_back(Region::Compound);
    // A component of the paper's notation is a compound until its behaviour begins; an inline connector has no `end`.
    if (w == "component" && at_file) open.push_back(Region::Compound);
    if (w == "behavior" && open.back() == Region::Compound) open.push_back(Region::Atom);
    if (w == "end" && open.size() > 1) open.pop_back();
  }
  return open.back();
}

Texts keywords(Region region) {
  switch (region) {
    case Region::File: return {"package", "component", "use", "port", "connector", "atom", "compound"};
    case Region::Package:
      return {"use",       "port type",  "connector type",   "atom type",       "compound type",
              "component", "const data", "extern data type", "extern function", "function",
              "end"};
    case Region::Connector: return {"data", "export port", "define", "on", "provided", "up", "down", "end"};
    case Region::Atom:
      return {"data", "export data", "port", "export port", "place",     "initial to", "on",    "internal", "from",
              "to",   "provided",    "do",   "priority",    "invariant", "clock",      "state", "end"};
    case Region::Compound:
      return {"component", "connector", "contains", "for",    "priority", "property", "export port", "export data",
              "port",      "data",      "behavior", "define", "on",       "provided", "do",          "end"};
    case Region::Action: return {"if", "then", "else", "fi", "true", "false"};
  }
  return {};
}

class Completer {
 public:
  /// `sources`: of the index; null only if that is empty.
  Completer(const Index& index, const SourceMap* sources, FileId file, std::uint32_t offset, std::string_view before)
      : index_(index), sources_(sources), words_(cut_into_words(before)) {
    std::vector<Word>& list = words_.list;
    // What is being typed is no context.
    if (!list.empty() && list.back().begin + list.back().text.size() == before.size() &&
        is_name_character(list.back().text.front()))
      list.pop_back();
    scope_ = file.is_valid() ? names_in_scope(index, file, offset) : index.file_symbols;
  }

  Json run() {
    if (words_.inside_comment || words_.inside_string) return items_;
    const std::vector<Word>& list = words_.list;
    const Region region = region_of(list);
    const std::string_view last = list.empty() ? std::string_view() : list.back().text;
    if (last == ".") {
      behind_dot();
    } else if (last == "@") {
      words({"SuppressWarning", "cpp"});
    } else if (const std::string_view governing = governing_word();
               governing == "from" || governing == "to" || governing == "at") {
      names({SymbolKind::Place});
    } else if (governing == "use") {
      names({SymbolKind::Package});
    } else if (governing == "on") {
      names({SymbolKind::Port, SymbolKind::Parameter, SymbolKind::Component, SymbolKind::Connector});
    } else if (last == "component" || last == "contains") {
      names({SymbolKind::AtomType, SymbolKind::CompoundType});
    } else if (last == "connector" && region == Region::Compound) {
      names({SymbolKind::ConnectorType});
    } else if (last == "port") {
      names({SymbolKind::PortType});
      if (region == Region::Package || region == Region::File) words({"type"});
    } else if (last == "data" || last == "const") {
      names({SymbolKind::ExternType});
      words({"int", "bool", "float", "string"});
      if (last == "const") words({"data"});
    } else if (last == "atom" || last == "compound" || last == "connector") {
      words({"type"});
    } else if (last == "priority") {
      names({SymbolKind::Connector});
    } else {
      anything(region, last);
    }
    return items_;
  }

 private:
  /// The word that a list of names follows: `from` in `from A, B, `.
  [[nodiscard]] std::string_view governing_word() const {
    const std::vector<Word>& list = words_.list;
    std::size_t at = list.size();
    while (at >= 2 && list[at - 1].text == "," && is_plain_name(list[at - 2].text)) at -= 2;
    return at == 0 ? std::string_view() : list[at - 1].text;
  }

  void anything(Region region, std::string_view last) {
    const bool is_value =
        last == "=" || last == "(" || last == "," || last == "provided" || last == "do" ||
        (last.size() == 1 && std::string_view("+-*/%<>&|!^~-[{;").find(last) != std::string_view::npos);
    if (is_value || region == Region::Action || last == "define" || last == "then" || last == "else") {
      names({SymbolKind::Data, SymbolKind::Parameter, SymbolKind::LoopVariable, SymbolKind::Port, SymbolKind::Clock,
             SymbolKind::Component, SymbolKind::Connector, SymbolKind::Constant, SymbolKind::Function});
      if (last == "(" || last == ",") names({SymbolKind::PortType, SymbolKind::ExternType});
    }
    if (is_value && region != Region::Action) {
      words({"true", "false"});
    } else {
      words(keywords(region));
    }
    if (!is_value && region == Region::Action) return;
    if (is_value && (last == "(" || last == ",")) words({"int", "bool", "float", "string"});
  }

  void behind_dot() {
    const std::vector<Word>& list = words_.list;
    // a . b [ i ] . : names from the right to the left, brackets jumped over.
    std::vector<std::string_view> path;
    std::size_t at = list.size();
    while (at >= 2 && list[at - 1].text == ".") {
      --at;
      int depth = 0;
      while (at > 0 && (depth > 0 || list[at - 1].text == "]")) {
        depth += list[at - 1].text == "]" ? 1 : list[at - 1].text == "[" ? -1 : 0;
        --at;
      }
      if (at == 0) return;
      path.insert(path.begin(), list[--at].text);
    }
    SymbolId owner = find(path.front());
    for (std::size_t i = 1; i < path.size() && owner.is_valid(); ++i) owner = index_.member(owner, path[i]);
    if (!owner.is_valid()) return;
    if (index_.symbols[owner].kind == SymbolKind::Package) {
      for (const SymbolId id : index_.file_symbols) {
        if (index_.symbols[id].name_range.file == index_.symbols[owner].name_range.file) add(id);
      }
      return;
    }
    for (const SymbolId id : index_.members_behind_dot(owner)) add(id);
  }

  [[nodiscard]] SymbolId find(std::string_view name) const {
    for (const SymbolId id : scope_) {
      if (index_.symbols[id].name == name) return id;
    }
    // The declaration around may be too broken to be known: any part of that name is better than nothing.
    for (std::uint32_t row = 0; row < index_.symbols.size(); ++row) {
      const Symbol& s = index_.symbols[SymbolId(row)];
      const bool has_members = s.kind == SymbolKind::Component || s.kind == SymbolKind::Parameter ||
                               s.kind == SymbolKind::Connector || s.kind == SymbolKind::Port;
      if (has_members && s.name == name) return SymbolId(row);
    }
    return {};
  }

  void names(const Kinds& kinds) {
    for (const SymbolId id : scope_) {
      if (std::find(kinds.begin(), kinds.end(), index_.symbols[id].kind) != kinds.end()) add(id);
    }
  }

  void add(SymbolId id) {
    const Symbol& s = index_.symbols[id];
    if (!seen_.insert(std::string(s.name)).second) return;
    Json item{{"label", s.name}, {"kind", item_kind(s.kind)}, {"detail", detail_of(s, *sources_)}};
    if (!s.doc.empty()) item["documentation"] = s.doc;
    items_.push_back(std::move(item));
  }

  void words(const Texts& list) {
    for (const std::string_view word : list) {
      if (seen_.insert(std::string(word)).second) items_.push_back({{"label", word}, {"kind", 14}});
    }
  }

  const Index& index_;
  const SourceMap* sources_;
  Words words_;
  std::vector<SymbolId> scope_;
  std::set<std::string> seen_;
  Json items_ = Json::array();
};

}  // namespace

Reply completion(Workspace& /*w*/, const Document& d, std::uint32_t offset) {
  const bool is_readable = d.analysis.index.symbols.size() > 0;
  const Index& index = is_readable ? d.analysis.index : d.last_names;
  const pipeline::Compilation* read = is_readable ? d.analysis.compilation.get() : d.last_compilation.get();
  // Offsets of an older state are near enough to tell the declaration around.
  const FileId file = index.symbols.size() > 0 ? d.analysis.file : FileId();
  return Json{{"isIncomplete", false},
              {"items", Completer(index, read == nullptr ? nullptr : &read->sources, file, offset,
                                  std::string_view(d.text.str()).substr(0, offset))
                            .run()}};
}

}  // namespace bip::lsp
