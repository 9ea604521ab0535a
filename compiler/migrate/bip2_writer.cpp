// See bip2_writer.hpp: the package, port types and atoms.
#include "compiler/migrate/bip2_writer.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"
#include "compiler/base/ascii.hpp"
#include "compiler/migrate/translate_code.hpp"

namespace bip::migrate {

using namespace syntax::bip1;
using syntax::Name;

namespace {

constexpr std::string_view kUnitsOfTime[] = {"nanosecond", "microsecond", "millisecond", "second",
                                             "minute",     "hour",        "day"};

bool is_identifier(std::string_view text) {
  return !text.empty() && !is_digit(text[0]) &&
         std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

std::string listed(const Bip2Names& names, const Names& list) {
  std::string out;
  for (const Name& name : list) out += (out.empty() ? "" : ", ") + names.name(name.text);
  return out;
}

}  // namespace

Bip2Writer::Bip2Writer(const Model& model, const SourceMap& sources, Diagnostics& diags)
    : model_(model), sources_(sources), diags_(diags), names_(sources.text(model.file)), cpp_(names_) {
  for (const Decl& d : model.decls) decls_.emplace(d.name.text, &d);
  for (const Decl& d : model.decls) {
    for (const Priority& p : d.priorities) find_exported(d, p);
  }
}

// `a.x` in the guard of a priority of a compound: BIP2 wants `export data`.
void Bip2Writer::find_exported(const Decl& d, const Priority& p) {
  for (const Condition& condition : p.conditions) {
    std::vector<const Expr*> open;
    if (condition.guard.expr) open.push_back(&*condition.guard.expr);
    while (!open.empty()) {
      const Expr& e = *open.back();
      open.pop_back();
      for (const Expr& operand : e.operands) open.push_back(&operand);
      if (e.kind != ExprKind::Variable || e.path.size() != 2) continue;
      for (const Instances& list : d.instances) {
        for (const Instance& instance : list.items) {
          if (instance.name.text == e.path[0].text) exported_.emplace(list.type.text, e.path[1].text);
        }
      }
    }
  }
}

std::string Bip2Writer::run(const std::string& cpp_stem) {
  indent_ = 1;
  headers(model_.headers);
  for (const Decl& d : model_.decls) decl(d);
  roots();
  BIP_ASSERT(indent_ == 1, "the package ends at indentation {}", indent_);
  std::vector<Line> all;
  if (!cpp_.is_empty())
    all.push_back({0, "@cpp(include=\"" + cpp_stem + ".hpp\", src=\"" + cpp_stem + ".cpp\")", model_.range.begin,
                   model_.range.begin + 1});
  all.push_back({0, "package " + names_.name(model_.name.text), model_.range.begin, model_.name.range.end});
  for (const std::string& text : cpp_.declarations()) all.push_back({1, text});
  for (const auto& [params, name] : port_types_) all.push_back({1, "port type " + name + "(" + params + ")"});
  all.insert(all.end(), lines_.begin(), lines_.end());
  all.push_back({0, "end", model_.range.end - 3, model_.range.end});
  return with_comments(all);
}

// ---- lines
// ------------------------------------------------------------------------------------------------------------

void Bip2Writer::open(std::string text, SourceRange source) {
  line(std::move(text), source);
  ++indent_;
}

void Bip2Writer::close(SourceRange source) {
  BIP_ASSERT(indent_ > 1, "`end` of nothing, at indentation {}", indent_);
  --indent_;
  line("end", {source.file, source.end - std::min(source.end, 3u), source.end});
}

std::string Bip2Writer::place(SourceRange at) const {
  return sources_.name(at.file) + ":" + std::to_string(sources_.loc(at).line);
}

std::string Bip2Writer::in_one_line(SourceRange at) const {
  std::string out;
  for (const char c : sources_.text(at)) {
    const bool is_blank = static_cast<unsigned char>(c) <= ' ';
    if (!is_blank || (!out.empty() && out.back() != ' ')) out += is_blank ? ' ' : c;
  }
  while (out.ends_with(' ') || out.ends_with('\\')) out.pop_back();
  return out;
}

void Bip2Writer::no_counterpart(SourceRange at, const std::string& what, const std::string& why) {
  diags_.report(Diag::kB6140, at, what, why);
  line("// " + what + " has no counterpart in BIP2 (" + place(at) + "): " + in_one_line(at),
       {at.file, at.begin, at.begin});
}

std::string Bip2Writer::with_comments(const std::vector<Line>& lines) const {
  // A comment inside the source of a line, or on the line where it ends, belongs to it, any other to the next one.
  std::vector<std::vector<std::size_t>> before(lines.size() + 1), behind(lines.size());
  std::vector<std::size_t> sorted;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].begin < lines[i].end) sorted.push_back(i);
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&lines](std::size_t a, std::size_t b) { return lines[a].begin < lines[b].begin; });
  const std::string_view text = sources_.text(model_.file);
  for (std::size_t c = 0; c < model_.comments.size(); ++c) {
    const SourceRange at = model_.comments[c].range;
    const auto next = std::upper_bound(sorted.begin(), sorted.end(), at.begin,
                                       [&lines](std::uint32_t begin, std::size_t l) { return begin < lines[l].begin; });
    const std::size_t following = next == sorted.end() ? lines.size() : *next;
    if (next == sorted.begin()) {
      before[following].push_back(c);
      continue;
    }
    BIP_ASSERT(c == 0 || model_.comments[c - 1].range.end <= at.begin, "comment {} is not in the order of the source",
               c);
    const std::size_t last = *(next - 1);
    const std::uint32_t end = lines[last].end;
    if (at.begin < end) {
      before[last].push_back(c);
    } else if (text.substr(end, at.begin - end).find('\n') == std::string_view::npos) {
      behind[last].push_back(c);
    } else {
      before[following].push_back(c);
    }
  }
  std::string out;
  const auto write = [&](std::size_t c) { out += sources_.text(model_.comments[c].range); };
  for (std::size_t i = 0; i <= lines.size(); ++i) {
    const std::string blanks(static_cast<std::size_t>(i < lines.size() ? lines[i].indent : 0) * 2, ' ');
    for (const std::size_t c : before[i]) {
      out += blanks;
      write(c);
      out += '\n';
    }
    if (i == lines.size()) break;
    out += blanks + lines[i].text;
    for (const std::size_t c : behind[i]) {
      out += "  ";
      write(c);
      // A second one on the line would be part of the first.
      out += c == behind[i].back() ? "" : "\n" + blanks;
    }
    out += '\n';
    const bool ends_type = lines[i].indent == 1 && lines[i].text == "end";
    if (ends_type && i + 2 < lines.size()) out += '\n';
  }
  return out;
}

