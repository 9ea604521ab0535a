// See idl.hpp. By recursive descent; a name is looked for in its scope, then in those around it.
#include "compiler/genom/idl.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "compiler/genom/check_scalar.hpp"
#include "compiler/genom/codel_arguments.hpp"
#include "compiler/genom/constant_expression.hpp"
#include "compiler/genom/cursor.hpp"
#include "compiler/genom/declarations.hpp"
#include "compiler/genom/names.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom::idl {
namespace {

// Those of the interface `genom`, which every component provides.
struct StandardException {
  const char* name;
  std::vector<std::pair<const char*, std::int64_t>> members;  // bounded strings; 0: a short
};
const std::vector<StandardException> kStandardExceptions{{"syserr", {{"code", 0}, {"what", 128}}},
                                                         {"unkown_error", {{"what", 128}}},
                                                         {"bad_transition", {{"from", 128}, {"to", 128}}},
                                                         {"bad_cpu_usage", {}},
                                                         {"too_many_activities", {}},
                                                         {"disallowed", {}},
                                                         {"interrupted", {}},
                                                         {"no_such_data", {}},
                                                         {"no_such_task", {}},
                                                         {"no_such_service", {}},
                                                         {"no_such_inport", {}},
                                                         {"no_such_outport", {}},
                                                         {"no_such_activity", {}},
                                                         {"serialization", {}},
                                                         {"port_io", {}},
                                                         {"not_running", {}}};
constexpr int kDeepest = 50;

struct Unit {
  Component part;
  std::vector<std::string> inherited, used;
};

class IdlParser {
 public:
  IdlParser(const std::vector<Token>& tokens, FileId file, Purpose purpose, Diagnostics& diags)
      : in_(tokens, diags), file_(file), purpose_(purpose) {
    for (const PrimitiveType& row : kPrimitiveTypes) {
      if (row.is_checked_only && purpose != Purpose::Check) continue;
      names_[std::string(row.idl_name)] = add({.kind = Kind::Primitive, .c_name = std::string(row.c_name)});
    }
    for (const StandardException& e : kStandardExceptions) {
      Exception exception{fmt::format("genom_{}", e.name), fmt::format("::genom::{}", e.name), {}};
      for (const auto& [name, bound] : e.members)
        exception.members.push_back({name, bound == 0 ? names_["short"] : string_of(bound), {}});
      exceptions_.push_back(std::move(exception));
    }
  }

  std::optional<Component> run() {
    while (!in_.at_end() && ok_) declaration();
    BIP_ASSERT(scope_.empty() && namespaces_ == 0 && depth_ == 0, "{} scopes, {} namespaces, {} types are open",
               scope_.size(), namespaces_, depth_);
    if (!ok_ || has_unknown_ || !component_) return std::nullopt;
    Unit unit = std::move(*component_);
    inherit_all(unit);
    unit.part.types = std::move(types_);
    for (const std::string& name : unit.used) use(unit.part, name);
    unit.part.constants = std::move(constants_);
    unit.part.exceptions = std::move(exceptions_);
    return std::move(unit.part);
  }

 private:
  void inherit_all(Unit& unit) const {
    BIP_ASSERT(unit.part.types.empty(), "{} types are of one unit alone", unit.part.types.size());
    std::set<std::string> done;
    for (std::size_t i = 0; i < unit.inherited.size(); ++i) {
      const auto found = units_.find(unit.inherited[i]);
      if (found == units_.end() || !done.insert(unit.inherited[i]).second) continue;
      inherit(unit, found->second);
    }
  }

  // Of an attribute the types are those of members of the interface's IDS.
  void use(Component& part, const std::string& name) const {
    const auto found = units_.find(name);
    part.knows_remotes = part.knows_remotes && found != units_.end();
    if (found == units_.end()) return;
    Unit from = found->second;
    inherit_all(from);
    from.part.types = part.types;
    const CodelArguments data(from.part);
    for (const Service& s : from.part.services) {
      Service remote{.name = s.name, .parameters = s.parameters, .locals = {}, .codels = {}};
      for (Parameter& p : remote.parameters) p.type = data.type_of(s, p).value_or(p.type);
      add_missing(part.remotes, {remote});
    }
  }

