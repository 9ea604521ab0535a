// The base class of the generated parser's tree nodes: accessors of children without `dynamic_cast`.
//
// ANTLR's accessors find the class of every child by walking the class hierarchy, twice per match; that was an eighth
// of the time of parsing. No node class is derived from, and all are instantiated in this program, so equal classes
// have one `type_info`.
#pragma once
#include <typeinfo>
#include <vector>

#include "antlr4-runtime.h"

namespace bip::antlr {

class TreeNode : public antlr4::ParserRuleContext {
 public:
  TreeNode(antlr4::ParserRuleContext* parent, std::size_t invoking_state)
      : antlr4::ParserRuleContext(parent, invoking_state) {}

  template <class T>
  T* getRuleContext(std::size_t i) {
    for (antlr4::tree::ParseTree* child : children) {
      if (&typeid(*child) == &typeid(T) && i-- == 0) return static_cast<T*>(child);
    }
    return nullptr;
  }

  template <class T>
  std::vector<T*> getRuleContexts() {
    std::vector<T*> found;
    for (antlr4::tree::ParseTree* child : children) {
      if (&typeid(*child) == &typeid(T)) found.push_back(static_cast<T*>(child));
    }
    return found;
  }

  antlr4::tree::TerminalNode* getToken(std::size_t type, std::size_t i) override {
    for (antlr4::tree::ParseTree* child : children) {
      antlr4::tree::TerminalNode* leaf = as_leaf(child);
      if (leaf != nullptr && leaf->getSymbol()->getType() == type && i-- == 0) return leaf;
    }
    return nullptr;
  }

  std::vector<antlr4::tree::TerminalNode*> getTokens(std::size_t type) override {
    std::vector<antlr4::tree::TerminalNode*> found;
    for (antlr4::tree::ParseTree* child : children) {
      antlr4::tree::TerminalNode* leaf = as_leaf(child);
      if (leaf != nullptr && leaf->getSymbol()->getType() == type) found.push_back(leaf);
    }
    return found;
  }

  /// The leaf that `child` is, or null. Leaves of recovery (conjured tokens) count.
  [[nodiscard]] static antlr4::tree::TerminalNode* as_leaf(antlr4::tree::ParseTree* child) {
    const std::type_info& type = typeid(*child);
    const bool is_leaf =
        &type == &typeid(antlr4::tree::TerminalNodeImpl) || &type == &typeid(antlr4::tree::ErrorNodeImpl);
    return is_leaf ? static_cast<antlr4::tree::TerminalNode*>(child) : nullptr;
  }
};

}  // namespace bip::antlr