// ---- pieces
// -----------------------------------------------------------------------------------------------------------

VariableType Bip2Writer::known(ValueKind kind) {
  if (kind == ValueKind::Bool) return cpp_.type("bool");
  return cpp_.type("int");
}

void Bip2Writer::headers(const std::vector<Code>& list) {
  for (const Code& code : list) cpp_.add_header(sources_.text(code.range), place(code.range));
}

std::string Bip2Writer::port_type_name(const Port& port, const Variables& variables) {
  if (!port.type.text.empty()) return names_.name(port.type.text);
  std::string params;
  for (const Name& var : port.items.empty() ? Names() : port.items[0].vars) {
    const auto found = variables.find(std::string(var.text));
    const std::string type = found == variables.end() ? "int" : found->second.type.bip;
    params += (params.empty() ? "" : ", ") + type + " " + names_.name(var.text);
  }
  std::string& name = port_types_[params];
  if (name.empty()) name = names_.fresh("Port");
  return name;
}

std::string Bip2Writer::params(const std::vector<Param>& list, Variables& variables) {
  std::string out;
  for (const Param& param : list) {
    const VariableType type = cpp_.type(param.type.text);
    variables[std::string(param.name.text)] = {type};
    out += (out.empty() ? "" : ", ") + type.bip + " " + names_.name(param.name.text);
  }
  return out;
}

std::string Bip2Writer::port_type_of(const Param& param) {
  if (is_identifier(param.type.text)) return names_.name(param.type.text);
  no_counterpart(param.type.range, "`" + param.type.text + "` of a connector's port", "it is no port type");
  return port_type_name({}, {});
}

std::string Bip2Writer::constant(const Guard& guard, const VariableType& type, const Variables& variables) {
  const CodeTranslator translator(names_, variables);
  std::optional<std::string> text = guard.expr ? translator.value(*guard.expr, type.kind) : std::nullopt;
  if (text) return *text;
  no_counterpart(guard.range, "`" + in_one_line(guard.range) + "`",
                 "it is computed before the run, which calls no C++");
  return {};
}