  template <class Row>
  static void add_missing(std::vector<Row>& rows, const std::vector<Row>& more) {
    for (const Row& row : more) {
      if (std::none_of(rows.begin(), rows.end(), [&](const Row& known) { return known.name == row.name; }))
        rows.push_back(row);
    }
  }
  static void inherit(Unit& unit, const Unit& from) {
    add_missing(unit.part.ids, from.part.ids);
    add_missing(unit.part.ports, from.part.ports);
    add_missing(unit.part.services, from.part.services);
    add_missing(unit.part.tasks, from.part.tasks);
    unit.inherited.insert(unit.inherited.end(), from.inherited.begin(), from.inherited.end());
  }

  std::size_t add(Type type) {
    BIP_ASSERT(type.element == 0 || type.element < types_.size(), "type {} is of type {}, which comes later",
               types_.size(), type.element);
    BIP_ASSERT(std::all_of(type.members.begin(), type.members.end(),
                           [&](const Member& m) { return m.type == 0 || m.type < types_.size(); }),
               "type {} has a member of a type that comes later", types_.size());
    types_.push_back(std::move(type));
    return types_.size() - 1;
  }
  // One of each, by its name in C.
  std::size_t unique(Type type) {
    for (std::size_t k = 0; k < types_.size(); ++k) {
      if (types_[k].c_name == type.c_name && types_[k].kind == type.kind && types_[k].bound == type.bound) return k;
    }
    return add(std::move(type));
  }
  std::size_t string_of(std::int64_t bound) {
    return unique(
        {.kind = Kind::String, .c_name = bound == 0 ? "string" : fmt::format("string{}", bound), .bound = bound});
  }

  [[nodiscard]] std::string scoped(const std::string& name) const {
    std::string text;
    for (const std::string& s : scope_) text += s + "::";
    return text + name;
  }
  // With its names.
  std::size_t add_named(Type t, const std::string& name) {
    const std::string full_name = scoped(name);
    BIP_ASSERT(namespaces_ <= scope_.size(), "{} of {} scopes are modules or components", namespaces_, scope_.size());
    t.full_name = full_name;
    t.c_name = in_c(full_name);
    t.namespaces = namespaces_;
    return names_[full_name] = add(std::move(t));
  }
  [[nodiscard]] static std::string in_c(std::string name) {
    for (std::size_t at = name.find("::"); at != std::string::npos; at = name.find("::")) name.replace(at, 2, "_");
    return name;
  }
  // In the innermost scope that has it.
  template <class Map>
  [[nodiscard]] auto look(const Map& map, const std::string& name) const {
    for (std::size_t n = scope_.size() + 1; n-- > 0;) {
      std::string text;
      for (std::size_t k = 0; k < n; ++k) text += scope_[k] + "::";
      if (const auto found = map.find(text + name); found != map.end()) return found;
    }
    return map.end();
  }

  bool fail(std::string_view expected) {
    if (ok_) in_.unexpected(expected);
    return ok_ = false;
  }
  bool expect(std::string_view sign) { return ok_ && (ok_ = in_.expect(sign)); }
  std::string word(std::string_view what) {
    if (in_.peek().kind == TokenKind::Word) return std::string(in_.take().text);
    fail(what);
    return {};
  }
  // a::b::c, after an optional `::`.
  std::string path(std::string_view what) {
    in_.accept("::");
    std::string text = word(what);
    while (ok_ && in_.at("::")) {
      in_.take();
      text += "::" + word(what);
    }
    return text;
  }

  // ---- declarations

  void declaration() {
    if (in_.accept(";")) return;
    if (in_.at("module") && in_.peek(2).is("{")) return block();
    if ((in_.at("interface") || in_.at("component")) && in_.peek(1).kind == TokenKind::Word) return unit();
    item();
  }

