// GenoM 3 components: properties, tasks, ports, attributes, functions, activities. IDL is read for the names that it
// declares, not for layouts. Words of GenoM may be names, so a word counts by where it stands.
#include "compiler/genom/parse_genom3.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compiler/genom/constant_expression.hpp"
#include "compiler/genom/declarations.hpp"
#include "compiler/genom/parse_genom.hpp"

namespace bip::genom {
namespace {

using v3::ParsedCodel;

/// Those of the interface `genom`, which every component provides.
const std::set<std::string_view> kStandardExceptions{
    "unkown_error",   "syserr",          "bad_cpu_usage",    "too_many_activities", "disallowed",
    "interrupted",    "bad_transition",  "no_such_data",     "no_such_task",        "no_such_service",
    "no_such_inport", "no_such_outport", "no_such_activity", "unknown_error",       "serialization",
    "port_io",        "not_running"};

bool is_one_of(const Token& token, std::initializer_list<std::string_view> words) {
  for (const std::string_view w : words) {
    if (token.is(w)) return true;
  }
  return false;
}

/// As written: whether it is complete is checked when it is known to be of the module.
struct ParsedTask {
  Task task;
  std::vector<ParsedCodel> codels;
  std::set<std::string> locals;
  std::vector<Name> thrown;
};
struct ParsedService {
  Service service;
  std::string kind;
  std::vector<ParsedCodel> codels;
  std::set<std::string> locals;
};
/// A component or an interface.
struct Unit {
  Name name;
  std::vector<ParsedTask> tasks;
  std::vector<ParsedService> services;
  std::vector<Poster> posters;
  std::set<std::string> members, ports;
  std::vector<Name> inherited;  // what it provides and extends
  std::vector<Name> used;
  std::vector<Name> thrown;  // by every service
};

class Genom3Parser {
 public:
  Genom3Parser(const std::vector<Token>& tokens, FileId file, Headers headers, Diagnostics& diags)
      : in_(tokens, diags), diags_(diags), first_(tokens.front().range), file_(file) {
    module_.is_open = headers == Headers::Missing;
    module_.generation = 3;
  }

  Module run() {
    while (!in_.at_end()) {
      const bool is_unit = is_one_of(in_.peek(), {"component", "interface"});
      if (is_unit) {
        if (!declaration()) in_.skip_past_semicolon();
      } else if (!idl()) {
        if (in_.at("}")) in_.take();
        in_.skip_past_semicolon();
      }
    }
    if (component_) {
      finish_module(*component_);
    } else if (!diags_.has_errors()) {
      diags_.report(Diag::kB6014, first_, "component");
    }
    v3::settle_uses(module_, scopes_, diags_);
    return std::move(module_);
  }

 private:
  // The component of the description itself is the module. An interface, or a component of an included file, is what
  // it provides, extends or uses.
  bool declaration() {
    const bool is_module = in_.peek().is("component") && in_.peek().range.file == file_;
    in_.take();
    unit_ = {};
    if (!in_.name(unit_.name, "the name of a component")) return false;
    const std::string outer = std::exchange(scope_, scope_ + unit_.name.text + "::");
    const bool is_declared_only = in_.at(";");
    const bool is_sound = unit_body();
    scope_ = outer;
    if (is_declared_only) return is_sound;
    if (is_module && component_) {
      diags_.report(Diag::kB6025, unit_.name.range, component_->name.text, unit_.name.text)
          .label(component_->name.range, "the first one");
    } else if (is_module) {
      component_ = std::move(unit_);
    } else {
      const std::string name = unit_.name.text;
      units_.insert_or_assign(name, std::move(unit_));
    }
    return is_sound;
  }

  bool unit_body() {
    if (in_.accept("{")) {
      while (!in_.at("}") && !in_.at_end()) {
        if (!item()) in_.skip_past_semicolon();
      }
      if (!in_.expect("}")) return false;
    }
    in_.accept(";");
    return true;
  }

  const Unit* unit_of(const Name& name) {
    const auto found = units_.find(name.text);
    if (found != units_.end()) return &found->second;
    if (!module_.is_open) diags_.report(Diag::kB6008, name.range, "interface", name.text);
    return nullptr;
  }

