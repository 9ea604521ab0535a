// The edits of the shrinker. A walk over the description counts the places at which an edit is possible and applies the
// n-th.
#include "tools/gen/shrink.hpp"

#include <algorithm>

#include "tools/gen/ffi_prototypes.hpp"

namespace bip::gen {
namespace {

class Editor {
 public:
  explicit Editor(std::size_t target) : left_(target) {}
  [[nodiscard]] bool done() const { return done_; }

  void walk(Description& model) {
    if (model.split != Split::One && still_fails_here()) model.split = Split::One;
    if (model.qualified && still_fails_here()) model.qualified = false;
    for (std::size_t c = model.compound_types.size(); c-- > 0 && !done_;) {
      CompoundType& type = model.compound_types[c];
      remove_one(type.priorities);
      remove_one(type.connectors);
      remove_one(type.components);
      remove_one(type.port_exports);
      remove_one(type.data_exports);
      for (Priority& p : type.priorities) drop(p.guard);
      for (PortExport& e : type.port_exports) {
        if (e.targets.size() > 1) remove_one(e.targets);
      }
    }
    for (std::size_t k = 0; k < model.connector_types.size() && !done_; ++k)
      remove_param(model, model.connector_types[k]);
    for (ConnectorType& type : model.connector_types) walk(type);
    for (AtomType& type : model.atom_types) walk(type);
    for (CompoundType& type : model.compound_types) {
      for (Component& c : type.components) each(c.args);
      for (Priority& p : type.priorities) each(p.guard);
    }
    for (ConnectorType& type : model.connector_types) {
      for (Clause& c : type.clauses) {
        each(c.guard);
        each(c.up);
        each(c.down);
      }
    }
    for (AtomType& type : model.atom_types) {
      each(type.initial_action);
      for (AtomRule& r : type.rules) each(r.guard);
      for (Invariant& i : type.invariants) each(i.condition);
      for (Var& v : type.data) each(v.init);
      for (Transition& t : type.transitions) {
        each(t.guard);
        each(t.action);
      }
    }
  }

