// Codels and parameters of GenoM 3, and the checks of the states of an activity.
#include <algorithm>

#include "compiler/genom/parse_genom3.hpp"

namespace bip::genom::v3 {
namespace {

// ['pause' '::'] id
bool parse_event(Cursor& in, Yield& into) {
  into.next = in.at("pause") && in.peek(1).is("::") ? Next::Pause : Next::State;
  if (into.next == Next::Pause) {
    in.take();
    in.take();
  }
  if (!in.name(into.name, "a state")) return false;
  if (into.name.text == "ether" && into.next == Next::State) into.next = Next::Ether;
  return true;
}

// ['ids'|'local'|'port'|'remote'] ('in'|'out'|'inout') (path | path '::' id | '::' id)
bool parse_use(Cursor& in, DataUse& into) {
  std::string where;
  const auto is_direction = [](const Token& t) { return t.is("in") || t.is("out") || t.is("inout"); };
  if (in.peek().kind == TokenKind::Word && is_direction(in.peek(1)) && !is_direction(in.peek())) where = in.take().text;
  if (!is_direction(in.peek())) {
    in.unexpected("`in`, `out` or `inout`");
    return false;
  }
  into.writes = in.take().text != "in";
  if (in.accept("::")) {
    Name ignored;
    into.data = "*";
    return in.name(ignored, "a name");
  }
  Name first;
  if (!in.name(first, "a name")) return false;
  into.data = (where.empty() ? "?" : where + ":") + first.text;
  // The rest of the path, and the name under which C sees it.
  while (!in.at_end() && !in.at(",") && !in.at(")") && !in.at(";")) {
    if (in.at("[")) {
      if (!in.skip_group()) return false;
    } else {
      in.take();
    }
  }
  return true;
}

// From `<` until after its `>`: the bounds of sequences and strings, with their commas.
bool skip_angles(Cursor& in) {
  std::size_t depth = 0;
  do {
    if (in.at("<")) ++depth;
    if (in.at(">")) --depth;
    if (in.at_end() || in.at(";")) return in.expect(">");
    in.take();
  } while (depth > 0);
  return true;
}

std::size_t find_state(const Activity& activity, std::string_view name) {
  for (std::size_t i = 0; i < activity.states.size(); ++i) {
    if (activity.states[i].name.text == name) return i;
  }
  return activity.states.size();
}

// States from which one may go on, from `from` on.
std::vector<bool> reached(const Activity& activity, std::vector<std::size_t> from) {
  std::vector<bool> seen(activity.states.size(), false);
  while (!from.empty()) {
    const std::size_t state = from.back();
    from.pop_back();
    if (state >= seen.size() || seen[state]) continue;
    seen[state] = true;
    for (const Yield& y : activity.states[state].yields) {
      if (y.next == Next::State || y.next == Next::Pause) from.push_back(y.state);
    }
  }
  return seen;
}

}  // namespace

bool parse_call(Cursor& in, Codel& into) {
  if (!in.name(into.name, "the name of a codel") || !in.expect("(")) return false;
  while (!in.at(")") && !in.at_end()) {
    DataUse use;
    if (!parse_use(in, use)) return false;
    into.uses.push_back(std::move(use));
    if (!in.accept(",") && !in.at(")")) return in.expect(")");
  }
  return in.expect(")");
}

bool parse_codel(Cursor& in, ParsedCodel& into) {
  if (in.accept("<")) {
    if (!in.names(into.states, "a state") || !in.expect(">")) return false;
  }
  if (!parse_call(in, into.codel)) return false;
  if (in.accept("yield") || in.accept("yields")) {
    do {
      Yield y;
      if (!parse_event(in, y)) return false;
      into.yields.push_back(std::move(y));
    } while (in.accept(","));
  }
  return true;
}

bool parse_parameters(Cursor& in, ParametersOf owner, std::set<std::string>& locals, std::vector<DataUse>& uses,
                      std::vector<std::string>& inputs) {
  if (!in.at("(")) return in.expect("(");
  in.take();
  while (!in.at(")") && !in.at_end()) {
    // dir [type] name [array] [= value] [: "text"]; of a path of an attribute the first name is the member.
    bool writes = false;
    std::string first;
    std::string last;
    bool in_declarator = true;
    while (!in.at_end() && !in.at(",") && !in.at(")") && !in.at(";")) {
      if (in.at("{") || in.at("(") || in.at("[")) {
        if (!in.skip_group()) return false;
        continue;
      }
      if (in.at("<") && in_declarator) {
        if (!skip_angles(in)) return false;
        continue;
      }
      const Token& token = in.take();
      if (token.is("=") || token.is(":")) in_declarator = false;
      if (!in_declarator || token.kind != TokenKind::Word) continue;
      if (token.text == "in" || token.text == "inout") writes = true;
      if (token.text == "in" || token.text == "out" || token.text == "inout") continue;
      if (first.empty()) first = token.text;
      last = token.text;
    }
    if (last.empty()) {
      in.unexpected("a parameter");
      return false;
    }
    locals.insert(last);
    if (writes) inputs.push_back(last);
    if (owner == ParametersOf::Attribute) uses.push_back({"ids:" + first, writes});
    if (!in.accept(",") && !in.at(")")) return in.expect(")");
  }
  return in.expect(")");
}

bool parse_declared_names(Cursor& in, std::vector<Name>& names) {
  Name last;
  std::size_t angles = 0;
  while (!in.at_end() && !in.at(";") && !(in.at("}") && angles == 0)) {
    // The properties of a port follow its name.
    if (in.at("{") && last.is_set() && in.peek(1).is("doc")) break;
    if (in.at("{") || in.at("[") || in.at("(")) {
      if (!in.skip_group()) return false;
      continue;
    }
    const Token& token = in.take();
    if (token.is("<")) ++angles;
    if (token.is(">") && angles > 0) --angles;
    if (angles > 0) continue;
    if (token.kind == TokenKind::Word) last = {std::string(token.text), token.range};
    if (token.is(",") && last.is_set()) names.push_back(last);
  }
  if (!last.is_set()) {
    in.unexpected("a declaration");
    return false;
  }
  names.push_back(std::move(last));
  return true;
}

Activity make_activity(const std::vector<ParsedCodel>& codels, const Name& owner, const std::string& kind,
                       Diagnostics& diags) {
  const std::string what = fmt::format("{} `{}`", kind, owner.text);
  Activity a;
  for (const ParsedCodel& c : codels) {
    if (c.states.empty())
      diags.report(Diag::kB6000, c.codel.name.range, "the states of this codel, as in `codel<start>`",
                   "`" + c.codel.name.text + "`");
    for (const Name& state : c.states) {
      const std::size_t known = find_state(a, state.text);
      if (known < a.states.size()) {
        diags.report(Diag::kB6016, state.range, state.text, what).label(a.states[known].name.range, "the first one");
        continue;
      }
      a.states.push_back({state, c.codel, c.yields});
      if (c.yields.empty())
        diags.report(Diag::kB6007, c.codel.name.range, fmt::format("codel `{}`", c.codel.name.text), "yield");
    }
  }
  a.start = find_state(a, "start");
  if (a.start == a.states.size()) {
    diags.report(Diag::kB6007, owner.range, what, "codel<start>");
    a.start = 0;
    if (a.states.empty()) return a;
  }
  a.stop = find_state(a, "stop");
  const bool has_stop = a.stop < a.states.size();
  // One that just ends.
  if (!has_stop) a.states.push_back({{"stop", {}}, {}, {{Next::Ether, {}, 0}}});
  bool all_known = true;
  for (State& s : a.states) {
    for (Yield& y : s.yields) {
      if (y.next != Next::State && y.next != Next::Pause) continue;
      y.state = find_state(a, y.name.text);
      if (y.state < a.states.size()) continue;
      diags.report(Diag::kB6015, y.name.range, s.codel.name.text, y.name.text);
      y.state = 0;
      all_known = false;
    }
  }
  const std::vector<bool> seen = reached(a, {a.start, a.stop});
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    if (!seen[i] && all_known) diags.report(Diag::kB6017, a.states[i].name.range, a.states[i].name.text, what);
  }
  if (has_stop) {
    const std::vector<bool> after = reached(a, {a.stop});
    bool ends = false;
    for (std::size_t i = 0; i < a.states.size(); ++i) {
      const std::vector<Yield>& yields = a.states[i].yields;
      ends = ends || (after[i] &&
                      std::any_of(yields.begin(), yields.end(), [](const Yield& y) { return y.next == Next::Ether; }));
    }
    if (!ends) diags.report(Diag::kB6018, a.states[a.stop].name.range, what);
  }
  return a;
}

