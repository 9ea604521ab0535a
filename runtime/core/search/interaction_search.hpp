// The candidates of interactions that must be searched: connectors with guards, or with several configurations.
//
// A *configuration* is a set of a plan's leaves; the candidates are the maximal enabled ones. Downward from the largest
// available configuration. Connectors of the tree are evaluated bottom up (guard, then `up` into the connector's own
// frame). If a guard fails for a sub-choice, every configuration with the same sub-choice fails, so only configurations
// that change it are looked at next: one step smaller, or without it where it cannot shrink. Enabled ones stop the
// descent. With k guarded clauses this looks at O(k * ports) configurations where guards are independent; where data of
// a hierarchy decide and the descent goes on for long, range_search.hpp goes on from above with bounds (a limit turns
// what is inherently exponential into a fault). From one configuration to the next a connector is evaluated again only
// if its own sub-choice is another one: in a tree those above what went.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "bip/assert.hpp"
#include "runtime/core/link/tables.hpp"
#include "runtime/core/search/bits.hpp"
#include "runtime/core/search/remembered_searches.hpp"
#include "runtime/core/state/state.hpp"

namespace bip::rt {

struct CoreParts;

/// The candidates of a searched interaction.
struct Listing {
  std::vector<u64> configs;  // Planned: count * words
  u32 count = 0;
  std::vector<std::uint8_t> hidden;  // by configuration; empty: none
};

/// By use of the plan that is searched: the sub-choice for which it was evaluated last, and whether its guard held
/// then.
struct EvaluatedUses {
  struct Use {
    bool is_known = false, holds = false;
  };
  std::vector<Use> uses;
  std::vector<u64> bits;  // plan.words a use; of the leaves below it
  void forget(const Plan& plan) {
    uses.assign(plan.use_count, {});
    bits.resize(std::size_t{plan.use_count} * plan.words);
  }
  /// Was it evaluated for the same leaves? Else from now on it is, and holds unless one says otherwise.
  [[nodiscard]] bool knows(const Plan& plan, u32 row, const PlanUse& use, const u64* now) {
    u64* const last = bits.data() + std::size_t{row} * plan.words;
    bool same = uses[row].is_known;
    for (u32 w = use.first_leaf / 64; w * 64 < use.end_leaf; ++w) {
      u64 mask = ~u64{0};
      if (w * 64 < use.first_leaf) mask &= ~u64{0} << (use.first_leaf & 63);
      if (use.end_leaf - w * 64 < 64) mask &= ~(~u64{0} << (use.end_leaf & 63));
      same = same && last[w] == (now[w] & mask);
      last[w] = now[w] & mask;
    }
    if (!same) uses[row] = {true, true};
    return same;
  }
};

/// What searches have cost so far.
struct SearchWork {
  u64 searches = 0, configurations = 0, connectors = 0;  // configurations looked at, connectors evaluated
  u64 recalled = 0;                                      // searches that were not made: their inputs were known
  u64 range_looks = 0;                                   // sets of configurations looked at as ranges
};

/// The guard of a flat rendezvous, found without a look at the image.
struct FlatGuard {
  u32 code = kNone;  // row of the step programs' codes
  VariableId own;    // the connector's first
  u32 binds = 0;
};

class InteractionSearch {
 public:
  explicit InteractionSearch(CoreParts& core) : core_(core) {}
  void link();
  /// Forgets all candidates.
  void reset();

  // ---- candidates before priorities
  /// Has an interaction more than one candidate in some state?
  [[nodiscard]] bool is_weighted() const { return is_weighted_; }
  [[nodiscard]] bool is_searched(InteractionId interaction) const { return listing_of(interaction) != kNone; }
  /// Finds the candidates of a searched interaction. Cost: a guard, or a search. False: a fault.
  bool list(InteractionId interaction);
  /// Of a searched interaction.
  [[nodiscard]] Listing& listing(InteractionId interaction) { return listings_[listing_of(interaction)]; }
  [[nodiscard]] const Listing& listing(InteractionId interaction) const { return listings_[listing_of(interaction)]; }
  /// Of a searched interaction: the row of its `rank`-th configuration that no rule hides.
  [[nodiscard]] u32 config_of(InteractionId interaction, u32 rank) const {
    const Listing& of = listing(interaction);
    if (of.hidden.empty()) return rank;
    BIP_ASSERT(of.hidden.size() == of.count && rank < std::count(of.hidden.begin(), of.hidden.end(), 0),
               "candidate {} of {} configurations, with {} flags", rank, of.count, of.hidden.size());
    u32 config = 0;
    for (u32 left = rank; of.hidden[config] != 0 || left-- > 0;) ++config;
    return config;
  }
  /// How many candidates the interaction has.
  [[nodiscard]] u32 base_count(InteractionId interaction) const;
  /// Finds the parameters of the top connector that take part in a candidate: all of them unless the interaction is
  /// searched, where only `c:*` and `*:*` can match otherwise.
  void direct_params(InteractionId interaction, u32 config, std::vector<u32>& out) const;
  /// Candidates of the connector; 0 also if it exports a port.
  [[nodiscard]] u32 listed_count(u32 connector) const;
  [[nodiscard]] const SearchWork& work() const { return search_work_; }
  /// Of all rows.
  [[nodiscard]] std::size_t bytes() const;

