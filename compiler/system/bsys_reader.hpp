// The cursor over the tree of a .bsys text: takes elements of a list in order and remembers the first error.
// Internal to system/.
//
// After an error every call returns a harmless default and takes nothing more, so callers need not check each step;
// loops end because `more` is then false.
#pragma once
#include <optional>
#include <string>
#include <unordered_map>

#include "compiler/system/bsys_text.hpp"
#include "compiler/system/bsys_tree.hpp"

namespace bip::system::text {

/// A list being read. `loc` is the place written in what was taken so far.
struct List {
  std::uint32_t node = kNoNode;
  std::uint32_t at = kNoNode;  // next element
  Loc loc{};
};

class BsysReader {
 public:
  BsysReader(const Tree& tree, System& system) : tree_(tree), system_(system) {}

  void fail(std::uint32_t node, std::string_view message);
  [[nodiscard]] bool failed() const { return failure_.has_value(); }
  [[nodiscard]] const Failure& failure() const { return *failure_; }

  /// Opens a list node; its first element must be a word, which is taken and stored in `head`.
  List open(std::uint32_t node, std::string_view& head);
  /// Opens a list node without a head.
  [[nodiscard]] List open_bare(std::uint32_t node) const {
    return {.node = node, .at = tree_.nodes[node].first, .loc = {}};
  }
  [[nodiscard]] bool more(List& list);
  /// The next element, whatever it is.
  std::uint32_t next(List& list, std::string_view wanted);
  std::string name(List& list);
  std::string quoted(List& list);
  Type type(List& list);
  /// The row's own number, which must be `expected`.
  void row(List& list, std::size_t expected);
  /// A reference to one of `count` rows: `number` or `number:name`. `name_of(number)` gives the name to compare.
  template <class NameOf>
  std::uint32_t ref(List& list, std::size_t count, const char* what, NameOf name_of) {
    std::string_view hint;
    std::uint32_t node = kNoNode;
    const std::uint32_t number = number_of_ref(list, count, what, hint, node);
    if (!failed() && hint.data() != nullptr && hint != std::string_view(name_of(number)))
      fail(node, "the name after `:` is not that of the row");
    return number;
  }
  /// Takes the word if it comes next.
  bool flag(List& list, std::string_view word);
  /// Opens the next element if it is a list headed by `head`.
  std::optional<List> sub(List& list, std::string_view head);
  /// The same, required.
  List need(List& list, const char* head);
  /// Nothing may be left.
  void close(List& list);

  /// A constant: 3 3.0 true "text".
  Value literal(std::uint32_t node);
  ExprId expr(List& list, const CodeScope& scope);
  /// All that is left of the list, as a body.
  StmtId body(List& list, const CodeScope& scope);
  /// Adds a string constant row. False if it is there already.
  bool add_string(const std::string& text);

 private:
  std::uint32_t number_of_ref(List& list, std::size_t count, const char* what, std::string_view& hint,
                              std::uint32_t& node);
  std::string text_of(std::uint32_t node);
  void take_loc(List& list, std::uint32_t node);
  std::uint32_t variable(List& list, const std::vector<ScopeVariable>& variables);
  ExprId expr(std::uint32_t node, const CodeScope& scope);
  StmtId stmt(std::uint32_t node, const CodeScope& scope);

  const Tree& tree_;
  System& system_;
  std::optional<Failure> failure_;
  std::unordered_map<std::string, std::uint32_t> strings_;
};

}  // namespace bip::system::text
