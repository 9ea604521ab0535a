// See intervals.hpp.
#include "compiler/verify/invariants/intervals.hpp"

#include "compiler/model/abstract_interpreter.hpp"

#include <algorithm>
#include <functional>
#include <set>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using u32 = std::uint32_t;
constexpr Range kBool{0, 1};
constexpr int kGrowthsBeforeWidening = 4;
constexpr int kMaxWidenings = 16;

Range joined(const Range& a, const Range& b) {
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  return {std::min(a.low, b.low), std::max(a.high, b.high)};
}
Range common(const Range& a, const Range& b) { return {std::max(a.low, b.low), std::min(a.high, b.high)}; }
Range fitted(const Range& r) { return r.low < kAnyInt.low || r.high > kAnyInt.high ? kAnyInt : r; }
Range of(bool may_be_false, bool may_be_true) { return {may_be_false ? 0 : 1, may_be_true ? 1 : 0}; }

// The abstract state of a piece of code: copies of its variables' ranges, which guards refine.
struct Local {
  std::vector<Range> self, bind;
};

/// The domain of intervals.
class IntervalDomain : public AbstractInterpreter<IntervalDomain, Range, Local> {
 public:
  using AbstractInterpreter::AbstractInterpreter;

  Range constant(const Expr& e) { return e.op == Op::ConstFloat ? kAnyInt : Range{e.int_value, e.int_value}; }
  Range load(const Expr& e, Local& local) {
    const std::vector<Range>& ranges = e.op == Op::LoadSelf ? local.self : local.bind;
    return e.index < ranges.size() ? ranges[e.index] : whole(e.type);
  }
  Range call(const Expr& e, Local& local) {
    pass_arguments(e, local);
    return whole(e.type);
  }
  void forget(const Expr& load, Local& local) {
    (load.op == Op::LoadSelf ? local.self : local.bind)[load.index] = kAnyInt;
  }
  Range unary(const Expr& e, const Range& a, Local&) {
    if (e.type == Type::Float || a.is_empty()) return whole(e.type);
    switch (e.op) {
      case Op::Neg: return fitted({-a.high, -a.low});
      case Op::BitNot: return {-1 - a.high, -1 - a.low};
      case Op::Not:
        return {1 - a.high, 1 - a.low};
        BIP_LEAF_OPS(BIP_OP_CASE)
        BIP_CONVERSION_OPS(BIP_OP_CASE)
        BIP_BINARY_OPS(BIP_OP_CASE)
        break;
    }
    return whole(e.type);
  }
  Range binary(const Expr& e, const Range& a, const Range& b, Local&) {
    if (!is_int(e) || a.is_empty() || b.is_empty()) return whole(e.type);
    return apply(e.op, a, b);
  }
  // Whether the second operand is evaluated makes no difference to the ranges.
  Range logic(const Expr& e, Local& local) {
    const Range a = evaluate(e.a, local), b = evaluate(e.b, local);
    return binary(e, a, b, local);
  }

  // Refines the variables to the states in which the condition is `truth`; false: there is none.
  bool assume(ExprId id, bool truth, Local& local) {
    if (!id.is_valid()) return truth;
    const Expr& e = code_.exprs[id];
    if (e.op == Op::Not) return assume(e.a, !truth, local);
    if ((e.op == Op::And && truth) || (e.op == Op::Or && !truth))
      return assume(e.a, truth, local) && assume(e.b, truth, local);
    if (e.op == Op::And || e.op == Op::Or) {
      Local other = local;
      const bool first = assume(e.a, truth, local);
      const bool second = assume(e.b, truth, other);
      if (!first) local = std::move(other);
      else if (second) join(local, other);
      return first || second;
    }
    if (is_load(e.op)) return narrow(id, {truth ? 1 : 0, truth ? 1 : 0}, local);
    if (is_comparison(e.op)) return !is_int(e) || compare(truth ? e.op : negation_of(e.op), e.a, e.b, local);
    const Range r = evaluate(id, local);
    return r.is_empty() || common(r, of(!truth, truth)).low <= common(r, of(!truth, truth)).high;
  }

