// The enabled set: how many candidates each interaction has, kept in one or both of two ways.
//
// Ranked: a bitset in interaction order with a tree of counts of fan-out 8 above it, so that "the k-th candidate" and
// "how many before interaction s" cost O(log n) and an update costs one addition a level. Choices are random, so the
// descent has no branch that depends on them. Listed: the interactions that have candidates as one dense array and
// where each of them is: a uniform choice is one load, an update a few stores. Its order is part of what the policy
// `uniform` means (semantics.md): after a step the changes are applied in interaction order, what goes is replaced by
// the last one, what comes goes to the end.
//
// Most systems have at most one candidate an interaction; only `weighted` sets keep a weight an interaction. A set
// starts ranked; one that only draws uniformly ranks no more until it is asked for a rank, as one with weights is where
// an interaction has several candidates.
#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "bip/assert.hpp"
#include "bip/ids.hpp"
#include "runtime/core/state/list_changes.hpp"
#include "runtime/core/state/member_order.hpp"

namespace bip::rt {

class EnabledSet {
 public:
  void reset(std::uint32_t interactions, bool weighted) {
    words_.assign(static_cast<std::size_t>(interactions) / 64 + 1, 0);
    weights_.assign(weighted ? interactions : 0, 0);
    counts_.clear();
    levels_ = 0;
    for (std::size_t entries = words_.size(); entries > 1; entries = (entries + 7) / 8) {
      offset_[levels_++] = static_cast<std::uint32_t>(counts_.size());
      // Padded to whole groups of 8, so that a scan of a group never leaves the level.
      counts_.resize(counts_.size() + (entries + 7) / 8 * 8, 0);
      if (entries <= 8) break;
    }
    size_ = interactions;
    total_ = 0;
    last_in_ = InteractionId(0u);
    ranked_ = true;
    unlist();
  }

  [[nodiscard]] std::uint64_t total() const { return total_; }
  [[nodiscard]] std::uint32_t weight(InteractionId interaction) const {
    BIP_ASSERT(interaction.value < size_, "interaction {} of {}", interaction, size_);
    if (!weights_.empty()) return weights_[interaction];
    if (ranked_) return static_cast<std::uint32_t>(words_[word_of(interaction)] >> bit_of(interaction) & 1);
    return (position_[interaction] != kAbsent) != changes_.has(interaction) ? 1 : 0;
  }

  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const {
    return words_.size() * sizeof(std::uint64_t) + changes_.bytes() +
           (counts_.size() + weights_.size() + members_.size() + position_.size()) * sizeof(std::uint32_t) +
           order_.bytes();
  }

  // ---- the list
  /// Starts the list: all interactions with candidates, in interaction order.
  void list(std::uint32_t interactions) {
    ensure_ranked();
    position_.assign(interactions, kAbsent);
    changes_.reset(interactions);
    members_.assign(std::size_t{interactions} + 1, 0);
    listed_count_ = 0;
    if (ordered_) order_.reset(interactions);
    for (std::size_t entry = 0; entry < words_.size(); ++entry) {
      for (std::uint64_t word = words_[entry]; word != 0; word &= word - 1) {
        append(at_bit(entry, std::countr_zero(word)));
      }
    }
    listed_ = true;
    ranked_ = false;
  }
  /// In the order that it had before. What that lacks came since it was up to date, what it has too much went.
  void list(const std::vector<InteractionId>& order, std::uint32_t interactions) {
    list(interactions);
    IndexVector<InteractionId, std::uint8_t> differs(interactions, 0);
    for (std::uint32_t i = 0; i < listed_count_; ++i) {
      differs[listed(i)] = 1;
      position_[listed(i)] = kAbsent;
    }
    listed_count_ = 0;
    for (const InteractionId interaction : order) {
      append(interaction);
      differs[interaction] ^= 1;
    }
    for (const InteractionId interaction : differs.ids()) {
      if (differs[interaction] != 0) changes_.toggle(interaction);
    }
  }
  /// Lists keep the order of their members from now on.
  void keep_order() { ordered_ = true; }
  [[nodiscard]] bool keeps_order() const { return ordered_; }
  /// Requires a list that was started after keep_order. Code that changes the open list marks what enters.
  [[nodiscard]] MemberOrder& order() {
    BIP_ASSERT(listed_ && ordered_, "a list without order");
    return order_;
  }
  /// Back to ranks alone.
  void unlist() {
    ensure_ranked();
    listed_ = false;
    changes_.clear();
  }
  [[nodiscard]] bool is_listed() const { return listed_; }
  [[nodiscard]] std::uint32_t listed_count() const { return listed_count_; }
  [[nodiscard]] InteractionId listed(std::uint64_t position) const { return InteractionId(members_[position]); }
  /// Brings the list up to date with what came and went since the last time.
  void settle_list() {
    BIP_ASSERT(listed_ || !changes_.any(), "changes without a list");
    if (changes_.any()) apply_changes();
  }

