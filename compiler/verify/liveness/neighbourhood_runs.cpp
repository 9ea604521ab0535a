// See neighbourhood_runs.hpp.
#include "compiler/verify/liveness/neighbourhood_runs.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "compiler/base/log.hpp"
#include "compiler/verify/liveness/neighbourhood_graph.hpp"
#include "compiler/verify/regions/property_ranges.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::size_t kMostNamed = 2;
constexpr std::size_t kMostNodesOfCases = 200'000;

void insert_sorted(std::vector<u32>& sorted, u32 value) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), value);
  if (at == sorted.end() || *at != value) sorted.insert(at, value);
}

class NeighbourhoodProver {
 public:
  NeighbourhoodProver(const Formula& formula, const System& system, const rt::Image& image,
                      const NeighbourhoodOptions& options)
      : formula_(formula), system_(system), options_(options), steps_(system, image) {}

  NeighbourhoodProof run() {
    if (is_invariant_of_past(formula_)) return proof_;
    Result<Automaton> automaton = make_automaton(formula_, RunsOf::Negation);
    if (!automaton || automaton->is_empty()) return proof_;
    named_.automaton = &*automaton;
    if (!find_named()) return proof_;
    const Neighbourhood nobody(steps_, named_.atoms, {}, options_.cancellation);
    if (!nobody.is_complete() || !find_nodes(nobody)) return proof_;
    const std::vector<std::uint8_t> none(steps_.size(), 0);
    NeighbourhoodGraph alone(steps_, named_, nodes_, nobody, none, true);
    if (!alone.build(options_.cancellation)) return proof_;
    find_candidates();
    neighbourhoods_.resize(candidates_.size());
    for (const std::vector<CaseNode>& part : alone.find_repeated(options_.fairness).parts) {
      if (!is_refuted(part)) return proof_;
      ++proof_.cases;
    }
    proof_.is_proved = true;
    proof_.may_have_errors = !steps_.faultless().has_all();
    return proof_;
  }

 private:
  // ---- the property's side

  bool find_named() {
    for (const Property& condition : formula_.states) {
      for (const u32 atom : atoms_of(condition)) insert_sorted(named_.atoms, atom);
    }
    for (const StepCondition& condition : formula_.steps) {
      BIP_ASSERT(condition.instances.empty(), "a formula that a proof made");
      if (condition.is_port) insert_sorted(named_.atoms, condition.owner);
    }
    // A step that the property names is one of a named component.
    for (const StepCondition& condition : formula_.steps) {
      if (condition.is_port) continue;
      const std::vector<u32>& members = steps_.atoms_of(condition.owner);
      if (std::none_of(members.begin(), members.end(), [&](u32 atom) { return is_named(atom); }))
        insert_sorted(named_.atoms, members.front());
    }
    if (named_.atoms.empty() || named_.atoms.size() > kMostNamed) return false;
    named_.of_states = first_conditions(formula_.states.size());
    for (u32 step = 0; step < steps_.size(); ++step) {
      std::uint64_t& happens = named_.happens.emplace_back(0);
      for (std::size_t k = 0; k < formula_.steps.size(); ++k) {
        if (is_step_of(step, formula_.steps[k])) happens |= std::uint64_t{1} << (formula_.states.size() + k);
      }
    }
    return std::all_of(named_.atoms.begin(), named_.atoms.end(),
                       [&](u32 atom) { return steps_.space(atom, options_.cancellation) != nullptr; });
  }
  [[nodiscard]] bool is_named(u32 atom) const {
    return std::binary_search(named_.atoms.begin(), named_.atoms.end(), atom);
  }
  [[nodiscard]] bool is_step_of(u32 step, const StepCondition& condition) const {
    if (!condition.is_port) return steps_.is_connector(step) && step == condition.owner;
    const std::vector<u32>& members = steps_.atoms_of(step);
    return std::binary_search(members.begin(), members.end(), condition.owner) &&
           steps_.port_of(step, condition.owner) == condition.port;
  }
  void see(const std::vector<u32>& states) {
    const auto [at, is_new] = named_.seen.try_emplace(states);
    if (!is_new) return;
    std::map<u32, u32> state_of;
    for (std::size_t k = 0; k < states.size(); ++k) state_of[named_.atoms[k]] = states[k];
    for (std::size_t k = 0; k < formula_.states.size(); ++k) {
      const PropertyRanges ranges(formula_.states[k], [this](u32 atom) -> const LocalSpace& {
        return *steps_.space(atom, options_.cancellation);
      });
      const std::uint64_t bit = std::uint64_t{1} << k;
      if (ranges.may_be(true, state_of)) at->second.may_hold |= bit;
      if (ranges.may_be(false, state_of)) at->second.may_fail |= bit;
    }
  }

  // What the automaton and the named components reach, everything else being free.
  bool find_nodes(const Neighbourhood& nobody) {
    std::set<CaseNode> reached;
    std::vector<CaseNode> todo;
    const auto reach = [&](CaseNode node) {
      see(node.states);
      if (reached.insert(node).second) todo.push_back(std::move(node));
    };
    std::vector<std::vector<u32>> first(1);
    for (const u32 atom : named_.atoms) {
      std::vector<std::vector<u32>> more;
      for (const u32 state : steps_.initial(atom)) {
        for (const std::vector<u32>& before : first) {
          more.push_back(before);
          more.back().push_back(state);
        }
      }
      first = std::move(more);
    }
    for (const std::vector<u32>& states : first) reach({0, states});
    while (!todo.empty()) {
      if (reached.size() > kMostNodesOfCases || options_.cancellation.is_over()) return false;
      const CaseNode node = std::move(todo.back());
      todo.pop_back();
      for_each_automaton_edge(named_, node, kOtherStep, [&](u32 to, u32) { reach({to, node.states}); });
      for (const FollowedStep& step : nobody.steps()) {
        for_each_move(steps_, nobody, step, node.states, 0, [&](const std::vector<u32>& states, u32) {
          for_each_automaton_edge(named_, node, step.step, [&](u32 to, u32) { reach({to, states}); });
        });
      }
    }
    nodes_.assign(reached.begin(), reached.end());
    return true;
  }