  template <class Row>
  static const Name& name_of(const Row& row) {
    if constexpr (requires { row.task.name; }) return row.task.name;
    else if constexpr (requires { row.service.name; }) return row.service.name;
    else return row.name;
  }
  // What the component declares itself goes before what an interface declares.
  template <class Row>
  static void add_missing(std::vector<Row>& rows, const std::vector<Row>& more) {
    for (const Row& row : more) {
      const bool is_known = std::any_of(rows.begin(), rows.end(),
                                        [&](const Row& known) { return name_of(known).text == name_of(row).text; });
      if (!is_known) rows.push_back(row);
    }
  }

  void declare(const char* kind, const Name& name) {
    declared_.add(diags_, kind, name.text, fmt::format("{} {}{}", kind, scope_, name.text), name.range);
  }

  // Reports interfaces that provide or extend themselves, also by way of others: one error for each cycle.
  void no_ring() {
    std::set<std::string> told;
    for (const auto& [name, unit] : units_) {
      if (told.contains(name)) continue;
      std::set<std::string> seen;
      std::vector<const Unit*> todo{&unit};
      for (std::size_t i = 0; i < todo.size(); ++i) {
        for (const Name& next : todo[i]->inherited) {
          if (next.text == name) {
            auto d = diags_.report(Diag::kB6029, next.range, name);
            d.label(unit.name.range, "it is declared here");
            told.insert(seen.begin(), seen.end());
            todo.resize(i + 1);
            break;
          }
          const auto found = units_.find(next.text);
          if (found != units_.end() && seen.insert(next.text).second) todo.push_back(&found->second);
        }
      }
    }
  }

  // Linear in what is inherited; an interface that comes twice is taken once.
  void inherit(Unit& unit) {
    std::set<std::string> done{unit.name.text};
    std::vector<Name> todo = unit.inherited;
    for (std::size_t i = 0; i < todo.size(); ++i) {
      const Name name = todo[i];
      const Unit* const from = unit_of(name);
      if (from == nullptr || !done.insert(name.text).second) continue;
      add_missing(unit.tasks, from->tasks);
      add_missing(unit.services, from->services);
      add_missing(unit.posters, from->posters);
      unit.members.insert(from->members.begin(), from->members.end());
      unit.ports.insert(from->ports.begin(), from->ports.end());
      todo.insert(todo.end(), from->inherited.begin(), from->inherited.end());
    }
    for (const Name& name : unit.used) (void)unit_of(name);
  }

  void finish_module(Unit& unit) {
    no_ring();
    inherit(unit);
    module_.name = unit.name;
    module_.posters = std::move(unit.posters);
    for (const std::string& port : unit.ports) {
      const bool is_out = std::any_of(module_.posters.begin(), module_.posters.end(),
                                      [&](const Poster& poster) { return poster.name.text == port; });
      module_.ports.push_back({port, "", is_out});
    }
    scopes_.members = std::move(unit.members);
    scopes_.ports = std::move(unit.ports);
    for (ParsedTask& parsed : unit.tasks) {
      Task& task = parsed.task;
      known_exceptions(parsed.thrown);
      if (!parsed.codels.empty()) task.activity = v3::make_activity(parsed.codels, task.name, "task", diags_);
      scopes_.task_locals.push_back(std::move(parsed.locals));
      module_.tasks.push_back(std::move(task));
    }
    for (ParsedService& parsed : unit.services) {
      std::vector<Name>& reports = parsed.service.reports;
      reports.insert(reports.end(), unit.thrown.begin(), unit.thrown.end());
      finish(parsed.service, parsed.kind, parsed.codels);
      scopes_.service_locals.push_back(std::move(parsed.locals));
      module_.services.push_back(std::move(parsed.service));
    }
  }

  void known_exceptions(const std::vector<Name>& names) {
    for (const Name& name : names) {
      if (!module_.is_open && !exceptions_.contains(name.text) && !kStandardExceptions.contains(name.text))
        diags_.report(Diag::kB6008, name.range, "exception", name.text);
    }
  }

