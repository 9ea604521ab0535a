// See place_invariants.hpp.
//
// Steps. 1 to 3 solve y · C = 0 (K. Lautenbach 1987) once; 4 to 6 use the solutions for one candidate.
//   1. The unknowns are by how much each port changes the sum; cycle equations: a cycle of an atom's modes changes it
//   by
//      nothing, so that weights y exist at all.
//   2. Step equations: no interaction changes the sum, the columns of C.
//   3. Eliminate. Each free port gives one basis vector of the solutions.
//   4. The candidate M satisfies the marking equation M = M0 + C · x over the rationals exactly if y · (M - M0) = 0 for
//      all basis vectors (J. Esparza, S. Melzer 2000): compute these residuals for all of them at once.
//   5. For a residual that is not 0, turn the basis vector into weights of modes, without negative ones and without
//      common divisors.
//   6. Check the invariant again by structure.
#include "compiler/verify/invariants/place_invariants.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "compiler/base/log.hpp"
#include "compiler/verify/invariants/step_equations.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Candidates are evaluated modulo a prime: a residual that is not 0 there is not 0. One that is 0 there only costs
// precision.
constexpr std::uint64_t kPrime = (std::uint64_t{1} << 31) - 1;
// An atom with more modes has weight 0 where most of its modes have the same weight.
constexpr u32 kLargeClass = 64;

std::uint64_t residue(std::int64_t value) {
  const std::int64_t rest = value % static_cast<std::int64_t>(kPrime);
  return static_cast<std::uint64_t>(rest < 0 ? rest + static_cast<std::int64_t>(kPrime) : rest);
}
std::uint64_t product(std::uint64_t a, std::uint64_t b) { return a * b % kPrime; }
// By Fermat's little theorem.
std::uint64_t inverse(std::uint64_t value) {
  std::uint64_t result = 1;
  for (std::uint64_t exponent = kPrime - 2; exponent != 0; exponent /= 2) {
    if (exponent % 2 != 0) result = product(result, value);
    value = product(value, value);
  }
  return result;
}

std::int64_t most_frequent(const std::vector<std::pair<u32, std::int64_t>>& weights) {
  std::map<std::int64_t, std::size_t> counts;
  for (const auto& [mode, weight] : weights) ++counts[weight];
  const auto best =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == counts.end() ? 0 : best->first;
}

}  // namespace

std::vector<u32> PlaceInvariantFinder::path_to(u32 mode) const {
  std::vector<u32> ports;
  for (; parent_mode_[mode] != kNoRow; mode = parent_mode_[mode]) ports.push_back(parent_port_[mode]);
  return ports;
}

// Step 1. A spanning forest of the atom's modes from the initial ones; each move beside it closes a cycle, which
// changes the sum by nothing.
void PlaceInvariantFinder::add_cycle_equations(u32 atom, std::vector<SparseSystem::Row>& equations) {
  const u32 base = net_.mode_base[atom];
  std::vector<u32> queue;
  std::vector<std::uint8_t> is_visited(net_.mode_base[atom + 1] - base, 0);
  for (u32 mode : net_.class_at(atom).initial) {
    queue.push_back(base + mode);
    is_visited[mode] = 1;
  }
  for (std::size_t head = 0; head < queue.size(); ++head) {
    const u32 from = queue[head];
    for (const PortMove& move : net_.moves_out(from)) {
      const u32 port = net_.graph.port_base[atom] + move.port, to = base + move.other;
      if (!reachable_.in_context(port)) continue;
      if (is_visited[move.other] == 0) {
        is_visited[move.other] = 1;
        parent_mode_[to] = from;
        parent_port_[to] = port;
        queue.push_back(to);
        continue;
      }
      if (parent_mode_[to] == from && parent_port_[to] == port) continue;
      // path(from) + port - path(to) = 0.
      std::vector<SparseSystem::Term> terms{{port, 1}};
      for (u32 on_path : path_to(from)) terms.push_back({on_path, 1});
      for (u32 on_path : path_to(to)) terms.push_back({on_path, -1});
      if (!port_changes_.spend(terms.size())) return;
      if (SparseSystem::Row row = SparseSystem::row_of_terms(std::move(terms)); !row.empty())
        equations.push_back(std::move(row));
    }
  }
}

