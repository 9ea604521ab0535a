// Warns about names in `@SuppressWarning` that no warning has, because the warning that was meant is not suppressed
// then. Other annotations are not checked. Linear in the annotations.
#include <algorithm>
#include <array>

#include "compiler/model/model_builder.hpp"

namespace bip::model {

namespace {

// The names of the published compiler, and those that this compiler adds (the last row).
constexpr std::array kNames = {"nondeterminism",
                               "unboundcomponentport",
                               "unboundconnectorport",
                               "missingup",
                               "missinginteraction",
                               "nointeraction",
                               "atomprioritycycle",
                               "compoundprioritycycle",
                               "uselessdown",
                               "modifiedvariabletransition",
                               "modifiedvariableinteraction",
                               "maybenotsafe"};

void check(Diagnostics& diags, syntax::Annotations annotations) {
  for (const syntax::Annotation& a : annotations) {
    if (a.name.text != "SuppressWarning") continue;
    for (const syntax::AnnotationArg& arg : a.args) {
      if (std::find(kNames.begin(), kNames.end(), arg.key.text) != kNames.end()) continue;
      help_similar(diags.report(Diag::kB1049, arg.key.range, arg.key.text), arg.key.text, arg.key.range,
                   {kNames.begin(), kNames.end()});
    }
  }
}

template <class Rows>
void check_rows(Diagnostics& diags, const Rows& rows) {
  for (const auto& row : rows) check(diags, row.annotations);
}

void check_connector(Diagnostics& diags, const syntax::ConnectorBody* body) {
  if (body == nullptr) return;
  check_rows(diags, body->data);
  check(diags, body->exported.annotations);
  check_rows(diags, body->clauses);
}

}  // namespace

void check_suppressions(Diagnostics& diags, const syntax::Decl& decl) {
  check(diags, decl.annotations);
  check_rows(diags, decl.data);
  check_rows(diags, decl.ports);
  check_rows(diags, decl.clocks);
  check_rows(diags, decl.transitions);
  check_rows(diags, decl.priorities);
  check_rows(diags, decl.exports);
  check_connector(diags, decl.connector);
  std::vector<const syntax::CompoundItem*> todo(decl.items.begin(), decl.items.end());
  while (!todo.empty()) {
    const syntax::CompoundItem* item = todo.back();
    todo.pop_back();
    check(diags, item->annotations);
    if (item->priority != nullptr) check(diags, item->priority->annotations);
    check_connector(diags, item->inline_body);
    todo.insert(todo.end(), item->items.begin(), item->items.end());
  }
}

}  // namespace bip::model
