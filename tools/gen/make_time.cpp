// Adds time to a complete random model: clocks in units of different lengths, bounds with small limits (so that
// intervals intersect), urgency, invariants that usually can be satisfied, `resume`, `@async`, external event ports.
// Types in the paper's notation that get time are written in BIP2's.
#include <algorithm>

#include "tools/gen/make.hpp"

namespace bip::gen {
namespace {

class TimeMaker {
 public:
  TimeMaker(Prng& random, Description& model, AtomType& atom) : random_(random), model_(model), atom_(atom) {}

  void make() {
    atom_.paper = false;
    static const std::vector<std::string> units = {"millisecond", "millisecond", "millisecond", "microsecond",
                                                   "second"};
    const std::string unit = random_.pick(units);
    for (int k = 0, n = random_.between(1, 2); k < n; ++k)
      atom_.clocks.push_back({"k" + std::to_string(k), random_.percent(80) ? unit : random_.pick(units)});
    if (random_.percent(25)) make_event_port();
    static const std::vector<std::string> urgencies = {"", "", "lazy", "delayable", "delayable", "eager"};
    for (Transition& t : atom_.transitions) {
      if (t.port.empty()) continue;
      if (random_.percent(60)) t.when = bounds(2);
      t.urgency = random_.pick(urgencies);
      if (random_.percent(60))
        t.sets.push_back({random_.pick(atom_.clocks).name, random_.percent(80) ? 0 : random_.between(-2, 5), false});
      if (random_.percent(8)) t.sets.push_back({random_.pick(atom_.clocks).name, random_.between(0, 3), true});
      t.resumes = random_.percent(12);
      if (t.resumes && random_.percent(80))
        t.resume = {{random_.pick(atom_.clocks).name, "", random_.percent(70) ? ">=" : ">", "", random_.between(0, 6)}};
      t.is_async = random_.percent(8);
      if (t.is_async && random_.percent(70)) t.budget = random_.between(1, 9);
    }
    if (random_.percent(30)) make_invariant();
  }

 private:
  std::vector<ClockBound> bounds(int most) {
    static const std::vector<std::string> ops = {"<", "<=", ">", ">=", ">=", "<=", "=="};
    std::vector<ClockBound> result;
    for (int n = random_.between(1, most); n > 0; --n) {
      ClockBound b{random_.pick(atom_.clocks).name, "", random_.pick(ops), "", random_.between(0, 12)};
      if (atom_.clocks.size() == 2 && atom_.clocks[0].unit == atom_.clocks[1].unit && random_.percent(20)) {
        b.minus = atom_.clocks[b.clock == "k0" ? 1 : 0].name;
        b.limit = random_.between(-6, 6);
      }
      for (const Var& var : atom_.data) {
        if (var.type == Ty::Int && random_.percent(6)) b.limit_name = var.name;
      }
      result.push_back(std::move(b));
    }
    return result;
  }
  void make_invariant() {
    Invariant i{"late",
                random_.percent(80) ? "from" : "",
                {},
                {},
                {{random_.pick(atom_.clocks).name, "", random_.percent(70) ? "<=" : "<", "", random_.between(3, 20)}}};
    if (!i.scope.empty()) i.places.push_back(random_.pick(atom_.places));
    atom_.invariants.push_back(std::move(i));
  }
  // Of a type whose variables the atom has, each another one; events bring values of native types only.
  void make_event_port() {
    const PortType& type = random_.pick(model_.port_types);
    Port port{"e0", type.name, {}, false, "", ""};
    for (const Var& var : type.vars) {
      for (const Var& d : atom_.data) {
        if (d.type == var.type && d.type < Ty::Pair &&
            std::find(port.vars.begin(), port.vars.end(), d.name) == port.vars.end()) {
          port.vars.push_back(d.name);
          break;
        }
      }
    }
    if (port.vars.size() != type.vars.size()) port.type = "T0", port.vars.clear();
    static const std::vector<std::string> policies = {"remember", "remember", "remember", "ignore", "ignore", "error"};
    port.event = random_.pick(policies);
    atom_.ports.push_back(port);
    // Where the first group of places is: one transition a place.
    for (const std::string& place : atom_.places) {
      if (place[0] != 'S' || random_.percent(30)) continue;
      Transition t;
      t.port = "e0";
      t.from = {place};
      t.to = {random_.percent(50) ? place : random_.pick(atom_.places)};
      if (t.to[0][0] != 'S') t.to = {place};
      atom_.transitions.push_back(std::move(t));
    }
  }

  Prng& random_;
  Description& model_;
  AtomType& atom_;
};

}  // namespace

void make_time(Prng& random, Description& model) {
  for (AtomType& atom : model.atom_types) {
    if (random.percent(75)) TimeMaker(random, model, atom).make();
  }
}

}  // namespace bip::gen