// Steps 1 to 3: cycle and step equations, solved once for all candidates.
void PlaceInvariantFinder::solve() {
  is_solved_ = true;
  parent_mode_.assign(net_.mode_count(), kNoRow);
  parent_port_.assign(net_.mode_count(), kNoRow);
  is_returned_.assign(net_.graph.port_count(), 0);
  change_.assign(net_.graph.port_count(), 0);
  std::vector<SparseSystem::Row> equations;
  for (u32 atom = 0; atom + 1 < net_.mode_base.size() && !port_changes_.is_given_up(); ++atom)
    add_cycle_equations(atom, equations);
  // Step 2.
  if (!port_changes_.is_given_up()) add_step_equations(net_, reachable_, port_changes_, equations);
  // Step 3.
  const std::size_t count = equations.size();
  port_changes_.solve(std::move(equations));
  BIP_LOG(Places, 1, "{} equations for {} ports{}", count, net_.graph.port_count(),
          port_changes_.is_given_up() ? ": given up" : "");
}

// Step 5. The basis vector of a free port: this port changes the sum, other free ports do not. False: numbers or
// support are too large, or all weights are 0.
bool PlaceInvariantFinder::invariant_of(u32 free_port, TokenInvariant& invariant) {
  const std::vector<SparseSystem::Term> changes = port_changes_.solution(free_port);
  if (changes.empty()) return false;
  std::vector<u32> atoms;
  for (const SparseSystem::Term& term : changes) {
    change_[term.unknown] = term.factor;
    atoms.push_back(net_.graph.atom_of_port[term.unknown]);
  }
  std::sort(atoms.begin(), atoms.end());
  atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
  invariant = {InvariantKind::Sum, {}, {}, 0};
  bool is_small = atoms.size() <= kMaxAtoms;
  // An atom is in one mode at a time, so its weights may all be moved by a constant: the least becomes 0. Of the two
  // signs of the vector the one with the smaller total: round 0 computes both totals, round 1 the weights.
  std::int64_t totals[2] = {0, 0};
  for (int round = 0; round < 2 && is_small; ++round) {
    for (u32 atom : atoms) {
      std::vector<std::pair<u32, std::int64_t>> weights;
      std::int64_t least = 0, most = 0;
      const bool is_large = net_.mode_base[atom + 1] - net_.mode_base[atom] > kLargeClass;
      for (u32 mode = net_.mode_base[atom]; mode < net_.mode_base[atom + 1]; ++mode) {
        if (!reachable_.is_on(mode)) continue;
        // A mode weighs what the path to it changes.
        std::int64_t weight = 0;
        for (u32 m = mode; parent_mode_[m] != kNoRow; m = parent_mode_[m]) weight += change_[parent_port_[m]];
        if (round == 1 && totals[1] < totals[0]) weight = -weight;
        least = std::min(least, weight);
        most = std::max(most, weight);
        weights.emplace_back(mode, weight);
      }
      is_small = is_small && most - least <= SparseSystem::kMaxNumber;
      // Of many modes only a few should have a weight, whatever its sign.
      if (is_large) least = most = most_frequent(weights);
      totals[0] -= round == 0 ? least : 0;
      totals[1] += round == 0 ? most : 0;
      if (round == 0) continue;
      invariant.total -= least;
      for (const auto& [mode, weight] : weights) {
        if (weight == least) continue;
        invariant.modes.push_back(mode);
        invariant.weights.push_back(weight - least);
      }
    }
  }
  for (const SparseSystem::Term& term : changes) change_[term.unknown] = 0;
  if (!is_small || invariant.total > SparseSystem::kMaxNumber) return false;
  // Without common divisors.
  std::int64_t common = invariant.total;
  for (std::int64_t weight : invariant.weights) common = std::gcd(common, weight);
  if (common == 0) return false;
  invariant.total /= common;
  for (std::int64_t& weight : invariant.weights) weight /= common;
  return true;
}