  bool goes_on(const Local&) { return true; }
  void store(const Stmt& s, Local& local) {
    const Range value = evaluate(s.value, local);
    (s.op == StmtOp::StoreSelf ? local.self : local.bind)[s.index] = value;
  }
  void branch(const Stmt& s, Local& local) {
    Local other = local;
    (void)evaluate(s.value, local);
    const bool yes = assume(s.value, true, local);
    const bool no = assume(s.value, false, other);
    if (yes) execute(s.then_body, local);
    if (no) execute(s.else_body, other);
    if (!yes) local = std::move(other);
    else if (no) join(local, other);
  }
  void run_call(const Stmt& s, Local& local) { (void)evaluate(s.value, local); }

 private:
  static void join(Local& to, const Local& from) {
    for (std::size_t k = 0; k < to.self.size(); ++k) to.self[k] = joined(to.self[k], from.self[k]);
    for (std::size_t k = 0; k < to.bind.size(); ++k) to.bind[k] = joined(to.bind[k], from.bind[k]);
  }
  static Range whole(Type type) { return type == Type::Bool ? kBool : kAnyInt; }
  // The operands are ints, bools or rows of strings.
  bool is_int(const Expr& e) const {
    const Type operands = code_.exprs[e.a].type;
    return operands != Type::Float && !is_ffi(operands);
  }
  bool narrow(ExprId id, const Range& to, Local& local) {
    const Expr& e = code_.exprs[id];
    if (!is_load(e.op)) return true;
    std::vector<Range>& all = e.op == Op::LoadSelf ? local.self : local.bind;
    if (e.index >= all.size() || all[e.index].is_empty()) return true;
    all[e.index] = common(all[e.index], to);
    return !all[e.index].is_empty();
  }
  bool compare(Op op, ExprId left, ExprId right, Local& local) {
    const Range a = evaluate(left, local), b = evaluate(right, local);
    if (a.is_empty() || b.is_empty()) return true;
    constexpr std::int64_t kFar = std::int64_t{1} << 40;
    switch (op) {
      case Op::Eq: return narrow(left, b, local) && narrow(right, a, local) && !common(a, b).is_empty();
      case Op::Lt:
        return a.low < b.high && narrow(left, {-kFar, b.high - 1}, local) && narrow(right, {a.low + 1, kFar}, local);
      case Op::Le:
        return a.low <= b.high && narrow(left, {-kFar, b.high}, local) && narrow(right, {a.low, kFar}, local);
      case Op::Gt:
        return b.low < a.high && narrow(left, {b.low + 1, kFar}, local) && narrow(right, {-kFar, a.high - 1}, local);
      case Op::Ge:
        return b.low <= a.high && narrow(left, {b.low, kFar}, local) && narrow(right, {-kFar, a.high}, local);
      case Op::Ne:
        break;
        BIP_NO_COMPARISON_OPS(BIP_OP_CASE)
        BIP_UNREACHABLE("not a comparison");
    }
    // !=: only an end can be cut off.
    const auto without = [](const Range& r, const Range& x) {
      if (x.low != x.high) return r;
      return Range{r.low == x.low ? r.low + 1 : r.low, r.high == x.low ? r.high - 1 : r.high};
    };
    return narrow(left, without(a, b), local) && narrow(right, without(b, a), local) && !(a == b && a.low == a.high);
  }