std::string Bip2Writer::value(const Guard& guard, const VariableType& type, const Variables& variables,
                              const std::string& owner) {
  const CodeTranslator translator(names_, variables);
  if (guard.expr) {
    if (const std::optional<std::string> text = translator.value(*guard.expr, type.kind)) return *text;
  }
  if (const std::optional<std::string> call =
          cpp_.value(owner, sources_.text(guard.range), variables, type, place(guard.range)))
    return *call;
  no_counterpart(guard.range, "this C code", cpp_.reason());
  return {};
}

std::string Bip2Writer::guards(const std::vector<Guard>& list, const Variables& variables, const std::string& owner) {
  std::string out;
  for (const Guard& guard : list) {
    const std::string text = value(guard, known(ValueKind::Bool), variables, owner);
    if (!text.empty()) out += (out.empty() ? "" : " && ") + (list.size() > 1 ? "(" + text + ")" : text);
  }
  return out;
}

std::string Bip2Writer::action(const Code& code, const Variables& variables, const std::string& owner) {
  if (!code.is_present) return {};
  const CodeTranslator translator(names_, variables);
  if (code.stmts) {
    if (std::optional<std::string> text = translator.statements(*code.stmts)) return *text;
  }
  if (std::optional<std::string> call = cpp_.action(owner, sources_.text(code.range), variables, place(code.range)))
    return *call;
  no_counterpart(code.range, "this C code", cpp_.reason());
  return {};
}

// ---- declarations
// -----------------------------------------------------------------------------------------------------

void Bip2Writer::decl(const Decl& d) {
  switch (d.kind) {
    case DeclKind::PortType: return port_type(d);
    case DeclKind::ConnectorType: return connector_type(d);
    case DeclKind::AtomType: return atom_type(d);
    case DeclKind::CompoundType: return compound_type(d);
  }
}

void Bip2Writer::port_type(const Decl& d) {
  Variables ignored;
  line("port type " + names_.name(d.name.text) + "(" + params(d.params, ignored) + ")", d.range);
}

// `data int x = 1, y`; what needs C++ for its first value gets it at the beginning of the run: the statements returned.
std::string Bip2Writer::data(const Data& data, Variables& variables, const Decl* atom) {
  if (!data.is_readable) no_counterpart(data.range, "this `data`", "it has more of C than declarations of variables");
  std::string later;
  for (const Var& var : data.vars) {
    const VariableType type = cpp_.type(var.type.text);
    const bool is_exported =
        data.is_exported || (atom != nullptr && exported_.contains({atom->name.text, var.name.text}));
    std::string text =
        std::string(is_exported ? "export " : "") + "data " + type.bip + " " + names_.name(var.name.text);
    if (var.init) {
      const CodeTranslator translator(names_, variables);
      const std::optional<std::string> first = var.init->expr && type.kind != ValueKind::Object
                                                   ? translator.value(*var.init->expr, type.kind)
                                                   : std::nullopt;
      if (first) {
        text += " = " + *first;
      } else if (atom == nullptr) {
        no_counterpart(var.init->range, "this first value of a connector's data", "it is computed before the run");
      } else if (const std::string called = value(*var.init, type, variables, std::string(atom->name.text));
                 !called.empty()) {
        later += names_.name(var.name.text) + " = " + called + "; ";
      }
    }
    variables[std::string(var.name.text)] = {type};
    line(std::move(text), &var == &data.vars.front() ? data.range : var.range);
  }
  return later;
}

void Bip2Writer::port(const Port& port, const Variables& variables) {
  if (!port.completeness.text.empty())
    no_counterpart(port.completeness.range, "`" + std::string(port.completeness.text) + "` of a port",
                   "`define` of a connector says which ports are triggers");
  std::string items;
  for (const PortItem& item : port.items) {
    items += (items.empty() ? "" : ", ") + names_.name(item.name.text) + "(" + listed(names_, item.vars) + ")";
  }
  std::string text =
      std::string(port.is_exported ? "export " : "") + "port " + port_type_name(port, variables) + " " + items;
  const bool is_renamed =
      !port.exported_as.text.empty() && (port.items.size() != 1 || port.items[0].name.text != port.exported_as.text);
  if (is_renamed && !port.is_exported) {
    no_counterpart(port.exported_as.range, "another name of a port that is not exported", "nothing sees it");
  } else if (is_renamed) {
    text += " as " + names_.name(port.exported_as.text);
  }
  line(std::move(text), port.range);
}

