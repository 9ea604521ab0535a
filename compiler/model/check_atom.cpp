// Warnings about an atom type as a whole. About linear in its transitions and code.
#include <algorithm>
#include <map>

#include "compiler/model/exclusive_guards.hpp"
#include "compiler/model/model_builder.hpp"
#include "compiler/model/clock_uses.hpp"
#include "compiler/model/code_uses.hpp"

namespace bip::model {

namespace {

void check_uninitialised(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  const CodeTable& code = b.model.code;
  std::vector<bool> read(atom.variables.size()), written(atom.variables.size());
  const auto look = [&](ExprId expr) { mark_reads(code, expr, Op::LoadSelf, read); };
  const auto look_at_all = [&](StmtId first) { for_each_stmt(code, first, [&](const Stmt& s) { look(s.value); }); };
  mark_writes(code, atom.initial_action, Op::LoadSelf, written);
  for (const Transition& t : atom.transitions) {
    look(t.guard);
    look(t.resume.guard);
    look_at_all(t.when.measure);
    look_at_all(t.resume.when.measure);
    look_at_all(t.action);
  }
  look(atom.initial_resume.guard);
  look_at_all(atom.initial_resume.when.measure);
  for (const AtomPriority& p : atom.priorities) look(p.guard);
  for (const Invariant& i : atom.invariants) {
    look(i.condition);
    look_at_all(i.when.measure);
  }
  std::uint32_t variable = static_cast<std::uint32_t>(
      std::count_if(atom.variables.begin(), atom.variables.end(), [](const DataVariable& s) { return s.is_param; }));
  for (const syntax::DataDecl& d : decl.data) {
    for (const syntax::Var& v : d.vars) {
      // C++ objects begin as their class says.
      if (variable < atom.variables.size() && !is_ffi(atom.variables[variable].type) && read[variable] &&
          !written[variable] && decl.notation == syntax::Notation::Bip2) {
        static constexpr const char* kZeros[] = {"0", "false", "0.0", "\"\""};
        const char* zero = kZeros[static_cast<int>(atom.variables[variable].type)];
        const std::string mended = fmt::format("{} = {}", v.name.text, zero);
        b.diags.report(Diag::kB1024, v.name.range, v.name.text, zero)
            .help(fmt::format("write `{}` if that is meant", mended), v.name.range, mended);
      }
      ++variable;
    }
  }
}

void check_nondeterminism(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::size_t> firsts;  // transitions by port and places
  for (std::size_t j = 0; j < atom.transitions.size(); ++j) {
    const Transition& second = atom.transitions[j];
    const auto [known, is_new] = firsts.try_emplace(std::pair(second.port, second.from), j);
    if (is_new) continue;
    const bool is_internal = second.port == Transition::kInternal;
    const Transition& first = atom.transitions[known->second];
    if (are_exclusive(first.when, second.when) || are_exclusive(b.model.code, first.guard, second.guard)) continue;
    const bool sure = !first.guard.is_valid() && !second.guard.is_valid() && first.when.empty() && second.when.empty();
    if (!sure && (is_suppressed(decl.annotations, "nondeterminism") ||
                  is_suppressed(decl.transitions[j].annotations, "nondeterminism")))
      continue;
    const std::string what = is_internal ? fmt::format("atom type `{}` has two internal transitions", atom.name)
                                         : fmt::format("port `{}` has two transitions", atom.ports[second.port].name);
    const std::string place = second.from.empty() ? "?" : atom.places[second.from[0]];
    b.diags.report(sure ? Diag::kB1025 : Diag::kB1026, decl.transitions[j].range, what, place)
        .label(decl.transitions[known->second].range, "the other one")
        .help(!sure
                  ? "write guards that exclude each other, or `@SuppressWarning(nondeterminism)` before the transition"
              : is_internal ? "give them guards that exclude each other"
                            : "give them two ports, or guards that exclude each other");
  }
}

void check_clocks(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  std::vector<bool> used(atom.clocks.size());
  const auto look = [&](const TimeGuard& when) {
    for (const Bound& bound : when.bounds) {
      used[bound.clock] = true;
      if (bound.minus != Bound::kNone) used[bound.minus] = true;
    }
  };
  for (const Transition& t : atom.transitions) {
    look(t.when);
    look(t.resume.when);
  }
  for (const Invariant& i : atom.invariants) look(i.when);
  look(atom.initial_resume.when);
  for (std::size_t clock = 0; clock < used.size(); ++clock)
    used[clock] = used[clock] || is_read_by_actions(b.model.code, atom, atom.clocks[clock]);
  std::size_t row = 0;
  for (const syntax::ClockDecl& c : decl.clocks) {
    for (const syntax::Name& name : c.names) {
      if (!used[row++]) b.diags.report(Diag::kB1615, name.range, name.text);
    }
  }
}

}  // namespace

void check_atom(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  if (b.diags.has_errors()) return;
  for (std::size_t p = 0; p < atom.ports.size(); ++p) {
    const bool used =
        std::any_of(atom.transitions.begin(), atom.transitions.end(), [&](const Transition& t) { return t.port == p; });
    if (used) continue;
    std::size_t row = 0;
    for (const syntax::PortDecl& d : decl.ports) {
      for (const syntax::PortItem& item : d.items) {
        if (row++ == p) b.diags.report(Diag::kB1028, item.name.range, atom.ports[p].name);
      }
    }
  }
  check_uninitialised(b, atom, decl);
  check_clocks(b, atom, decl);
  check_atom_net(b, atom, decl);
  check_nondeterminism(b, atom, decl);
  check_atom_priorities(b, atom, decl);
}

}  // namespace bip::model
