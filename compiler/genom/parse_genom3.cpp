// GenoM 3 components: properties, tasks, ports, attributes, functions, activities. IDL is read for the names that it
// declares, not for layouts. Words of GenoM may be names, so a word counts by where it stands.
#include "compiler/genom/parse_genom3.hpp"

#include <deque>

#include "compiler/genom/condition.hpp"
#include "compiler/genom/parse_genom.hpp"

namespace bip::genom {
namespace {

using v3::ParsedCodel;

bool is_one_of(const Token& token, std::initializer_list<std::string_view> words) {
  for (const std::string_view w : words) {
    if (token.is(w)) return true;
  }
  return false;
}

class Genom3Parser {
 public:
  Genom3Parser(const std::vector<Token>& tokens, Headers headers, Diagnostics& diags)
      : in_(tokens, diags), diags_(diags), first_(tokens.front().range) {
    module_.is_open = headers == Headers::Missing;
    module_.generation = 3;
  }

  Module run() {
    while (!in_.at_end()) {
      const bool is_component = is_one_of(in_.peek(), {"component", "interface"});
      if (is_component && !module_.name.is_set()) {
        if (!component()) in_.skip_past_semicolon();
      } else if (is_component) {
        in_.skip_past_semicolon();
      } else if (!idl()) {
        if (in_.at("}")) in_.take();
        in_.skip_past_semicolon();
      }
    }
    if (!module_.name.is_set() && !diags_.has_errors()) diags_.report(Diag::kB6014, first_, "component");
    v3::settle_uses(module_, scopes_, diags_);
    return std::move(module_);
  }

 private:
  bool component() {
    in_.take();
    if (!in_.name(module_.name, "the name of a component")) return false;
    if (in_.accept("{")) {
      while (!in_.at("}") && !in_.at_end()) {
        if (!item()) in_.skip_past_semicolon();
      }
      if (!in_.expect("}")) return false;
    }
    in_.accept(";");
    return true;
  }

  bool item() {
    const Token& word = in_.peek();
    if (word.is("ids") && in_.peek(1).is("{")) return ids();
    if (word.is("task")) return task();
    if (word.is("port")) return port();
    if (word.is("attribute")) return service("attribute");
    if (word.is("function")) return service("function");
    if (word.is("activity")) return service("activity");
    if (is_property(word)) return skip_property();
    return idl();
  }