  bool item() {
    const Token& word = in_.peek();
    if (word.is("ids") && in_.peek(1).is("{")) return ids();
    if (word.is("task")) return task();
    if (word.is("port")) return port();
    if (word.is("attribute")) return service("attribute");
    if (word.is("function")) return service("function");
    if (word.is("activity")) return service("activity");
    if (is_one_of(word, {"provide", "provides", "extend", "extends"})) return interfaces(unit_.inherited);
    if (is_one_of(word, {"use", "uses"})) return interfaces(unit_.used);
    if (in_.accept("throw") || in_.accept("throws")) return exceptions(unit_.thrown) && in_.expect(";");
    if (is_property(word)) return skip_property();
    return idl();
  }

  bool interfaces(std::vector<Name>& into) {
    in_.take();
    return in_.names(into, "the name of an interface") && in_.expect(";");
  }

  static bool is_property(const Token& word) {
    return is_one_of(word, {"doc", "version", "lang", "email", "require", "requires", "codels", "clock", "stack",
                            "throw", "throws", "scheduling", "size"});
  }

  bool skip_property() {
    while (!in_.at_end() && !in_.at(";") && !in_.at("}")) in_.take();
    return in_.expect(";");
  }

  // typedef, struct, const …: a constant is kept, of the rest the end is looked for.
  bool idl() {
    if (in_.at("const")) return constant();
    if (in_.peek().kind != TokenKind::Word) {
      in_.unexpected("a declaration");
      in_.take();
      return false;
    }
    if (in_.at("module") && in_.peek(2).is("{")) return idl_module();
    if (in_.at("exception")) {
      const Name name{std::string(in_.peek(1).text), in_.peek(1).range};
      if (in_.peek(1).kind == TokenKind::Word) declare("exception", name);
      exceptions_.insert(name.text);
    }
    static const std::set<std::string_view> kBegins{"typedef",   "struct",   "union",  "enum",      "native",
                                                    "exception", "sequence", "string", "interface", "component"};
    if (!kBegins.contains(in_.peek().text)) {
      in_.unexpected("a declaration");
      return false;
    }
    while (!in_.at_end() && !in_.at(";") && !in_.at("}")) {
      if (in_.at("{")) {
        if (!in_.skip_group()) return false;
      } else {
        in_.take();
      }
    }
    return in_.expect(";");
  }

  bool idl_module() {
    in_.take();
    const std::string outer = std::exchange(scope_, scope_ + std::string(in_.take().text) + "::");
    in_.take();
    while (!in_.at("}") && !in_.at_end()) {
      if (!idl()) in_.skip_past_semicolon();
    }
    scope_ = outer;
    if (!in_.expect("}")) return false;
    in_.accept(";");
    return true;
  }

  // const TYPE name = expression; What is wrong with it is reported where types are read (idl.cpp).
  bool constant() {
    std::string name;
    SourceRange range;
    for (in_.take(); !in_.at_end() && !in_.at("=") && !in_.at(";"); in_.take()) {
      name = in_.peek().text;
      range = in_.peek().range;
    }
    if (!in_.expect("=")) return false;
    Diagnostics unheard;
    const std::vector<Token> tokens = tokens_up_to(";");
    Cursor in(tokens, unheard);
    const std::optional<idl::Value> value = idl::read_constant_expression(in, finder(), {});
    idl::Value known = value && in.at(";") ? *value : idl::Value{.kind = idl::ValueKind::Error};
    known.range = range;
    // Without its scope for who provides or extends the interface.
    constants_[name] = constants_[scope_ + name] = known;
    return in_.expect(";");
  }

  // Up to one of these signs, which is in the result as well.
  std::vector<Token> tokens_up_to(std::string_view ends) {
    std::vector<Token> tokens;
    while (!in_.at_end() &&
           !(in_.peek().kind == TokenKind::Sign && ends.find(in_.peek().text) != std::string_view::npos))
      tokens.push_back(in_.take());
    tokens.push_back(in_.peek());
    Token end = in_.peek();
    end.kind = TokenKind::End;
    tokens.push_back(end);
    return tokens;
  }

