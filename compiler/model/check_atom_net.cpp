// What the net of an atom type cannot do, or does and must not: places and transitions that are never reached, a second
// token on a place, internal transitions without end, transitions that an internal one always forestalls.
//
// Guards are left out, so that what is called unreachable is so surely. An atom in which one token walks about needs a
// linear search of its places; for others the markings are listed (Murata, Proc. IEEE 77(4), 1989, Section IV-A, the
// reachability tree), up to a bound beyond which only the linear checks speak.
#include <algorithm>
#include <set>

#include "compiler/model/exclusive_guards.hpp"
#include "compiler/model/model_builder.hpp"

namespace bip::model {

namespace {

using Marking = std::vector<bool>;
using Places = std::vector<std::uint32_t>;
constexpr std::size_t kMaxWork = 2'000'000;  // markings times transitions and places

struct NetCheck {
  ModelBuilder& b;
  const AtomType& atom;
  const syntax::Decl& decl;
  std::set<Marking> markings{};
  std::vector<std::size_t> enabled, unsafe;                  // by transition: in how many markings
  std::vector<bool> forestalled;                             // by transition: never fires, and told
  std::vector<std::uint32_t> second_token;                   // by transition: a place that would get a second one
  std::set<std::pair<std::size_t, std::size_t>> together{};  // transitions of one port that one marking enables

  NetCheck(ModelBuilder& builder, const AtomType& a, const syntax::Decl& d)
      : b(builder),
        atom(a),
        decl(d),
        enabled(a.transitions.size()),
        unsafe(a.transitions.size()),
        forestalled(a.transitions.size()),
        second_token(a.transitions.size()) {}

  [[nodiscard]] std::string name(std::size_t t) const {
    const std::uint32_t port = atom.transitions[t].port;
    return port == Transition::kInternal ? "an internal transition" : fmt::format("port `{}`", atom.ports[port].name);
  }
  /// Nothing but its places decides when it fires.
  [[nodiscard]] bool is_free(std::size_t t) const {
    const Transition& row = atom.transitions[t];
    return !row.guard.is_valid() && row.when.empty() && !row.resume.present;
  }
  [[nodiscard]] bool is_silent(std::size_t t, const char* warning) const {
    return is_suppressed(decl.annotations, warning) || is_suppressed(decl.transitions[t].annotations, warning);
  }
  [[nodiscard]] static bool includes(const Marking& marking, const Places& places) {
    return std::all_of(places.begin(), places.end(), [&](std::uint32_t p) { return marking[p]; });
  }