 private:
  bool still_fails_here() {
    if (done_ || left_-- > 0) return false;
    return done_ = true;
  }
  template <class T>
  void remove_one(std::vector<T>& items) {
    for (std::size_t k = items.size(); k-- > 0 && !done_;) {
      if (still_fails_here()) items.erase(items.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
  void drop(std::optional<Expr>& e) {
    if (e && still_fails_here()) e.reset();
  }
  void drop(Body& body) {
    if (body.size() > 1 && still_fails_here()) body.clear();
    remove_one(body);
  }
  void walk(ConnectorType& type) {
    remove_one(type.clauses);
    for (Clause& c : type.clauses) {
      drop(c.guard);
      drop(c.up);
      drop(c.down);
    }
    walk(type.define);
  }
  void walk(Define& define) {
    if (define.trigger && still_fails_here()) define.trigger = false;
    for (Define& child : define.children) walk(child);
  }
  void walk(AtomType& type) {
    if (type.paper && still_fails_here()) type.paper = false;
    remove_one(type.rules);
    remove_one(type.invariants);
    remove_one(type.transitions);
    remove_one(type.ports);
    remove_one(type.finals);
    for (Transition& t : type.transitions) {
      remove_one(t.when);
      remove_one(t.sets);
      if (!t.urgency.empty() && still_fails_here()) t.urgency.clear();
      if (t.resumes && still_fails_here()) t.resumes = false;
      if (t.is_async && still_fails_here()) t.is_async = false, t.budget = 0;
    }
    for (AtomRule& r : type.rules) drop(r.guard);
    for (Transition& t : type.transitions) {
      drop(t.guard);
      drop(t.action);
    }
    drop(type.initial_action);
    for (Var& v : type.data) drop(v.init);
  }

  static void forget_leaf(Define& define, int param) {
    std::erase_if(define.children, [&](const Define& d) { return d.param == param; });
    for (Define& child : define.children) {
      forget_leaf(child, param);
      if (child.param > param) --child.param;
    }
    std::erase_if(define.children, [](const Define& d) { return d.param < 0 && d.children.empty(); });
  }
  void remove_param(Description& model, ConnectorType& type) {
    for (std::size_t k = type.params.size(); k-- > 0 && type.params.size() > 1 && !done_;) {
      if (!still_fails_here()) continue;
      int param = static_cast<int>(k);
      type.params.erase(type.params.begin() + param);
      forget_leaf(type.define, param);
      std::erase_if(type.clauses,
                    [&](const Clause& c) { return std::count(c.params.begin(), c.params.end(), param) > 0; });
      for (Clause& c : type.clauses) {
        for (int& p : c.params) p -= p > param ? 1 : 0;
      }
      for (CompoundType& compound : model.compound_types) {
        auto concerns = [&](const Pattern& pattern) {
          const Connector* c = find_named(compound.connectors, pattern.connector);
          return c != nullptr && c->type == type.name && !pattern.any_interaction;
        };
        std::erase_if(compound.priorities, [&](const Priority& p) { return concerns(p.low) || concerns(p.high); });
        for (Connector& c : compound.connectors) {
          if (c.type == type.name) c.ports.erase(c.ports.begin() + param);
        }
      }
    }
  }

  void each(std::optional<Expr>& e) {
    if (e) each(*e);
  }
  void each(std::vector<Expr>& all) {
    for (Expr& e : all) each(e);
  }
  /// An operand of the same type instead, or a literal.
  void each(Expr& e) {
    // What a distribution is given stays what it can have.
    const std::size_t count = e.kind == ExprKind::Draw ? 0 : e.args.size() - (e.kind == ExprKind::Inline ? 1 : 0);
    for (std::size_t k = 0; k < count; ++k) {
      if (e.args[k].type != e.type || !still_fails_here()) continue;
      Expr operand = e.args[k];
      e = std::move(operand);
      return;
    }
    // A constant's value and a function's body stand elsewhere, too; what a call changes stays a variable.
    if (e.kind == ExprKind::Constant) return;
    if (e.kind != ExprKind::Literal && e.type < Ty::Pair && still_fails_here()) {
      static const char* const kSimple[] = {"1", "true", "1.5", "\"a\""};
      Expr literal;
      literal.type = e.type;
      literal.text = kSimple[static_cast<int>(e.type)];
      e = literal;
      return;
    }
    if (e.extra_parens && still_fails_here()) e.extra_parens = false;
    const bool changes = e.kind == ExprKind::Call && !ffi_functions()[static_cast<std::size_t>(e.row)].is_pure();
    for (std::size_t k = 0; k < count && !changes; ++k) each(e.args[k]);
  }
  void each(Body& body) {
    for (std::size_t k = 0; k < body.size() && !done_; ++k) {
      if (body[k].is_if && still_fails_here()) {
        Body inner = body[k].then_body;
        body.erase(body.begin() + static_cast<std::ptrdiff_t>(k));
        body.insert(body.begin() + static_cast<std::ptrdiff_t>(k), inner.begin(), inner.end());
        return;
      }
      if (body[k].is_if) {
        drop(body[k].else_body);
        if (body[k].then_body.size() > 1) drop(body[k].then_body);
      }
      if (!body[k].is_call) each(body[k].value);
      each(body[k].then_body);
      each(body[k].else_body);
    }
  }

  std::size_t left_;
  bool done_ = false;
};

}  // namespace

bool apply_edit(Description& model, std::size_t n) {
  Editor editor(n);
  editor.walk(model);
  return editor.done();
}

Description shrink(Description model, const std::function<bool(const Description&)>& still_fails, int budget) {
  for (bool improved = true; improved && budget > 0;) {
    improved = false;
    for (std::size_t n = 0; budget > 0; --budget) {
      Description smaller = model;
      if (!apply_edit(smaller, n)) break;
      tidy(smaller);
      if (!smaller.compound_types.empty() && !smaller.compound_types.back().components.empty() &&
          still_fails(smaller)) {
        model = std::move(smaller);
        improved = true;
      } else {
        ++n;
      }
    }
  }
  return model;
}

}  // namespace bip::gen