  void block() {
    in_.take();
    if (++depth_ > kDeepest) fail("a module that is not so deep");
    scope_.push_back(word("a name"));
    ++namespaces_;
    expect("{");
    while (ok_ && !in_.at("}") && !in_.at_end()) declaration();
    expect("}");
    --namespaces_;
    scope_.pop_back();
    --depth_;
  }

  void unit() {
    const bool is_module = in_.at("component") && in_.peek().range.file == file_;
    in_.take();
    unit_ = {};
    unit_.part.name = word("a name");
    scope_.push_back(unit_.part.name);
    ++namespaces_;
    const bool is_whole = in_.accept("{");
    while (is_whole && ok_ && !in_.at("}") && !in_.at_end()) item();
    if (is_whole) expect("}");
    --namespaces_;
    scope_.pop_back();
    if (!is_whole || !ok_) return;
    if (is_module && !component_) component_ = std::move(unit_);
    else units_.insert_or_assign(unit_.part.name, std::move(unit_));
  }

  void item() {
    if (in_.accept(";")) return;
    const Token& t = in_.peek();
    if (t.is("const")) return constant();
    if (t.is("typedef")) {
      in_.take();
      const std::size_t base = type();
      do {
        const Member m = declarator(base);
        add_named({.kind = Kind::Alias, .element = m.type}, m.name);
      } while (ok_ && in_.accept(","));
      expect(";");
      return;
    }
    if (t.is("struct") || t.is("union") || t.is("enum")) {
      type();
      expect(";");
      return;
    }
    if (t.is("native")) {
      in_.take();
      add_named({.kind = Kind::Native}, word("a name"));
      expect(";");
      return;
    }
    if (t.is("exception")) return exception();
    if (t.is("ids") && in_.peek(1).is("{")) return ids();
    if (t.is("port") && (in_.peek(1).is("in") || in_.peek(1).is("out") || in_.peek(1).is("multiple"))) return port();
    if (t.is("task")) return task();
    if (t.is("attribute") || t.is("function") || t.is("activity")) return service();
    if (t.is("lang") && in_.peek(1).kind == TokenKind::String) {
      in_.take();
      unit_.part.language_range = in_.peek().range;
      unit_.part.language = in_.take().text;
      expect(";");
      return;
    }
    if (t.is("provides") || t.is("provide") || t.is("extends") || t.is("extend")) {
      in_.take();
      do unit_.inherited.push_back(word("the name of an interface"));
      while (ok_ && in_.accept(","));
      expect(";");
      return;
    }
    if ((t.is("uses") || t.is("use")) && in_.peek(1).kind == TokenKind::Word) {
      in_.take();
      do unit_.used.push_back(word("the name of an interface"));
      while (ok_ && in_.accept(","));
      expect(";");
      return;
    }
    skip();
  }

  void skip() {
    while (!in_.at_end() && !in_.at(";") && !in_.at("}")) {
      if (in_.at("{")) {
        if (!in_.skip_group()) return;
      } else {
        in_.take();
      }
    }
    expect(";");
  }

  void constant() {
    in_.take();
    const std::size_t its = type();
    const SourceRange range = in_.peek().range;
    const std::string name = scoped(word("a name"));
    expect("=");
    Value value = expression({.unsigned_bits = unsigned_bits(its)});
    if (!ok_) return;
    check_scalar(plain(its), value, fmt::format("constant `{}`", name), range, in_.diags());
    value = as_type(plain(its), std::move(value));
    constants_.push_back({.c_name = in_c(name), .value = c_expression(value), .full_name = name, .type = its});
    values_[name] = std::move(value);
    expect(";");
  }