void settle_uses(Module& module, const Scopes& scopes, Diagnostics& diags) {
  // The same function cannot be compiled with two lists of parameters.
  std::map<std::string, std::pair<SourceRange, std::size_t>> parameters;
  const auto settle = [&](Codel& codel, const std::set<std::string>& locals) {
    if (codel.name.is_set()) {
      const auto [known, is_new] =
          parameters.try_emplace(codel.name.text, std::pair(codel.name.range, codel.uses.size()));
      if (!is_new && known->second.second != codel.uses.size()) {
        diags.report(Diag::kB6019, codel.name.range, codel.name.text, codel.uses.size(), known->second.second)
            .label(known->second.first, "here");
      }
    }
    std::vector<DataUse> shared;
    const auto add = [&](const std::string& data, bool writes) {
      const auto known = std::find_if(shared.begin(), shared.end(), [&](const DataUse& u) { return u.data == data; });
      if (known == shared.end()) {
        shared.push_back({data, writes});
      } else {
        known->writes = known->writes || writes;
      }
    };
    for (const DataUse& use : codel.uses) {
      const std::size_t colon = use.data.find(':');
      const std::string where = colon == std::string::npos ? "" : use.data.substr(0, colon);
      const std::string name = colon == std::string::npos ? use.data.substr(1) : use.data.substr(colon + 1);
      if (use.data == "*") {
        for (const std::string& member : scopes.members) add("ids_" + member, use.writes);
      } else if (codel.name.is_set() && !module.is_open &&
                 ((where == "ids" && !scopes.members.contains(name)) ||
                  (where == "port" && !scopes.ports.contains(name)) || (where == "local" && !locals.contains(name)))) {
        diags.report(Diag::kB6021, codel.name.range, name, codel.name.text);
      } else if (where == "ids" || (where.empty() && !locals.contains(name) && scopes.members.contains(name))) {
        add("ids_" + name, use.writes);
      } else if (where == "port" || (where.empty() && !locals.contains(name) && scopes.ports.contains(name))) {
        add("port_" + name, use.writes);
      } else if (where.empty() && !locals.contains(name)) {
        // A port of an interface whose file is not here.
        if (!module.is_open) diags.report(Diag::kB6021, codel.name.range, name, codel.name.text);
        add("port_" + name, use.writes);
      }
    }
    codel.uses = std::move(shared);
  };
  for (std::size_t i = 0; i < module.services.size(); ++i) {
    Service& s = module.services[i];
    settle(s.validate, scopes.service_locals[i]);
    for (Codel& c : s.body) settle(c, scopes.service_locals[i]);
    for (State& state : s.activity.states) settle(state.codel, scopes.service_locals[i]);
  }
  for (std::size_t i = 0; i < module.tasks.size(); ++i) {
    for (State& state : module.tasks[i].activity.states) settle(state.codel, scopes.task_locals[i]);
  }
}

}  // namespace bip::genom::v3
