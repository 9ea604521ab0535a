// See time_divergence.hpp. Limits are evaluated where they are constants or made of parameters.
#include "compiler/verify/timed/time_divergence.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "compiler/system/system.hpp"
#include "runtime/core/time/clock_constraints.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr u32 kMaxTreeDepth = 100;
// Well below what the core treats as infinite: limits are computed in another way there.
constexpr std::int64_t kFarInstant = rt::kFarLimit / 2;

std::optional<double> value_of(const CodeTable& code, ExprId id, const std::vector<Value>& args, u32 depth) {
  if (depth > kMaxTreeDepth || !id.is_valid()) return std::nullopt;
  const Expr& e = code.exprs[id];
  switch (e.op) {
    case Op::ConstInt: return e.int_value;
    case Op::ConstFloat: return e.float_value;
    case Op::IntToFloat: return value_of(code, e.a, args, depth + 1);
    case Op::LoadSelf: {
      if (e.index >= args.size()) return std::nullopt;
      const Value& value = args[e.index];
      if (value.type == Type::Int) return value.int_value;
      return value.type == Type::Float ? std::optional(value.float_value) : std::nullopt;
    }
    case Op::Add:
    case Op::Sub:
    case Op::Mul: {
      const std::optional<double> a = value_of(code, e.a, args, depth + 1), b = value_of(code, e.b, args, depth + 1);
      if (!a || !b) return std::nullopt;
      const double result = e.op == Op::Add ? *a + *b : e.op == Op::Sub ? *a - *b : *a * *b;
      // An int would wrap.
      if (e.type == Type::Int && std::fabs(result) > 2147483647.0) return std::nullopt;
      return result;
    }
    case Op::ConstBool:
    case Op::ConstString:
    case Op::LoadBind:
      BIP_CALL_OPS(BIP_OP_CASE)
      BIP_SIGN_OPS(BIP_OP_CASE)
      BIP_DIVISION_OPS(BIP_OP_CASE)
      BIP_BITWISE_OPS(BIP_OP_CASE)
      BIP_LOGIC_OPS(BIP_OP_CASE)
      BIP_COMPARISON_OPS(BIP_OP_CASE)
      break;
  }
  return std::nullopt;
}

// Returns the limit in ticks; nothing: it depends on data.
std::optional<std::int64_t> limit_of(const System& system, const AtomType& type, const std::vector<Value>& args,
                                     const TimeGuard& when, const Bound& bound) {
  if (bound.variable == Bound::kNone) return bound.ticks;
  BIP_ASSERT(bound.clock < type.clocks.size() && bound.variable < type.variables.size(),
             "a bound of clock {} of {} by variable {}", bound.clock, type.clocks.size(), bound.variable);
  std::optional<double> value;
  for (StmtId id = when.measure; id.is_valid(); id = system.code.stmts[id].next) {
    const Stmt& s = system.code.stmts[id];
    const std::optional<u32> stored = model::assigned_variable(s, Op::LoadSelf);
    if (!stored) return std::nullopt;
    if (*stored == bound.variable) value = value_of(system.code, s.value, args, 0);
  }
  std::int64_t ticks = 0;
  if (!value || !to_ticks(*value, type.clocks[bound.clock].unit, ticks)) return std::nullopt;
  return ticks;
}

// Do the bounds hold from some instant on, for all these components? Lower bounds of one clock do.
bool holds_in_the_limit(const System& system, const AtomType& type, const std::vector<const Atom*>& atoms,
                        const TimeGuard& when) {
  return std::all_of(when.bounds.begin(), when.bounds.end(), [&](const Bound& bound) {
    if (bound.minus != Bound::kNone || (bound.op != BoundOp::Ge && bound.op != BoundOp::Gt)) return false;
    return std::all_of(atoms.begin(), atoms.end(), [&](const Atom* atom) {
      const std::optional<std::int64_t> limit = limit_of(system, type, atom->args, when, bound);
      return limit && *limit <= kFarInstant;
    });
  });
}

bool holds_in_the_limit(const System& system, const AtomType& type, const std::vector<const Atom*>& atoms,
                        const Resume& resume) {
  return !resume.present || (!resume.guard.is_valid() && holds_in_the_limit(system, type, atoms, resume.when));
}

std::string place_of(const System& system, const Loc& loc) {
  return loc.line == 0 ? "" : fmt::format(" ({}:{})", system.files[loc.file], loc.line);
}

std::string unfollowed_of(const System& system, const AtomType& type) {
  for (const Port& port : type.ports) {
    if (port.external)
      return fmt::format("port `{}` of `{}`{} waits for events from outside", port.name, type.name,
                         place_of(system, port.loc));
  }
  std::string found;
  const auto visit = [&](StmtId body) {
    for_each_stmt(system.code, body, [&](const Stmt& s) {
      const std::optional<u32> stored = model::assigned_variable(s, Op::LoadSelf);
      if (!stored) return;
      for (const Clock& clock : type.clocks) {
        if (*stored == clock.variable + static_cast<u32>(ClockVariable::Speed))
          found = fmt::format("clock `{}` of `{}`{} gets a speed", clock.name, type.name, place_of(system, s.loc));
      }
    });
  };
  visit(type.initial_action);
  for (const Transition& t : type.transitions) {
    visit(t.action);
    if (t.async.present)
      return fmt::format("an action of `{}`{} runs beside the others", type.name, place_of(system, t.loc));
  }
  return found;
}

}  // namespace