  /// Opens the list for a caller that changes it and the count directly, until close_list. Unweighted, without
  /// unsettled changes.
  struct List {
    std::uint32_t *members, *position, *count;
  };
  List open_list() {
    BIP_ASSERT(listed_ && weights_.empty() && !changes_.any(), "unsettled changes, or no list");
    return {members_.data(), position_.rows().data(), &listed_count_};
  }
  void close_list(std::uint32_t count) {
    BIP_ASSERT(count <= size_, "{} members of {}", count, size_);
    listed_count_ = total_ = count;
    ranked_ = false;
  }

  // ---- changes; with a list they count from settle_list on
  /// With one candidate. The interaction must not be in the set.
  void insert(InteractionId interaction) {
    BIP_ASSERT(weight(interaction) == 0, "interaction {} is in the set already", interaction);
    toggle(interaction, 1);
  }
  /// The interaction must be in the set with one candidate.
  void erase(InteractionId interaction) {
    BIP_ASSERT(weight(interaction) == 1, "interaction {} has {} candidates", interaction, weight(interaction));
    toggle(interaction, ~0u);
  }
  /// Unweighted sets without unsettled changes. Members of the word that holds interactions 64 * word ... come and go,
  /// `difference` more than before.
  void flip(std::uint32_t word, std::uint64_t flips, std::uint32_t difference) {
    BIP_ASSERT(weights_.empty() && !changes_.any(), "unsettled changes, or weights");
    if (ranked_) {
      words_[word] ^= flips;
      add(at_bit(word, 0), difference);
    }
    total_ += difference;
    if (!listed_) return;
    const List list{members_.data(), position_.rows().data(), nullptr};
    for (; flips != 0; flips &= flips - 1) {
      const InteractionId interaction = at_bit(word, std::countr_zero(flips));
      if (exchange(interaction.value, list, listed_count_) && ordered_) order_.mark(interaction);
    }
  }
  [[gnu::noinline]] void set(InteractionId interaction, std::uint32_t weight_now) {
    const std::uint32_t before = weight(interaction);
    BIP_ASSERT(!weights_.empty() || weight_now <= 1, "weight {} of interaction {}", weight_now, interaction);
    if (before == weight_now) return;
    // Mostly one of them is 0, the other 1.
    if (before + weight_now == 1) toggle(interaction, weight_now - before);
    else change_weight(interaction, before, weight_now);
  }

