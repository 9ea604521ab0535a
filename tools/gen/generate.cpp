// Generates the model of a seed: first its style, then port types, atom types, and compounds from the leaves to the
// root.
#include "tools/gen/make.hpp"

namespace bip::gen {

namespace {

// Most places of most atoms, so that some states are final.
void make_finals(Prng& random, Description& model) {
  for (AtomType& type : model.atom_types) {
    if (random.percent(5)) continue;
    for (const std::string& place : type.places) {
      if (random.percent(70)) type.finals.push_back(place);
    }
  }
}

}  // namespace

Description generate(std::uint64_t seed, Features features) {
  Prng random(seed);
  Style style;
  style.faults = random.percent(12);
  style.large = random.percent(3);
  style.paper = random.percent(15);
  style.odd_names = random.percent(5);
  style.lively = random.percent(60);
  style.deep = random.percent(35);
  style.ruled = random.percent(35);
  style.merged = random.percent(20);
  style.atom_rules = random.percent(20);
  style.invariants = random.percent(10);
  style.calls = random.percent(15);
  style.ffi = random.percent(25);
  style.objects = style.ffi && random.percent(60);
  if (features == Features::Plain) style.merged = style.atom_rules = style.invariants = false;
  // Random numbers of its own: other seeds' models stay what they are.
  style.regular = Prng(seed ^ 0x7265677561u).percent(30);
  style.has_initial_values = Prng(seed ^ 0x696e6974u).percent(25);
  if (style.regular) {
    style.faults = style.merged = style.atom_rules = style.invariants = false;
    style.calls = style.ffi = style.objects = false;
    style.narrow = Prng(seed ^ 0x6e6172726f77u).percent(80);
  }
  if (style.large) style.max_weight = 3000;
  CodeMaker code(random, style);

  Description model;
  model.package = "random" + std::to_string(seed);
  if (random.percent(25)) {
    model.split = random.percent(50) ? Split::Base : Split::Parts;
    model.qualified = random.percent(40);
  }
  if (random.percent(25)) style.constants = model.constants = make_constants(code, random);
  if (random.percent(20)) {
    // Their bodies are one expression over the parameters: no calls of C++, and of each other none.
    Style plain = style;
    plain.calls = plain.ffi = plain.objects = false;
    CodeMaker of_functions(random, plain);
    style.functions = model.functions = make_functions(of_functions, random);
  }
  model.port_types.push_back({"T0", {}});
  for (int k = 1, n = random.between(1, 3); k <= n; ++k) {
    PortType type;
    type.name = "T" + std::to_string(k);
    for (int v = 0, m = random.between(1, 3); v < m; ++v)
      type.vars.push_back({"v" + std::to_string(v), code.type(), false, {}});
    model.port_types.push_back(type);
  }
  for (int k = 0, n = random.between(1, 4); k < n; ++k) {
    model.atom_types.push_back(make_atom(random, style, model.port_types, "A" + std::to_string(k)));
  }
  std::map<std::string, Interface> interfaces;
  for (int k = 0, n = style.deep ? random.between(1, 4) : random.percent(40) ? random.between(1, 3) : 0; k < n; ++k) {
    make_compound(random, style, model, interfaces, "C" + std::to_string(k), CompoundLevel::Inner);
  }
  make_compound(random, style, model, interfaces, "Root", CompoundLevel::Root);
  Prng of_ends(seed ^ 0x656e6473u);
  if (of_ends.percent(25)) make_finals(of_ends, model);
  // As for `regular`.
  Prng of_time(seed ^ 0x74696d65u);
  const bool may_have_time = features == Features::Timed || features == Features::Drawn;
  if (may_have_time && of_time.percent(30)) make_time(of_time, model);
  Prng of_draws(seed ^ 0x6472617773u);
  if (features == Features::Drawn && of_draws.percent(20)) make_draws(of_draws, model);
  return model;
}

}  // namespace bip::gen