  [[nodiscard]] const Type& plain(std::size_t its) const {
    while (types_[its].kind == Kind::Alias) its = types_[its].element;
    return types_[its];
  }
  // 0: it is no unsigned integer.
  [[nodiscard]] int unsigned_bits(std::size_t its) const {
    const PrimitiveType* const row = find_primitive_type(plain(its).c_name);
    return plain(its).kind == Kind::Primitive && row != nullptr && row->is_unsigned() ? row->bits : 0;
  }

  void exception() {
    in_.take();
    const std::string name = word("the name of an exception");
    Exception e{in_c(scoped(name)), "::" + scoped(name), {}};
    if (in_.accept("{")) {
      scope_.push_back(name);
      e.members = members();
      scope_.pop_back();
      expect("}");
    }
    exceptions_.push_back(std::move(e));
    expect(";");
  }

  void ids() {
    in_.take();
    in_.take();
    scope_.emplace_back("ids");
    for (Member& m : members()) unit_.part.ids.push_back(std::move(m));
    scope_.pop_back();
    expect("}");
    in_.accept(";");
  }

  // TYPE declarator {, declarator} ; … up to `}`.
  std::vector<Member> members() {
    std::vector<Member> all;
    Declarations known;
    while (ok_ && !in_.at("}") && !in_.at_end()) {
      const std::size_t base = type();
      do {
        const SourceRange range = in_.peek().range;
        all.push_back(declarator(base));
        if (ok_) known.add(in_.diags(), "member", all.back().name, all.back().name, range);
      } while (ok_ && in_.accept(","));
      expect(";");
    }
    return all;
  }

  Member declarator(std::size_t base) {
    Member m{word("a name"), base, {}};
    std::vector<std::int64_t> bounds;
    while (ok_ && in_.accept("[")) {
      bounds.push_back(whole({}));
      expect("]");
    }
    for (std::size_t k = bounds.size(); k-- > 0;)
      m.type = add({.kind = Kind::Array, .element = m.type, .bound = bounds[k]});
    return m;
  }

  // ---- types

  std::size_t type() {
    if (++depth_ > kDeepest) fail("a type that is not so deep");
    const std::size_t result = ok_ ? type_here() : 0;
    --depth_;
    return result;
  }

  std::size_t type_here() {
    const Token first = in_.peek();
    if (in_.at("struct") || in_.at("union") || in_.at("enum")) return defined();
    if (in_.accept("sequence") || in_.accept("optional")) {
      expect("<");
      const std::size_t element = type();
      const bool is_sequence = first.is("sequence");
      const std::int64_t bound = is_sequence && in_.accept(",") ? whole({.ends_with_angle = true}) : 0;
      expect(">");
      const std::string of = c_part(element);
      return unique({.kind = is_sequence ? Kind::Sequence : Kind::Optional,
                     .c_name = !is_sequence ? "optional_" + of
                               : bound == 0 ? "sequence_" + of
                                            : fmt::format("sequence{}_{}", bound, of),
                     .element = element,
                     .bound = bound});
    }
    if (in_.accept("string")) {
      std::int64_t bound = 0;
      if (in_.accept("<")) {
        bound = whole({.ends_with_angle = true});
        expect(">");
      }
      return string_of(bound);
    }
    if (purpose_ == Purpose::Check && in_.accept("fixed")) {
      while (!in_.at_end() && !in_.at(">") && !in_.at(";")) in_.take();
      expect(">");
      return names_["double"];
    }
    std::string name;
    if (in_.accept("unsigned")) name = "unsigned ";
    if (in_.at("long") && (in_.peek(1).is("long") || (purpose_ == Purpose::Check && in_.peek(1).is("double")))) {
      in_.take();
      name += "long ";
    }
    name += path("a type");
    const auto found = look(names_, name);
    if (found != names_.end()) return found->second;
    if (!ok_) return 0;
    // One report a name.
    if (unknown_.insert(name).second) {
      auto d = in_.diags().report(Diag::kB6008, first.range, "type", name);
      for (const std::string& similar : similar_names(name, type_names()))
        d.help(fmt::format("there is `{}`", similar), first.range, similar);
    }
    has_unknown_ = true;
    return 0;
  }

