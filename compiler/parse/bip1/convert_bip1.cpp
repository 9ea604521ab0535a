// See convert_bip1.hpp. Recursion is bounded by is_flat_bip1(), which looks at every text before a tree is made of it.
#include "compiler/parse/bip1/convert_bip1.hpp"

#include <charconv>
#include <memory>

#include "antlr4-runtime.h"
#include "compiler/parse/row_stream.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

using antlr::Bip1Parser;
using syntax::Name;
using namespace syntax::bip1;

namespace {

/// Deepest nesting of blocks in C code that is translated: each level is lexed once more.
constexpr int kMaxBlocks = 40;

/// A number that C may write otherwise than BIP2: hexadecimal, octal.
std::string decimal(std::string_view digits) {
  const bool is_hex = digits.starts_with("0x") || digits.starts_with("0X");
  if (!is_hex && (digits.size() < 2 || digits[0] != '0')) return std::string(digits);
  std::uint64_t value = 0;
  const std::string_view rest = digits.substr(is_hex ? 2 : 1);
  const auto read = std::from_chars(rest.data(), rest.data() + rest.size(), value, is_hex ? 16 : 8);
  return read.ec == std::errc() && read.ptr == rest.data() + rest.size() ? std::to_string(value) : std::string();
}

/// The sign among the children of an operator expression.
const antlr4::Token* bip1_sign(const antlr4::ParserRuleContext* ctx) {
  for (antlr4::tree::ParseTree* child : ctx->children) {
    if (auto* leaf = antlr::TreeNode::as_leaf(child)) return leaf->getSymbol();
  }
  BIP_UNREACHABLE("an expression that is no primary has a sign");
}

}  // namespace

// ---- names and places -----------------------------------------------------------------------------------------------

SourceRange Bip1Converter::range(const antlr4::Token* token) const {
  return {file_, static_cast<std::uint32_t>(token->getStartIndex()), static_cast<std::uint32_t>(token->getStopIndex())};
}

SourceRange Bip1Converter::range(const antlr4::ParserRuleContext* ctx) const {
  SourceRange r = range(ctx->start);
  // An empty rule stops before it starts.
  r.end = ctx->stop != nullptr && ctx->stop->getStopIndex() >= r.begin
              ? static_cast<std::uint32_t>(ctx->stop->getStopIndex())
              : r.begin;
  return r;
}

SourceRange Bip1Converter::inside(Parser::BlockContext* ctx) const {
  SourceRange r = range(ctx);
  r.begin = range(ctx->start).end;
  r.end = range(ctx->stop).begin;
  return r;
}

Name Bip1Converter::name(Parser::IdContext* ctx) const {
  return ctx == nullptr ? Name() : Name{text(range(ctx->start)), range(ctx->start)};
}

Names Bip1Converter::names(const std::vector<Parser::IdContext*>& ids) const {
  Names list;
  for (Parser::IdContext* id : ids) list.push_back(name(id));
  return list;
}

Names Bip1Converter::names(Parser::IdListContext* ctx) const { return ctx == nullptr ? Names() : names(ctx->id()); }
syntax::bip1::Path Bip1Converter::path(Parser::PathContext* ctx) const { return names(ctx->id()); }

std::vector<syntax::bip1::Path> Bip1Converter::paths(const std::vector<Parser::PathContext*>& list) const {
  std::vector<syntax::bip1::Path> out;
  for (Parser::PathContext* path_ctx : list) out.push_back(path(path_ctx));
  return out;
}

Type Bip1Converter::type(Parser::TypeNameContext* ctx) const {
  Type made{.text = {}, .range = range(ctx)};
  const std::string_view words = ctx->block() != nullptr ? text(inside(ctx->block())) : text(made.range);
  for (const char c : words) {
    const bool is_blank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!is_blank) made.text += c;
    if (is_blank && !made.text.empty() && made.text.back() != ' ') made.text += ' ';
  }
  while (made.text.ends_with(' ')) made.text.pop_back();
  return made;
}