  struct Position {
    InteractionId interaction;
    std::uint32_t rank;  // among the interaction's candidates
  };
  /// Is there such a candidate?
  [[nodiscard]] bool has(Position at) const { return at.interaction.value < size_ && at.rank < weight(at.interaction); }
  /// The number of a candidate in canonical order. O(log interactions).
  [[nodiscard]] std::uint64_t number(Position at) const { return rank(at.interaction) + at.rank; }
  /// The number of the first candidate in an interaction greater than `interaction`, cyclically. O(log interactions).
  [[nodiscard]] std::uint64_t next_after(InteractionId interaction) const {
    const std::uint64_t k = rank(InteractionId(interaction.value + 1));
    return k < total_ ? k : 0;
  }
  /// The same candidate itself; total() > 0. O(1) if it is near, as that of an engine that goes round mostly is.
  [[nodiscard]] Position first_after(InteractionId interaction) const {
    BIP_ASSERT(total_ != 0, "no candidate comes after interaction {}", interaction.value);
    ensure_ranked();
    constexpr std::size_t kNear = 8;
    const InteractionId from(interaction.value + 1);
    std::size_t entry = word_of(from);
    const std::size_t end = std::min(entry + kNear, words_.size());
    std::uint64_t word = entry < end ? words_[entry] & ~std::uint64_t{0} << bit_of(from) : 0;
    while (word == 0 && ++entry < end) word = words_[entry];
    return entry < end ? Position{at_bit(entry, std::countr_zero(word)), 0} : select(next_after(interaction));
  }
  /// The k-th candidate in the list's order while every interaction in it has one, else in canonical order; k <
  /// total(). Needs the list. O(1) while every interaction has one.
  [[nodiscard]] Position drawn(std::uint64_t k) const {
    BIP_ASSERT(listed_ && k < total_, "candidate {} of {} in the list", k, total_);
    if (listed_count_ == total_) return {listed(k), 0};
    return select(k);
  }
  /// The interactions of the list, in its order; none without a list.
  [[nodiscard]] std::vector<InteractionId> list_order() const {
    if (!listed_) return {};
    return std::vector<InteractionId>(members_.begin(), members_.begin() + static_cast<std::ptrdiff_t>(listed_count_));
  }
  /// The k-th candidate, k < total().
  [[nodiscard]] Position select(std::uint64_t k) const {
    BIP_ASSERT(k < total_, "candidate {} of {}", k, total_);
    ensure_ranked();
    // With clocks there often is one alone, the one that came last.
    if (total_ == 1 && weights_.empty() && (words_[word_of(last_in_)] >> bit_of(last_in_) & 1) != 0)
      return {last_in_, 0};
    auto left = static_cast<std::uint32_t>(k);
    std::size_t entry = 0;
    for (std::uint32_t level = levels_; level-- > 0;) {
      const std::uint32_t* c = counts_.data() + offset_[level] + entry * 8;
      // Sums up to each entry, and of those that are passed, as short trees: a step waits for this chain of additions.
      const std::uint32_t c01 = c[0] + c[1], c45 = c[4] + c[5], c03 = c01 + (c[2] + c[3]), c05 = c03 + c45;
      const std::uint32_t p0 = passed(c[0], left), p1 = passed(c01, left), p2 = passed(c01 + c[2], left),
                          p3 = passed(c03, left);
      const std::uint32_t p4 = passed(c03 + c[4], left), p5 = passed(c05, left), p6 = passed(c05 + c[6], left);
      const std::uint32_t skipped = 0 - (((p0 + p1) + (p2 + p3)) + ((p4 + p5) + p6));
      const std::uint32_t before =
          (((c[0] & p0) + (c[1] & p1)) + ((c[2] & p2) + (c[3] & p3))) + (((c[4] & p4) + (c[5] & p5)) + (c[6] & p6));
      left -= before;
      entry = entry * 8 + skipped;
    }
    std::uint64_t word = words_[entry];
    if (weights_.empty()) {
      return {at_bit(entry, fast_pdep_ ? select_bit_pdep(word, left) : select_bit(word, left)), 0};
    }
    for (;; word &= word - 1) {
      const InteractionId interaction = at_bit(entry, std::countr_zero(word));
      if (left < weights_[interaction]) return {interaction, left};
      left -= weights_[interaction];
    }
  }
  /// The number of candidates in interactions below `interaction`.
  [[nodiscard]] std::uint64_t rank(InteractionId interaction) const {
    BIP_ASSERT(interaction.value <= size_, "interaction {} of {}", interaction, size_);
    ensure_ranked();
    std::uint64_t sum = 0;
    std::size_t entry = word_of(interaction);
    std::uint64_t word = words_[entry] & ((std::uint64_t{1} << bit_of(interaction)) - 1);
    if (weights_.empty()) {
      sum = count_bits(word);
    } else {
      for (; word != 0; word &= word - 1) sum += weights_[at_bit(entry, std::countr_zero(word))];
    }
    for (std::uint32_t level = 0; level < levels_; ++level) {
      for (std::size_t i = entry / 8 * 8; i < entry; ++i) sum += counts_[offset_[level] + i];
      entry /= 8;
    }
    return sum;
  }

  /// Do the ranks, the list and the total agree? O(interactions).
  [[nodiscard]] bool is_consistent() const {
    std::uint64_t sum = 0;
    for (const InteractionId interaction : ids()) sum += weight(interaction);
    return sum == total_ && (!ranked_ || has_consistent_counts()) && (!listed_ || has_consistent_list());
  }

