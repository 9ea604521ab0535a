// Converts the contents of atoms in both notations: ports, clocks, places or states, transitions, rules.
#include <algorithm>

#include "compiler/parse/convert.hpp"

namespace bip::parse {

using namespace syntax;

namespace {

constexpr std::string_view kUnits[] = {"nanosecond", "microsecond", "millisecond", "second", "minute", "hour", "day"};

/// The unit that `word` abbreviates or misspells; empty if none.
std::string meant_unit(std::string_view word) {
  constexpr std::pair<std::string_view, std::string_view> kShort[] = {
      {"ns", "nanosecond"}, {"us", "microsecond"}, {"ms", "millisecond"}, {"s", "second"},
      {"sec", "second"},    {"min", "minute"},     {"h", "hour"},         {"d", "day"}};
  for (const auto& [brief, unit] : kShort) {
    if (word == brief) return std::string(unit);
  }
  const std::vector<std::string> similar = similar_names(word, {std::begin(kUnits), std::end(kUnits)});
  return similar.empty() ? std::string() : similar.front();
}

}  // namespace

void Converter::body_item(BipParser::BodyItemContext* ctx, Items& to) {
  const Annotations marks = annotations(ctx->annotation());
  if (compound_item(ctx, marks, to)) return;
  if (owner_.kind == DeclKind::AtomType) return atom_item(ctx, marks, to);
  if (ctx->dataDecl() != nullptr && owner_.notation == Notation::Paper) {
    to.data.push_back(data(ctx->dataDecl(), marks));
    return;
  }
  std::string_view what = "a behavior";
  if (ctx->dataDecl() != nullptr) what = "data";
  if (ctx->portDecl() != nullptr) what = "a port of its own";
  if (ctx->clockDecl() != nullptr) what = "a clock";
  if (ctx->places() != nullptr) what = "a `place` line";
  if (ctx->initial() != nullptr) what = "an `initial` line";
  if (ctx->finals() != nullptr) what = "a `final` line";
  if (ctx->transition() != nullptr) what = "a transition";
  if (ctx->invariant() != nullptr) what = "an invariant";
  misplaced(what, range(ctx));
}

void Converter::atom_item(BipParser::BodyItemContext* ctx, Annotations marks, Items& to) {
  if (ctx->dataDecl() != nullptr) {
    to.data.push_back(data(ctx->dataDecl(), marks));
  } else if (ctx->portDecl() != nullptr) {
    to.ports.push_back(port(ctx->portDecl(), marks));
  } else if (BipParser::ClockDeclContext* clock = ctx->clockDecl()) {
    std::vector<BipParser::IdContext*> ids = clock->id();
    ClockDecl made{.annotations = marks, .range = range(clock)};
    if (clock->INT() != nullptr && text(range(clock->INT()->getSymbol())) != "1")
      diags_
          .report(Diag::kB0021, range(clock->INT()->getSymbol()),
                  std::string(text(range(clock->INT()->getSymbol()))) + " " + std::string(name(ids.back()).text))
          .note("a unit is one of `nanosecond` to `day`, such as `unit 1 second`");
    if (clock->UNIT() != nullptr) {
      made.unit = name(ids.back());
      ids.pop_back();
      if (std::find(std::begin(kUnits), std::end(kUnits), made.unit.text) == std::end(kUnits)) {
        auto diagnostic =
            diags_.report(Diag::kB0021, made.unit.range, made.unit.text)
                .note("units are `nanosecond`, `microsecond`, `millisecond`, `second`, `minute`, `hour` and `day`");
        if (const std::string unit = meant_unit(made.unit.text); !unit.empty())
          diagnostic.help("write `" + unit + "`", made.unit.range, unit);
        made.unit = {};
      }
    }
    made.names = names(ids);
    to.clocks.push_back(made);
  } else if (ctx->places() != nullptr) {
    for (BipParser::IdContext* id : ctx->places()->idList()->id()) to.places.push_back(name(id));
  } else if (ctx->initial() != nullptr) {
    if (to.initial.present) repeated("`initial`", owner_.phrase, range(ctx->initial()));
    to.initial = initial(ctx->initial());
  } else if (ctx->finals() != nullptr) {
    to.finals.push_back({.places = names(ctx->finals()->idList()), .range = range(ctx->finals())});
  } else if (ctx->transition() != nullptr) {
    if (!failed(ctx->transition())) transition(ctx->transition(), marks, nullptr, to);
  } else if (ctx->priority() != nullptr) {
    atom_priority(ctx->priority(), to);
    if (BipParser::IndexContext* index = ctx->priority()->index())
      diags_.report(Diag::kB3020, range(index), "priority", name(ctx->priority()->id()).text);
  } else if (ctx->invariant() != nullptr) {
    if (!failed(ctx->invariant()->provided())) to.invariants.push_back(invariant(ctx->invariant()));
  } else if (ctx->behavior() != nullptr) {
    if (to.has_behavior) repeated("`behavior`", owner_.phrase, range(ctx->behavior()->start));
    to.has_behavior = true;
    behavior(ctx->behavior(), to);
  } else {
    misplaced("a part", range(ctx));
  }
}

void Converter::behavior(BipParser::BehaviorContext* ctx, Items& to) {
  std::vector<BipParser::AnnotationContext*> marks;
  // A transition whose state could not be read has no `from`: that is no second error.
  bool is_whole = true;
  for (antlr4::tree::ParseTree* child : ctx->children) {
    auto* rule = dynamic_cast<antlr4::ParserRuleContext*>(child);
    is_whole = is_whole && (rule == nullptr || !failed(rule));
  }
  for (antlr4::tree::ParseTree* child : ctx->children) {
    auto* rule = dynamic_cast<antlr4::ParserRuleContext*>(child);
    if (rule == nullptr || failed(rule)) continue;
    switch (rule->getRuleIndex()) {
      case BipParser::RuleAnnotation: marks.push_back(static_cast<BipParser::AnnotationContext*>(rule)); break;
      case BipParser::RuleInitial:
        if (to.initial.present) repeated("`initial`", owner_.phrase, range(rule));
        to.initial = initial(static_cast<BipParser::InitialContext*>(rule));
        break;
      case BipParser::RuleTransition:
        if (auto* step = static_cast<BipParser::TransitionContext*>(rule); is_whole || !step->from().empty()) {
          transition(step, annotations(marks), nullptr, to);
        }
        marks.clear();
        break;
      default: {
        auto* state = static_cast<BipParser::StateContext*>(rule);
        const Name place = name(state->id());
        to.places.push_back(place);
        std::vector<BipParser::AnnotationContext*> inner;
        for (antlr4::tree::ParseTree* part : state->children) {
          if (auto* mark = dynamic_cast<BipParser::AnnotationContext*>(part)) inner.push_back(mark);
          if (auto* step = dynamic_cast<BipParser::TransitionContext*>(part)) {
            if (!failed(step)) transition(step, annotations(inner), &place, to);
            inner.clear();
          }
        }
      }
    }
  }
}

PortDecl Converter::port(BipParser::PortDeclContext* ctx, Annotations marks) {
  PortDecl made{.annotations = marks, .range = range(ctx)};
  made.role = ctx->EXPORT() != nullptr || owner_.notation == Notation::Paper ? PortRole::Exported : PortRole::Internal;
  if (ctx->EXTERN() != nullptr) made.role = PortRole::External;
  made.type = type_ref(ctx->typeName(), Constness::Mutable);
  std::vector<PortItem> items;
  for (BipParser::PortItemContext* item : ctx->portItem()) {
    items.push_back({.name = name(item->id()), .vars = names(item->idList()), .has_vars = item->LPAREN() != nullptr});
  }
  made.items = arena_.list(items);
  if (!made.type.is_written() && owner_.notation == Notation::Bip2 && !is_broken(declaration_)) {
    diags_.report(Diag::kB0014, made.items[0].name.range, "port `" + std::string(made.items[0].name.text) + "`", "type")
        .help("write its port type before its name: `port Port " + std::string(made.items[0].name.text) + "()`");
  }
  if (ctx->id() != nullptr) made.merged_as = name(ctx->id());
  if (ctx->STRING() != nullptr) made.extern_class = string(ctx->STRING());
  for (antlr4::tree::TerminalNode* policy : {ctx->REMEMBER(), ctx->IGNORE(), ctx->ERROR()}) {
    if (policy != nullptr) made.extern_policy = name(policy->getSymbol());
  }
  if (made.role != PortRole::External && (ctx->STRING() != nullptr || !made.extern_policy.text.empty())) {
    diags_.report(Diag::kB0019, made.range, "a class or a policy belongs to an `extern port`");
  }
  if (made.role != PortRole::Exported && ctx->id() != nullptr) {
    diags_.report(Diag::kB0019, made.merged_as.range, "only exported ports are merged by `as`")
        .help("write `export port`");
  }
  return made;
}

Initial Converter::initial(BipParser::InitialContext* ctx) {
  Initial made{.present = true, .range = range(ctx)};
  constexpr std::string_view kWhole = "the `initial` line";
  for (std::size_t i = 1; i < ctx->to().size(); ++i) repeated("`to`", kWhole, range(ctx->to(i)));
  for (std::size_t i = 1; i < ctx->action().size(); ++i) repeated("`do`", kWhole, range(ctx->action(i)));
  if (ctx->to().empty()) {
    diags_.report(Diag::kB0014, made.range, "the `initial` line of " + owner_.phrase, "`to`");
  } else {
    made.to = names(ctx->to(0)->idList());
  }
  if (!ctx->action().empty()) made.action = action(ctx->action(0));
  for (BipParser::ClockResetContext* reset : ctx->clockReset()) add_resets(reset, made.action);
  if (!ctx->resume().empty()) {
    made.resumes = true;
    made.resume = value(ctx->resume(0)->expr());
  }
  return made;
}

// The older spelling of time: `provided (data) when (clocks)` is one guard, `reset c` sets c before the action does.
bool Converter::is_when(BipParser::ProvidedContext* ctx) const { return text(range(ctx->start)) == "when"; }

const Expr* Converter::both(BipParser::ProvidedContext* first, BipParser::ProvidedContext* second) {
  const Expr *left = guard(first), *right = guard(second);
  if (left == nullptr || right == nullptr) return left == nullptr ? right : left;
  Expr e{.kind = ExprKind::Binary, .range = {file_, left->range.begin, right->range.end}};
  e.binary = BinaryOp::And;
  e.op_range = range((is_when(second) ? second : first)->start);
  e.operands = arena_.list(std::vector<const Expr*>{left, right});
  return arena_.make(e);
}

void Converter::add_resets(BipParser::ClockResetContext* ctx, Block& action) {
  if (failed(ctx)) return;
  std::vector<const Stmt*> list;
  for (BipParser::IdContext* id : ctx->idList()->id()) {
    const Name clock = name(id);
    Stmt stmt{.kind = StmtKind::Assign, .range = clock.range};
    stmt.target = {arena_.list(std::vector<PathPart>{{.name = clock}}), clock.range};
    stmt.value = arena_.make(Expr{.kind = ExprKind::Int, .range = clock.range, .text = "0"});
    list.push_back(arena_.make(stmt));
  }
  list.insert(list.end(), action.stmts.begin(), action.stmts.end());
  const SourceRange resets = range(ctx);
  if (action.present) {
    action.range.begin = std::min(action.range.begin, resets.begin);
    action.range.end = std::max(action.range.end, resets.end);
  } else {
    action.range = resets;
  }
  action.present = true;
  action.stmts = arena_.list(list);
}

void Converter::missing_from_or_to(BipParser::TransitionContext* ctx, std::string_view word) {
  const SourceRange whole = range(ctx);
  // What the parser found wrong earlier on the line may have been it.
  const std::size_t line = text_.rfind('\n', whole.begin) + 1;  // the first line: npos + 1 = 0
  if (is_broken({file_, static_cast<std::uint32_t>(line), whole.end})) return;
  std::string after = " after ";
  const antlr4::Token* next = nullptr;
  // The child that follows the port, or for `to` whatever follows `from …`.
  const std::size_t at = ctx->INTERNAL() != nullptr ? 1 : 2;
  if (word == "from") {
    after +=
        ctx->INTERNAL() != nullptr ? std::string("`internal`") : "port `" + std::string(name(ctx->id()).text) + "`";
    if (ctx->children.size() > at) next = static_cast<antlr4::ParserRuleContext*>(ctx->children[at])->start;
  } else {
    const antlr4::ParserRuleContext* last = ctx->from().empty() ? nullptr : ctx->from(0);
    after += last == nullptr ? std::string("the port") : "`" + std::string(text(range(last))) + "`";
    if (ctx->from().empty() && ctx->children.size() > at)
      next = static_cast<antlr4::ParserRuleContext*>(ctx->children[at])->start;
    if (last != nullptr && ctx->children.size() > at + 1)
      next = static_cast<antlr4::ParserRuleContext*>(ctx->children[at + 1])->start;
  }
  const SourceRange where = next != nullptr ? range(next) : SourceRange{file_, whole.begin, whole.end};
  const std::string found = next != nullptr ? "`" + std::string(text(where)) + "`" : "the next item";
  auto diagnostic = diags_.report(Diag::kB0001, where, "`" + std::string(word) + "`",
                                  after + " in a transition of " + owner_.phrase, found);
  if (word == "to" && !ctx->from().empty()) {
    const SourceRange from = range(ctx->from(0));
    const std::string stays = "to " + std::string(text(range(ctx->from(0)->idList())));
    diagnostic.help("a transition that stays says `" + stays + "`", {file_, from.end, from.end}, " " + stays);
  } else if (word == "from") {
    diagnostic.help("write `from PLACE`, or put it into a `state`");
  }
}

void Converter::check_from_of_state(BipParser::FromContext* from, const Name& state) {
  const std::span<const Name> places = names(from->idList());
  if (std::any_of(places.begin(), places.end(), [&](const Name& n) { return n.text == state.text; })) return;
  const SourceRange at = range(from);
  diags_.report(Diag::kB0023, at, text(at), state.text)
      .label(state.range, "it belongs to this state")
      .help("leave `" + std::string(text(at)) + "` out", at, "")
      .help("move the transition to `state " + std::string(places.front().text) + "`");
}

void Converter::transition(BipParser::TransitionContext* ctx, Annotations marks, const Name* state, Items& to) {
  Transition t{.annotations = marks, .internal = ctx->INTERNAL() != nullptr, .range = range(ctx)};
  constexpr std::string_view kWhole = "a transition";
  if (!t.internal) t.port = name(ctx->id());
  for (std::size_t i = 1; i < ctx->from().size(); ++i) repeated("`from`", kWhole, range(ctx->from(i)));
  for (std::size_t i = 1; i < ctx->to().size(); ++i) repeated("`to`", kWhole, range(ctx->to(i)));
  for (std::size_t i = 1; i < ctx->provided().size(); ++i) {
    if (is_when(ctx->provided(i)) == is_when(ctx->provided(0)) || i > 1)
      repeated(is_when(ctx->provided(i)) ? "`when`" : "`provided`", kWhole, range(ctx->provided(i)));
  }
  for (std::size_t i = 1; i < ctx->urgency().size(); ++i) repeated("urgency", kWhole, range(ctx->urgency(i)));
  for (std::size_t i = 1; i < ctx->action().size(); ++i) repeated("`do`", kWhole, range(ctx->action(i)));
  for (std::size_t i = 1; i < ctx->resume().size(); ++i) repeated("`resume`", kWhole, range(ctx->resume(i)));
  if (!ctx->from().empty()) {
    t.from = names(ctx->from(0)->idList());
    if (state != nullptr) check_from_of_state(ctx->from(0), *state);
  } else if (state != nullptr) {
    t.from = arena_.list(std::vector<Name>{*state});
  } else {
    return missing_from_or_to(ctx, "from");
  }
  if (ctx->to().empty()) return missing_from_or_to(ctx, "to");
  t.to = names(ctx->to(0)->idList());
  if (ctx->provided().size() == 1) t.guard = guard(ctx->provided(0));
  if (ctx->provided().size() > 1) t.guard = both(ctx->provided(0), ctx->provided(1));
  if (!ctx->urgency().empty()) t.urgency = name(ctx->urgency(0)->start);
  if (!ctx->action().empty()) t.action = action(ctx->action(0));
  for (BipParser::ClockResetContext* reset : ctx->clockReset()) add_resets(reset, t.action);
  if (!ctx->resume().empty()) {
    t.resumes = true;
    t.resume = value(ctx->resume(0)->expr());
  }
  to.transitions.push_back(t);
}

void Converter::atom_priority(BipParser::PriorityContext* ctx, Items& to) {
  AtomPriority made{.name = name(ctx->id()), .range = range(ctx)};
  Name* sides[] = {&made.low, &made.high};
  for (std::size_t i = 0; i < 2; ++i) {
    BipParser::PrioritySideContext* side = ctx->prioritySide(i);
    if (side->start != side->stop) {
      diags_.report(Diag::kB0019, range(side),
                    "a priority of an atom compares ports of its own, `*` stands for all others");
      return;
    }
    *sides[i] = name(side->start);
  }
  if (ctx->provided() != nullptr) made.guard = guard(ctx->provided());
  to.atom_priorities.push_back(made);
}

Invariant Converter::invariant(BipParser::InvariantContext* ctx) {
  Invariant made{.name = name(ctx->id()), .range = range(ctx)};
  if (ctx->AT() != nullptr) made.scope = InvariantScope::At;
  if (ctx->FROM() != nullptr) made.scope = InvariantScope::From;
  made.places = names(ctx->idList());
  made.expr = guard(ctx->provided());
  return made;
}

}  // namespace bip::parse