std::vector<Param> Bip1Converter::params(Parser::ParamsContext* ctx) {
  std::vector<Param> list;
  if (ctx == nullptr) return list;
  for (Parser::ParamContext* param_ctx : ctx->param())
    list.push_back({type(param_ctx->typeName()), name(param_ctx->id())});
  return list;
}

// ---- declarations ---------------------------------------------------------------------------------------------------

Model Bip1Converter::model(Parser::FileContext* ctx) {
  Model made;
  made.file = file_;
  made.name = name(ctx->id());
  made.range = range(ctx);
  for (Parser::DeclContext* decl_ctx : ctx->decl()) {
    if (decl_ctx->header() != nullptr) made.headers.push_back(code(decl_ctx->header()->block()));
    if (decl_ctx->portType() != nullptr) made.decls.push_back(port_type(decl_ctx->portType()));
    if (decl_ctx->connectorType() != nullptr) made.decls.push_back(connector_type(decl_ctx->connectorType()));
    if (decl_ctx->atomType() != nullptr) made.decls.push_back(atom_type(decl_ctx->atomType()));
    if (decl_ctx->compoundType() != nullptr) made.decls.push_back(compound_type(decl_ctx->compoundType()));
    if (decl_ctx->instances() != nullptr) made.roots.push_back(instances(decl_ctx->instances()));
  }
  return made;
}

Decl Bip1Converter::port_type(Parser::PortTypeContext* ctx) {
  Decl made{.kind = DeclKind::PortType, .name = name(ctx->id())};
  made.params = params(ctx->params());
  made.range = range(ctx);
  return made;
}

Decl Bip1Converter::connector_type(Parser::ConnectorTypeContext* ctx) {
  Decl made{.kind = DeclKind::ConnectorType, .name = name(ctx->id())};
  made.params = params(ctx->params());
  made.range = range(ctx);
  made.connector = connector_body(ctx->connectorPart());
  return made;
}

ConnectorBody Bip1Converter::connector_body(const std::vector<Parser::ConnectorPartContext*>& parts) {
  ConnectorBody body;
  for (Parser::ConnectorPartContext* part : parts) {
    if (part->data() != nullptr) body.data.push_back(data(part->data()));
    if (part->portDecl() != nullptr) body.exports.push_back(port(part->portDecl()));
    if (Parser::DefineContext* define = part->define()) {
      for (Parser::PortTermContext* term : define->portTerm()) body.define.push_back(port_term(term));
      body.define_range = range(define);
    }
    if (part->completeness() != nullptr) body.completeness.push_back(completeness(part->completeness()));
    for (Parser::ClauseContext* clause_ctx : part->clause()) body.clauses.push_back(clause(clause_ctx));
  }
  return body;
}

PortTerm Bip1Converter::port_term(Parser::PortTermContext* ctx) {
  PortTerm made;
  made.range = range(ctx);
  made.is_trigger = ctx->PRIME() != nullptr;
  if (ctx->path() != nullptr) made.port = path(ctx->path());
  for (Parser::PortTermContext* child : ctx->portTerm()) made.children.push_back(port_term(child));
  return made;
}

Completeness Bip1Converter::completeness(Parser::CompletenessContext* ctx) {
  Completeness made;
  made.range = range(ctx);
  made.is_complete = ctx->COMPLETE() != nullptr;
  for (Parser::InteractionContext* interaction_ctx : ctx->interaction())
    made.interactions.push_back(paths(interaction_ctx->path()));
  return made;
}

Clause Bip1Converter::clause(Parser::ClauseContext* ctx) {
  Clause made;
  made.range = range(ctx);
  made.ports = paths(ctx->path());
  for (Parser::ProvidedContext* provided_ctx : ctx->provided()) made.guards.push_back(guard(provided_ctx->guard()));
  if (!ctx->up().empty()) made.up = code(ctx->up(0)->block());
  if (!ctx->down().empty()) made.down = code(ctx->down(0)->block());
  // `do` of a connector is its `down`.
  if (!made.down.is_present && !ctx->action().empty()) made.down = code(ctx->action(0));
  return made;
}