  /// The position of the k-th one of the word, two ways to the same answer.
#if defined(__x86_64__)
  [[gnu::target("bmi2")]] static std::uint32_t select_bit_pdep(std::uint64_t word, std::uint32_t k) {
    return static_cast<std::uint32_t>(std::countr_zero(__builtin_ia32_pdep_di(std::uint64_t{1} << k, word)));
  }
  // The first two Zens have the instruction in microcode, slower than what it replaces.
  static bool has_fast_pdep() {
    return __builtin_cpu_supports("bmi2") && !__builtin_cpu_is("znver1") && !__builtin_cpu_is("znver2");
  }
#else
  static std::uint32_t select_bit_pdep(std::uint64_t word, std::uint32_t k) { return select_bit(word, k); }
  static bool has_fast_pdep() { return false; }
#endif
  // The position of the k-th one, free of branches (Vigna, "Broadword implementation of rank/select queries", 2008).
  static std::uint32_t select_bit(std::uint64_t word, std::uint32_t k) {
    constexpr std::uint64_t kOnes = 0x0101010101010101u;
    std::uint64_t sums = word - (word >> 1 & 0x5555555555555555u);
    sums = (sums & 0x3333333333333333u) + (sums >> 2 & 0x3333333333333333u);
    sums = ((sums + (sums >> 4)) & 0x0f0f0f0f0f0f0f0fu) * kOnes;
    const std::uint64_t not_above = ((k * kOnes | kOnes << 7) - sums) & kOnes << 7;
    const auto place = static_cast<std::uint32_t>((not_above >> 7) * kOnes >> 56) * 8;
    const std::uint32_t left = k - static_cast<std::uint32_t>((sums << 8) >> place & 0xff);
    // Bit i of the byte alone in byte i, then 1 there, then how many up to there.
    const std::uint64_t spread = (word >> place & 0xff) * kOnes & 0x8040201008040201u;
    const std::uint64_t upto = ((spread + 0x7f7f7f7f7f7f7f7fu) >> 7 & kOnes) * kOnes;
    const std::uint64_t passed = ((left * kOnes | kOnes << 7) - upto) & kOnes << 7;
    return place + static_cast<std::uint32_t>((passed >> 7) * kOnes >> 56);
  }

  /// All interactions.
  [[nodiscard]] IdRange<InteractionId> ids() const { return IdRange<InteractionId>(size_); }

