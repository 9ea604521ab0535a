// Clocks, and conditions on them: see build_time.hpp.
//
// A condition is split at its `&&`s. What reads no clock stays an expression; what does must be a comparison that, with
// all clocks on one side, bounds one clock or the difference of two of the same unit. Recursion is as deep as the
// parser lets expressions be.
#include "compiler/model/build_time.hpp"

#include <algorithm>

#include "compiler/model/evaluate.hpp"
#include "compiler/model/exclusive_guards.hpp"
#include "compiler/model/ffi_declarations.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::model {

using syntax::BinaryOp;
using syntax::ExprKind;
using syntax::UnaryOp;

namespace {

constexpr std::pair<const char*, std::int64_t> kUnits[] = {
    {"nanosecond", 1},          {"microsecond", 1'000},      {"millisecond", 1'000'000}, {"second", 1'000'000'000},
    {"minute", 60'000'000'000}, {"hour", 3'600'000'000'000}, {"day", 86'400'000'000'000}};

bool is_comparison(const syntax::Expr* e) {
  if (e->kind != ExprKind::Binary) return false;
#define BIP_IS_BINARY(name, ...) || e->binary == BinaryOp::name
  return false BIP_COMPARISON_OPS(BIP_IS_BINARY);
#undef BIP_IS_BINARY
}

BoundOp bound_op(BinaryOp op, bool is_flipped) {
  switch (op) {
    case BinaryOp::Lt: return is_flipped ? BoundOp::Gt : BoundOp::Lt;
    case BinaryOp::Le: return is_flipped ? BoundOp::Ge : BoundOp::Le;
    case BinaryOp::Gt: return is_flipped ? BoundOp::Lt : BoundOp::Gt;
    case BinaryOp::Ge: return is_flipped ? BoundOp::Le : BoundOp::Ge;
    case BinaryOp::Eq: return BoundOp::Eq;
#define BIP_BINARY_CASE(name, ...) case BinaryOp::name:
      BIP_VALUE_OPS(BIP_BINARY_CASE)
      BIP_LOGIC_OPS(BIP_BINARY_CASE)
#undef BIP_BINARY_CASE
    case BinaryOp::Ne: break;
  }
  BIP_UNREACHABLE("not a bound");
}

}  // namespace

/// Clocks and data of one side of a comparison, each with its sign.
struct TimeBuilder::Linear {
  std::vector<std::pair<const syntax::Expr*, bool>> clocks, data;  // true: negative
};

const char* unit_name(std::int64_t ticks) {
  for (const auto& [name, length] : kUnits) {
    if (length == ticks) return name;
  }
  return "second";
}

void TimeBuilder::add_clock(const syntax::Name& name, const syntax::Name& unit) {
  Clock clock{.name = std::string(name.text),
              .variable = static_cast<std::uint32_t>(atom_.variables.size()),
              .loc = builder_.loc(name.range)};
  for (const auto& [word, length] : kUnits) {
    if (unit.text == word) clock.unit = length;
  }
  scope_.names[clock.name] = {.index = clock.variable,
                              .type = Type::Float,
                              .read_only = "",
                              .value = {},
                              .is_clock = true,
                              .declared = name.range};
  atom_.variables.push_back({fmt::format("clock {}", clock.name), Type::Float, false, false, clock.loc});
  atom_.variables.push_back({fmt::format("clock {} is set", clock.name), Type::Bool, false, false, clock.loc});
  atom_.variables.push_back({fmt::format("clock {} speed", clock.name), Type::Float, false, false, clock.loc});
  BIP_ASSERT(atom_.variables.size() == clock.variable + std::size_t{kClockVariables}, "clock `{}` has {} variables",
             clock.name, atom_.variables.size() - clock.variable);
  atom_.clocks.push_back(std::move(clock));
}

const syntax::Expr* TimeBuilder::clock_in(const syntax::Expr* e) const {
  if (e == nullptr || atom_.clocks.empty()) return nullptr;
  if (e->kind == ExprKind::Path && !e->clock_speed) {
    const auto found = scope_.names.find(path_key(e->path, builder_.sources));
    return found != scope_.names.end() && found->second.is_clock ? e : nullptr;
  }
  for (const syntax::Expr* operand : e->operands) {
    if (const syntax::Expr* found = clock_in(operand)) return found;
  }
  return nullptr;
}

ExprId TimeBuilder::make(Op op, Type type, ExprId left, ExprId right, SourceRange at) {
  return builder_.model.code.exprs.push({.op = op, .type = type, .a = left, .b = right, .loc = builder_.loc(at)});
}

TimedCondition TimeBuilder::condition(const syntax::Expr* e, const std::string& what) {
  TimedCondition out;
  if (e == nullptr) return out;
  conjunct(e, what, out);
  check_satisfiable(out.when, e);
  return out;
}

Resume TimeBuilder::resume(bool present, const syntax::Expr* e, SourceRange at) {
  if (!present) return {};
  TimedCondition parts = condition(e, "what `resume` waits for");
  return {.present = true,
          .guard = parts.data,
          .when = std::move(parts.when),
          .loc = builder_.loc(e != nullptr ? e->range : at)};
}

void TimeBuilder::conjunct(const syntax::Expr* e, const std::string& what, TimedCondition& out) {
  const syntax::Expr* clock = clock_in(e);
  if (clock == nullptr) {
    CodeBuilder code(builder_.model, builder_.diags, scope_);
    code.set_const_calls();
    const ExprId data = code.expr_as(e, Type::Bool, what);
    out.data = out.data.is_valid() ? make(Op::And, Type::Bool, out.data, data, e->range) : data;
    return;
  }
  const bool is_and = e->kind == ExprKind::Binary && e->binary == BinaryOp::And;
  if (is_and) {
    for (const syntax::Expr* operand : e->operands) conjunct(operand, what, out);
    return;
  }
  if (is_comparison(e) && e->binary != BinaryOp::Ne) return bound(e, out);
  const bool is_operator = e->kind == ExprKind::Binary || e->kind == ExprKind::Unary;
  if (is_operator && (e->kind == ExprKind::Unary ? e->unary == UnaryOp::Not
                                                 : e->binary == BinaryOp::Or || e->binary == BinaryOp::Ne)) {
    auto d = builder_.diags
                 .report(Diag::kB1602, e->op_range, clock->path.parts[0].name.text, builder_.sources.text(e->op_range))
                 .label(clock->range, "this is a clock");
    if (e->kind == ExprKind::Binary && e->binary == BinaryOp::Or) d.help("write two transitions, one a case");
    else d.help("write the comparison the other way round: `x > 5` for `!(x <= 5)`");
    return;
  }
  builder_.diags.report(Diag::kB1603, e->range, clock->path.parts[0].name.text)
      .help("compare a clock, or the difference of two, with data: `x <= 5`, `x - y >= n`");
}

bool TimeBuilder::collect(const syntax::Expr* e, Sign sign, Linear& out) {
  const syntax::Expr* clock = clock_in(e);
  if (clock == nullptr) {
    out.data.emplace_back(e, sign == Sign::Minus);
    return true;
  }
  if (clock == e) {
    out.clocks.emplace_back(e, sign == Sign::Minus);
    return true;
  }
  const bool is_sum = e->kind == ExprKind::Binary && (e->binary == BinaryOp::Add || e->binary == BinaryOp::Sub);
  if (is_sum)
    return collect(e->operands[0], sign, out) &&
           collect(e->operands[1], e->binary == BinaryOp::Sub ? opposite(sign) : sign, out);
  if (e->kind == ExprKind::Unary && (e->unary == UnaryOp::Neg || e->unary == UnaryOp::Plus)) {
    return collect(e->operands[0], e->unary == UnaryOp::Neg ? opposite(sign) : sign, out);
  }
  builder_.diags.report(Diag::kB1603, e->range, clock->path.parts[0].name.text)
      .help("compare a clock, or the difference of two, with data: `x <= 5`, `x - y >= n`");
  return false;
}

// left op right as clock - minus op limit.
void TimeBuilder::bound(const syntax::Expr* e, TimedCondition& out) {
  Linear sum;
  if (!collect(e->operands[0], Sign::Plus, sum) || !collect(e->operands[1], Sign::Minus, sum)) return;
  const std::size_t negative = static_cast<std::size_t>(
      std::count_if(sum.clocks.begin(), sum.clocks.end(), [](const auto& c) { return c.second; }));
  const std::size_t positive = sum.clocks.size() - negative;
  const auto name = [](const syntax::Expr* clock) { return clock->path.parts[0].name.text; };
  const auto same = [&] { return name(sum.clocks[0].first) == name(sum.clocks[1].first); };
  if (positive > 1 || negative > 1 || (sum.clocks.size() == 2 && same())) {
    builder_.diags.report(Diag::kB1604, e->range)
        .label(sum.clocks[0].first->range, "a clock")
        .label(sum.clocks[1].first->range, "and another one")
        .help("what is bounded is one clock, or the difference of two");
    return;
  }
  BIP_ASSERT(!sum.clocks.empty() && sum.clocks.size() <= 2, "a bound on {} clocks", sum.clocks.size());
  const bool is_flipped = positive == 0;
  std::uint32_t rows[2] = {Bound::kNone, Bound::kNone};
  for (const auto& [clock, is_negative] : sum.clocks) {
    const std::uint32_t first = scope_.names.at(std::string(name(clock))).index;
    for (std::uint32_t row = 0; row < atom_.clocks.size(); ++row) {
      if (atom_.clocks[row].variable == first) rows[is_negative != is_flipped ? 1 : 0] = row;
    }
  }
  Bound row{.clock = rows[0], .minus = rows[1], .op = bound_op(e->binary, is_flipped), .loc = builder_.loc(e->range)};
  BIP_ASSERT(row.clock < atom_.clocks.size() && row.clock != row.minus, "a bound on clock {} of {}", row.clock,
             atom_.clocks.size());
  const std::int64_t unit = atom_.clocks[row.clock].unit;
  if (row.minus != Bound::kNone && atom_.clocks[row.minus].unit != unit) {
    const Clock& other = atom_.clocks[row.minus];
    builder_.diags
        .report(Diag::kB1605, e->range, atom_.clocks[row.clock].name, unit_name(unit), other.name,
                unit_name(other.unit))
        .help("give them the same unit");
    return;
  }
  // The limit is what remains, on the other side.
  CodeBuilder code(builder_.model, builder_.diags, scope_);
  code.set_const_calls();
  ExprId limit;
  for (const auto& [term, is_negative] : sum.data) {
    const std::string what = fmt::format("the limit of clock `{}`", atom_.clocks[row.clock].name);
    const ExprId value = code.expr_as(term, Type::Float, what);
    const bool is_minus = is_negative == is_flipped;
    if (limit.is_valid()) limit = make(is_minus ? Op::Sub : Op::Add, Type::Float, limit, value, term->range);
    else limit = is_minus ? make(Op::Neg, Type::Float, value, {}, term->range) : value;
  }
  if (!limit.is_valid())
    limit = builder_.model.code.exprs.push(
        {.op = Op::ConstFloat, .type = Type::Float, .float_value = 0, .a = {}, .b = {}, .loc = row.loc});
  set_limit(e, limit, unit, row, out.when);
}

bool TimeBuilder::is_constant(ExprId id) const {
  std::vector<ExprId> todo{id};
  while (!todo.empty()) {
    const Expr& e = builder_.model.code.exprs[todo.back()];
    todo.pop_back();
    if (e.op == Op::LoadSelf || e.op == Op::LoadBind || e.op == Op::Call) return false;
    for (const ExprId part : {e.a, e.b}) {
      if (part.is_valid()) todo.push_back(part);
    }
  }
  return true;
}

void TimeBuilder::set_limit(const syntax::Expr* e, ExprId limit, std::int64_t unit, Bound& bound, TimeGuard& out) {
  if (is_constant(limit)) {
    const Evaluated value = evaluate(builder_.model.code, limit, {});
    if (value.fault == Fault::None) {
      if (!to_ticks(value.value.float_value, unit, bound.ticks)) {
        builder_.diags.report(Diag::kB1606, e->range, value.value.float_value, unit_name(unit))
            .note("time is counted in nanoseconds, up to 146 years");
        return;
      }
      out.bounds.push_back(bound);
      return;
    }
  }
  std::size_t used = 0;
  for (const Bound& other : out.bounds) used += other.variable != Bound::kNone ? 1 : 0;
  if (used == limit_variables_.size()) {
    limit_variables_.push_back(static_cast<std::uint32_t>(atom_.variables.size()));
    atom_.variables.push_back({fmt::format("limit {}", used), Type::Float, false, false, builder_.loc(e->range)});
  }
  BIP_ASSERT(used < limit_variables_.size(), "limit {} of {}", used, limit_variables_.size());
  bound.variable = limit_variables_[used];
  CodeBuilder code(builder_.model, builder_.diags, scope_);
  const StmtId store = code.store_self(bound.variable, Type::Float, limit, bound.loc, {});
  StmtId last = out.measure;
  while (last.is_valid() && builder_.model.code.stmts[last].next.is_valid())
    last = builder_.model.code.stmts[last].next;
  if (last.is_valid()) builder_.model.code.stmts[last].next = store;
  else out.measure = store;
  out.bounds.push_back(bound);
}

void TimeBuilder::check_satisfiable(const TimeGuard& when, const syntax::Expr* e) {
  if (are_exclusive(when, {})) builder_.diags.report(Diag::kB1607, e->range);
}

// ---- clocks in code
// --------------------------------------------------------------------------------------------------

std::optional<Typed> CodeBuilder::clock_path(const syntax::Expr* e) {
  const Binding* b = find(e->path, Lookup::Reported);
  if (b == nullptr || b->poison) return std::nullopt;
  const std::string name = path_key(e->path, *model_.sources);
  if (!b->is_clock) {
    diags_.report(Diag::kB1608, e->range, name).label(b->declared, "declared here");
    return std::nullopt;
  }
  if (!e->clock_speed) {
    diags_.report(Diag::kB1601, e->range, name)
        .label(b->declared, "declared here")
        .help("a clock can be compared in guards of transitions, invariants and `resume`, and set in actions");
    return std::nullopt;
  }
  const auto variable = b->index + static_cast<std::uint32_t>(ClockVariable::Speed);
  return Typed{
      make({.op = Op::LoadSelf, .type = Type::Float, .index = variable, .a = {}, .b = {}, .loc = loc(e->range)}),
      Type::Float};
}

StmtId CodeBuilder::clock_statement(const syntax::Stmt* s, const Binding& target, StmtId next) {
  const std::string name = path_key(s->target, *model_.sources);
  if (!target.is_clock) {
    diags_.report(Diag::kB1608, s->target.range, name).label(target.declared, "declared here");
    return next;
  }
  const Loc at = loc(s->range);
  if (s->clock_speed) {
    const ExprId value = expr_as(s->value, Type::Float, fmt::format("the speed of `{}`", name));
    const Expr& e = model_.code.exprs[value];
    const bool is_negative = (e.op == Op::ConstFloat && e.float_value < 0) ||
                             (e.op == Op::Neg && model_.code.exprs[e.a].op == Op::ConstFloat) ||
                             (e.op == Op::IntToFloat && model_.code.exprs[e.a].op == Op::Neg &&
                              model_.code.exprs[model_.code.exprs[e.a].a].op == Op::ConstInt);
    if (is_negative) diags_.report(Diag::kB1609, s->value->range, name);
    return store_self(target.index + static_cast<std::uint32_t>(ClockVariable::Speed), Type::Float, value, at, next);
  }
  const ExprId value = expr_as(s->value, Type::Float, fmt::format("clock `{}`", name));
  const ExprId yes = make({.op = Op::ConstBool, .type = Type::Bool, .int_value = 1, .a = {}, .b = {}, .loc = at});
  const StmtId mark =
      store_self(target.index + static_cast<std::uint32_t>(ClockVariable::IsSet), Type::Bool, yes, at, next);
  return store_self(target.index + static_cast<std::uint32_t>(ClockVariable::Value), Type::Float, value, at, mark);
}

}  // namespace bip::model
