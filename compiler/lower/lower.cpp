// Lowers a System to an image: fills the pools, then sets the image's pointers.
//
// Requires a System that `validate` accepts. Deterministic; linear in time and memory, with code per type. Functions
// are null until an executor fills `codes`.
#include "compiler/lower/lower.hpp"

#include "compiler/lower/check_image.hpp"
#include "compiler/lower/pools.hpp"
#include "compiler/model/draws.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"
#include "runtime/include/bip/draws.hpp"

namespace bip::lower {

std::uint32_t Lowering::guard(CodeOwner owner, std::uint32_t row, const std::string& name, ExprId expr) {
  if (!expr.is_valid()) return rt::kNone;
  out.units.push_back({CodeKind::Guard, owner, row, names.make(name), expr, StmtId{}, system.code.exprs[expr].loc});
  return static_cast<std::uint32_t>(out.units.size() - 1);
}

std::uint32_t Lowering::action(CodeOwner owner, std::uint32_t row, const std::string& name, StmtId body) {
  if (!body.is_valid()) return rt::kNone;
  out.units.push_back({CodeKind::Action, owner, row, names.make(name), ExprId{}, body, system.code.stmts[body].loc});
  return static_cast<std::uint32_t>(out.units.size() - 1);
}

namespace {

// One site an int division or modulo or a call, in the order of the expressions.
void number_sites(Lowering& l) {
  const auto& exprs = l.system.code.exprs;
  l.out.site_of_expr.assign(exprs.size(), rt::kNone);
  std::size_t row = 0;
  for (const Expr& expr : exprs) {
    const bool is_call = expr.op == Op::Call;
    if (is_call || ((expr.op == Op::Div || expr.op == Op::Mod) && expr.type == Type::Int)) {
      l.out.site_of_expr[row] = static_cast<std::uint32_t>(l.pools.sites.size());
      const Function* function = is_call ? &l.system.code.functions[expr.index] : nullptr;
      l.pools.sites.push_back({loc_of(expr.loc), is_call ? function->name.c_str() : nullptr,
                               is_call && function->kind == FunctionKind::Draw});
    }
    ++row;
  }
}

void lower_texts(Lowering& l) {
  for (const std::string& file : l.system.files) l.pools.files.push_back(file.c_str());
  for (const std::string& text : l.system.code.strings) l.pools.strings.push_back(text.c_str());
  if (l.pools.strings.empty()) l.pools.strings.push_back("");
  // Zeroed variables read row 0.
  BIP_ENSURE(*l.pools.strings[0] == '\0');
}

// Do events bring strings? Their rows are made while the model runs.
bool brings_strings(const rt::Image& image) {
  for (const rt::AtomType& type : image.atom_types) {
    if (type.time == nullptr) continue;
    for (const rt::EventPort& event : type.time->events) {
      for (const rt::Var& var : image.port_types[type.ports[event.port].type].vars) {
        if (var.type == rt::CellType::String) return true;
      }
    }
  }
  return false;
}

void point_image_to_pools(LoweredSystem& out, const LoweredSystem::Pools& pools) {
  rt::Image& image = out.image;
  image.name = pools.name.c_str();
  image.files = span_of(pools.files);
  image.strings = span_of(pools.strings);
  image.codes = span_of(out.codes);
  image.sites = span_of(pools.sites);
  image.port_types = span_of(pools.port_types);
  image.atom_types = span_of(pools.atom_types);
  image.connector_types = span_of(pools.connector_types);
  image.compounds = span_of(pools.compounds);
  image.atoms = pools.atoms.view();
  image.args = span_of(pools.args);
  image.connectors = pools.connectors.view();
  image.port_refs = pools.port_refs.view();
  image.binds = pools.binds.view();
  image.choices = span_of(pools.choices);
  image.shown_ports = span_of(pools.shown_ports);
  image.ffi_types = span_of(out.ffi_types);
  image.event_classes = span_of(out.event_classes);
  if (out.system->code.has_cpp() || !out.event_classes.empty() || brings_strings(image)) image.ffi = &out.ffi;
  image.priorities = span_of(pools.priorities);
  image.transition_weights = span_of(pools.transition_weights);
  image.connector_weights = span_of(pools.connector_weights);
}

}  // namespace

std::unique_ptr<LoweredSystem> lower(const System& system, const std::string& name) {
  auto out = std::make_unique<LoweredSystem>();
  out->system = &system;
  out->code = &system.code;
  out->pools = {new LoweredSystem::Pools, [](LoweredSystem::Pools* p) { delete p; }};
  out->pools->name = name;
  Lowering l{system, *out, *out->pools, {}};
  l.event_classes = event_class_uses(system);
  for (const EventClassUse& use : l.event_classes) {
    out->event_classes.push_back(
        {system.atom_types[use.type].ports[use.port].event_class.c_str(), nullptr, nullptr, nullptr, nullptr});
  }
  number_sites(l);
  lower_texts(l);
  lower_types(l);
  lower_instances(l);
  out->codes.resize(out->units.size());
  for (const Function& function : system.code.functions) {
    const rt::ProbabilityDistribution* drawn = model::distribution_of(function);
    out->functions.push_back(
        drawn == nullptr ? nullptr : rt::draw_function(static_cast<std::size_t>(drawn - rt::kDistributions)));
  }
  for (const FfiType& type : system.code.ffi_types)
    out->ffi_types.push_back({type.name.c_str(), nullptr, nullptr, nullptr, nullptr, nullptr});
  point_image_to_pools(*out, *out->pools);
  BIP_ASSERT(check_lowered(*out), "image `{}`", name);
  return out;
}

}  // namespace bip::lower