  // ---- the configuration at hand, for firing it
  /// Makes the candidate's configuration the one at hand.
  void choose(const Candidate& candidate, const Plan& plan);
  [[nodiscard]] bool is_chosen(u32 node) const { return chosen_[node] != 0; }
  /// Returns what decides the candidate's configuration: that itself where it is listed, else which ports are enabled.
  /// Candidates of one plan with equal keys have the same configuration. Valid up to the next call. Cost: the leaves.
  [[nodiscard]] Span<u64> choice_key(const Candidate& candidate, const Plan& plan);
  /// The child of a Choice that is chosen.
  [[nodiscard]] u32 chosen_alternative(const Plan& plan, u32 choice) const;
  /// Runs the `up`s of the configuration, bottom up. False: a fault.
  bool run_ups(const Plan& plan);
  /// After run_ups: the clause of the plan's use, or kNone.
  [[nodiscard]] u32 clause_of_use(u32 use) const { return use_clause_[use]; }

 private:
  [[nodiscard]] u32 listing_of(InteractionId interaction) const {
    return listing_of_.empty() ? kNone : listing_of_[interaction];
  }
  FlatGuard flat_guard(const InteractionInfo& info);
  bool list_at_once(const Plan& plan, Listing& listing);
  bool evaluate_use(const PlanUse& use, u32 clause_row, bool& holds);
  bool list_flat(const InteractionInfo& info, Listing& listing);
  void bind_choices(const Plan& plan, const PlanUse& use);
  void look_at_availability(const Plan& plan, u32 root);
  void choose_largest(const Plan& plan, u32 root);
  void choose_bits(const Plan& plan, const u64* bits);
  void bits_of_choice(const Plan& plan, Bits& bits) const;
  bool evaluate(const Plan& plan, u32 root, const Bits& bits, u32& failed);
  u32 chosen_clause(const Plan& plan, u32 use);
  bool search(const Plan& plan, u32 root, std::vector<Bits>& found);
  bool search_links(const Plan& plan);
  bool decide_inner_rules(const Plan& plan, u32 first_witness);
  void hide_by_inner_rules(const Plan& plan, u32 use, std::vector<Bits>& found);
  void params_of_use(const Plan& plan, u32 use, const u64* bits, std::vector<u32>& out) const;
  bool choice_alternatives(const Plan& plan, u32 choice, std::vector<Bits>& found);
  bool initial_configurations(const Plan& plan, u32 root, std::vector<Bits>& out);
  void smaller(const Plan& plan, u32 root, u32 failed, const Bits& bits, std::vector<Bits>& out);
  bool may_hold(const Plan& plan, u32 root, const std::vector<Bits>& largest);
  bool search_ranges(const Plan& plan, u32 root, const std::vector<Bits>& largest, SetsBySize& enabled,
                     std::vector<Bits>& found);
  bool enumerate(const Plan& plan, std::vector<Bits>& found);

  CoreParts& core_;
  bool is_weighted_ = false;
  IndexVector<InteractionId, u32> listing_of_;  // kNone: not searched. Empty: none is
  std::vector<Listing> listings_;
  std::vector<FlatGuard> flat_guards_;  // by listing; code == kNone: not that simple
  SearchWork search_work_;
  RememberedSearches remembered_;

  // scratch
  std::vector<std::uint8_t> available_, chosen_;  // by plan node
  std::vector<u32> node_scratch_;                 // by plan node
  std::vector<u64> key_;                          // of choice_key
  std::vector<u32> use_clause_;                   // by use
  std::vector<u32> params_;
  std::vector<std::vector<Bits>> link_alternatives_;  // by plan node: of maximal_only links and choices
  std::vector<std::vector<Bits>> witness_configs_;    // by witness of the plan at hand
  std::vector<std::uint8_t> inner_active_;            // by rule: it hides what it matches
  EvaluatedUses evaluated_;
};

}  // namespace bip::rt
