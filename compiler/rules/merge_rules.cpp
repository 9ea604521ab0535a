// See merge_rules.hpp. A group may be made of earlier groups, also of those of a file that is extended, so groups are
// expanded when all files have been merged.
#include "compiler/rules/merge_rules.hpp"

#include <iterator>
#include <utility>

#include "runtime/include/bip/assert.hpp"

namespace bip::rules {
namespace {

template <typename T>
void prepend(std::vector<T>& list, std::vector<T>& first) {
  list.insert(list.begin(), std::make_move_iterator(first.begin()), std::make_move_iterator(first.end()));
}

class GroupExpander {
 public:
  GroupExpander(RuleFile& file, Diagnostics& diags) : file_(file), diags_(diags) {}

  void run() {
    for (; known_ < file_.groups.size(); ++known_) {
      ServiceGroup& g = file_.groups[known_];
      expand(g.services);
      if (const ServiceGroup* const first = group_of({.module = {}, .name = g.name}))
        diags_.report(Diag::kB6013, g.name.range, "group", g.name.text).label(first->name.range, "the first one");
    }
    for (ParameterDecl& p : file_.parameters) expand(p.services);
    for (Rule& r : file_.rules) {
      expand(r.left);
      expand(r.right);
      expand(r.condition);
    }
    for (Promise& p : file_.promises) expand(p.condition);
  }

 private:
  [[nodiscard]] const ServiceGroup* group_of(const Path& path) const {
    for (std::size_t k = 0; k < known_; ++k) {
      if (!path.module.is_set() && file_.groups[k].name.text == path.name.text) return &file_.groups[k];
    }
    return nullptr;
  }
  // The services of a group stand where its name stood.
  void expand(std::vector<Path>& paths) const {
    std::vector<Path> all;
    for (Path& path : paths) {
      const ServiceGroup* const g = group_of(path);
      if (g == nullptr) all.push_back(std::move(path));
      else all.insert(all.end(), g->services.begin(), g->services.end());
    }
    paths = std::move(all);
  }
  // `moving.active`: one of them is.
  void expand(Expr& e) const {
    for (Expr& operand : e.operands) expand(operand);
    const bool is_of_service = e.kind == ExprKind::Active || e.kind == ExprKind::Done || e.kind == ExprKind::Failed ||
                               e.kind == ExprKind::Lost || e.kind == ExprKind::Late;
    const ServiceGroup* const g = is_of_service ? group_of(e.path) : nullptr;
    if (g == nullptr) return;
    Expr any = e;
    BIP_ASSERT(!g->services.empty(), "group `{}` has no services", g->name.text);
    any.path = g->services.front();
    for (std::size_t k = 1; k < g->services.size(); ++k) {
      Expr next = e;
      next.path = g->services[k];
      any = {.kind = ExprKind::Operator, .range = e.range, .text = "||", .operands = {std::move(any), std::move(next)}};
    }
    e = std::move(any);
  }

  RuleFile& file_;
  Diagnostics& diags_;
  std::size_t known_ = 0;  // groups before this one are expanded
};

}  // namespace

void extend(RuleFile& file, RuleFile base) {
  prepend(file.modules, base.modules);
  prepend(file.groups, base.groups);
  prepend(file.parameters, base.parameters);
  prepend(file.values, base.values);
  prepend(file.rules, base.rules);
  prepend(file.promises, base.promises);
  if (!file.side_file.is_set()) file.side_file = std::move(base.side_file);
}

void expand_groups(RuleFile& file, Diagnostics& diags) { GroupExpander(file, diags).run(); }

}  // namespace bip::rules
