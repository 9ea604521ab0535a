// Completion: the names and the words of the language that may stand at the cursor.
//
// The context is computed from the words before the cursor, because the text there is usually incomplete; the names
// come from the index. While the file cannot be parsed, the names of its last parsed state are used.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "compiler/pipeline/load_packages.hpp"
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

// Ports that are listed as arguments of a connector: a longer list would hide what is looked for.
constexpr std::size_t kMostArguments = 500;

class Completer {
 public:
  /// `sources`: of the index; null only if that is empty. `folders`: as -I; `path`: the document's.
  Completer(const Index& index, const SourceMap* sources, const std::vector<std::string>& folders, std::string path,
            FileId file, std::uint32_t offset, std::string_view before)
      : index_(index), sources_(sources), folders_(folders), path_(std::move(path)), words_(cut_into_words(before)) {
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
    if (const std::optional<std::string> begin = begin_of_package()) {
      packages(*begin);
    } else if (last == ".") {
      behind_dot();
    } else if (const std::optional<SymbolId> wanted = wanted_port(list.size());
               wanted && (last == "(" || last == ",")) {
      connector_arguments(*wanted);
    } else if (last == "@") {
      words({"SuppressWarning", "cpp"});
    } else if (const std::string_view governing = governing_word();
               governing == "from" || governing == "to" || governing == "at") {
      names({SymbolKind::Place});
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
  /// What stands behind `use` before the cursor: "std." or nothing.
  [[nodiscard]] std::optional<std::string> begin_of_package() const {
    const std::vector<Word>& list = words_.list;
    std::size_t at = list.size();
    std::string begin;
    while (at >= 2 && list[at - 1].text == "." && is_plain_name(list[at - 2].text)) {
      begin.insert(0, std::string(list[at - 2].text) + ".");
      at -= 2;
    }
    if (at == 0 || list[at - 1].text != "use") return std::nullopt;
    return begin;
  }

  // What is left of the names of packages that begin so.
  void packages(const std::string& begin) {
    const std::vector<Word>& list = words_.list;
    std::string own;
    for (std::size_t at = 1; at < list.size() && list[0].text == "package"; ++at) {
      const bool is_part = at % 2 == 1 ? is_plain_name(list[at].text) : list[at].text == ".";
      if (!is_part) break;
      own += list[at].text;
    }
    std::vector<std::filesystem::path> folders(folders_.begin(), folders_.end());
    folders.emplace_back(pipeline::folder_of_packages(path_, own));
    if (const std::string library = pipeline::find_stdlib(); !library.empty()) folders.emplace_back(library);
    for (const std::string& name : pipeline::packages_below(folders)) {
      if (!name.starts_with(begin) || name == own) continue;
      if (!seen_.insert(name).second) continue;
      items_.push_back({{"label", name.substr(begin.size())}, {"kind", 9}, {"detail", "package " + name}});
    }
  }

  /// The port type that a connector wants at the cursor, if the first `count` words end in its arguments; invalid where
  /// it wants any.
  [[nodiscard]] std::optional<SymbolId> wanted_port(std::size_t count) const {
    const std::vector<Word>& list = words_.list;
    std::size_t position = 0;
    int depth = 0;
    std::size_t at = count;
    while (at > 0) {
      const std::string_view word = list[--at].text;
      if (word == ")" || word == "]") ++depth;
      if (depth == 0 && word == ",") ++position;
      if (depth == 0 && (word == "{" || word == "}" || word == ";" || word == "end")) return std::nullopt;
      if (word == "(" || word == "[") {
        if (depth == 0) break;
        --depth;
      }
    }
    if (at == 0 || list[at].text != "(") return std::nullopt;
    // connector TYPE name [index] (
    while (at > 0 && list[at - 1].text == "]") {
      while (at > 0 && list[at - 1].text != "[") --at;
      if (at > 0) --at;
    }
    if (at < 3 || !is_plain_name(list[at - 1].text) || !is_plain_name(list[at - 2].text)) return std::nullopt;
    std::size_t before = at - 2;
    while (before >= 2 && list[before - 1].text == "." && is_plain_name(list[before - 2].text)) before -= 2;
    if (before == 0 || list[before - 1].text != "connector") return std::nullopt;
    for (const SymbolId id : index_.file_symbols) {
      const Symbol& type = index_.symbols[id];
      if (type.kind != SymbolKind::ConnectorType || type.name != list[at - 2].text) continue;
      for (const SymbolId member : type.members) {
        if (index_.symbols[member].kind == SymbolKind::Parameter && position-- == 0) return index_.symbols[member].type;
      }
      return SymbolId();
    }
    return SymbolId();
  }

  [[nodiscard]] bool fits(SymbolId id, SymbolId wanted) const {
    const Symbol& s = index_.symbols[id];
    if (s.kind != SymbolKind::Port && s.kind != SymbolKind::ExportedPort) return false;
    return !wanted.is_valid() || !s.type.is_valid() || s.type == wanted;
  }

  // `a.p` for each component and connector beside the cursor; of arrays, and where there are too many, the names of
  // those that have a port that fits.
  void connector_arguments(SymbolId wanted) {
    std::vector<std::pair<SymbolId, std::vector<SymbolId>>> found;
    std::size_t count = 0;
    for (const SymbolId id : scope_) {
      const Symbol& s = index_.symbols[id];
      if (s.kind != SymbolKind::Component && s.kind != SymbolKind::Connector) continue;
      std::vector<SymbolId> fitting;
      for (const SymbolId member : index_.members_behind_dot(id)) {
        if (fits(member, wanted)) fitting.push_back(member);
      }
      count += fitting.size();
      if (!fitting.empty()) found.emplace_back(id, std::move(fitting));
    }
    for (const auto& [id, ports] : found) {
      const Symbol& s = index_.symbols[id];
      const std::string_view text = sources_->text(s.name_range.file);
      const std::size_t next = text.find_first_not_of(" \t", s.name_range.end);
      if (count > kMostArguments || (next != std::string_view::npos && text[next] == '[')) {
        add(id);
        continue;
      }
      for (const SymbolId port : ports) add(port, std::string(s.name) + ".");
    }
    names({SymbolKind::LoopVariable});
  }

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
    const std::vector<SymbolId> members = index_.members_behind_dot(owner);
    const std::optional<SymbolId> wanted = wanted_port(at);
    const auto is_fitting = [&](SymbolId id) { return wanted && fits(id, *wanted); };
    // Where none fits, all are shown rather than nothing.
    const bool is_any = std::any_of(members.begin(), members.end(), is_fitting);
    for (const SymbolId id : members) {
      if (!is_any || is_fitting(id)) add(id);
    }
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

  void add(SymbolId id, const std::string& before = {}) {
    const Symbol& s = index_.symbols[id];
    const std::string label = before + std::string(s.name);
    if (!seen_.insert(label).second) return;
    Json item{{"label", label}, {"kind", item_kind(s.kind)}, {"detail", detail_of(s, *sources_)}};
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
  const std::vector<std::string>& folders_;
  std::string path_;
  Words words_;
  std::vector<SymbolId> scope_;
  std::set<std::string> seen_;
  Json items_ = Json::array();
};

}  // namespace

Reply completion(Workspace& w, const Document& d, std::uint32_t offset) {
  const bool is_readable = d.analysis.index.symbols.size() > 0;
  const Index& index = is_readable ? d.analysis.index : d.last_names;
  const pipeline::Compilation* read = is_readable ? d.analysis.compilation.get() : d.last_compilation.get();
  // Offsets of an older state are near enough to tell the declaration around.
  const FileId file = index.symbols.size() > 0 ? d.analysis.file : FileId();
  return Json{{"isIncomplete", false},
              {"items", Completer(index, read == nullptr ? nullptr : &read->sources, w.folders, d.path, file, offset,
                                  std::string_view(d.text.str()).substr(0, offset))
                            .run()}};
}

}  // namespace bip::lsp
