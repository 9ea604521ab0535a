// The states that were found, as words: one word a state, whatever its width.
//
// A state of one word is its own key. A wider one is a tree (Blom, Lisser, van de Pol, Weber 2008; Laarman, van de Pol,
// Weber 2011): each word is numbered in a set of its own, two numbers are a word of the next set, and so on up to the
// root, whose words are the states. Different states have different roots, so this is exact; the inner sets hold what
// states share and are small beside the root. Cost: one look-up a node of the tree, most of them in cache.
#pragma once
#include "runtime/explore/word_set.hpp"

#include "bip/assert.hpp"

namespace bip::rt {

class StateStore {
 public:
  using u32 = std::uint32_t;
  using u64 = std::uint64_t;

  /// words: of a state, at least 1. limit: in bytes, 0: none.
  StateStore(u32 words, std::size_t limit);

  /// Adds `count` states of `words()` words each. True unless memory is short; then those before are added. New ones
  /// are numbered in order; `is_new` (may be null) has a byte a state, `rows` (may be null) gets the number of each.
  bool add(const u64* states, std::size_t count, std::uint8_t* is_new = nullptr, u32* rows = nullptr);
  /// The number of a state; WordSet::kFull: it is not there.
  [[nodiscard]] u32 find(const u64* state) const;
  [[nodiscard]] bool contains(const u64* state) const { return find(state) != WordSet::kFull; }
  /// scratch: of the caller's thread.
  void read(u32 row, u64* out, std::vector<u64>& scratch) const;

  [[nodiscard]] u32 size() const { return sets_.back().size(); }
  [[nodiscard]] u32 words() const { return words_; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  // Node k joins the numbers that nodes left and right give; nodes below words_ are the words themselves.
  struct Node {
    u32 left, right;
  };
  bool fold(const u64* state, u64& root);
  // Is the state stored in this row? For assertions.
  [[nodiscard]] bool is_row(u32 row, const u64* state) const;

  u32 words_;
  std::size_t limit_;
  std::vector<Node> nodes_;    // inner nodes but the root, then the root
  std::vector<WordSet> sets_;  // by node: words, inner nodes, the root (words_ == 1: only the root)
  std::vector<u64> roots_;     // scratch
  std::vector<u64> values_;
};

}  // namespace bip::rt
