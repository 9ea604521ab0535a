// Adds draws of random numbers to a complete random model: assignments from distributions of std.chance at the ends of
// actions, and in the initial action. Numbers are small, so that guards still hold now and then.
#include "tools/gen/make.hpp"

namespace bip::gen {
namespace {

Expr float_literal(const char* text) {
  Expr e;
  e.type = Ty::Float;
  e.text = text;
  return e;
}

class DrawMaker {
 public:
  DrawMaker(Prng& random, AtomType& atom) : random_(random), atom_(atom) {}

  void make() {
    for (Transition& t : atom_.transitions) {
      if (random_.percent(60)) add(t.action);
    }
    if (random_.percent(40)) add(atom_.initial_action);
  }

 private:
  void add(Body& body) {
    for (int n = random_.between(1, 2); n > 0; --n) {
      if (atom_.data.empty()) return;
      const Var& target = random_.pick(atom_.data);
      if (target.type == Ty::String || target.type == Ty::Pair || target.type == Ty::Wide) continue;
      Stmt stmt;
      stmt.name = target.name;
      stmt.value = draw(target.type);
      // Two draws in one expression: from left to right.
      if (target.type != Ty::Bool && random_.percent(25))
        stmt.value = binary("+", std::move(stmt.value), draw(target.type), target.type);
      if (!random_.percent(20)) {
        body.push_back(std::move(stmt));
        continue;
      }
      Stmt branch;
      branch.is_if = true;
      branch.value = draw(Ty::Bool);
      branch.then_body.push_back(std::move(stmt));
      body.push_back(std::move(branch));
    }
  }

  // Of an int variable, or a literal.
  Expr bound(int low, int high) {
    for (const Var& var : atom_.data) {
      if (var.type == Ty::Int && random_.percent(4)) return name_of({"", var.name, Ty::Int, true});
    }
    return int_literal(random_.between(low, high));
  }

  Expr draw(Ty type) {
    Expr e;
    e.kind = ExprKind::Draw;
    e.type = type;
    if (type == Ty::Bool) {
      e.text = "flip";
      e.args = {float_literal(random_.percent(10) ? "1.0" : "0.4")};
    } else if (type == Ty::Int && random_.percent(60)) {
      e.text = "uniform";
      e.args = {bound(-3, 1), bound(2, 5)};
    } else if (type == Ty::Int) {
      e.text = "table";
      for (int n = random_.between(2, 4); n > 0; --n) {
        e.args.push_back(int_literal(random_.between(-5, 5)));
        // Not all of them are 0.
        e.args.push_back(float_literal(n > 1 && random_.percent(20) ? "0.0" : "2.5"));
      }
    } else {
      static const std::vector<std::string> kNames = {"uniform", "exponential", "normal"};
      e.text = random_.pick(kNames);
      if (e.text != "exponential") e.args.push_back(float_literal("0.5"));
      e.args.push_back(float_literal(random_.percent(50) ? "1.5" : "2.25"));
    }
    return e;
  }

  Prng& random_;
  AtomType& atom_;
};

}  // namespace

void make_draws(Prng& random, Description& model) {
  model.draws = true;
  for (AtomType& type : model.atom_types) {
    if (random.percent(70)) DrawMaker(random, type).make();
  }
}

}  // namespace bip::gen