Port Bip1Converter::port(Parser::PortDeclContext* ctx) {
  Port made;
  made.range = range(ctx);
  made.is_exported = ctx->EXPORT() != nullptr;
  for (antlr4::tree::TerminalNode* word : {ctx->COMPLETE(), ctx->INCOMPLETE()}) {
    if (word != nullptr) made.completeness = {text(range(word->getSymbol())), range(word->getSymbol())};
  }
  // One name before the ports is their type, one behind `is` the exported name.
  bool is_behind = false;
  for (antlr4::tree::ParseTree* child : ctx->children) {
    if (antlr4::tree::TerminalNode* leaf = antlr::TreeNode::as_leaf(child)) {
      const std::size_t kind = leaf->getSymbol()->getType();
      is_behind |= kind == Bip1Parser::IS || kind == Bip1Parser::AS || kind == Bip1Parser::ASSIGN;
    } else if (auto* id = dynamic_cast<Parser::IdContext*>(child)) {
      (is_behind ? made.exported_as : made.type) = name(id);
    }
  }
  for (Parser::PortItemContext* item : ctx->portItem()) {
    made.items.push_back({name(item->id()), names(item->idList())});
  }
  return made;
}

Decl Bip1Converter::atom_type(Parser::AtomTypeContext* ctx) {
  Decl made{.kind = DeclKind::AtomType, .name = name(ctx->id())};
  made.params = params(ctx->params());
  made.range = range(ctx);
  for (Parser::AtomItemContext* item : ctx->atomItem()) {
    if (item->header() != nullptr) made.headers.push_back(code(item->header()->block()));
    if (item->data() != nullptr) made.data.push_back(data(item->data()));
    if (item->portDecl() != nullptr) made.ports.push_back(port(item->portDecl()));
    if (item->priority() != nullptr) made.priorities.push_back(priority(item->priority()));
    if (item->initial() != nullptr) made.initials.push_back(initial(item->initial()));
    if (item->behavior() != nullptr) behavior(item->behavior(), made);
    if (Parser::ClockContext* clock = item->clock()) {
      Clock clock_decl{.names = names(clock->idList()), .unit = {}, .range = range(clock)};
      if (clock->INT() != nullptr) clock_decl.unit = std::string(text(range(clock->INT()->getSymbol()))) + " ";
      if (clock->id() != nullptr) clock_decl.unit += name(clock->id()).text;
      made.clocks.push_back(std::move(clock_decl));
    }
  }
  return made;
}

void Bip1Converter::behavior(Parser::BehaviorContext* ctx, Decl& to) {
  Name state;
  const auto add_place = [&to](const Name& place) {
    if (to.places.empty()) to.places_range = place.range;
    to.places.push_back(place);
  };
  for (antlr4::tree::ParseTree* child : ctx->children) {
    if (auto* id = dynamic_cast<Parser::IdContext*>(child)) {
      state = name(id);
      add_place(state);
    } else if (auto* list = dynamic_cast<Parser::IdListContext*>(child)) {
      for (const Name& place : names(list)) add_place(place);
    } else if (auto* first = dynamic_cast<Parser::InitialContext*>(child)) {
      to.initials.push_back(initial(first));
    } else if (auto* next = dynamic_cast<Parser::TransitionContext*>(child)) {
      Transition made = transition(next);
      if (made.from.empty() && !state.text.empty()) made.from.push_back(state);
      to.transitions.push_back(std::move(made));
    }
  }
}