  // `max` or `robot::max`: of the scope, or of one around it.
  [[nodiscard]] idl::FindConstant finder() {
    return [this](const std::string& name) -> std::optional<idl::Value> {
      std::string scope = scope_;
      while (true) {
        if (const auto found = constants_.find(scope + name); found != constants_.end()) {
          if (found->second.kind == idl::ValueKind::Error) without_value_ = found->second.range;
          return found->second;
        }
        if (scope.empty()) return std::nullopt;
        scope.resize(scope.size() - 2);
        const std::size_t outer = scope.rfind("::");
        scope.resize(outer == std::string::npos ? 0 : outer + 2);
      }
    };
  }

  bool ids() {
    in_.take();
    in_.take();
    while (!in_.at("}") && !in_.at_end()) {
      std::vector<Name> names;
      if (!v3::parse_declared_names(in_, names) || !in_.expect(";")) return false;
      for (const Name& name : names) {
        declare("ids member", name);
        unit_.members.insert(name.text);
      }
    }
    if (!in_.expect("}")) return false;
    in_.accept(";");
    return true;
  }

  bool port() {
    in_.take();
    in_.accept("multiple");
    const bool is_out = in_.at("out");
    if (!in_.accept("in") && !in_.accept("out")) {
      in_.unexpected("`in` or `out`");
      return false;
    }
    std::vector<Name> names;
    if (!v3::parse_declared_names(in_, names)) return false;
    for (const Name& name : names) {
      declare("port", name);
      if (unit_.ports.insert(name.text).second && is_out) unit_.posters.push_back({name, {}, 0, false});
    }
    if (in_.at("{") && !in_.skip_group()) return false;
    return in_.expect(";");
  }

  bool task() {
    in_.take();
    ParsedTask parsed;
    if (!in_.name(parsed.task.name, "the name of a task")) return false;
    if (in_.accept("{")) {
      while (!in_.at("}") && !in_.at_end()) {
        if (!task_property(parsed)) in_.skip_past_semicolon();
      }
      if (!in_.expect("}")) return false;
    }
    unit_.tasks.push_back(std::move(parsed));
    return in_.expect(";");
  }

  bool task_property(ParsedTask& parsed) {
    Task& task = parsed.task;
    if (in_.at("period") || in_.at("delay")) {
      const bool is_period = in_.at("period");
      const SourceRange range = in_.take().range;
      if (!duration(is_period ? task.period_us : task.delay_us)) return false;
      if (is_period && task.period_us == 0) diags_.report(Diag::kB6030, range, task.name.text);
      return in_.expect(";");
    }
    if (in_.at("codel") || (in_.at("async") && in_.peek(1).is("codel"))) return codel(parsed.codels);
    if (in_.at("local")) return local(parsed.locals);
    if (in_.accept("throw") || in_.accept("throws")) return exceptions(parsed.thrown) && in_.expect(";");
    if (in_.at("priority") || is_property(in_.peek())) return skip_property();
    auto d = diags_.report(Diag::kB6011, in_.peek().range, in_.peek().text, fmt::format("task `{}`", task.name.text));
    d.help("a task has `period`, `delay`, `priority`, `scheduling`, `stack`, `codel`, `throw`, `doc`");
    return false;
  }

  // `1ms` is one word: a number, then its unit.
  static void split_unit(std::vector<Token>& tokens) {
    // Before the sign that ends it.
    if (tokens.size() < 3) return;
    const auto last = tokens.end() - 3;
    if (last->kind != TokenKind::Number || last->text.starts_with("0x")) return;
    const std::size_t digits = last->text.find_last_of("0123456789.") + 1;
    Token unit = *last;
    unit.kind = TokenKind::Word;
    unit.text.remove_prefix(digits);
    if (!is_one_of(unit, {"s", "sec", "ms", "us"})) return;
    last->text = last->text.substr(0, digits);
    tokens.insert(last + 1, unit);
  }