  // Places that some run of the atom alone can mark, each for itself.
  [[nodiscard]] std::vector<bool> reachable_places() const {
    std::vector<bool> reached(atom.places.size());
    std::vector<Places> leaving(atom.places.size());            // transitions
    std::vector<std::size_t> missing(atom.transitions.size());  // places not yet reached
    for (std::uint32_t t = 0; t < missing.size(); ++t) {
      missing[t] = atom.transitions[t].from.size();
      for (const std::uint32_t p : atom.transitions[t].from) leaving[p].push_back(t);
    }
    Places todo;
    const auto reach = [&](const Places& places) {
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

  [[nodiscard]] bool is_one_token() const {
    return atom.initial.size() == 1 &&
           std::all_of(atom.transitions.begin(), atom.transitions.end(),
                       [](const Transition& t) { return t.from.size() == 1 && t.to.size() == 1; });
  }

  // Fires `t` into `to`; false if a place would hold two tokens.
  bool fire(std::size_t t, Marking& to) {
    for (const std::uint32_t p : atom.transitions[t].from) to[p] = false;
    for (const std::uint32_t p : atom.transitions[t].to) {
      if (to[p]) {
        second_token[t] = p;
        return false;
      }
      to[p] = true;
    }
    return true;
  }

  // All markings, until one is unsafe on each way; false if they are too many.
  bool list_markings() {
    const std::size_t cost = atom.transitions.size() + atom.places.size() + 1;
    Marking first(atom.places.size());
    for (const std::uint32_t p : atom.initial) first[p] = true;
    markings.insert(first);
    std::vector<Marking> todo{first};
    while (!todo.empty()) {
      if (markings.size() * cost > kMaxWork) return false;
      const Marking marking = std::move(todo.back());
      todo.pop_back();
      std::vector<std::size_t> fires;
      bool internal_is_first = false;
      for (std::size_t t = 0; t < atom.transitions.size(); ++t) {
        if (!includes(marking, atom.transitions[t].from)) continue;
        fires.push_back(t);
        internal_is_first |= atom.transitions[t].port == Transition::kInternal && is_free(t);
      }
      if (internal_is_first)
        std::erase_if(fires, [&](std::size_t t) { return atom.transitions[t].port != Transition::kInternal; });
      for (std::size_t i = 0; i < fires.size(); ++i) {
        const std::size_t t = fires[i];
        for (std::size_t j = 0; j < i; ++j) {
          if (atom.transitions[fires[j]].port == atom.transitions[t].port) together.insert({fires[j], t});
        }
        ++enabled[t];
        Marking next = marking;
        if (!fire(t, next)) ++unsafe[t];
        else if (markings.insert(next).second) todo.push_back(std::move(next));
      }
    }
    return true;
  }

  void check_places(const std::vector<bool>& reached) {
    for (std::size_t p = 0; p < atom.places.size(); ++p) {
      if (!reached[p]) b.diags.report(Diag::kB1027, decl.places[p].range, atom.places[p]);
    }
  }

  void check_markings() {
    std::vector<bool> marked(atom.places.size());
    for (const Marking& m : markings) {
      for (std::size_t p = 0; p < m.size(); ++p) marked[p] = marked[p] || m[p];
    }
    for (std::size_t t = 0; t < atom.transitions.size(); ++t) {
      const SourceRange at = decl.transitions[t].range;
      if (enabled[t] == 0 && !forestalled[t] && includes(marked, atom.transitions[t].from) &&
          atom.transitions[t].from.size() > 1) {
        b.diags.report(Diag::kB1029, at, name(t))
            .note("each of its places can be marked, but never all of them together");
      }
      if (unsafe[t] == 0) continue;
      const bool sure = unsafe[t] == enabled[t] && is_free(t);
      const std::string& place = atom.places[second_token[t]];
      if (sure)
        b.diags.report(Diag::kB1034, at, name(t), place)
            .help(fmt::format("take the token of `{}`, too: write it after `from`", place));
      else if (!is_silent(t, "maybenotsafe"))
        b.diags.report(Diag::kB1035, at, name(t), place)
            .help("`@SuppressWarning(maybenotsafe)` before it, if guards or connectors prevent that");
    }
    for (const auto& [i, j] : together) {
      if (atom.transitions[i].from == atom.transitions[j].from || is_silent(j, "nondeterminism"))
        continue;  // check_atom tells of those
      if (are_exclusive(atom.transitions[i].when, atom.transitions[j].when) ||
          are_exclusive(b.model.code, atom.transitions[i].guard, atom.transitions[j].guard))
        continue;
      const bool is_internal = atom.transitions[j].port == Transition::kInternal;
      const std::string what = is_internal ? fmt::format("atom type `{}` has two internal transitions", atom.name)
                                           : name(j) + " has two transitions";
      b.diags.report(Diag::kB1051, decl.transitions[j].range, what)
          .label(decl.transitions[i].range, "the other one")
          .help("give them two ports, or guards that exclude each other");
    }
    for (std::size_t i = 0; i < atom.invariants.size(); ++i) check_invariant(i);
  }

  // Where one token walks about, no two places are ever marked together.
  void check_invariants_of_one_token() {
    for (std::size_t i = 0; i < atom.invariants.size(); ++i) {
      const Invariant& invariant = atom.invariants[i];
      if (invariant.scope == InvariantScope::Always || invariant.places.size() < 2) continue;
      b.diags.report(Diag::kB1036, decl.invariants[i].range, invariant.name)
          .note(fmt::format("only one place of `{}` is marked at a time, and this asks for {} together", atom.name,
                            invariant.places.size()))
          .help("write an invariant for each place");
    }
  }

  void check_invariant(std::size_t row) {
    const Invariant& invariant = atom.invariants[row];
    if (invariant.scope == InvariantScope::Always) return;
    const bool is_checked = std::any_of(markings.begin(), markings.end(), [&](const Marking& m) {
      const auto tokens = static_cast<std::size_t>(std::count(m.begin(), m.end(), true));
      return includes(m, invariant.places) &&
             (invariant.scope == InvariantScope::From || tokens == invariant.places.size());
    });
    if (!is_checked) b.diags.report(Diag::kB1036, decl.invariants[row].range, invariant.name);
  }

  // Unguarded internal transitions with one place on each side: a cycle of them is never left.
  void check_endless(const std::vector<bool>& reached) {
    constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    std::vector<std::size_t> leaves(atom.places.size(), kNone);
    for (std::size_t t = 0; t < atom.transitions.size(); ++t) {
      const Transition& row = atom.transitions[t];
      const bool is_step =
          row.port == Transition::kInternal && is_free(t) && row.from.size() == 1 && row.to.size() == 1;
      if (is_step && reached[row.from[0]] && leaves[row.from[0]] == kNone) leaves[row.from[0]] = t;
    }
    std::vector<std::size_t> visit(atom.places.size());  // number of the walk that came there
    for (std::size_t start = 0; start < leaves.size(); ++start) {
      std::size_t place = start, last = kNone;
      while (leaves[place] != kNone && visit[place] == 0) {
        visit[place] = start + 1;
        last = leaves[place];
        place = atom.transitions[last].to[0];
      }
      if (last == kNone || visit[place] != start + 1) continue;
      b.diags.report(Diag::kB1037, decl.transitions[last].range, atom.places[place])
          .help("give one of them a guard, or a port");
    }
  }

  // An internal transition without a guard, from some of its places, is enabled whenever the other one is, and goes
  // first.
  void check_forestalled(const std::vector<bool>& reached) {
    std::vector<std::vector<std::size_t>> by_place(atom.places.size());
    for (std::size_t t = 0; t < atom.transitions.size(); ++t) {
      const Transition& row = atom.transitions[t];
      if (row.port == Transition::kInternal && is_free(t) && !row.from.empty()) by_place[row.from[0]].push_back(t);
    }
    for (std::size_t t = 0; t < atom.transitions.size(); ++t) {
      const Transition& row = atom.transitions[t];
      if (row.port == Transition::kInternal || !includes(reached, row.from)) continue;
      for (const std::uint32_t p : row.from) {
        const auto first = std::find_if(by_place[p].begin(), by_place[p].end(), [&](std::size_t i) {
          const Places& from = atom.transitions[i].from;
          return std::all_of(from.begin(), from.end(), [&](std::uint32_t q) {
            return std::find(row.from.begin(), row.from.end(), q) != row.from.end();
          });
        });
        if (first == by_place[p].end()) continue;
        b.diags.report(Diag::kB1038, decl.transitions[t].range, name(t), atom.places[p])
            .label(decl.transitions[*first].range, "this one is always enabled then");
        forestalled[t] = true;
        break;
      }
    }
  }
};

}  // namespace

void check_atom_net(ModelBuilder& b, const AtomType& atom, const syntax::Decl& decl) {
  NetCheck check(b, atom, decl);
  const std::vector<bool> reached = check.reachable_places();
  check.check_places(reached);
  check.check_forestalled(reached);
  check.check_endless(reached);
  if (check.is_one_token()) {
    check.check_invariants_of_one_token();
  } else if (check.list_markings()) {
    check.check_markings();
  }
}

}  // namespace bip::model
