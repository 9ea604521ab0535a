// Random priority rules. Connectors are ranked, and a rule between two connectors goes up in rank. A rule within a
// connector is the only one of that connector, and neither of its sides contains the other. A rule with *:* is the only
// rule. So no cycle can close, whatever the values of guards.
#include <algorithm>

#include "tools/gen/make.hpp"

namespace bip::gen {
namespace {

bool contains(const std::vector<int>& big, const std::vector<int>& small) {
  return std::includes(big.begin(), big.end(), small.begin(), small.end());
}

std::vector<Known> readable_data(const Description& model, const CompoundType& compound) {
  std::vector<Known> result;
  for (const Component& component : compound.components) {
    if (!component.size.empty()) continue;
    if (const AtomType* atom = find_named(model.atom_types, component.type)) {
      for (const Var& var : atom->data) {
        if (var.exported) result.push_back({component.name, var.name, var.type, false});
      }
    } else if (const CompoundType* inner = find_named(model.compound_types, component.type)) {
      for (const DataExport& e : inner->data_exports) result.push_back({component.name, e.name, e.type, false});
    }
  }
  return result;
}

class PriorityMaker {
 public:
  PriorityMaker(Prng& random, const Style& style, const Description& model, CompoundType& compound)
      : random_(random),
        style_(style),
        model_(model),
        compound_(compound),
        code_(random, style),
        data_(readable_data(model, compound)) {}

  void make() {
    for (const Connector& c : compound_.connectors) {
      if (c.size.empty() && (!type_of(c).exports || is_top_level(c))) ranked_.push_back(&c);
    }
    if (ranked_.empty()) return;
    random_.shuffle(ranked_);
    if (!style_.regular && random_.percent(20)) return star();
    if (style_.ruled && ranked_.size() > 4) ranked_.resize(4);  // chains need rules that meet
    for (int k = style_.ruled ? random_.between(2, 6) : random_.between(1, 3); k > 0; --k) {
      if (ranked_.size() >= 2 && random_.percent(75)) {
        between_connectors();
      } else {
        within_connector();
      }
    }
  }

 private:
  const ConnectorType& type_of(const Connector& c) const { return *find_named(model_.connector_types, c.type); }
  // No connector of this compound binds it. Half of them: they need the search, and the fast ways want rules, too.
  bool is_top_level(const Connector& exporting) {
    for (const Connector& c : compound_.connectors) {
      for (const PortPath& path : c.ports) {
        if (path.component == exporting.name) return false;
      }
    }
    return random_.percent(50);
  }
  Pattern side(const Connector& c) {
    Pattern pattern;
    pattern.connector = c.name;
    pattern.any_interaction = random_.percent(40);
    if (!pattern.any_interaction) pattern.params = random_.pick(expand(type_of(c).define));
    return pattern;
  }
  void add(Pattern low, Pattern high) {
    Priority rule;
    rule.name = "r" + std::to_string(compound_.priorities.size());
    rule.low = std::move(low);
    rule.high = std::move(high);
    if (!style_.regular && random_.percent(40)) rule.guard = code_.guard(data_);
    compound_.priorities.push_back(std::move(rule));
  }
  void star() {
    Pattern any;
    any.any_connector = true;
    if (compound_.connectors.size() < 2) return;
    if (random_.percent(50)) {
      add(any, side(*ranked_[0]));
    } else {
      add(side(*ranked_[0]), any);
    }
  }
  void between_connectors() {
    std::size_t low = random_.below(ranked_.size() - 1);
    std::size_t high = low + 1 + random_.below(ranked_.size() - low - 1);
    Pattern low_side = side(*ranked_[low]);
    add(std::move(low_side), side(*ranked_[high]));
  }
  void within_connector() {
    const Connector& c = *random_.pick(ranked_);
    if (ruled_within_.contains(c.name)) return;
    auto sets = expand(type_of(c).define);
    random_.shuffle(sets);
    for (std::size_t k = 1; k < sets.size(); ++k) {
      if (contains(sets[0], sets[k]) || contains(sets[k], sets[0])) continue;
      ruled_within_.insert(c.name);
      Pattern low, high;
      low.connector = high.connector = c.name;
      low.params = sets[0];
      high.params = sets[k];
      return add(low, high);
    }
  }

  Prng& random_;
  const Style& style_;
  const Description& model_;
  CompoundType& compound_;
  CodeMaker code_;
  std::vector<Known> data_;
  std::vector<const Connector*> ranked_;
  std::set<std::string> ruled_within_;
};

}  // namespace

void make_priorities(Prng& random, const Style& style, const Description& model, CompoundType& compound) {
  PriorityMaker(random, style, model, compound).make();
}

}  // namespace bip::gen