void Bip2Writer::atom_type(const Decl& d) {
  Variables variables;
  headers(d.headers);
  const std::string head = params(d.params, variables);
  open("atom type " + names_.name(d.name.text) + "(" + head + ")", {d.range.file, d.range.begin, d.name.range.end});
  std::string first_values;
  for (const Data& data_decl : d.data) first_values += data(data_decl, variables, &d);
  for (const Clock& clock : d.clocks) {
    std::string_view unit = clock.unit;
    if (unit.starts_with("1 ")) unit.remove_prefix(2);
    if (!unit.empty() && std::find(std::begin(kUnitsOfTime), std::end(kUnitsOfTime), unit) == std::end(kUnitsOfTime)) {
      no_counterpart(clock.range, "the unit `" + clock.unit + "` of a clock", "BIP2 has `nanosecond` to `day`");
      unit = {};
    }
    line("clock " + listed(names_, clock.names) + (unit.empty() ? "" : " unit " + std::string(unit)), clock.range);
    for (const Name& name : clock.names) variables[std::string(name.text)] = {{ValueKind::Clock, "", ""}};
  }
  for (const Port& port_decl : d.ports) port(port_decl, variables);
  atom_behavior(d, variables, first_values);
  for (const Priority& priority_decl : d.priorities) priority(priority_decl, d);
  close(d.range);
}

void Bip2Writer::atom_behavior(const Decl& d, const Variables& variables, const std::string& first_values) {
  // States may be written more than once.
  Names places;
  for (const Name& place : d.places) {
    const bool is_new = std::none_of(places.begin(), places.end(), [&](const Name& p) { return p.text == place.text; });
    if (is_new) places.push_back(place);
  }
  if (places.empty()) {
    no_counterpart(d.name.range, "an atom without states", "it has no place to begin at");
    const std::string place = names_.fresh("S");
    line("place " + place, {});
    line("initial to " + place, {});
    for (const Transition& transition_decl : d.transitions)
      no_counterpart(transition_decl.range, "a transition without state", "it leads nowhere");
    return;
  }
  line("place " + listed(names_, places), {d.range.file, d.places_range.begin, d.places_range.end});
  if (d.initials.empty()) {
    no_counterpart(d.name.range, "an atom without `initial`", "its first state is unknown");
    line("initial to " + names_.name(places[0].text), {});
  }
  if (d.initials.size() > 1) no_counterpart(d.initials[1].range, "a second `initial`", "one is the beginning");
  if (!d.initials.empty()) {
    const Initial& first = d.initials.front();
    std::string body = first_values + action(first.action, variables, std::string(d.name.text));
    Names to = first.to;
    if (to.empty()) {
      no_counterpart(first.range, "`initial` without `to`", "its first state is unknown");
      to.push_back(places[0]);
    }
    line("initial to " + listed(names_, to) + (body.empty() ? "" : " do { " + body + "}"), first.range);
  }
  for (const Transition& transition_decl : d.transitions) transition(d, transition_decl, variables);
}

void Bip2Writer::transition(const Decl& d, const Transition& t, const Variables& variables) {
  const std::string owner = std::string(d.name.text) + (t.port.text.empty() ? "" : "_" + std::string(t.port.text));
  if (t.from.empty() || t.to.empty())
    return no_counterpart(t.range, "a transition without " + std::string(t.from.empty() ? "state" : "`to`"),
                          "it leads nowhere");
  std::string text = t.is_internal ? "internal" : "on " + names_.name(t.port.text);
  text += " from " + listed(names_, t.from) + " to " + listed(names_, t.to);
  std::string guard = guards(t.guards, variables, owner);
  for (const When& when : t.whens) {
    BIP_ASSERT(when.ends.size() == (when.clock.empty() ? 1u : 2u), "`when` of {} ends", when.ends.size());
    std::string bound;
    if (when.clock.empty()) {
      bound = guards(when.ends, variables, owner);
    } else {
      const std::string clock = names_.path(when.clock);
      const VariableType number = known(ValueKind::Int);
      const std::string low = constant(when.ends[0], number, variables),
                        high = constant(when.ends[1], number, variables);
      if (!low.empty() && !high.empty()) bound = clock + " >= " + low + " && " + clock + " <= " + high;
    }
    if (bound.empty()) continue;
    if (guard.empty()) {
      guard = bound;
    } else {
      guard = "(" + guard + ") && " + bound;
    }
  }
  if (!guard.empty()) text += " provided (" + guard + ")";
  if (!t.urgency.text.empty()) text += " " + std::string(t.urgency.text);
  std::string body;
  for (const Name& clock : t.resets) body += names_.name(clock.text) + " = 0; ";
  body += action(t.action, variables, owner);
  if (!body.empty()) text += " do { " + body + "}";
  line(std::move(text), t.range);
}

}  // namespace bip::migrate
