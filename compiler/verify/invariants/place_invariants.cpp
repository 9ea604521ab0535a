// See place_invariants.hpp.
#include "compiler/verify/invariants/place_invariants.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "compiler/verify/invariants/step_equations.hpp"

namespace bip::verify {

namespace {

// Candidates are judged modulo a prime: what is not 0 there is not 0.
constexpr std::uint64_t kPrime = (std::uint64_t{1} << 31) - 1;
// An atom with more modes has a weight 0 where most of them have the same.
constexpr u32 kLargeClass = 64;

std::uint64_t residue(std::int64_t value) {
  const std::int64_t rest = value % static_cast<std::int64_t>(kPrime);
  return static_cast<std::uint64_t>(rest < 0 ? rest + static_cast<std::int64_t>(kPrime) : rest);
}
std::uint64_t product(std::uint64_t a, std::uint64_t b) { return a * b % kPrime; }
std::uint64_t inverse(std::uint64_t value) {
  std::uint64_t result = 1;
  for (std::uint64_t exponent = kPrime - 2; exponent != 0; exponent /= 2) {
    if (exponent % 2 != 0) result = product(result, value);
    value = product(value, value);
  }
  return result;
}

}  // namespace

// Ways from initial modes to all others; each move beside them closes a way round.
void PlaceInvariantFinder::walk_atom(u32 atom, std::vector<SparseSystem::Row>& equations) {
  const u32 base = net_.mode_base[atom];
  std::vector<u32> todo;
  std::vector<std::uint8_t> is_seen(net_.mode_base[atom + 1] - base, 0);
  for (u32 mode : net_.class_at(atom).initial) {
    todo.push_back(base + mode);
    is_seen[mode] = 1;
  }
  const auto way_to = [&](u32 mode) {
    std::vector<u32> ports;
    for (; parent_mode_[mode] != kNoRow; mode = parent_mode_[mode]) ports.push_back(parent_port_[mode]);
    return ports;
  };
  for (std::size_t head = 0; head < todo.size(); ++head) {
    const u32 from = todo[head];
    for (const PortMove& move : net_.moves_out(from)) {
      const u32 port = net_.port_base[atom] + move.port, to = base + move.other;
      if (!reachable_.in_context(port)) continue;
      if (is_seen[move.other] == 0) {
        is_seen[move.other] = 1;
        parent_mode_[to] = from;
        parent_port_[to] = port;
        todo.push_back(to);
        continue;
      }
      if (parent_mode_[to] == from && parent_port_[to] == port) continue;
      std::vector<SparseSystem::Term> terms{{port, 1}};
      for (u32 p : way_to(from)) terms.push_back({p, 1});
      for (u32 p : way_to(to)) terms.push_back({p, -1});
      if (!system_.spend(terms.size())) return;
      if (SparseSystem::Row row = SparseSystem::row_of_terms(std::move(terms)); !row.empty())
        equations.push_back(std::move(row));
    }
  }
}

void PlaceInvariantFinder::solve() {
  is_solved_ = true;
  parent_mode_.assign(net_.mode_count(), kNoRow);
  parent_port_.assign(net_.mode_count(), kNoRow);
  is_used_.assign(net_.port_count(), 0);
  change_.assign(net_.port_count(), 0);
  std::vector<SparseSystem::Row> equations;
  for (u32 atom = 0; atom + 1 < net_.mode_base.size() && !system_.is_given_up(); ++atom) walk_atom(atom, equations);
  if (!system_.is_given_up()) add_step_equations(net_, reachable_, system_, equations);
  system_.solve(std::move(equations));
}

namespace {
std::int64_t most_frequent(const std::vector<std::pair<u32, std::int64_t>>& weights) {
  std::map<std::int64_t, std::size_t> times;
  for (const auto& [mode, weight] : weights) ++times[weight];
  const auto best =
      std::max_element(times.begin(), times.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == times.end() ? 0 : best->first;
}
}  // namespace

// The free port changes the sum, other free ones do not. False: numbers or support are too large, or it is none after
// all.
bool PlaceInvariantFinder::solution(u32 free, TokenInvariant& invariant) {
  const std::vector<SparseSystem::Term> changes = system_.solution(free);
  if (changes.empty()) return false;
  std::vector<u32> atoms;
  for (const SparseSystem::Term& term : changes) {
    change_[term.unknown] = term.factor;
    atoms.push_back(net_.atom_of_port[term.unknown]);
  }
  std::sort(atoms.begin(), atoms.end());
  atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
  invariant = {InvariantKind::Sum, {}, {}, 0};
  bool is_small = atoms.size() <= kMaxAtoms;
  // Of the two signs the one with the smaller total: no weight is negative, each atom's may be moved, its modes being
  // one at a time.
  std::int64_t totals[2] = {0, 0};
  for (int round = 0; round < 2 && is_small; ++round) {
    for (u32 atom : atoms) {
      std::vector<std::pair<u32, std::int64_t>> weights;
      std::int64_t least = 0, most = 0;
      const bool is_large = net_.mode_base[atom + 1] - net_.mode_base[atom] > kLargeClass;
      for (u32 mode = net_.mode_base[atom]; mode < net_.mode_base[atom + 1]; ++mode) {
        if (!reachable_.is_on(mode)) continue;
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
  std::int64_t common = invariant.total;
  for (std::int64_t weight : invariant.weights) common = std::gcd(common, weight);
  if (common == 0) return false;
  invariant.total /= common;
  for (std::int64_t& weight : invariant.weights) weight /= common;
  return true;
}

std::vector<TokenInvariant> PlaceInvariantFinder::find_small(TrapFinder& checker) {
  if (!is_solved_) solve();
  std::vector<TokenInvariant> found;
  for (u32 port = 0; port < net_.port_count() && !system_.is_given_up(); ++port) {
    if (!system_.is_free(port) || system_.uses(port) == 0 || system_.uses(port) > kFewPorts) continue;
    TokenInvariant invariant;
    if (!solution(port, invariant) || !checker.keeps_sum(invariant)) continue;
    is_used_[port] = 1;
    found.push_back(std::move(invariant));
  }
  return found;
}

std::vector<TokenInvariant> PlaceInvariantFinder::find(TrapFinder& checker, const std::vector<std::uint8_t>& marked) {
  if (!is_solved_) solve();
  satisfies_all_ = false;
  std::vector<TokenInvariant> found;
  if (system_.is_given_up()) return found;
  // How far the candidate's sum is from the initial one's, as a sum over the unknowns; then over the free ones alone.
  std::vector<std::uint64_t> sum(net_.port_count(), 0);
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
    if (marked[mode] == 0) continue;
    for (u32 m = mode; parent_mode_[m] != kNoRow; m = parent_mode_[m]) ++sum[parent_port_[m]];
  }
  for (u32 port = 0; port < sum.size(); ++port) {
    if (system_.is_free(port) || sum[port] == 0) continue;
    const SparseSystem::Row& row = system_.row_of(port);
    std::uint64_t own = 0;
    for (const SparseSystem::Term& term : row) own = term.unknown == port ? residue(term.factor) : own;
    const std::uint64_t times = product(sum[port], inverse(own));
    sum[port] = 0;
    for (const SparseSystem::Term& term : row) {
      if (term.unknown != port)
        sum[term.unknown] = (sum[term.unknown] + kPrime - product(times, residue(term.factor))) % kPrime;
    }
  }
  satisfies_all_ = true;
  for (u32 port = 0; port < sum.size(); ++port) {
    if (sum[port] == 0) continue;
    satisfies_all_ = false;
    TokenInvariant invariant;
    if (is_used_[port] == 0 && solution(port, invariant) && checker.keeps_sum(invariant))
      found.push_back(std::move(invariant));
    is_used_[port] = 1;
  }
  return found;
}

}  // namespace bip::verify