  // EXPRESSION [s|ms|us], in microseconds, to the nearest one.
  bool duration(std::int64_t& into) {
    const SourceRange range = in_.peek().range;
    std::vector<Token> tokens = tokens_up_to(";}");
    split_unit(tokens);
    Cursor in(tokens, diags_);
    const std::size_t errors = diags_.error_count();
    const std::optional<idl::Value> value = idl::read_constant_expression(in, finder(), {});
    if (!value) return false;
    if (value->kind == idl::ValueKind::Error) {
      // The error of a constant is not reported here.
      if (diags_.error_count() == errors)
        diags_.report(Diag::kB6031, range, "a constant in it has none").label(without_value_, "this one");
      return false;
    }
    if (value->kind != idl::ValueKind::Integer && value->kind != idl::ValueKind::Real) {
      diags_.report(Diag::kB6000, range, "a time", idl::name_of(value->kind));
      return false;
    }
    std::int64_t unit = 1'000'000;
    if (is_one_of(in.peek(), {"s", "sec", "ms", "us"})) {
      const Token& name = in.take();
      unit = name.is("ms") ? 1000 : name.is("us") ? 1 : 1'000'000;
    }
    if (!in.at(";") && !in.at("}")) {
      in.unexpected("`s`, `ms`, `us` or the end of the time");
      return false;
    }
    const bool is_whole = value->kind == idl::ValueKind::Integer;
    const double number = is_whole ? static_cast<double>(value->integer) : value->real;
    if (!(number >= 0 && number <= 1e9)) {
      diags_.report(Diag::kB6010, range, "a time", idl::json_of(*value), 0, 1'000'000'000);
      return false;
    }
    into =
        is_whole ? static_cast<std::int64_t>(value->integer) * unit : std::llround(number * static_cast<double>(unit));
    return true;
  }

  bool codel(std::vector<ParsedCodel>& codels) {
    ParsedCodel parsed;
    parsed.codel.is_async = in_.accept("async");
    in_.take();
    if (!v3::parse_codel(in_, parsed)) return false;
    // A dialect: what the codel may take; an `async` one is given up then.
    const SourceRange range = in_.peek().range;
    const bool has_time = in_.accept("wcet");
    const bool is_time_sound = !has_time || duration(parsed.codel.budget_us);
    if (has_time && is_time_sound && parsed.codel.budget_us == 0)
      diags_.report(Diag::kB6034, range, parsed.codel.name.text);
    codels.push_back(std::move(parsed));
    return is_time_sound && in_.expect(";");
  }

  bool local(std::set<std::string>& locals) {
    in_.take();
    std::vector<Name> names;
    if (!v3::parse_declared_names(in_, names)) return false;
    for (const Name& name : names) locals.insert(name.text);
    return in_.expect(";");
  }

  bool service(const std::string& kind) {
    in_.take();
    ParsedService parsed{.service = {}, .kind = kind, .codels = {}, .locals = {}};
    Service& s = parsed.service;
    if (!in_.name(s.name, fmt::format("the name of a {}", kind))) return false;
    s.kind = kind == "activity" ? ServiceKind::Execution : ServiceKind::Control;
    std::vector<DataUse> uses;
    if (!v3::parse_parameters(in_, kind == "attribute" ? v3::ParametersOf::Attribute : v3::ParametersOf::Codel,
                              parsed.locals, uses, s.inputs))
      return false;
    if (kind == "attribute") s.body.push_back({{}, std::move(uses)});
    if (in_.accept("{")) {
      while (!in_.at("}") && !in_.at_end()) {
        if (!service_property(s, kind, parsed.codels, parsed.locals)) in_.skip_past_semicolon();
      }
      if (!in_.expect("}")) return false;
    }
    unit_.services.push_back(std::move(parsed));
    return in_.expect(";");
  }

  // Of `robot::e_rate` the last name counts.
  bool exceptions(std::vector<Name>& into) {
    do {
      Name name;
      if (!in_.name(name, "the name of an exception")) return false;
      while (in_.accept("::")) {
        if (!in_.name(name, "the name of an exception")) return false;
      }
      into.push_back(std::move(name));
    } while (in_.accept(","));
    return true;
  }

  bool service_property(Service& s, const std::string& kind, std::vector<ParsedCodel>& codels,
                        std::set<std::string>& locals) {
    const Token& word = in_.peek();
    if (word.is("task")) {
      in_.take();
      return in_.name(s.task, "the name of a task") && in_.expect(";");
    }
    if (is_one_of(word, {"interrupt", "interrupts"})) {
      in_.take();
      s.interrupts_all = s.interrupts_all || in_.accept("all");
      return (s.interrupts_all || in_.names(s.interrupts, "`all` or the name of a service")) && in_.expect(";");
    }
    if (is_one_of(word, {"before", "after"})) {
      std::vector<Name>& list = in_.take().text == "before" ? s.before : s.after;
      return in_.names(list, "the name of a service") && in_.expect(";");
    }
    if (is_one_of(word, {"throw", "throws"})) {
      in_.take();
      return exceptions(s.reports) && in_.expect(";");
    }
    if (word.is("validate")) {
      in_.take();
      Codel validate;
      if (!v3::parse_call(in_, validate)) return false;
      if (s.validate.name.is_set())
        diags_.report(Diag::kB6005, validate.name.range, "validate", fmt::format("{} `{}`", kind, s.name.text))
            .label(s.validate.name.range, "the first one");
      s.validate = std::move(validate);
      return in_.expect(";");
    }
    if (word.is("codel") || (word.is("async") && in_.peek(1).is("codel"))) return codel(codels);
    if (word.is("local")) return local(locals);
    if (is_property(word)) return skip_property();
    auto d = diags_.report(Diag::kB6011, word.range, word.text, fmt::format("{} `{}`", kind, s.name.text));
    d.help("a service has `task`, `validate`, `codel`, `local`, `interrupt`, `before`, `after`, `throw`, `doc`");
    return false;
  }

  void finish(Service& s, const std::string& kind, std::vector<ParsedCodel>& codels) {
    const std::string owner = fmt::format("{} `{}`", kind, s.name.text);
    known_exceptions(s.reports);
    s.validate_fails = !s.reports.empty();
    s.body_fails = !s.reports.empty();
    if (s.kind == ServiceKind::Execution) {
      if (!s.task.is_set()) diags_.report(Diag::kB6007, s.name.range, owner, "task");
      s.activity = v3::make_activity(codels, s.name, kind, diags_);
      return;
    }
    if (s.task.is_set()) diags_.report(Diag::kB6020, s.task.range, owner).help("an `activity` has a task");
    for (ParsedCodel& c : codels) {
      if (kind == "attribute")
        diags_.report(Diag::kB6011, c.codel.name.range, "codel", owner)
            .help("an attribute is read or set, and has `validate` at most; a `function` has codels");
      else if (!c.states.empty())
        diags_.report(Diag::kB6020, c.states.front().range, owner).help("an `activity` has states");
      else if (!c.yields.empty())
        diags_.report(Diag::kB6020, c.yields.front().name.range, owner).help("a codel of an `activity` yields states");
      if (c.codel.is_async)
        diags_.report(Diag::kB6024, c.codel.name.range, c.codel.name.text,
                      "which only codels of activities and tasks can be");
      s.body.push_back(std::move(c.codel));
    }
    if (kind == "attribute") s.body_fails = false;
  }

  Cursor in_;
  Diagnostics& diags_;
  SourceRange first_;
  FileId file_;
  Module module_;
  v3::Scopes scopes_;
  Unit unit_;  // that is read now
  std::optional<Unit> component_;
  std::map<std::string, Unit> units_;  // interfaces, and components of included files
  std::set<std::string> exceptions_;
  Declarations declared_;                        // "port robot::speed"
  std::string scope_;                            // "robot::" inside of interface or module robot
  std::map<std::string, idl::Value> constants_;  // with their scopes, "robot::max"; of kind Error: without a value
  SourceRange without_value_;                    // the constant that was looked for last and has no value
};

}  // namespace

Module parse_genom3(const std::vector<Token>& tokens, FileId file, Headers headers, Diagnostics& diags) {
  return Genom3Parser(tokens, file, headers, diags).run();
}

bool is_genom3(const std::vector<Token>& tokens) {
  std::size_t depth = 0;
  for (std::size_t i = 0; i + 1 < tokens.size(); ++i) {
    const Token& t = tokens[i];
    if (t.is("{")) ++depth;
    if (t.is("}") && depth > 0) --depth;
    if (depth == 0 && is_one_of(t, {"component", "interface"}) && tokens[i + 1].kind == TokenKind::Word) return true;
  }
  return false;
}

}  // namespace bip::genom