  static Range apply(Op op, const Range& a, const Range& b) {
    switch (op) {
      case Op::Add: return fitted({a.low + b.low, a.high + b.high});
      case Op::Sub: return fitted({a.low - b.high, a.high - b.low});
      case Op::Mul: {
        const auto [low, high] = std::minmax({a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high});
        return fitted({low, high});
      }
      case Op::Div: {
        // The quotient is nearest to zero for the largest divisor, farthest for one near zero.
        const std::int64_t most = std::max(std::abs(a.low), std::abs(a.high));
        const std::int64_t least = b.low > 0 ? b.low : b.high < 0 ? -b.high : 1;
        const bool same_sign = a.low >= 0 && b.low >= 0;
        return fitted({same_sign ? 0 : -(most / least), most / least});
      }
      case Op::Mod: {
        const std::int64_t most =
            std::min(std::max(std::abs(b.low), std::abs(b.high)) - 1, std::max(std::abs(a.low), std::abs(a.high)));
        return fitted(
            {a.low >= 0 ? 0 : -std::max<std::int64_t>(most, 0), a.high <= 0 ? 0 : std::max<std::int64_t>(most, 0)});
      }
      case Op::BitAnd:
        if (a.low >= 0 || b.low >= 0) return {0, a.low < 0 ? b.high : b.low < 0 ? a.high : std::min(a.high, b.high)};
        return kAnyInt;
      case Op::BitOr:
      case Op::BitXor: {
        if (a.low < 0 || b.low < 0) return kAnyInt;
        std::int64_t mask = 1;
        while (mask <= std::max(a.high, b.high)) mask *= 2;
        return {0, mask - 1};
      }
      case Op::And: return {std::min(a.low, b.low), std::min(a.high, b.high)};
      case Op::Or: return {std::max(a.low, b.low), std::max(a.high, b.high)};
      case Op::Eq: return of(a.low != a.high || a != b, !common(a, b).is_empty());
      case Op::Ne: return of(!common(a, b).is_empty(), a.low != a.high || a != b);
      case Op::Lt: return of(a.high >= b.low, a.low < b.high);
      case Op::Le: return of(a.high > b.low, a.low <= b.high);
      case Op::Gt: return of(b.high >= a.low, b.low < a.high);
      case Op::Ge:
        return of(b.high > a.low, b.low <= a.high);
        BIP_LEAF_OPS(BIP_OP_CASE)
        BIP_UNARY_OPS(BIP_OP_CASE)
        break;
    }
    BIP_UNREACHABLE("not an operator of two ints");
  }
};

class IntervalAnalysis {
 public:
  IntervalAnalysis(const System& system, const rt::Image& image) : system_(system), image_(image), code_(system.code) {
    ranges_.assign(image.cell_count, {0, 0});
    growths_.assign(image.cell_count, 0);
    for (const Expr& e : system.code.exprs) {
      if (e.op != Op::ConstInt) continue;
      for (std::int64_t k = -1; k <= 1; ++k) thresholds_.insert(std::int64_t{e.int_value} + k);
    }
  }

  std::vector<Range> run() {
    for (std::size_t a = 0; a < system_.atoms.size(); ++a) start(a);
    while (changed_) {
      changed_ = false;
      for (std::size_t a = 0; a < system_.atoms.size(); ++a) atom(a);
      for (std::size_t c = 0; c < system_.connectors.size(); ++c) connector(c);
    }
    return std::move(ranges_);
  }

 private:
  // Joins a range into a variable; widens it if it has grown often.
  void grow(u32 row, Range to) {
    if (to.is_empty()) return;
    Range& range = ranges_[row];
    const Range next = joined(range, fitted(to));
    if (next == range) return;
    changed_ = true;
    const int times = ++growths_[row];
    const Range before = range;
    range = next;
    if (times <= kGrowthsBeforeWidening) return;
    // Widening: the next threshold, then the end of int.
    if (next.low < before.low) {
      const auto above = thresholds_.upper_bound(next.low);
      range.low = times > kMaxWidenings || above == thresholds_.begin() ? kAnyInt.low : *std::prev(above);
    }
    if (next.high > before.high) {
      const auto next_threshold = thresholds_.lower_bound(next.high);
      range.high = times > kMaxWidenings || next_threshold == thresholds_.end() ? kAnyInt.high : *next_threshold;
    }
    range = fitted(range);
    BIP_ASSERT(range.low <= before.low && range.high >= before.high, "the range of variable {} shrinks", row);
  }

  Local of_atom(std::size_t a) const {
    const u32 base = image_.atoms[a].first_cell;
    const std::size_t count = system_.atom_types[system_.atoms[AtomId(a)].type].variables.size();
    return {{ranges_.begin() + base, ranges_.begin() + base + static_cast<std::ptrdiff_t>(count)}, {}};
  }
  void give_back(std::size_t a, const Local& local) {
    for (std::size_t k = 0; k < local.self.size(); ++k)
      grow(image_.atoms[a].first_cell + static_cast<u32>(k), local.self[k]);
  }

  void start(std::size_t a) {
    const Atom& atom = system_.atoms[AtomId(a)];
    const AtomType& type = system_.atom_types[atom.type];
    const u32 base = image_.atoms[a].first_cell;
    for (std::size_t k = 0; k < type.variables.size() && k < atom.args.size(); ++k) {
      const Value& value = atom.args[k];
      ranges_[base + k] = {value.int_value, value.int_value};
      for (std::int64_t d = -1; d <= 1; ++d) thresholds_.insert(std::int64_t{value.int_value} + d);
    }
    Local local = of_atom(a);
    code_.execute(type.initial_action, local);
    // Data are read only after the initial action.
    for (std::size_t k = 0; k < local.self.size(); ++k) {
      if (!local.self[k].is_empty()) ranges_[base + k] = fitted(local.self[k]);
    }
  }

