// Definition, references, rename: questions to the index of each open document, and of each file below the editor's
// folders that holds the name.
//
// A symbol is known across files by where it is declared: path and offset. Cost: linear in the open documents' uses and
// in the text of the folders.
#include <map>
#include <set>

#include "tools/lsp/features.hpp"
#include "tools/lsp/uri.hpp"
#include "tools/lsp/words.hpp"

namespace bip::lsp {
namespace {

using index::Symbol;
using index::SymbolId;
using index::SymbolKind;
using index::Use;
using index::UseKind;

const Use* use_at(const Document& d, std::uint32_t offset) {
  return d.analysis.file.is_valid() ? d.analysis.index.use_at(d.analysis.file, offset) : nullptr;
}

/// The symbol of another analysis that is declared at the same place.
SymbolId same_symbol(const Analysis& a, const std::string& path, const Symbol& wanted) {
  for (std::uint32_t row = 0; row < a.index.symbols.size(); ++row) {
    const Symbol& s = a.index.symbols[SymbolId(row)];
    const std::string* in = a.path_of(s.name_range.file);
    if (in != nullptr && s.name_range.begin == wanted.name_range.begin && s.name == wanted.name &&
        s.kind == wanted.kind && *in == path)
      return SymbolId(row);
  }
  return {};
}

struct Found {
  const Analysis* analysis;
  Use use;
};
struct Uses {
  std::vector<Found> list;
  std::vector<Analysis> unopened;  // what some of the list point to
};

/// May an edit change the file?
bool is_ours(Workspace& w, const std::string& path) {
  return w.documents().contains(path) || w.unopened.contains(path);
}

enum class Files : std::uint8_t { All, Ours };

/// All uses in the open documents and in the files below the editor's folders, each place once: a used package is seen
/// by each of its users.
Uses all_uses(Workspace& w, const Document& d, const Symbol& symbol, Files files) {
  Uses found;
  const std::string* declared_in = d.analysis.path_of(symbol.name_range.file);
  if (declared_in == nullptr) return found;
  std::set<std::pair<std::string, std::uint32_t>> seen;
  const auto add = [&](const Analysis& a) {
    const SymbolId declared = same_symbol(a, *declared_in, symbol);
    if (!declared.is_valid()) return;
    for (const Use& u : a.index.uses_of(declared)) {
      const std::string* in = a.path_of(u.range.file);
      if (in == nullptr || (files == Files::Ours && !is_ours(w, *in))) continue;
      if (seen.emplace(*in, u.range.begin).second) found.list.push_back({&a, u});
    }
  };
  for (const auto& [path, document] : w.documents()) add(document->analysis);
  found.unopened = w.unopened.with_name(symbol.name, w.folders, w.open_texts());
  for (const Analysis& a : found.unopened) add(a);
  return found;
}

std::vector<SymbolId> symbols_named(const index::Index& index, std::string_view name) {
  std::vector<SymbolId> found;
  for (std::uint32_t row = 0; row < index.symbols.size(); ++row) {
    if (index.symbols[SymbolId(row)].name == name) found.push_back(SymbolId(row));
  }
  return found;
}

/// Why the symbol's name is not to be changed from here; empty if it may be.
std::string objection(Workspace& w, const Document& d, const Symbol& s) {
  const std::string* in = d.analysis.path_of(s.name_range.file);
  if (s.kind == SymbolKind::Package) return "a package is named as its file is: rename the file, then the package";
  if (in == nullptr || !is_ours(w, *in))
    return "`" + std::string(s.name) + "` is declared in a file that is neither open nor below the editor's folders";
  return {};
}

}  // namespace

std::vector<SymbolId> names_in_scope(const index::Index& index, FileId file, std::uint32_t offset) {
  std::vector<SymbolId> names;
  SymbolId owner = index.enclosing(file, offset);
  for (std::uint32_t row = 0; row < index.symbols.size(); ++row) {
    const Symbol& s = index.symbols[SymbolId(row)];
    if (s.kind == SymbolKind::LoopVariable && s.parent == owner && owner.is_valid()) names.push_back(SymbolId(row));
  }
  for (; owner.is_valid(); owner = index.symbols[owner].parent) {
    names.insert(names.end(), index.symbols[owner].members.begin(), index.symbols[owner].members.end());
  }
  names.insert(names.end(), index.file_symbols.begin(), index.file_symbols.end());
  return names;
}

Reply definition(Workspace& w, const Document& d, std::uint32_t offset) {
  const Use* at = use_at(d, offset);
  if (at == nullptr) return Json(nullptr);
  Json places = Json::array();
  for (const Use& u : d.analysis.index.uses_of(at->symbol)) {
    if (u.kind == UseKind::Declaration) places.push_back(w.location(d.analysis, u.range));
  }
  return places;
}

Reply references(Workspace& w, const Document& d, std::uint32_t offset, Declarations declarations) {
  const Use* at = use_at(d, offset);
  if (at == nullptr) return Json(nullptr);
  Json places = Json::array();
  const Uses uses = all_uses(w, d, d.analysis.index.symbols[at->symbol], Files::All);
  for (const Found& f : uses.list) {
    if (f.use.kind == UseKind::Declaration && declarations == Declarations::Excluded) continue;
    places.push_back(w.location(*f.analysis, f.use.range));
  }
  return places;
}

Reply prepare_rename(Workspace& w, const Document& d, std::uint32_t offset) {
  const Use* at = use_at(d, offset);
  if (at == nullptr) return Json(nullptr);
  const Symbol& symbol = d.analysis.index.symbols[at->symbol];
  if (const std::string why = objection(w, d, symbol); !why.empty()) return RpcError{ErrorCode::RequestFailed, why};
  return Json{{"range", w.range(d.analysis, at->range)}, {"placeholder", symbol.name}};
}

Reply rename(Workspace& w, const Document& d, std::uint32_t offset, const std::string& name) {
  const Use* at = use_at(d, offset);
  if (at == nullptr) return RpcError{ErrorCode::RequestFailed, "there is no name here"};
  const Symbol& symbol = d.analysis.index.symbols[at->symbol];
  if (const std::string why = objection(w, d, symbol); !why.empty()) return RpcError{ErrorCode::RequestFailed, why};
  if (!is_plain_name(name))
    return bad_params("`" + name + "` is no name: letters, digits and `_`, no word of the language");
  if (name == symbol.name) return Json{{"changes", Json::object()}};
  Json changes = Json::object();
  const Uses uses = all_uses(w, d, symbol, Files::Ours);
  std::map<const Analysis*, std::vector<SymbolId>> of_that_name;
  for (const Found& f : uses.list) {
    // Whatever has the name already where this one is used would catch it, or be caught.
    const index::Index& index = f.analysis->index;
    const auto [others, is_new] = of_that_name.try_emplace(f.analysis);
    if (is_new) others->second = symbols_named(index, name);
    const std::string_view text = f.analysis->compilation->sources.text(f.use.range.file);
    const bool is_behind_dot = f.use.range.begin > 0 && text[f.use.range.begin - 1] == '.';
    for (const SymbolId other : is_behind_dot ? std::vector<SymbolId>() : others->second) {
      const SymbolId owner = index.symbols[other].parent;
      if (!owner.is_valid() || index.is_around(owner, f.use.range.file, f.use.range.begin))
        return RpcError{
            ErrorCode::RequestFailed,
            "there is a " + std::string(index::name_of(index.symbols[other].kind)) + " `" + name + "` already"};
    }
    const Json place = w.location(*f.analysis, f.use.range);
    changes[place["uri"].get_ref<const std::string&>()].push_back({{"range", place["range"]}, {"newText", name}});
  }
  const SymbolId parent = symbol.parent;
  if (parent.is_valid()) {
    for (const SymbolId sibling : d.analysis.index.symbols[parent].members) {
      if (d.analysis.index.symbols[sibling].name == name)
        return RpcError{ErrorCode::RequestFailed,
                        "there is a " + std::string(index::name_of(d.analysis.index.symbols[sibling].kind)) + " `" +
                            name + "` already"};
    }
  }
  return Json{{"changes", std::move(changes)}};
}

}  // namespace bip::lsp
