// Random connector types: a `define` tree of synchrons, triggers and groups, clauses for some of its interactions, own
// data that is exported.
#include <algorithm>

#include "tools/gen/make.hpp"

namespace bip::gen {
namespace {

using Sets = std::vector<std::vector<int>>;

std::vector<int> merged(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> result = a;
  result.insert(result.end(), b.begin(), b.end());
  std::sort(result.begin(), result.end());
  return result;
}

Sets joined(const Sets& left, const Sets& right) {
  Sets result;
  for (const auto& a : left) {
    for (const auto& b : right) result.push_back(merged(a, b));
  }
  return result;
}

/// Groups of consecutive parameters, nested at most `depth` deep; weak_percent of them have triggers.
Define random_group(Prng& random, const std::vector<int>& params, int depth, int weak_percent) {
  Define group;
  int trigger_percent = random.percent(weak_percent) ? 45 : (random.percent(50) ? 0 : 15);
  for (std::size_t at = 0; at < params.size();) {
    std::size_t left = params.size() - at;
    std::size_t size = depth > 0 && left >= 2 && random.percent(25) ? 2 + random.below(left - 1) : 1;
    if (size == params.size() && size > 1) size = 1;
    Define child;
    if (size > 1) {
      std::vector<int> part(params.begin() + static_cast<std::ptrdiff_t>(at),
                            params.begin() + static_cast<std::ptrdiff_t>(at + size));
      child = random_group(random, part, depth - 1, weak_percent);
    } else {
      child.param = params[at];
    }
    child.trigger = random.percent(trigger_percent);
    group.children.push_back(child);
    at += size;
  }
  return group;
}

class ConnectorMaker {
 public:
  ConnectorMaker(Prng& random, const Style& style, const std::vector<PortType>& port_types)
      : random_(random), style_(style), port_types_(port_types), code_(random, style) {}

  ConnectorType make(const std::vector<std::string>& params, bool exports, const std::string& name) {
    type_.name = name;
    std::vector<int> order;
    for (std::size_t k = 0; k < params.size(); ++k) {
      type_.params.push_back({"q" + std::to_string(k), params[k]});
      order.push_back(static_cast<int>(k));
    }
    if (random_.percent(30)) random_.shuffle(order);
    bool is_broadcast = style_.regular && random_.percent(20);
    type_.define =
        style_.regular ? regular_group(order, is_broadcast) : random_group(random_, order, 2, style_.deep ? 65 : 50);
    if (exports) make_export();
    if (random_.percent(35)) own(code_.type());
    if (!is_broadcast) make_clauses();
    return type_;
  }

 private:
  Define regular_group(const std::vector<int>& params, bool is_broadcast) {
    Define group;
    for (int param : params) {
      Define child;
      child.param = param;
      child.trigger = is_broadcast && (group.children.empty() || random_.percent(10));
      group.children.push_back(child);
    }
    return group;
  }
  std::string own(Ty type) {
    Var var;
    var.name = "z" + std::to_string(type_.data.size());
    var.type = type;
    if (style_.has_initial_values && type != Ty::Pair && type != Ty::Wide && random_.percent(50))
      var.init = code_.literal(type);
    type_.data.push_back(var);
    return var.name;
  }
  void make_export() {
    const PortType& type = random_.pick(port_types_);
    type_.exports = true;
    type_.export_name = "e";
    type_.export_type = type.name;
    for (const Var& var : type.vars) type_.export_vars.push_back(own(var.type));
  }
  void make_clauses() {
    Sets sets = expand(type_.define);
    random_.shuffle(sets);
    if (sets.size() > 12) sets.resize(12);
    int percent = type_.exports ? 85 : 60;
    for (const auto& set : sets) {
      if (random_.percent(percent)) type_.clauses.push_back(clause(set));
    }
  }
  Clause clause(const std::vector<int>& set) {
    Clause result;
    result.params = set;
    std::vector<Known> ports, own;
    for (int p : set) {
      const ConnectorParam& param = type_.params[static_cast<std::size_t>(p)];
      for (const Var& var : find_named(port_types_, param.type)->vars)
        ports.push_back({param.name, var.name, var.type, true});
    }
    for (const Var& var : type_.data) own.push_back({"", var.name, var.type, true});
    std::vector<Known> all = ports, readable = ports;
    all.insert(all.end(), own.begin(), own.end());
    for (Known& k : readable) k.writable = false;
    readable.insert(readable.end(), own.begin(), own.end());
    if (random_.percent(style_.regular ? (type_.exports ? 0 : 15) : style_.deep ? 50 : 35))
      result.guard = code_.guard(all);
    if (type_.exports && random_.percent(85))
      result.up = code_.body(readable, random_.between(1, 3), 1, CodeMaker::Changes::ByAssignment);
    // What `up` computed is only seen if it reaches an atom: own data get more weight.
    for (int copies = 0; copies < 2; ++copies) all.insert(all.end(), own.begin(), own.end());
    if (random_.percent(65)) result.down = code_.body(all, random_.between(1, 3), 1);
    if (random_.percent(20)) random_.shuffle(result.params);
    return result;
  }

  Prng& random_;
  const Style& style_;
  const std::vector<PortType>& port_types_;
  CodeMaker code_;
  ConnectorType type_;
};

}  // namespace

std::vector<std::vector<int>> expand(const Define& define) {
  if (define.param >= 0) return {{define.param}};
  bool any_trigger =
      std::any_of(define.children.begin(), define.children.end(), [](const Define& d) { return d.trigger; });
  // Partial choices, and whether one of them holds a trigger already.
  std::vector<std::pair<std::vector<int>, bool>> chosen = {{{}, false}};
  for (const Define& child : define.children) {
    Sets mine = expand(child);
    std::vector<std::pair<std::vector<int>, bool>> next;
    for (const auto& [set, has_trigger] : chosen) {
      if (any_trigger) next.emplace_back(set, has_trigger);
      for (const auto& grown : joined({set}, mine)) next.emplace_back(grown, has_trigger || child.trigger);
    }
    chosen = std::move(next);
  }
  Sets result;
  for (auto& [set, has_trigger] : chosen) {
    if (has_trigger || !any_trigger) result.push_back(std::move(set));
  }
  return result;
}

ConnectorType make_connector(Prng& random, const Style& style, const std::vector<PortType>& port_types,
                             const std::vector<std::string>& params, bool exports, const std::string& name) {
  return ConnectorMaker(random, style, port_types).make(params, exports, name);
}

}  // namespace bip::gen
