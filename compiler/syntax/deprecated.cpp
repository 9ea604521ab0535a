// Walks every type name of a file. See deprecated.hpp.
#include "compiler/syntax/deprecated.hpp"

#include <algorithm>

namespace bip::syntax {
namespace {

class DeprecatedFormFinder {
 public:
  std::vector<Edit> edits;

  void decl(const Decl& d) {
    for (const Param& p : d.params) type(p.type);
    for (const DataDecl& data : d.data) type(data.type);
    type(d.result);
    if (d.connector != nullptr) connector(*d.connector);
    items(d.items);
  }

 private:
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
};

}  // namespace

std::vector<Edit> deprecated_spellings(const Syntax& syntax) {
  DeprecatedFormFinder finder;
  if (syntax.package != nullptr) {
    for (const Decl* decl : syntax.package->decls) finder.decl(*decl);
  }
  std::sort(finder.edits.begin(), finder.edits.end(),
            [](const Edit& a, const Edit& b) { return a.range.begin < b.range.begin; });
  return std::move(finder.edits);
}

}  // namespace bip::syntax
