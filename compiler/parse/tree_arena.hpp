// An arena of tree nodes that can list them, so that a tree is moved to another text without a walk over it.
#pragma once
#include <type_traits>
#include <vector>

#include "compiler/base/arena.hpp"
#include "compiler/syntax/move_nodes.hpp"

namespace bip::parse {

/// `count` nodes of one type, side by side in an arena.
struct MadeNodes {
  void* first = nullptr;
  std::size_t count = 0;
  std::size_t size = 0;  // of one
  void (*move)(void* first, std::size_t count, const syntax::NodeMove& by) = nullptr;
};

class TreeArena {
 public:
  /// `made` (may be null) gets a row for each allocation of nodes.
  explicit TreeArena(Arena& arena, std::vector<MadeNodes>* made = nullptr) : arena_(arena), made_(made) {}

  template <class T>
  T* make(T value) {
    T* node = arena_.make(std::move(value));
    list_nodes(node, 1);
    return node;
  }
  template <class T>
  std::span<const T> list(const std::vector<T>& items) {
    const std::span<const T> nodes = arena_.list(items);
    // The arena's own memory is not const.
    if (!nodes.empty()) list_nodes(const_cast<T*>(nodes.data()), nodes.size());
    return nodes;
  }
  std::string_view text(std::string_view s) { return arena_.text(s); }

 private:
  template <class T>
  void list_nodes(T* first, std::size_t count) {
    // Pointers hold no range.
    if constexpr (!std::is_pointer_v<T>) {
      if (made_ != nullptr) made_->push_back({first, count, sizeof(T), move_all<T>});
    }
  }
  template <class T>
  static void move_all(void* first, std::size_t count, const syntax::NodeMove& by) {
    T* const nodes = static_cast<T*>(first);
    for (std::size_t i = 0; i < count; ++i) move(nodes[i], by);
  }

  Arena& arena_;
  std::vector<MadeNodes>* made_;
};

}  // namespace bip::parse
