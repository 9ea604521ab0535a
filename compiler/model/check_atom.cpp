// Warnings about an atom type as a whole. About linear in its transitions and code.
#include <algorithm>
#include <map>

#include "compiler/model/build_time.hpp"
#include "compiler/model/builder.hpp"

namespace bip::model {

namespace {

// Places that some run of the atom alone, guards ignored, can mark.
std::vector<bool> reachable_places(const AtomType& atom) {
  std::vector<bool> reached(atom.places.size());
  std::vector<std::vector<std::uint32_t>> leaving(atom.places.size());  // transitions
  std::vector<std::size_t> missing(atom.transitions.size());            // places not yet reached
  for (std::uint32_t t = 0; t < missing.size(); ++t) {
    missing[t] = atom.transitions[t].from.size();
    for (const std::uint32_t p : atom.transitions[t].from) leaving[p].push_back(t);
  }
  std::vector<std::uint32_t> todo;
  const auto reach = [&](const std::vector<std::uint32_t>& places) {
    for (const std::uint32_t p : places) {
      if (!reached[p]) todo.push_back(p);
      reached[p] = true;
    }
  };
  reach(atom.initial);
  while (!todo.empty()) {
    const std::uint32_t place = todo.back();
    todo.pop_back();
    for (const std::uint32_t t : leaving[place]) {
      if (--missing[t] == 0) reach(atom.transitions[t].to);
    }
  }
  return reached;
}

// Calls `visit` on every expression below `root`, arguments of calls included.
template <class Visit>
void visit_exprs(const CodeTable& code, ExprId root, Visit visit) {
  std::vector<ExprId> todo{root};
  while (!todo.empty()) {
    const ExprId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Expr& e = code.exprs[id];
    visit(e);
    todo.insert(todo.end(), {e.a, e.b});
    if (e.op != Op::Call) continue;
    for (const ExprId arg : code.args_of(e)) todo.push_back(arg);
  }
}

void collect_reads(const CodeTable& code, ExprId root, std::vector<bool>& read) {
  visit_exprs(code, root, [&](const Expr& e) {
    if (e.op == Op::LoadSelf) read[e.index] = true;
  });
}

// Variables that a call hands over to C++ by reference.
void collect_changes(const CodeTable& code, ExprId root, std::vector<bool>& written) {
  visit_exprs(code, root, [&](const Expr& e) {
    if (e.op != Op::Call) return;
    const std::span<const ExprId> args = code.args_of(e);
    for (std::size_t k = 0; k < args.size(); ++k) {
      const Expr& arg = code.exprs[args[k]];
      if (code.functions[e.index].params[k].by_reference && arg.op == Op::LoadSelf) written[arg.index] = true;
    }
  });
}

void collect_stmts(const CodeTable& code, StmtId first, std::vector<bool>& read, std::vector<bool>& written) {
  std::vector<StmtId> todo{first};
  while (!todo.empty()) {
    const StmtId id = todo.back();
    todo.pop_back();
    if (!id.is_valid()) continue;
    const Stmt& s = code.stmts[id];
    collect_reads(code, s.value, read);
    if (s.op == StmtOp::StoreSelf) written[s.index] = true;
    collect_changes(code, s.value, written);
    todo.push_back(s.next);
    todo.push_back(s.then_body);
    todo.push_back(s.else_body);
  }
}

void check_uninitialised(Builder& b, const AtomType& atom, const syntax::Decl& decl) {
  std::vector<bool> read(atom.slots.size()), written(atom.slots.size()), unused(atom.slots.size());
  collect_stmts(b.model.code, atom.initial_action, unused, written);
  const auto collect_time = [&](const TimeGuard& when) { collect_stmts(b.model.code, when.measure, read, unused); };
  for (const Transition& t : atom.transitions) {
    collect_reads(b.model.code, t.guard, read);
    collect_reads(b.model.code, t.resume.guard, read);
    collect_time(t.when);
    collect_time(t.resume.when);
    collect_stmts(b.model.code, t.action, read, unused);
  }
  collect_reads(b.model.code, atom.initial_resume.guard, read);
  collect_time(atom.initial_resume.when);
  for (const Invariant& i : atom.invariants) collect_time(i.when);
  for (const AtomPriority& p : atom.priorities) collect_reads(b.model.code, p.guard, read);
  for (const Invariant& i : atom.invariants) collect_reads(b.model.code, i.condition, read);
  std::uint32_t slot = static_cast<std::uint32_t>(std::count_if(atom.slots.begin(), atom.slots.end(), [](const Slot& s) { return s.is_param; }));
  for (const syntax::DataDecl& d : decl.data) {
    for (const syntax::Var& v : d.vars) {
      // C++ objects begin as their class says.
      if (slot < atom.slots.size() && !is_extern(atom.slots[slot].type) && read[slot] && !written[slot] && decl.notation == syntax::Notation::Bip2) {
        static constexpr const char* kZeros[] = {"0", "false", "0.0", "\"\""};
        const char* zero = kZeros[static_cast<int>(atom.slots[slot].type)];
        const std::string mended = fmt::format("{} = {}", v.name.text, zero);
        b.diags.report(Diag::kB1024, v.name.range, v.name.text, zero).help(fmt::format("write `{}` if that is meant", mended), v.name.range, mended);
      }
      ++slot;
    }
  }
}

void check_nondeterminism(Builder& b, const AtomType& atom, const syntax::Decl& decl) {
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::size_t> firsts;  // transitions by port and places
  for (std::size_t j = 0; j < atom.transitions.size(); ++j) {
    const Transition& second = atom.transitions[j];
    const auto [known, is_new] = firsts.try_emplace(std::pair(second.port, second.from), j);
    if (is_new) continue;
    if (is_suppressed(decl.annotations, "nondeterminism") || is_suppressed(decl.transitions[j].annotations, "nondeterminism")) continue;
    const bool is_internal = second.port == Transition::kInternal;
    const Transition& first = atom.transitions[known->second];
    if (are_disjoint(first.when, second.when)) continue;
    const bool sure = !first.guard.is_valid() && !second.guard.is_valid() && first.when.empty() && second.when.empty();
    const std::string what = is_internal ? fmt::format("atom type `{}` has two internal transitions", atom.name)
                                         : fmt::format("port `{}` has two transitions", atom.ports[second.port].name);
    const std::string place = second.from.empty() ? "?" : atom.places[second.from[0]];
    b.diags.report(sure ? Diag::kB1025 : Diag::kB1026, decl.transitions[j].range, what, place)
        .label(decl.transitions[known->second].range, "the other one")
        .help(!sure         ? "write guards that exclude each other, or `@SuppressWarning(nondeterminism)` before the transition"
              : is_internal ? "give them guards that exclude each other"
                            : "give them two ports, or guards that exclude each other");
  }
}

void check_clocks(Builder& b, const AtomType& atom, const syntax::Decl& decl) {
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
  std::size_t row = 0;
  for (const syntax::ClockDecl& c : decl.clocks) {
    for (const syntax::Name& name : c.names) {
      if (!used[row++]) b.diags.report(Diag::kB1615, name.range, name.text);
    }
  }
}

}  // namespace

void check_atom(Builder& b, const AtomType& atom, const syntax::Decl& decl) {
  if (b.diags.has_errors()) return;
  const std::vector<bool> reached = reachable_places(atom);
  for (std::size_t p = 0; p < atom.places.size(); ++p) {
    if (!reached[p]) b.diags.report(Diag::kB1027, decl.places[p].range, atom.places[p]);
  }
  for (std::size_t p = 0; p < atom.ports.size(); ++p) {
    const bool used = std::any_of(atom.transitions.begin(), atom.transitions.end(), [&](const Transition& t) { return t.port == p; });
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
  check_nondeterminism(b, atom, decl);
  check_atom_priorities(b, atom, decl);
}

}  // namespace bip::model
