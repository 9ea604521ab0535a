// See intervals.hpp.
#include "compiler/verify/invariants/intervals.hpp"

#include <algorithm>
#include <functional>
#include <set>

#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

using u32 = std::uint32_t;
constexpr int kGrowthsBeforeWidening = 4;
constexpr int kMaxWidenings = 16;

class IntervalAnalysis {
 public:
  IntervalAnalysis(const System& system, const rt::Image& image, const std::vector<std::uint8_t>& is_free)
      : system_(system), image_(image), is_free_(is_free), code_(system.code) {
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

  IntervalPoint of_atom(std::size_t a) const {
    const u32 base = image_.atoms[a].first_cell;
    const std::size_t count = system_.atom_types[system_.atoms[AtomId(a)].type].variables.size();
    return {{ranges_.begin() + base, ranges_.begin() + base + static_cast<std::ptrdiff_t>(count)}, {}};
  }
  void give_back(std::size_t a, const IntervalPoint& local) {
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
    IntervalPoint local = of_atom(a);
    code_.execute(type.initial_action, local);
    // Data are read only after the initial action.
    for (std::size_t k = 0; k < local.self.size(); ++k) {
      if (!local.self[k].is_empty()) ranges_[base + k] = fitted(local.self[k]);
      if (!is_free_.empty() && is_free_[base + k] != 0)
        ranges_[base + k] = type.variables[k].type == Type::Bool ? kAnyBool : kAnyInt;
    }
  }

  void atom(std::size_t a) {
    const AtomType& type = system_.atom_types[system_.atoms[AtomId(a)].type];
    for (const Transition& t : type.transitions) {
      IntervalPoint local = of_atom(a);
      IntervalPoint before = local;
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
    IntervalPoint start;
    start.self.assign(ranges_.begin() + base,
                      ranges_.begin() + base + static_cast<std::ptrdiff_t>(type.variables.size()));
    for (const std::vector<u32>& sources : rows) {
      Range all{1, 0};
      for (u32 row : sources) all = joined(all, ranges_[row]);
      start.bind.push_back(all);
    }
    for (const Clause& clause : type.clauses) {
      IntervalPoint local = start;
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
  const std::vector<std::uint8_t>& is_free_;
  IntervalDomain code_;
  std::vector<Range> ranges_;
  std::vector<int> growths_;
  std::set<std::int64_t> thresholds_;
  bool changed_ = true;
};

}  // namespace

std::vector<Range> find_ranges(const System& system, const rt::Image& image, const std::vector<std::uint8_t>& is_free) {
  return IntervalAnalysis(system, image, is_free).run();
}

}  // namespace bip::verify