std::string obstacle_to_time_divergent_limit(const System& system) {
  if (system.code.has_cpp()) return "the model calls C++";
  if (system.code.has_draws()) return "the model draws random numbers";
  std::vector<std::uint8_t> is_used(system.atom_types.size(), 0);
  for (const Atom& atom : system.atoms) is_used[atom.type.value] = 1;
  for (std::size_t k = 0; k < is_used.size(); ++k) {
    if (is_used[k] == 0) continue;
    if (std::string found = unfollowed_of(system, system.atom_types[AtomTypeId(k)]); !found.empty()) return found;
  }
  return {};
}

System time_divergent_limit(const System& system) {
  System result = system;
  std::vector<std::vector<const Atom*>> atoms(system.atom_types.size());
  for (const Atom& atom : system.atoms) atoms[atom.type.value].push_back(&atom);
  std::vector<std::uint8_t> may_stay_busy(system.atom_types.size(), 0);
  bool stays_some_busy = false;
  for (std::size_t k = 0; k < atoms.size(); ++k) {
    const AtomType& type = system.atom_types[AtomTypeId(k)];
    bool comes_back = holds_in_the_limit(system, type, atoms[k], type.initial_resume);
    for (const Transition& t : type.transitions)
      comes_back = comes_back && holds_in_the_limit(system, type, atoms[k], t.resume);
    if (atoms[k].empty() || comes_back) continue;
    may_stay_busy[k] = 1;
    stays_some_busy = true;
  }
  // Components that resume together wait for each other: one that may stay busy holds the others.
  const bool is_sync = std::any_of(system.connectors.begin(), system.connectors.end(), [&](const Connector& connector) {
    return system.connector_types[connector.type].resume == ResumeMode::Sync;
  });
  for (std::size_t k = 0; k < atoms.size(); ++k) {
    AtomType& type = result.atom_types[AtomTypeId(k)];
    const bool is_lost = may_stay_busy[k] != 0 || (is_sync && stays_some_busy);
    ExprId unknown_guard;
    for (Transition& t : type.transitions) {
      const bool is_internal = t.port == Transition::kInternal;
      if (is_internal ? t.when.empty() : !is_lost && holds_in_the_limit(system, type, atoms[k], t.when)) continue;
      if (!unknown_guard.is_valid()) {
        CodeTable& code = result.code;
        const auto variable = static_cast<u32>(type.variables.size());
        type.variables.push_back({.name = "(time)", .type = Type::Float});
        const ExprId load = code.exprs.push({.op = Op::LoadSelf, .type = Type::Float, .index = variable});
        const ExprId zero = code.exprs.push({.op = Op::ConstFloat, .type = Type::Float});
        unknown_guard = code.exprs.push({.op = Op::Gt, .type = Type::Bool, .a = load, .b = zero});
      }
      if (!t.guard.is_valid()) {
        t.guard = unknown_guard;
        continue;
      }
      t.guard = result.code.exprs.push({.op = Op::And, .type = Type::Bool, .a = t.guard, .b = unknown_guard});
    }
  }
  return result;
}

std::vector<u32> bounded_modes(const Net& net, u32 atom) {
  BIP_ASSERT(atom < net.class_of.size(), "atom {} of {}", atom, net.class_of.size());
  const System& system = *net.system;
  const ModeClass& row = net.class_at(atom);
  const AtomType& type = system.atom_types[row.type];
  std::vector<u32> modes;
  const auto is_bounded = [&](const Mode& mode, const Invariant& invariant) {
    const bool includes = std::all_of(invariant.places.begin(), invariant.places.end(), [&](u32 place) {
      return std::binary_search(mode.places.begin(), mode.places.end(), place);
    });
    if (invariant.scope == InvariantScope::From && !includes) return false;
    if (invariant.scope == InvariantScope::At && mode.places != invariant.places) return false;
    return std::any_of(invariant.when.bounds.begin(), invariant.when.bounds.end(), [&](const Bound& bound) {
      if (bound.minus != Bound::kNone || bound.op == BoundOp::Ge || bound.op == BoundOp::Gt) return false;
      const std::optional<std::int64_t> limit = limit_of(system, type, row.args, invariant.when, bound);
      return limit && *limit <= kFarInstant;
    });
  };
  for (u32 mode = 0; mode < row.modes.size(); ++mode) {
    const Mode& of = row.modes[mode];
    if (std::any_of(type.invariants.begin(), type.invariants.end(),
                    [&](const Invariant& invariant) { return is_bounded(of, invariant); }))
      modes.push_back(mode);
  }
  return modes;
}

bool bounds_time(const System& system, AtomId atom) {
  const AtomType& type = system.atom_types[system.atoms[atom].type];
  return std::any_of(type.invariants.begin(), type.invariants.end(),
                     [](const Invariant& invariant) { return !invariant.when.empty(); });
}

}  // namespace bip::verify