  [[nodiscard]] std::vector<std::string> type_names() const {
    std::vector<std::string> all;
    // Without the scope in which they are looked for.
    const std::string prefix = scope_.empty() ? "" : scope_.front() + "::";
    for (const auto& [name, type] : names_) all.push_back(name.starts_with(prefix) ? name.substr(prefix.size()) : name);
    return all;
  }

  // Of arrays: the array has no name in C.
  [[nodiscard]] std::string c_part(std::size_t t) const {
    return types_[t].kind == Kind::Array ? fmt::format("{}_{}", c_part(types_[t].element), types_[t].bound)
                                         : types_[t].c_name;
  }

  std::size_t defined() {
    const std::string what(in_.take().text);
    const std::string name = word("a name");
    if (!in_.at("{") && !in_.at("switch")) {
      const auto known = look(names_, name);
      if (known != names_.end()) return known->second;
      // `struct node;`: it is defined later.
      if (purpose_ == Purpose::Check && what != "enum" && in_.at(";")) return add_named({.kind = Kind::Struct}, name);
      fail("`{`");
      return 0;
    }
    Type t{.kind = what == "enum" ? Kind::Enum : what == "union" ? Kind::Union : Kind::Struct};
    if (what == "enum") enumerators(t);
    scope_.push_back(name);
    if (what == "union") cases(t);
    if (what == "struct") {
      expect("{");
      t.members = members();
      expect("}");
    }
    scope_.pop_back();
    return add_named(std::move(t), name);
  }

  // They belong to the scope around the enumeration.
  void enumerators(Type& t) {
    t.prefix = in_c(scoped(""));
    expect("{");
    do {
      const SourceRange range = in_.peek().range;
      t.enumerators.push_back(word("a name"));
      const std::string& name = t.enumerators.back();
      if (ok_) enumerator_declarations_.add(in_.diags(), "enumerator", name, scoped(name), range);
      enumerators_[scoped(t.enumerators.back())] = t.prefix + t.enumerators.back();
    } while (ok_ && in_.accept(","));
    expect("}");
  }

  void cases(Type& t) {
    in_.take();
    expect("(");
    t.element = type();
    expect(")");
    expect("{");
    while (ok_ && !in_.at("}") && !in_.at_end()) {
      std::vector<std::string> labels;
      bool is_default = false;
      while (ok_ && (in_.at("case") || in_.at("default"))) {
        if (in_.take().is("default")) is_default = true;
        else labels.push_back(label());
        expect(":");
      }
      Member m = declarator(type());
      if (!is_default) m.labels = std::move(labels);
      t.members.push_back(std::move(m));
      expect(";");
    }
    expect("}");
  }

  std::string label() { return c_expression(expression({})); }

  // ---- expressions

  [[nodiscard]] std::optional<Value> find_constant(const std::string& name) const {
    if (const auto value = look(values_, name); value != values_.end()) return value->second;
    const auto enumerator = look(enumerators_, name);
    if (enumerator == enumerators_.end()) return std::nullopt;
    return Value{.kind = ValueKind::Enumerator,
                 .text = name.substr(name.rfind(':') == std::string::npos ? 0 : name.rfind(':') + 1),
                 .c_name = enumerator->second};
  }

  Value expression(const ExpressionContext& context) {
    if (!ok_) return {.kind = ValueKind::Error};
    std::optional<Value> value = read_constant_expression(
        in_, [this](const std::string& name) { return find_constant(name); }, context);
    ok_ = value.has_value();
    return std::move(value).value_or(Value{.kind = ValueKind::Error});
  }