Initial Bip1Converter::initial(Parser::InitialContext* ctx) {
  Initial made;
  made.range = range(ctx);
  for (Parser::ToContext* to_ctx : ctx->to()) made.to = names(to_ctx->idList());
  if (!ctx->action().empty()) made.action = code(ctx->action(0));
  return made;
}

Transition Bip1Converter::transition(Parser::TransitionContext* ctx) {
  Transition made;
  made.range = range(ctx);
  made.is_internal = ctx->INTERNAL() != nullptr;
  made.port = name(ctx->id());
  for (Parser::FromContext* from_ctx : ctx->from()) made.from = names(from_ctx->idList());
  for (Parser::ToContext* to_ctx : ctx->to()) made.to = names(to_ctx->idList());
  for (Parser::ProvidedContext* provided_ctx : ctx->provided()) made.guards.push_back(guard(provided_ctx->guard()));
  for (Parser::WhenContext* when_ctx : ctx->when()) made.whens.push_back(when(when_ctx));
  for (Parser::UrgencyContext* urgency_ctx : ctx->urgency())
    made.urgency = {text(range(urgency_ctx)), range(urgency_ctx)};
  for (Parser::IdListContext* clocks_ctx : ctx->idList()) {
    for (const Name& clock : names(clocks_ctx)) made.resets.push_back(clock);
  }
  if (!ctx->action().empty()) made.action = code(ctx->action(0));
  return made;
}

When Bip1Converter::when(Parser::WhenContext* ctx) {
  When made;
  made.range = range(ctx);
  if (ctx->guard() != nullptr) {
    made.ends.push_back(guard(ctx->guard()));
    return made;
  }
  made.clock = path(ctx->path());
  for (Parser::ExprContext* end : ctx->expr()) made.ends.push_back(guard(end));
  return made;
}

Decl Bip1Converter::compound_type(Parser::CompoundTypeContext* ctx) {
  Decl made{.kind = DeclKind::CompoundType, .name = name(ctx->id())};
  made.params = params(ctx->params());
  made.range = range(ctx);
  for (Parser::CompoundItemContext* item : ctx->compoundItem()) {
    if (item->instances() != nullptr) made.instances.push_back(instances(item->instances()));
    if (item->connectors() != nullptr) typed_connectors(item->connectors(), made);
    if (item->inlineConnector() != nullptr) made.connectors.push_back(inline_connector(item->inlineConnector()));
    if (item->priority() != nullptr) made.priorities.push_back(priority(item->priority()));
    if (item->compoundExport() != nullptr) made.exports.push_back(compound_export(item->compoundExport()));
  }
  return made;
}

Instances Bip1Converter::instances(Parser::InstancesContext* ctx) {
  Instances made;
  made.type = name(ctx->id());
  made.range = range(ctx);
  for (Parser::InstanceContext* instance_ctx : ctx->instance()) {
    Instance instance{.name = name(instance_ctx->id()), .args = {}};
    if (instance_ctx->args() != nullptr) {
      for (Parser::ExprContext* arg : instance_ctx->args()->expr()) instance.args.push_back(guard(arg));
    }
    made.items.push_back(std::move(instance));
  }
  return made;
}

void Bip1Converter::typed_connectors(Parser::ConnectorsContext* ctx, Decl& to) {
  for (Parser::BindingContext* binding_ctx : ctx->binding()) {
    Connector made;
    made.type = name(ctx->id());
    made.name = name(binding_ctx->id());
    made.ports = paths(binding_ctx->path());
    made.range = binding_ctx == ctx->binding(0) ? range(ctx) : range(binding_ctx);
    to.connectors.push_back(std::move(made));
  }
}

Connector Bip1Converter::inline_connector(Parser::InlineConnectorContext* ctx) {
  Connector made;
  Parser::BindingContext* binding = ctx->binding();
  made.name = name(binding != nullptr ? binding->id() : ctx->id());
  made.ports = paths(binding != nullptr ? binding->path() : ctx->path());
  made.range = range(ctx);
  made.body = connector_body(ctx->connectorPart());
  return made;
}

