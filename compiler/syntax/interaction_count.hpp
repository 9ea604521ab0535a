// How many interactions a `define` gives, without listing them.
#pragma once
#include <cstddef>

#include "compiler/syntax/syntax.hpp"

namespace bip::syntax {

/// The interactions of a group of `define`, from those of its children: the product where no child is a trigger, else
/// every choice of children that has a trigger among them. A double: it may be 2^1000.
class GroupCount {
 public:
  void add(double child, bool is_trigger) {
    all_ *= child;
    any_ *= 1 + child;
    if (is_trigger) has_triggers_ = true;
    else without_ *= 1 + child;
  }
  [[nodiscard]] double count() const { return has_triggers_ ? any_ - without_ : all_; }

 private:
  bool has_triggers_ = false;
  double all_ = 1, any_ = 1, without_ = 1;
};

/// As written, also where names in it are wrong. Without a `define` (the paper's notation) it is any subset of the
/// ports. Linear in the tree.
[[nodiscard]] double interaction_count(const ConnectorBody& body, std::size_t ports);

}  // namespace bip::syntax
