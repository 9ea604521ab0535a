// No component twice in one interaction, where merged ports are bound below: their alternatives exclude each other.
//
// The tree below a connector is walked once, alternatives included; every visit of an atom knows the alternatives that
// lead to it. Two visits may meet in one interaction unless they go through different alternatives of one choice. Cost:
// the expanded tree, which has a bound, times the visits of an atom and the depth of its choices.
#include "compiler/system/instantiator.hpp"
#include "compiler/system/system.hpp"

namespace bip::system {

namespace {

/// One alternative of one bound choice, and the one that leads to it.
struct Branch {
  std::size_t above = kNoBranch;
  std::size_t choice = 0;  // a number of this occurrence
  std::uint32_t alternative = 0;
  static constexpr std::size_t kNoBranch = static_cast<std::size_t>(-1);
};

bool exclude_each_other(const std::vector<Branch>& branches, std::size_t a, std::size_t b) {
  for (std::size_t i = a; i != Branch::kNoBranch; i = branches[i].above) {
    for (std::size_t j = b; j != Branch::kNoBranch; j = branches[j].above) {
      if (branches[i].choice == branches[j].choice) return branches[i].alternative != branches[j].alternative;
    }
  }
  return false;
}

}  // namespace

void Instantiator::check_alternatives(ConnectorId id, SourceRange at) {
  struct Todo {
    PortRef ref;
    std::size_t branch = Branch::kNoBranch;
  };
  std::vector<Branch> branches;
  std::map<std::uint32_t, std::vector<std::size_t>> visits;  // by atom: the branches that lead to it
  std::vector<Todo> todo;
  std::size_t choices = 0;
  std::size_t visited = 0;
  const auto open = [&](ConnectorId connector, std::size_t branch) {
    for (const PortRef& ref : out.connectors[connector].ports) todo.push_back({ref, branch});
  };
  open(id, Branch::kNoBranch);
  while (!todo.empty()) {
    const Todo next = todo.back();
    todo.pop_back();
    if (too_many(visited++, "alternatives below one connector", at)) return;
    switch (next.ref.kind) {
      case PortRef::Kind::Connector: open(next.ref.connector, next.branch); break;
      case PortRef::Kind::Choice: {
        std::uint32_t alternative = 0;
        for (const PortRef& ref : out.choices[next.ref.choice].ports) {
          branches.push_back({next.branch, choices, alternative++});
          todo.push_back({ref, branches.size() - 1});
        }
        ++choices;
        break;
      }
      case PortRef::Kind::Atom: {
        std::vector<std::size_t>& before = visits[next.ref.atom.value];
        for (const std::size_t branch : before) {
          if (exclude_each_other(branches, branch, next.branch)) continue;
          diags.report(Diag::kB4007, at, out.atoms[next.ref.atom].path, out.connectors[id].path);
          return;
        }
        before.push_back(next.branch);
        break;
      }
    }
  }
}

}  // namespace bip::system