Priority Bip1Converter::priority(Parser::PriorityContext* ctx) {
  Priority made;
  made.range = range(ctx);
  made.name = name(ctx->id());
  for (Parser::ConditionContext* condition_ctx : ctx->condition()) {
    Condition condition;
    condition.range = range(condition_ctx);
    if (condition_ctx->expr() != nullptr) {
      condition.guard = guard(condition_ctx->expr());
    } else {
      condition.guard.range = inside(condition_ctx->block());
      with_code(condition.guard.range, &Bip1Parser::guardCode, [&](Parser::GuardCodeContext* tree) {
        condition.guard.expr = expr(tree->expr());
        return condition.guard.expr.has_value();
      });
    }
    made.conditions.push_back(std::move(condition));
  }
  made.low = side(ctx->prioritySide(0));
  made.high = side(ctx->prioritySide(1));
  return made;
}

PrioritySide Bip1Converter::side(Parser::PrioritySideContext* ctx) {
  PrioritySide made;
  std::vector<syntax::bip1::Path> all = paths(ctx->path());
  made.is_any = all.empty();
  if (made.is_any) return made;
  made.connector = all.front();
  made.has_interaction = ctx->COLON() != nullptr;
  made.interaction.assign(all.begin() + 1, all.end());
  return made;
}

Export Bip1Converter::compound_export(Parser::CompoundExportContext* ctx) {
  Export made;
  made.range = range(ctx);
  made.is_data = ctx->DATA() != nullptr;
  // `T e is c.p`, `c.p is e` or `e is c.p`: the inner name is the one with a dot, else the last.
  const std::vector<Parser::PathContext*> all = ctx->path();
  const std::vector<Parser::IdContext*> left = all[all.size() - 2]->id(), right = all.back()->id();
  const bool is_inner_left = all.size() == 2 && left.size() > 1 && right.size() == 1;
  made.target = names(is_inner_left ? left : right);
  const std::vector<Parser::IdContext*>& outer = is_inner_left ? right : left;
  if (outer.size() == 1) made.name = name(outer[0]);
  return made;
}

// ---- C code ---------------------------------------------------------------------------------------------------------

template <class Rule, class Convert>
bool Bip1Converter::with_code(SourceRange code, Rule rule, Convert convert) {
  TokenList list = read_bip1_tokens(text(code), code.begin);
  TokenRow deep;
  if (!is_flat_bip1(list.rows, deep)) return false;
  for (const TokenRow& row : list.rows) {
    if (row.type == Bip1Parser::STRAY || row.type == Bip1Parser::UNCLOSED_COMMENT ||
        row.type == Bip1Parser::UNCLOSED_STRING)
      return false;
  }
  RowStream stream(list.rows, text_.size());
  Bip1Parser parser(&stream);
  parser.removeErrorListeners();
  parser.setErrorHandler(std::make_shared<antlr4::BailErrorStrategy>());
  try {
    if (!convert((parser.*rule)())) return false;
  } catch (const antlr4::ParseCancellationException&) {
    return false;
  }
  comments_.insert(comments_.end(), list.comments.begin(), list.comments.end());
  return true;
}

Code Bip1Converter::code(Parser::BlockContext* ctx) {
  Code made{.is_present = true, .range = inside(ctx), .stmts = std::nullopt};
  std::vector<Stmt> stmts;
  if (block(ctx, stmts)) made.stmts = std::move(stmts);
  return made;
}

Code Bip1Converter::code(Parser::ActionContext* ctx) {
  if (ctx->block() != nullptr) return code(ctx->block());
  Code made{.is_present = true, .range = range(ctx->simple()), .stmts = std::nullopt};
  std::vector<Stmt> stmts;
  if (simple(ctx->simple(), stmts)) made.stmts = std::move(stmts);
  return made;
}

