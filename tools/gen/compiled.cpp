// The stages in the order of the driver's pipeline (compiler/pipeline/pipeline.cpp), applied to a text in memory.
#include "tools/gen/compiled.hpp"

#include "compiler/model/model.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/syntax/print.hpp"
#include "compiler/system/bsys.hpp"
#include "compiler/system/instantiate.hpp"

namespace bip::gen {
namespace {

// What random models use of it.
constexpr const char* kChance = R"(package std.chance
  extern function int uniform(const int low, const int high)
  extern function float uniform(const float low, const float high)
  extern function float normal(const float mean, const float deviation)
  extern function float exponential(const float mean)
  extern function bool flip(const float probability)
  extern function int table(const int a, const float wa, const int b, const float wb)
  extern function int table(const int a, const float wa, const int b, const float wb, const int c, const float wc)
  extern function int table(const int a, const float wa, const int b, const float wb, const int c, const float wc, const int d, const float wd)
end
)";

std::string errors_of(const Diagnostics& diags, const SourceMap& sources) {
  RenderOptions options;
  options.format = DiagnosticFormat::Short;
  options.max_errors = 3;
  return render(diags, sources, options);
}

void lower_sound(Compiled& c) {
  std::vector<std::string> broken = system::validate(*c.system);
  if (!broken.empty()) {
    c.problem = "validate: " + broken.front();
    return;
  }
  c.lowered = lower::lower(*c.system, "Root()");
  const std::string missing = bind_ffi(*c.lowered);
  if (!missing.empty()) c.problem = "ffi: no C++ function " + missing;
}

}  // namespace

Compiled compile_texts(const std::vector<std::string>& texts) {
  Compiled c;
  SourceMap sources;
  Diagnostics diags;
  std::vector<syntax::Syntax> packages;
  packages.reserve(texts.size() + 1);
  if (texts.front().find("  use std.chance\n") != std::string::npos) {
    std::optional<syntax::Syntax> chance = parse::parse_file(sources, sources.add("chance.bip", kChance), diags);
    if (!chance) {
      c.problem = "parse: " + errors_of(diags, sources);
      return c;
    }
    packages.push_back(std::move(*chance));
  }
  for (const std::string& text : texts) {
    const FileId file = sources.add("random" + std::to_string(packages.size()) + ".bip", text);
    std::optional<syntax::Syntax> syntax = parse::parse_file(sources, file, diags);
    if (!syntax || diags.has_errors()) {
      c.problem = "parse: " + errors_of(diags, sources);
      return c;
    }
    c.formatted.push_back(syntax::print(*syntax, sources));
    packages.push_back(std::move(*syntax));
  }
  std::vector<const syntax::Syntax*> used;
  for (const syntax::Syntax& package : packages) used.push_back(&package);
  std::optional<Model> model = model::build_model(used, sources, diags);
  if (!model || diags.has_errors()) {
    c.problem = "model: " + errors_of(diags, sources);
    return c;
  }
  const FileId last = packages.back().file;
  std::optional<System> system = system::instantiate(*model, "Root", {}, diags, {.file = last, .begin = 0, .end = 0});
  if (!system || diags.has_errors()) {
    c.problem = "instantiate: " + errors_of(diags, sources);
    return c;
  }
  c.system = std::make_unique<System>(std::move(*system));
  lower_sound(c);
  return c;
}

Compiled compile_bsys(const std::string& text) {
  Compiled c;
  Result<System> system = system::parse_bsys(text);
  if (!system) {
    c.problem = "bsys: " + system.error();
    return c;
  }
  c.system = std::make_unique<System>(std::move(*system));
  lower_sound(c);
  return c;
}

void forget_places(System& system) {
  for (Expr& e : system.code.exprs) e.loc = {};
  for (Function& f : system.code.functions) f.loc = {};
  for (Stmt& s : system.code.stmts) s.loc = {};
  for (PortType& type : system.port_types) {
    type.loc = {};
    for (Variable& v : type.variables) v.loc = {};
  }
  for (AtomType& type : system.atom_types) {
    type.loc = {};
    for (DataVariable& s : type.variables) s.loc = {};
    for (Port& p : type.ports) p.loc = {};
    const auto forget_bounds = [](TimeGuard& when) {
      for (Bound& b : when.bounds) b.loc = {};
    };
    for (Transition& t : type.transitions) {
      t.loc = t.resume.loc = {};
      forget_bounds(t.when);
      forget_bounds(t.resume.when);
    }
    for (Clock& c : type.clocks) c.loc = {};
    type.initial_resume.loc = {};
    for (AtomPriority& p : type.priorities) p.loc = {};
    for (Invariant& i : type.invariants) {
      i.loc = {};
      forget_bounds(i.when);
    }
    for (MergedPort& m : type.merged) m.loc = {};
  }
  for (ConnectorType& type : system.connector_types) {
    type.loc = {};
    for (ConnectorParam& p : type.params) p.loc = {};
    for (DataVariable& s : type.variables) s.loc = {};
    for (Clause& c : type.clauses) c.loc = {};
  }
  for (Compound& c : system.compounds) c.loc = {};
  for (Atom& a : system.atoms) a.loc = {};
  for (Connector& c : system.connectors) c.loc = {};
  for (Priority& p : system.priorities) p.loc = {};
}

}  // namespace bip::gen