  void atom(std::size_t a) {
    const AtomType& type = system_.atom_types[system_.atoms[AtomId(a)].type];
    for (const Transition& t : type.transitions) {
      Local local = of_atom(a);
      Local before = local;
      if (t.guard.is_valid()) (void)code_.evaluate(t.guard, local);
      if (!code_.assume(t.guard, true, local) && t.guard.is_valid()) continue;
      // What a transfer writes comes after the guard: it may be anything that the variable ever is.
      if (t.port != Transition::kInternal) {
        for (u32 variable : type.ports[t.port].variables) local.self[variable] = before.self[variable];
      }
      code_.execute(t.action, local);
      give_back(a, local);
    }
  }

  // Collects the rows that a variable of a binding may refer to.
  void rows_of(const PortRef& ref, std::size_t variable, std::vector<u32>& rows) const {
    if (ref.kind == PortRef::Kind::Choice) {
      for (const PortRef& port : system_.choices[ref.choice].ports) rows_of(port, variable, rows);
    } else if (ref.kind == PortRef::Kind::Connector) {
      const Connector& below = system_.connectors[ref.connector];
      rows.push_back(image_.connectors[ref.connector.value].first_cell +
                     system_.connector_types[below.type].export_variables[variable]);
    } else {
      const Port& port = system_.atom_types[system_.atoms[ref.atom].type].ports[ref.port];
      rows.push_back(image_.atoms[ref.atom.value].first_cell + port.variables[variable]);
    }
  }

  void connector(std::size_t c) {
    const Connector& connector = system_.connectors[ConnectorId(c)];
    const ConnectorType& type = system_.connector_types[connector.type];
    if (type.clauses.empty()) return;
    const u32 base = image_.connectors[c].first_cell;
    std::vector<std::vector<u32>> rows;
    for (std::size_t p = 0; p < type.params.size(); ++p) {
      for (std::size_t v = 0; v < system_.port_types[type.params[p].type].variables.size(); ++v) {
        rows.emplace_back();
        rows_of(connector.ports[p], v, rows.back());
      }
    }
    for (const DataRef& ref : connector.data) rows.push_back({image_.atoms[ref.atom.value].first_cell + ref.variable});
    Local start;
    start.self.assign(ranges_.begin() + base,
                      ranges_.begin() + base + static_cast<std::ptrdiff_t>(type.variables.size()));
    for (const std::vector<u32>& sources : rows) {
      Range all{1, 0};
      for (u32 row : sources) all = joined(all, ranges_[row]);
      start.bind.push_back(all);
    }
    for (const Clause& clause : type.clauses) {
      Local local = start;
      if (clause.guard.is_valid()) (void)code_.evaluate(clause.guard, local);
      if (clause.guard.is_valid() && !code_.assume(clause.guard, true, local)) continue;
      code_.execute(clause.up, local);
      // A connector above may write to what is exported before `down` runs.
      for (u32 variable : type.export_variables)
        local.self[variable] = joined(local.self[variable], start.self[variable]);
      for (std::size_t k = 0; k < local.self.size(); ++k) grow(base + static_cast<u32>(k), local.self[k]);
      const auto write = [&] {
        for (std::size_t k = 0; k < rows.size(); ++k) {
          for (u32 row : rows[k]) grow(row, local.bind[k]);
        }
      };
      write();
      if (type.exports) local.bind = start.bind;
      code_.execute(clause.down, local);
      for (std::size_t k = 0; k < local.self.size(); ++k) grow(base + static_cast<u32>(k), local.self[k]);
      write();
    }
  }

  const System& system_;
  const rt::Image& image_;
  IntervalDomain code_;
  std::vector<Range> ranges_;
  std::vector<int> growths_;
  std::set<std::int64_t> thresholds_;
  bool changed_ = true;
};

}  // namespace

std::vector<Range> find_ranges(const System& system, const rt::Image& image) {
  return IntervalAnalysis(system, image).run();
}

}  // namespace bip::verify