bool Bip1Converter::statements(SourceRange code, std::vector<Stmt>& to) {
  return with_code(code, &Bip1Parser::code, [&](Parser::CodeContext* tree) {
    for (Parser::StmtContext* stmt_ctx : tree->stmt()) {
      if (!statement(stmt_ctx, to)) return false;
    }
    return tree->simple() == nullptr || simple(tree->simple(), to);
  });
}

bool Bip1Converter::block(Parser::BlockContext* ctx, std::vector<Stmt>& to) {
  if (nesting_ == kMaxBlocks) return false;
  ++nesting_;
  const std::size_t comments = comments_.size();
  const bool is_read = statements(inside(ctx), to);
  if (!is_read) comments_.resize(comments);
  --nesting_;
  return is_read;
}

bool Bip1Converter::statement(Parser::StmtContext* ctx, std::vector<Stmt>& to) {
  if (ctx->simple() != nullptr) return simple(ctx->simple(), to);
  if (ctx->block() != nullptr) return block(ctx->block(), to);
  Parser::IfStmtContext* branch = ctx->ifStmt();
  if (branch == nullptr) return true;
  Stmt made{.kind = StmtKind::If, .range = range(ctx)};
  std::optional<Expr> condition = expr(branch->expr());
  if (!condition || !statement(branch->stmt(0), made.then_body)) return false;
  made.exprs.push_back(std::move(*condition));
  if (branch->stmt().size() > 1 && !statement(branch->stmt(1), made.else_body)) return false;
  to.push_back(std::move(made));
  return true;
}

bool Bip1Converter::simple(Parser::SimpleContext* ctx, std::vector<Stmt>& to) {
  Stmt made{.kind = StmtKind::Assign, .range = range(ctx)};
  made.target = path(ctx->path());
  if (ctx->LPAREN() != nullptr) {
    made.kind = StmtKind::Call;
    if (ctx->args() != nullptr) {
      for (Parser::ExprContext* arg : ctx->args()->expr()) {
        std::optional<Expr> value = expr(arg);
        if (!value) return false;
        made.exprs.push_back(std::move(*value));
      }
    }
  } else if (ctx->INC() != nullptr || ctx->DEC() != nullptr) {
    made.kind = StmtKind::Change;
    made.op = std::string(1, ctx->INC() != nullptr ? '+' : '-');
    made.exprs.push_back({.kind = ExprKind::Int, .range = made.range, .text = "1"});
  } else {
    std::optional<Expr> value = expr(ctx->expr());
    if (!value) return false;
    made.exprs.push_back(std::move(*value));
    if (ctx->CHANGE() != nullptr) {
      made.kind = StmtKind::Change;
      made.op = std::string(text(range(ctx->CHANGE()->getSymbol())).substr(0, 1));
    }
  }
  to.push_back(std::move(made));
  return true;
}

Guard Bip1Converter::guard(Parser::GuardContext* ctx) {
  if (ctx->expr() != nullptr) return guard(ctx->expr());
  Guard made{.range = inside(ctx->block()), .expr = std::nullopt};
  with_code(made.range, &Bip1Parser::guardCode, [&](Parser::GuardCodeContext* tree) {
    made.expr = expr(tree->expr());
    return made.expr.has_value();
  });
  return made;
}

Guard Bip1Converter::guard(Parser::ExprContext* ctx) { return {.range = range(ctx), .expr = expr(ctx)}; }

Data Bip1Converter::data(Parser::DataContext* ctx) {
  Data made;
  made.range = range(ctx);
  made.is_exported = ctx->EXPORT() != nullptr;
  if (ctx->typeName() == nullptr) {
    made.is_readable = declarations(inside(ctx->block()), made.vars);
    if (!made.is_readable) made.vars.clear();
    return made;
  }
  for (Parser::VarContext* var_ctx : ctx->var()) {
    Var var{.type = type(ctx->typeName()), .name = name(var_ctx->id()), .init = std::nullopt, .range = range(var_ctx)};
    if (var_ctx->expr() != nullptr) var.init = guard(var_ctx->expr());
    made.vars.push_back(std::move(var));
  }
  return made;
}