  // A bound.
  std::int64_t whole(const ExpressionContext& context) {
    const Value value = expression(context);
    if (value.kind == ValueKind::Error) return 1;
    if (value.kind == ValueKind::Integer && value.integer > 0 && value.integer <= 1'000'000'000)
      return static_cast<std::int64_t>(value.integer);
    fail("a number from 1 to 1000000000 before this");
    return 0;
  }

  // An initial value: an expression, or { .member = 0.1 : "doc", … }. `its`: the type, if it is known.
  Value initial(std::optional<std::size_t> its) {
    while (its && plain(*its).kind == Kind::Optional) its = plain(*its).element;
    const SourceRange range = in_.peek().range;
    if (!in_.at("{")) return expression({.unsigned_bits = its ? unsigned_bits(*its) : 0, .may_be_enumerator = true});
    if (++depth_ > kDeepest) fail("a value that is not so deep");
    expect("{");
    Value group{.kind = in_.at(".") ? ValueKind::Object : ValueKind::List, .range = range};
    while (ok_ && !in_.at("}") && !in_.at_end()) {
      std::optional<std::size_t> part;
      if (group.kind == ValueKind::Object) {
        expect(".");
        group.names.push_back(word("a member"));
        expect("=");
        if (its) part = member_of(plain(*its).members, group.names.back());
      } else if (its && (plain(*its).kind == Kind::Array || plain(*its).kind == Kind::Sequence)) {
        part = plain(*its).element;
      }
      group.parts.push_back(initial(part));
      description();
      if (!in_.accept(",")) break;
    }
    expect("}");
    --depth_;
    return group;
  }
  static std::optional<std::size_t> member_of(const std::vector<Member>& members, const std::string& name) {
    for (const Member& m : members) {
      if (m.name == name) return m.type;
    }
    return std::nullopt;
  }
  // Of an attribute, if its member of the IDS stands before it.
  [[nodiscard]] std::optional<std::size_t> type_at(const std::vector<std::string>& path_) const {
    BIP_ASSERT(!path_.empty(), "an attribute without a path");
    std::optional<std::size_t> its = member_of(unit_.part.ids, path_.front());
    for (std::size_t k = 1; its && k < path_.size(); ++k) {
      const Type& t = plain(*its);
      if (path_[k].starts_with("["))
        its = t.kind == Kind::Array || t.kind == Kind::Sequence ? std::optional(t.element) : std::nullopt;
      else its = member_of(t.members, path_[k]);
    }
    return its;
  }
  // [: "text" "text"]
  void description() {
    if (!in_.accept(":")) return;
    while (in_.peek().kind == TokenKind::String) in_.take();
  }

  // ---- what a component has

  void port() {
    in_.take();
    Port p;
    p.is_multiple = in_.accept("multiple");
    p.is_out = in_.take().is("out");
    p.type = type();
    const Member m = declarator(p.type);
    p.type = m.type;
    p.name = m.name;
    unit_.part.ports.push_back(std::move(p));
    if (in_.at("{")) in_.skip_group();
    expect(";");
  }

  bool direction(Direction& into) {
    if (in_.accept("in")) into = Direction::In;
    else if (in_.accept("out")) into = Direction::Out;
    else if (in_.accept("inout")) into = Direction::InOut;
    else return fail("`in`, `out` or `inout`");
    return true;
  }

  // codel [<ev, …>] id(arguments) …
  Codel codel() {
    Codel c;
    if (in_.accept("<")) {
      while (!in_.at(">") && !in_.at_end()) in_.take();
      expect(">");
    }
    c.name = word("the name of a codel");
    expect("(");
    while (ok_ && !in_.at(")") && !in_.at_end()) {
      c.arguments.push_back(argument());
      if (!in_.accept(",")) break;
    }
    expect(")");
    while (!in_.at(";") && !in_.at_end()) in_.take();
    expect(";");
    return c;
  }

  static bool is_direction(const Token& t) { return t.is("in") || t.is("out") || t.is("inout"); }

  Argument argument() {
    Argument a;
    a.range = in_.peek().range;
    if (in_.peek().kind == TokenKind::Word && is_direction(in_.peek(1)) && !is_direction(in_.peek())) {
      const Token place = in_.take();
      a.place = place.is("ids")      ? Place::Ids
                : place.is("local")  ? Place::Local
                : place.is("port")   ? Place::Port
                : place.is("remote") ? Place::Remote
                                     : Place::Any;
      if (a.place == Place::Any) fail("`ids`, `local`, `port` or `remote`");
    }
    if (!direction(a.direction)) return a;
    if (!in_.accept("::")) {
      a.path.push_back(word("a name"));
      steps(a.path);
      if (!in_.accept("::")) return a;
    }
    word("a name");
    return a;
  }

  // .member, [3]
  void steps(std::vector<std::string>& path_) {
    while (ok_ && (in_.at(".") || in_.at("["))) {
      if (in_.accept(".")) {
        path_.push_back(word("a member"));
        continue;
      }
      in_.take();
      path_.push_back("[" + c_expression(expression({})) + "]");
      expect("]");
    }
  }

  void task() {
    in_.take();
    Task t;
    t.name = word("the name of a task");
    if (in_.accept("{")) {
      while (ok_ && !in_.at("}") && !in_.at_end()) property(t.locals, t.codels, {t.name});
      expect("}");
    }
    unit_.part.tasks.push_back(std::move(t));
    expect(";");
  }

  void property(std::vector<Member>& locals, std::vector<Codel>& codels, const std::string& owner) {
    if (in_.at("async") && in_.peek(1).is("codel")) in_.take();
    if (in_.accept("codel") || in_.accept("validate")) {
      codels.push_back(codel());
    } else if (in_.accept("local")) {
      scope_.push_back(owner);
      const std::size_t base = type();
      do locals.push_back(declarator(base));
      while (ok_ && in_.accept(","));
      scope_.pop_back();
      expect(";");
    } else {
      skip();
    }
  }

  void service() {
    Service s;
    const bool is_attribute = in_.at("attribute");
    s.kind = is_attribute ? ServiceKind::Attribute : in_.at("activity") ? ServiceKind::Activity : ServiceKind::Function;
    in_.take();
    s.name = word("the name of a service");
    expect("(");
    while (ok_ && !in_.at(")") && !in_.at_end()) {
      Parameter p;
      if (!direction(p.direction)) return;
      p.range = in_.peek().range;
      if (is_attribute) {
        p.path.push_back(word("a member of the IDS"));
        steps(p.path);
        p.name = p.path.back();
        if (in_.accept("::")) p.name = word("a name");
      } else {
        const Member m = declarator(type());
        p.name = m.name;
        p.type = m.type;
      }
      if (in_.accept("=") && !in_.at(":") && !in_.at(",") && !in_.at(")"))
        p.initial = initial(is_attribute ? type_at(p.path) : std::optional(p.type));
      description();
      s.parameters.push_back(std::move(p));
      if (!in_.accept(",")) break;
    }
    expect(")");
    if (in_.accept("{")) {
      while (ok_ && !in_.at("}") && !in_.at_end()) property(s.locals, s.codels, s.name);
      expect("}");
    }
    unit_.part.services.push_back(std::move(s));
    expect(";");
  }

  Cursor in_;
  FileId file_;
  Purpose purpose_;
  bool ok_ = true;
  bool has_unknown_ = false;
  std::set<std::string> unknown_;
  int depth_ = 0;
  std::vector<std::string> scope_;
  std::size_t namespaces_ = 0;  // so many of them are modules or components
  std::vector<Type> types_;
  std::vector<Constant> constants_;
  std::vector<Exception> exceptions_;
  std::map<std::string, std::size_t> names_;        // of types
  std::map<std::string, Value> values_;             // of constants
  std::map<std::string, std::string> enumerators_;  // in C
  Declarations enumerator_declarations_;
  Unit unit_;
  std::optional<Unit> component_;
  std::map<std::string, Unit> units_;
};

}  // namespace

std::optional<Component> read_idl(const std::vector<Token>& tokens, FileId file, Purpose purpose, Diagnostics& diags) {
  return IdlParser(tokens, file, purpose, diags).run();
}

}  // namespace bip::genom::idl