  static bool is_property(const Token& word) {
    return is_one_of(
        word, {"doc", "version", "lang", "email", "require", "requires", "codels", "clock", "provide", "provides",
               "use", "uses", "extend", "extends", "stack", "throw", "throws", "scheduling", "size"});
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
    if (in_.at("module") && in_.peek(2).is("{")) {
      in_.take();
      in_.take();
      return in_.skip_group() && (in_.accept(";"), true);
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

  // const TYPE name = expression;
  bool constant() {
    std::string name;
    for (in_.take(); !in_.at_end() && !in_.at("=") && !in_.at(";"); in_.take()) name = in_.peek().text;
    if (!in_.expect("=")) return false;
    std::vector<Token> tokens;
    while (!in_.at_end() && !in_.at(";")) tokens.push_back(in_.take());
    if (const std::optional<std::int64_t> value = constant_value(with_constants(tokens))) {
      values_.push_back(std::to_string(*value));
      constants_[name] = values_.back();
    }
    return in_.expect(";");
  }

  [[nodiscard]] std::vector<Token> with_constants(std::vector<Token> tokens) const {
    for (Token& t : tokens) {
      const auto known = t.kind == TokenKind::Word ? constants_.find(t.text) : constants_.end();
      if (known == constants_.end()) continue;
      t.kind = TokenKind::Number;
      t.text = known->second;
    }
    return tokens;
  }

  bool ids() {
    in_.take();
    in_.take();
    while (!in_.at("}") && !in_.at_end()) {
      if (!v3::parse_declared_names(in_, scopes_.members) || !in_.expect(";")) return false;
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
    std::set<std::string> names;
    const SourceRange range = in_.peek().range;
    if (!v3::parse_declared_names(in_, names)) return false;
    for (const std::string& name : names) {
      scopes_.ports.insert(name);
      if (is_out) module_.posters.push_back({{name, range}, {}, 0, false});
    }
    if (in_.at("{") && !in_.skip_group()) return false;
    return in_.expect(";");
  }

  bool task() {
    in_.take();
    Task task;
    if (!in_.name(task.name, "the name of a task")) return false;
    std::vector<ParsedCodel> codels;
    std::set<std::string> locals;
    if (in_.accept("{")) {
      while (!in_.at("}") && !in_.at_end()) {
        if (!task_property(task, codels, locals)) in_.skip_past_semicolon();
      }
      if (!in_.expect("}")) return false;
    }
    if (!codels.empty()) task.activity = v3::make_activity(codels, task.name, "task", diags_);
    scopes_.task_locals.push_back(std::move(locals));
    module_.tasks.push_back(std::move(task));
    return in_.expect(";");
  }

  bool task_property(Task& task, std::vector<ParsedCodel>& codels, std::set<std::string>& locals) {
    if (in_.at("period") || in_.at("delay")) {
      const bool is_period = in_.take().text == "period";
      return duration(is_period ? task.period_us : task.delay_us) && in_.expect(";");
    }
    if (in_.at("codel") || (in_.at("async") && in_.peek(1).is("codel"))) return codel(codels);
    if (in_.at("local")) return local(locals);
    if (in_.at("priority") || is_property(in_.peek())) return skip_property();
    auto d = diags_.report(Diag::kB6011, in_.peek().range, in_.peek().text, fmt::format("task `{}`", task.name.text));
    d.help("a task has `period`, `delay`, `priority`, `scheduling`, `stack`, `codel`, `throw`, `doc`");
    return false;
  }

  // EXPRESSION [s|ms|us], in microseconds.
  bool duration(std::int64_t& into) {
    std::vector<Token> tokens;
    const SourceRange range = in_.peek().range;
    while (!in_.at_end() && !in_.at(";") && !in_.at("}")) tokens.push_back(in_.take());
    std::int64_t unit = 1'000'000;
    if (!tokens.empty() && is_one_of(tokens.back(), {"s", "sec", "ms", "us"})) {
      unit = tokens.back().text == "ms" ? 1000 : tokens.back().text == "us" ? 1 : 1'000'000;
      tokens.pop_back();
    }
    // Seconds may be a fraction.
    if (tokens.size() == 1 && tokens.front().text.find('.') != std::string_view::npos) {
      const std::optional<std::int64_t> us = v3::scaled(tokens.front().text, unit);
      if (!us) diags_.report(Diag::kB6000, range, "a time", describe(tokens.front()));
      into = us.value_or(0);
      return us.has_value();
    }
    const std::optional<std::int64_t> value = constant_value(with_constants(tokens));
    if (!value) {
      diags_.report(Diag::kB6000, range, "a time", tokens.empty() ? describe(in_.peek()) : describe(tokens.front()));
      return false;
    }
    if (*value < 0 || *value > 1'000'000'000) {
      diags_.report(Diag::kB6010, range, "a time", *value, 0, 1'000'000'000);
      return false;
    }
    into = *value * unit;
    return true;
  }

  bool codel(std::vector<ParsedCodel>& codels) {
    ParsedCodel parsed;
    parsed.codel.is_async = in_.accept("async");
    in_.take();
    if (!v3::parse_codel(in_, parsed)) return false;
    codels.push_back(std::move(parsed));
    return in_.expect(";");
  }

  bool local(std::set<std::string>& locals) {
    in_.take();
    return v3::parse_declared_names(in_, locals) && in_.expect(";");
  }

  bool service(const std::string& kind) {
    in_.take();
    Service s;
    if (!in_.name(s.name, fmt::format("the name of a {}", kind))) return false;
    s.kind = kind == "activity" ? ServiceKind::Execution : ServiceKind::Control;
    std::set<std::string> locals;
    std::vector<DataUse> uses;
    if (!v3::parse_parameters(in_, kind == "attribute" ? v3::ParametersOf::Attribute : v3::ParametersOf::Codel, locals,
                              uses))
      return false;
    if (kind == "attribute") s.body.push_back({{}, std::move(uses)});
    std::vector<ParsedCodel> codels;
    if (in_.accept("{")) {
      while (!in_.at("}") && !in_.at_end()) {
        if (!service_property(s, kind, codels, locals)) in_.skip_past_semicolon();
      }
      if (!in_.expect("}")) return false;
    }
    finish(s, kind, codels);
    scopes_.service_locals.push_back(std::move(locals));
    module_.services.push_back(std::move(s));
    return in_.expect(";");
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
      return in_.names(s.reports, "the name of an exception") && in_.expect(";");
    }
    if (word.is("validate")) {
      in_.take();
      return v3::parse_call(in_, s.validate) && in_.expect(";");
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
    s.validate_fails = !s.reports.empty();
    s.body_fails = !s.reports.empty();
    if (s.kind == ServiceKind::Execution) {
      if (!s.task.is_set()) diags_.report(Diag::kB6007, s.name.range, owner, "task");
      s.activity = v3::make_activity(codels, s.name, kind, diags_);
      return;
    }
    if (s.task.is_set()) diags_.report(Diag::kB6020, s.task.range, owner).help("an `activity` has a task");
    for (ParsedCodel& c : codels) {
      if (!c.states.empty())
        diags_.report(Diag::kB6020, c.states.front().range, owner).help("an `activity` has states");
      s.body.push_back(std::move(c.codel));
    }
    if (kind == "attribute") s.body_fails = false;
  }

  Cursor in_;
  Diagnostics& diags_;
  SourceRange first_;
  Module module_;
  v3::Scopes scopes_;
  std::map<std::string, std::string, std::less<>> constants_;
  std::deque<std::string> values_;  // texts of constants: tokens are views
};

}  // namespace

Module parse_genom3(const std::vector<Token>& tokens, Headers headers, Diagnostics& diags) {
  return Genom3Parser(tokens, headers, diags).run();
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