 private:
  // Where an interaction is in the bitset, and the other way round.
  static std::uint32_t word_of(InteractionId interaction) { return interaction.value >> 6; }
  static std::uint32_t bit_of(InteractionId interaction) { return interaction.value & 63; }
  template <class Word, class Bit>
  static InteractionId at_bit(Word word, Bit bit) {
    return InteractionId(static_cast<std::uint32_t>(word * 64) + static_cast<std::uint32_t>(bit));
  }
  // Is each count the sum of what is below it?
  [[nodiscard]] bool has_consistent_counts() const {
    for (std::uint32_t level = 0; level < levels_; ++level) {
      const std::size_t end = level + 1 < levels_ ? offset_[level + 1] : counts_.size();
      for (std::size_t entry = 0; entry < end - offset_[level]; ++entry) {
        const std::size_t first = entry << (6 + 3 * level), last = (entry + 1) << (6 + 3 * level);
        std::uint32_t below = 0;
        for (std::size_t i = first; i < last && i < size_; ++i) below += weight(InteractionId(i));
        if (counts_[offset_[level] + entry] != below) return false;
      }
    }
    return true;
  }
  // Is each member where position_ says, and, but for what comes and goes, each interaction with candidates a member?
  [[nodiscard]] bool has_consistent_list() const {
    std::uint32_t members = 0;
    for (const InteractionId i : ids()) {
      const bool is_member = position_[i] != kAbsent;
      members += is_member ? 1 : 0;
      if (is_member && (position_[i] >= listed_count_ || listed(position_[i]) != i)) return false;
      if ((is_member != changes_.has(i)) != (weight(i) != 0)) return false;
    }
    return members == listed_count_;
  }
  // Without -mpopcnt std::popcount is a call; this is a dozen instructions.
  static std::uint32_t count_bits(std::uint64_t x) {
    x -= x >> 1 & 0x5555555555555555u;
    x = (x & 0x3333333333333333u) + (x >> 2 & 0x3333333333333333u);
    x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fu;
    return static_cast<std::uint32_t>(x * 0x0101010101010101u >> 56);
  }
  // All ones if `left` is not below `sum`, both less than 2^31. A mask, for compilers make branches of conditions here.
  static std::uint32_t passed(std::uint32_t sum, std::uint32_t left) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(~(left - sum)) >> 31);
  }
  void add(InteractionId interaction, std::uint32_t difference) const {
    std::uint32_t entry = word_of(interaction);
    for (std::uint32_t level = 0; level < levels_; ++level, entry >>= 3) counts_[offset_[level] + entry] += difference;
  }

  void toggle(InteractionId interaction, std::uint32_t difference) {
    total_ += difference;
    if (!weights_.empty()) weights_[interaction] += difference;
    if (ranked_) {
      if (difference == 1) last_in_ = interaction;
      words_[word_of(interaction)] ^= std::uint64_t{1} << bit_of(interaction);
      add(interaction, difference);
    }
    if (listed_) changes_.toggle(interaction);
  }
  [[gnu::noinline]] void change_weight(InteractionId interaction, std::uint32_t before, std::uint32_t weight_now) {
    if (listed_ && (before == 0) != (weight_now == 0)) changes_.toggle(interaction);
    weights_[interaction] = weight_now;
    total_ += weight_now - before;
    if (!ranked_) return;
    const std::uint64_t bit = std::uint64_t{1} << bit_of(interaction);
    if (weight_now != 0) words_[word_of(interaction)] |= bit;
    else words_[word_of(interaction)] &= ~bit;
    add(interaction, weight_now - before);
  }
  void append(InteractionId interaction) {
    position_[interaction] = listed_count_;
    members_[listed_count_++] = interaction.value;
    if (ordered_) order_.mark(interaction);
  }
  // The interaction comes to the end of the list, or the last one takes its place. Returns whether it came.
  static bool exchange(std::uint32_t interaction, const List& list, std::uint32_t& count) {
    const std::uint32_t at = list.position[interaction];
    if (at == kAbsent) {
      list.position[interaction] = count;
      list.members[count++] = interaction;
      return true;
    }
    const std::uint32_t last = list.members[--count];
    list.members[at] = last;
    list.position[last] = at;
    list.position[interaction] = kAbsent;
    return false;
  }
  [[gnu::noinline]] void apply_changes() {
    const List list{members_.data(), position_.rows().data(), nullptr};
    std::uint32_t count = listed_count_;
    changes_.take([&](InteractionId interaction) {
      if (exchange(interaction.value, list, count) && ordered_) order_.mark(interaction);
    });
    listed_count_ = count;
  }
  // Counts anew, from the weights or the list.
  void ensure_ranked() const {
    if (ranked_) return;
    ranked_ = true;
    std::fill(words_.begin(), words_.end(), std::uint64_t{0});
    std::fill(counts_.begin(), counts_.end(), 0u);
    const auto enter = [&](InteractionId interaction, std::uint32_t candidates = 1) {
      words_[word_of(interaction)] |= std::uint64_t{1} << bit_of(interaction);
      add(interaction, candidates);
    };
    if (!weights_.empty()) {
      for (const InteractionId interaction : weights_.ids()) {
        if (weights_[interaction] != 0) enter(interaction, weights_[interaction]);
      }
      return;
    }
    for (std::uint32_t i = 0; i < listed_count_; ++i) {
      if (!changes_.has(listed(i))) enter(listed(i));
    }
    changes_.visit([&](InteractionId interaction) {
      if (position_[interaction] == kAbsent) enter(interaction);
    });
  }

  static constexpr std::uint32_t kAbsent = 0xffffffffu;

  // Ranks; counted anew when one is needed, also in const functions.
  mutable std::vector<std::uint64_t> words_;
  mutable std::vector<std::uint32_t> counts_;
  mutable bool ranked_ = true;
  IndexVector<InteractionId, std::uint32_t> weights_;
  std::uint32_t offset_[12] = {};
  std::uint32_t levels_ = 0;
  std::uint32_t size_ = 0;  // interactions
  std::uint32_t total_ = 0;
  InteractionId last_in_{0u};
  bool fast_pdep_ = has_fast_pdep();

  bool listed_ = false;
  bool ordered_ = false;
  std::uint32_t listed_count_ = 0;
  std::vector<std::uint32_t>
      members_;  // interactions as plain numbers, for compiled steps change them: the first listed_count_; one more
                 // than interactions, for code that writes before it looks
  IndexVector<InteractionId, std::uint32_t> position_;  // in members_
  ListChanges changes_;                                 // in or out, contrary to the list
  MemberOrder order_;                                   // if ordered_
};

}  // namespace bip::rt
