// What codels are called with: which data each argument of a description names, its type in C or C++, and the
// expression that the C++ between BIP and codels passes for it. Internal to compiler/genom.
#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "compiler/genom/idl.hpp"

namespace bip::genom {

/// `value`: `@` stands for the number of the owner, an activity or a task.
struct CodelArgument {
  std::string type, value;
  [[nodiscard]] std::string value_of(std::size_t owner) const;
};

/// Names of one component.
class CodelArguments {
 public:
  explicit CodelArguments(const idl::Component& c) : component_(c) {}

  /// The type of the member that a path leads to from one of `members`, its expression goes to `text`. Nothing if it
  /// leads nowhere.
  [[nodiscard]] std::optional<std::size_t> follow(const std::vector<idl::Member>& members,
                                                  const std::vector<std::string>& path, std::string& text) const;
  /// Parameters and locals of a service.
  [[nodiscard]] std::vector<idl::Member> locals_of(const idl::Service& s) const;
  /// Of an attribute that of the IDS.
  [[nodiscard]] std::optional<std::size_t> type_of(const idl::Service& s, const idl::Parameter& p) const;
  /// Nothing: there is no such data.
  [[nodiscard]] std::optional<CodelArgument> argument(const idl::Argument& a,
                                                      const std::vector<idl::Member>& locals) const;

 private:
  const idl::Component& component_;
};

/// The row of that name; null: there is none.
template <class Row>
const Row* find_row(const std::vector<Row>& rows, const std::string& name) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.name == name; });
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace bip::genom
