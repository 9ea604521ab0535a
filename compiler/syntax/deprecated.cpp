// Walks every declaration and type name of a file. See deprecated.hpp.
#include "compiler/syntax/deprecated.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::syntax {
namespace {

class DeprecatedFormFinder {
 public:
  explicit DeprecatedFormFinder(std::string_view text) : text_(text) {}
  std::vector<Edit> edits;

  void decl(const Decl& d) {
    if (d.kind == DeclKind::ExternType && is_native_type(d.name.text)) {
      edits.push_back({whole_line(d.range), ""});
      return;
    }
    for (const Param& p : d.params) type(p.type);
    for (const DataDecl& data : d.data) type(data.type);
    type(d.result);
    if (d.connector != nullptr) connector(*d.connector);
    items(d.items);
  }

 private:
  // The range with its line's indentation and end, if there is nothing else on the line.
  SourceRange whole_line(SourceRange range) const {
    SourceRange wide = range;
    while (wide.begin > 0 && (text_[wide.begin - 1] == ' ' || text_[wide.begin - 1] == '\t')) --wide.begin;
    while (wide.end < text_.size() && (text_[wide.end] == ' ' || text_[wide.end] == '\t')) ++wide.end;
    const bool begins = wide.begin == 0 || text_[wide.begin - 1] == '\n';
    if (!begins || wide.end == text_.size() || text_[wide.end] != '\n') return range;
    ++wide.end;
    return wide;
  }
  void type(const TypeRef& t) {
    if (t.name.parts.size() == 1 && t.name.parts[0].name.text == "double") edits.push_back({t.name.range, "float"});
  }
  void connector(const ConnectorBody& body) {
    for (const DataDecl& data : body.data) type(data.type);
  }
  // Loops nest as deep as the parser lets them.
  void items(std::span<const CompoundItem* const> list) {
    for (const CompoundItem* item : list) {
      if (item->inline_body != nullptr) connector(*item->inline_body);
      items(item->items);
    }
  }

  std::string_view text_;
};

}  // namespace

std::vector<Edit> deprecated_spellings(const Syntax& syntax, std::string_view text) {
  DeprecatedFormFinder finder(text);
  if (syntax.package != nullptr) {
    for (const Decl* decl : syntax.package->decls) finder.decl(*decl);
  }
  std::sort(finder.edits.begin(), finder.edits.end(),
            [](const Edit& a, const Edit& b) { return a.range.begin < b.range.begin; });
  BIP_ASSERT(std::adjacent_find(finder.edits.begin(), finder.edits.end(),
                                [](const Edit& a, const Edit& b) { return a.range.end > b.range.begin; }) ==
                 finder.edits.end(),
             "two of {} edits overlap", finder.edits.size());
  return std::move(finder.edits);
}

}  // namespace bip::syntax