bool Bip1Converter::declarations(SourceRange code, std::vector<Var>& to) {
  return with_code(code, &Bip1Parser::dataCode, [&](Parser::DataCodeContext* tree) {
    // The variables stand between the type names, in the order of the source.
    Type current;
    for (antlr4::tree::ParseTree* child : tree->children) {
      if (auto* words = dynamic_cast<Parser::TypeNameContext*>(child)) current = type(words);
      auto* var_ctx = dynamic_cast<Parser::VarContext*>(child);
      if (var_ctx == nullptr) continue;
      Var var{.type = current, .name = name(var_ctx->id()), .init = std::nullopt, .range = range(var_ctx)};
      if (var_ctx->expr() != nullptr) var.init = guard(var_ctx->expr());
      to.push_back(std::move(var));
    }
    return true;
  });
}

std::optional<Expr> Bip1Converter::expr(Parser::ExprContext* ctx) {
  // A chain a + b + c … is a left spine.
  std::vector<Parser::ExprContext*> spine;
  while (ctx->children.size() == 3) {
    spine.push_back(ctx);
    ctx = ctx->expr(0);
  }
  std::optional<Expr> left = operand(ctx);
  for (auto at = spine.rbegin(); at != spine.rend() && left; ++at) {
    std::optional<Expr> right = expr((*at)->expr(1));
    if (!right) return std::nullopt;
    Expr both{.kind = ExprKind::Binary, .range = range(*at), .text = std::string(text(range(bip1_sign(*at))))};
    both.operands.push_back(std::move(*left));
    both.operands.push_back(std::move(*right));
    left = std::move(both);
  }
  return left;
}

std::optional<Expr> Bip1Converter::operand(Parser::ExprContext* ctx) {
  if (ctx->primary() != nullptr) return primary(ctx->primary());
  std::optional<Expr> inner = expr(ctx->expr(0));
  if (!inner) return std::nullopt;
  Expr made{.kind = ExprKind::Unary, .range = range(ctx), .text = std::string(text(range(bip1_sign(ctx))))};
  made.operands.push_back(std::move(*inner));
  return made;
}

std::optional<Expr> Bip1Converter::primary(Parser::PrimaryContext* ctx) {
  Expr made;
  made.range = range(ctx);
  made.text = std::string(text(made.range));
  if (!ctx->PRIME().empty()) {
    // 'a': its code. Blanks inside, or more letters, are no character.
    if (made.text.size() != 3) return std::nullopt;
    made.text = std::to_string(static_cast<int>(made.text[1]));
  } else if (ctx->INT() != nullptr || ctx->HEX() != nullptr) {
    made.text = decimal(made.text);
    if (made.text.empty()) return std::nullopt;
  } else if (ctx->FLOAT() != nullptr) {
    made.kind = ExprKind::Float;
  } else if (ctx->STRING() != nullptr) {
    made.kind = ExprKind::String;
  } else if (ctx->TRUE() != nullptr || ctx->FALSE() != nullptr) {
    made.kind = ExprKind::Bool;
  } else if (ctx->path() == nullptr) {
    made.kind = ExprKind::Parenthesised;
    std::optional<Expr> inner = expr(ctx->expr());
    if (!inner) return std::nullopt;
    made.operands.push_back(std::move(*inner));
  } else {
    made.kind = ctx->LPAREN() != nullptr ? ExprKind::Call : ExprKind::Variable;
    made.path = path(ctx->path());
    if (ctx->args() != nullptr) {
      for (Parser::ExprContext* arg : ctx->args()->expr()) {
        std::optional<Expr> value = expr(arg);
        if (!value) return std::nullopt;
        made.operands.push_back(std::move(*value));
      }
    }
  }
  return made;
}

}  // namespace bip::parse