  // ---- cases

  // Components beside the named ones: none, one, or two that take part in a step together. Small ones first.
  void find_candidates() {
    std::vector<u32> others;
    for (u32 atom = 0; atom < system_.atoms.size(); ++atom) {
      if (!is_named(atom) && steps_.space(atom, options_.cancellation) != nullptr) others.push_back(atom);
    }
    std::stable_sort(others.begin(), others.end(), [&](u32 a, u32 b) {
      return steps_.space(a, options_.cancellation)->size() < steps_.space(b, options_.cancellation)->size();
    });
    candidates_.emplace_back();
    for (const u32 atom : others) candidates_.push_back({atom});
    singles_ = candidates_.size();
    if (named_.atoms.size() + 2 > NeighbourhoodSteps::kMostMembers) return;
    std::vector<std::uint8_t> is_other(system_.atoms.size(), 0);
    for (const u32 atom : others) is_other[atom] = 1;
    std::set<std::vector<u32>> pairs;
    for (u32 step = 0; step < steps_.size(); ++step) {
      const std::vector<u32>& members = steps_.atoms_of(step);
      for (std::size_t a = 0; a < members.size(); ++a) {
        for (std::size_t b = a + 1; b < members.size(); ++b) {
          if (is_other[members[a]] != 0 && is_other[members[b]] != 0) pairs.insert({members[a], members[b]});
        }
      }
    }
    candidates_.insert(candidates_.end(), pairs.begin(), pairs.end());
  }

  bool is_refuted(std::vector<CaseNode> nodes) {
    std::vector<std::uint8_t> is_finite(steps_.size(), 0);
    std::size_t count = 0;  // of finite steps
    // By candidate: how much was known when it was last tried.
    std::vector<std::size_t> tried(candidates_.size(), 0);
    std::size_t known = 1;
    for (std::size_t row = 0; row < candidates_.size();) {
      if (options_.cancellation.is_over()) return false;
      if (tried[row] == known) {
        ++row;
        continue;
      }
      tried[row] = known;
      const Neighbourhood& around = neighbourhood(row);
      if (!around.is_complete()) continue;
      std::size_t finite_inside = 0;
      for (const FollowedStep& step : around.steps()) finite_inside += is_finite[step.step];
      const bool are_others_finite = count - finite_inside == steps_.size() - around.steps().size();
      NeighbourhoodGraph graph(steps_, named_, nodes, around, is_finite, !(are_others_finite && never_ends()));
      if (!graph.build(options_.cancellation)) continue;
      const NeighbourhoodGraph::Repeated repeated = graph.find_repeated(options_.fairness);
      proof_.neighbours = std::max(proof_.neighbours, static_cast<u32>(candidates_[row].size()));
      if (repeated.is_empty()) return true;
      bool has_more = false;
      for (const FollowedStep& step : around.steps()) {
        if (is_finite[step.step] != 0 || repeated.steps[step.step] != 0) continue;
        is_finite[step.step] = 1;
        ++count;
        has_more = true;
      }
      std::vector<CaseNode> left;
      for (const std::vector<CaseNode>& part : repeated.parts) left.insert(left.end(), part.begin(), part.end());
      std::sort(left.begin(), left.end());
      left.erase(std::unique(left.begin(), left.end()), left.end());
      has_more = has_more || left.size() < nodes.size();
      nodes = std::move(left);
      if (has_more) ++known;
      // Pairs only while single ones have nothing to add.
      row = has_more && row >= singles_ ? 0 : row + 1;
      if (row == singles_ && tried[0] != known) row = 0;
    }
    BIP_LOG(Ic3, 1, "a case of {} nodes stays open: {} of {} steps are finite", nodes.size(), count, steps_.size());
    return false;
  }
  const Neighbourhood& neighbourhood(std::size_t candidate) {
    std::unique_ptr<Neighbourhood>& made = neighbourhoods_[candidate];
    if (!made)
      made = std::make_unique<Neighbourhood>(steps_, named_.atoms, candidates_[candidate], options_.cancellation);
    return *made;
  }
  bool never_ends() {
    if (!never_ends_) never_ends_ = options_.never_ends && options_.never_ends();
    proof_.needs_endless_runs = proof_.needs_endless_runs || *never_ends_;
    return *never_ends_;
  }

  const Formula& formula_;
  const System& system_;
  const NeighbourhoodOptions& options_;
  NeighbourhoodSteps steps_;
  NamedPart named_;
  std::vector<CaseNode> nodes_;
  std::vector<std::vector<u32>> candidates_;
  std::size_t singles_ = 0;  // of the candidates, with none
  // By candidate, made when it is first tried.
  std::vector<std::unique_ptr<Neighbourhood>> neighbourhoods_;
  std::optional<bool> never_ends_;
  NeighbourhoodProof proof_;
};

}  // namespace

bool has_neighbourhoods(const System& system, const rt::Image& image) {
  return image.ffi == nullptr && !rt::has_time(image) && is_plain_rendezvous(system);
}

NeighbourhoodProof prove_by_neighbourhoods(const Formula& formula, const System& system, const rt::Image& image,
                                           const NeighbourhoodOptions& options) {
  return NeighbourhoodProver(formula, system, image, options).run();
}

}  // namespace bip::verify
