// See linear.hpp.
#include "compiler/verify/linear.hpp"

#include <algorithm>
#include <map>
#include <numeric>

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

std::int64_t LinearFinder::factor_of(const Row& row, u32 port) {
  const auto found = std::lower_bound(row.begin(), row.end(), port, [](const Term& t, u32 p) { return t.port < p; });
  return found != row.end() && found->port == port ? found->factor : 0;
}

LinearFinder::Row LinearFinder::combined(const Row& a, std::int64_t factor_a, const Row& b, std::int64_t factor_b) {
  Row sum;
  std::int64_t divisor = 0;
  std::vector<std::int64_t> factors;
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    const u32 port = std::min(i < a.size() ? a[i].port : kNoRow, j < b.size() ? b[j].port : kNoRow);
    std::int64_t factor = 0;
    if (i < a.size() && a[i].port == port) factor += a[i++].factor * factor_a;
    if (j < b.size() && b[j].port == port) factor += b[j++].factor * factor_b;
    if (factor == 0) continue;
    sum.push_back({port, 0});
    factors.push_back(factor);
    for (std::int64_t x = factor < 0 ? -factor : factor; x != 0;) divisor = std::exchange(x, divisor % x);
  }
  work_ += a.size() + b.size();
  for (std::size_t k = 0; k < sum.size(); ++k) {
    const std::int64_t factor = factors[k] / divisor;
    if (factor > kMaxNumber || factor < -kMaxNumber) is_given_up_ = true;
    else sum[k].factor = factor;
  }
  return sum;
}

// `by` gives the port: it goes out of the row.
void LinearFinder::eliminate(Row& row, u32 port, const Row& by) {
  const std::int64_t here = factor_of(row, port), there = factor_of(by, port);
  if (here == 0) return;
  const std::int64_t common = std::gcd(here, there);
  row = combined(row, there / common, by, -(here / common));
}

void LinearFinder::add_equation(Row row) {
  for (bool changed = true; changed && !is_given_up_;) {
    changed = false;
    for (const Term& term : row) {
      if (row_of_[term.port] == kNoRow) continue;
      const u32 port = term.port;
      eliminate(row, port, rows_[row_of_[port]]);
      changed = true;
      break;
    }
  }
  if (row.empty() || is_given_up_) return;
  // What it gives: a port that stands in few other rows, best without a fraction.
  const auto cost = [&](const Term& t) { return std::pair(t.factor != 1 && t.factor != -1, rows_with_[t.port].size()); };
  const u32 given = std::min_element(row.begin(), row.end(), [&](const Term& a, const Term& b) { return cost(a) < cost(b); })->port;
  const std::vector<u32> others = std::move(rows_with_[given]);
  rows_with_[given].clear();
  const u32 number = static_cast<u32>(rows_.size());
  for (u32 other : others) {
    eliminate(rows_[other], given, row);
    for (const Term& term : row) {
      std::vector<u32>& with = rows_with_[term.port];
      if (term.port != given && std::find(with.begin(), with.end(), other) == with.end()) with.push_back(other);
      work_ += with.size();
    }
    if (work_ > kMaxWork) is_given_up_ = true;
    if (is_given_up_) return;
  }
  for (const Term& term : row) {
    if (term.port != given) rows_with_[term.port].push_back(number);
  }
  row_of_[given] = number;
  rows_.push_back(std::move(row));
  if (work_ > kMaxWork) is_given_up_ = true;
}

// Ways from initial modes to all others; each move beside them closes a way round.
void LinearFinder::walk_atom(u32 atom, std::vector<Row>& equations) {
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
      std::vector<std::pair<u32, std::int64_t>> terms{{port, 1}};
      for (u32 p : way_to(from)) terms.emplace_back(p, 1);
      for (u32 p : way_to(to)) terms.emplace_back(p, -1);
      std::sort(terms.begin(), terms.end());
      Row row;
      for (const auto& [p, factor] : terms) {
        if (!row.empty() && row.back().port == p) row.back().factor += factor;
        else row.push_back({p, factor});
        if (row.back().factor == 0) row.pop_back();
      }
      work_ += terms.size();
      if (!row.empty()) equations.push_back(std::move(row));
      if (work_ > kMaxWork) {
        is_given_up_ = true;
        return;
      }
    }
  }
}

// What a choice below a node changes, as a sum over ports. All choices must agree, and steps change nothing.
void LinearFinder::add_nodes(std::vector<Row>& equations) {
  std::vector<Row> change(net_.nodes.size());
  std::vector<std::uint8_t> is_dead(net_.nodes.size(), 0);
  for (u32 row = 0; row < net_.nodes.size() && !is_given_up_; ++row) {
    const Node& node = net_.nodes[row];
    if (node.kind == NodeKind::Port) {
      const u32 base = net_.mode_base[net_.atom_of_port[row]];
      const auto moves = net_.moves(row);
      is_dead[row] = !reachable_.in_context(row) ||
                     std::none_of(moves.begin(), moves.end(), [&](const Move& move) { return reachable_.is_on(base + move.from); });
      change[row] = {{row, 1}};
    } else {
      std::vector<u32> live;
      for (const Edge& child : net_.children(row)) {
        if (is_dead[child.node] == 0) live.push_back(child.node);
        else if (node.kind == NodeKind::All) is_dead[row] = 1;
      }
      if (live.empty()) is_dead[row] = 1;
      if (is_dead[row] != 0) continue;
      if (node.kind == NodeKind::All) {
        for (u32 child : live) change[row] = combined(change[row], 1, change[child], 1);
      } else if (node.kind == NodeKind::Trigger && live.size() > 1) {
        for (u32 child : live) equations.push_back(change[child]);
      } else {
        change[row] = change[live[0]];
        for (std::size_t k = 1; k < live.size(); ++k) equations.push_back(combined(change[live[k]], 1, change[live[0]], -1));
      }
    }
    if (node.is_root && is_dead[row] == 0) equations.push_back(change[row]);
    if (work_ > kMaxWork) is_given_up_ = true;
  }
}