std::vector<TokenInvariant> PlaceInvariantFinder::find_small() {
  if (!is_solved_) solve();
  std::vector<TokenInvariant> found;
  for (u32 port = 0; port < net_.graph.port_count() && !port_changes_.is_given_up(); ++port) {
    if (!port_changes_.is_free(port) || port_changes_.uses(port) == 0 || port_changes_.uses(port) > kFewPorts) continue;
    TokenInvariant invariant;
    if (!invariant_of(port, invariant) || !checker_.holds(invariant)) continue;
    is_returned_[port] = 1;
    found.push_back(std::move(invariant));
  }
  BIP_LOG(Places, 1, "{} small place invariants", found.size());
  return found;
}

// Step 4. How far the candidate's sum is from the initial one, as a sum over all ports (those of the paths to its
// modes), with the ports that are not free replaced by the free ones. By port; not 0: the candidate breaks that port's
// invariant.
std::vector<std::uint64_t> PlaceInvariantFinder::residuals_of(const std::vector<std::uint8_t>& marked) const {
  std::vector<std::uint64_t> residuals(net_.graph.port_count(), 0);
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
    if (marked[mode] == 0) continue;
    for (u32 m = mode; parent_mode_[m] != kNoRow; m = parent_mode_[m]) ++residuals[parent_port_[m]];
  }
  for (u32 port = 0; port < residuals.size(); ++port) {
    if (port_changes_.is_free(port) || residuals[port] == 0) continue;
    const SparseSystem::Row& row = port_changes_.row_of(port);
    std::uint64_t own_factor = 0;
    for (const SparseSystem::Term& term : row) {
      if (term.unknown == port) own_factor = residue(term.factor);
    }
    BIP_ASSERT(own_factor != 0, "the row of port {} does not contain it", port);
    const std::uint64_t times = product(residuals[port], inverse(own_factor));
    residuals[port] = 0;
    for (const SparseSystem::Term& term : row) {
      if (term.unknown != port)
        residuals[term.unknown] = (residuals[term.unknown] + kPrime - product(times, residue(term.factor))) % kPrime;
    }
  }
  return residuals;
}

std::vector<TokenInvariant> PlaceInvariantFinder::find(const std::vector<std::uint8_t>& marked) {
  BIP_ASSERT(marked.size() == net_.mode_count(), "{} marks of {} modes", marked.size(), net_.mode_count());
  if (!is_solved_) solve();
  satisfies_all_ = false;
  std::vector<TokenInvariant> found;
  if (port_changes_.is_given_up()) return found;
  const std::vector<std::uint64_t> residuals = residuals_of(marked);
  satisfies_all_ = true;
  for (u32 port = 0; port < residuals.size(); ++port) {
    if (residuals[port] == 0) continue;
    BIP_ASSERT(port_changes_.is_free(port), "port {} is given by others", port);
    satisfies_all_ = false;
    TokenInvariant invariant;
    // Steps 5 and 6.
    if (is_returned_[port] == 0 && invariant_of(port, invariant) && checker_.holds(invariant)) {
      BIP_ASSERT(!is_satisfied(invariant, marked), "an invariant over {} modes holds in the candidate",
                 invariant.modes.size());
      BIP_LOG(Places, 2, "place invariant over {} modes, total {}", invariant.modes.size(), invariant.total);
      found.push_back(std::move(invariant));
    }
    is_returned_[port] = 1;
  }
  BIP_LOG(Places, 1, "{} place invariants exclude the candidate", found.size());
  return found;
}

}  // namespace bip::verify
