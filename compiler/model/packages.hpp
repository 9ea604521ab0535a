// Names across packages: from a name as it is written in a file to its key in the model's tables.
//
// A package sees its own names, then those of the packages it uses, unqualified and as `p.X`; what a used package uses
// it does not see. An own name hides a used one; two used packages with the same name are an error where it is written.
// Cost: a look-up in a hash table, and one more a used package.
#pragma once
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "compiler/model/model.hpp"

namespace bip::model {

/// The package of a file; texts that are no package's (--root) speak for the compiled one.
[[nodiscard]] const PackageScope& package_of(const Model& model, FileId file);

/// The key to try first: that of the own package, or of the one that the name is qualified with; empty if there is
/// none.
[[nodiscard]] std::string own_key(const Model& model, std::string_view name, FileId file);
/// The keys to try then, of used packages; more than one in a table is ambiguous. None for qualified names.
[[nodiscard]] std::vector<std::string> used_keys(const Model& model, std::string_view name, FileId file);

/// Every key that `name` may mean in `file`: none, one, or several if used packages disagree.
template <class Row>
[[nodiscard]] std::vector<std::string> visible_keys(const Model& model,
                                                    const std::unordered_map<std::string, Row>& table,
                                                    std::string_view name, FileId file) {
  if (std::string own = own_key(model, name, file); table.contains(own)) return {std::move(own)};
  std::vector<std::string> found;
  for (std::string& key : used_keys(model, name, file)) {
    if (table.contains(key)) found.push_back(std::move(key));
  }
  return found;
}

/// The row of `name` as written at `at`, or nullptr. Reports it if two used packages have the name; the first is meant
/// then.
template <class Row>
[[nodiscard]] const Row* find_visible(const Model& model, const std::unordered_map<std::string, Row>& table,
                                      std::string_view name, SourceRange at, Diagnostics& diags);

/// What find_visible reports.
void report_ambiguous(Diagnostics& diags, SourceRange at, std::string_view name, const std::vector<std::string>& keys);

/// The `extern function`s of a name, of all used packages together: one C++ name is one set of overloads, wherever its
/// prototypes are written.
[[nodiscard]] std::vector<const syntax::Decl*> visible_prototypes(const Model& model, const std::string& name,
                                                                  FileId file);

/// A key of the tables as one writes it in `file`, without the package where that is clear; empty if it is not visible
/// there.
[[nodiscard]] std::string shown_key(const Model& model, const std::string& key, FileId file);

template <class Row>
const Row* find_visible(const Model& model, const std::unordered_map<std::string, Row>& table, std::string_view name,
                        SourceRange at, Diagnostics& diags) {
  const std::vector<std::string> keys = visible_keys(model, table, name, at.file);
  if (keys.empty()) return nullptr;
  if (keys.size() > 1) report_ambiguous(diags, at, name, keys);
  return &table.find(keys.front())->second;
}

}  // namespace bip::model