void LinearFinder::solve() {
  is_solved_ = true;
  const u32 ports = net_.port_count();
  parent_mode_.assign(net_.mode_count(), kNoRow);
  parent_port_.assign(net_.mode_count(), kNoRow);
  row_of_.assign(ports, kNoRow);
  rows_with_.resize(ports);
  is_used_.assign(ports, 0);
  change_.assign(ports, 0);
  std::vector<Row> equations;
  for (u32 atom = 0; atom + 1 < net_.mode_base.size() && !is_given_up_; ++atom) walk_atom(atom, equations);
  if (!is_given_up_) add_nodes(equations);
  // Short ones first: they fill least.
  std::stable_sort(equations.begin(), equations.end(), [](const Row& a, const Row& b) { return a.size() < b.size(); });
  for (Row& row : equations) {
    if (is_given_up_) return;
    if (!row.empty()) add_equation(std::move(row));
  }
}

namespace {
std::int64_t most_frequent(const std::vector<std::pair<u32, std::int64_t>>& weights) {
  std::map<std::int64_t, std::size_t> times;
  for (const auto& [mode, weight] : weights) ++times[weight];
  const auto best = std::max_element(times.begin(), times.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == times.end() ? 0 : best->first;
}
}  // namespace

// The free port changes the sum, other free ones do not. False: numbers or support are too large, or it is none after all.
bool LinearFinder::solution(u32 free, TokenInvariant& invariant) {
  std::vector<u32> ports{free};
  std::int64_t scale = 1;
  std::vector<std::pair<u32, u32>> given;  // port, row
  for (u32 row : rows_with_[free]) {
    if (factor_of(rows_[row], free) == 0) continue;
    for (const Term& term : rows_[row]) {
      if (row_of_[term.port] != row) continue;
      given.emplace_back(term.port, row);
      scale = std::lcm(scale, std::abs(term.factor));
    }
    if (scale > kMaxNumber) return false;
  }
  change_[free] = scale;
  for (const auto& [port, row] : given) {
    change_[port] = -scale / factor_of(rows_[row], port) * factor_of(rows_[row], free);
    ports.push_back(port);
  }
  std::vector<u32> atoms;
  for (u32 port : ports) atoms.push_back(net_.atom_of_port[port]);
  std::sort(atoms.begin(), atoms.end());
  atoms.erase(std::unique(atoms.begin(), atoms.end()), atoms.end());
  invariant = {InvariantKind::Sum, {}, {}, 0};
  bool is_small = atoms.size() <= kMaxAtoms;
  // Of the two signs the one with the smaller total: no weight is negative, each atom's may be moved, its modes being one at a time.
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
      is_small = is_small && most - least <= kMaxNumber;
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
  for (u32 port : ports) change_[port] = 0;
  if (!is_small || invariant.total > kMaxNumber) return false;
  std::int64_t common = invariant.total;
  for (std::int64_t weight : invariant.weights) common = std::gcd(common, weight);
  if (common == 0) return false;
  invariant.total /= common;
  for (std::int64_t& weight : invariant.weights) weight /= common;
  return true;
}

std::vector<TokenInvariant> LinearFinder::find_small(TrapFinder& checker) {
  if (!is_solved_) solve();
  std::vector<TokenInvariant> found;
  for (u32 port = 0; port < net_.port_count() && !is_given_up_; ++port) {
    if (row_of_[port] != kNoRow || rows_with_[port].empty() || rows_with_[port].size() > kFewPorts) continue;
    TokenInvariant invariant;
    if (!solution(port, invariant) || !checker.keeps_sum(invariant)) continue;
    is_used_[port] = 1;
    found.push_back(std::move(invariant));
  }
  return found;
}

std::vector<TokenInvariant> LinearFinder::find(TrapFinder& checker, const std::vector<std::uint8_t>& marked) {
  if (!is_solved_) solve();
  satisfies_all_ = false;
  std::vector<TokenInvariant> found;
  if (is_given_up_) return found;
  // How far the candidate's sum is from the initial one's, as a sum over the unknowns; then over the free ones alone.
  std::vector<std::uint64_t> sum(net_.port_count(), 0);
  for (u32 mode = 0; mode < net_.mode_count(); ++mode) {
    if (marked[mode] == 0) continue;
    for (u32 m = mode; parent_mode_[m] != kNoRow; m = parent_mode_[m]) ++sum[parent_port_[m]];
  }
  for (u32 port = 0; port < sum.size(); ++port) {
    if (row_of_[port] == kNoRow || sum[port] == 0) continue;
    std::uint64_t own = 0;
    for (const Term& term : rows_[row_of_[port]]) own = term.port == port ? residue(term.factor) : own;
    const std::uint64_t times = product(sum[port], inverse(own));
    sum[port] = 0;
    for (const Term& term : rows_[row_of_[port]]) {
      if (term.port != port) sum[term.port] = (sum[term.port] + kPrime - product(times, residue(term.factor))) % kPrime;
    }
  }
  satisfies_all_ = true;
  for (u32 port = 0; port < sum.size(); ++port) {
    if (sum[port] == 0) continue;
    satisfies_all_ = false;
    TokenInvariant invariant;
    if (is_used_[port] == 0 && solution(port, invariant) && checker.keeps_sum(invariant)) found.push_back(std::move(invariant));
    is_used_[port] = 1;
  }
  return found;
}

}  // namespace bip::verify
