// Questions about a `define` tree, answered without listing interactions: linear in the tree.
#include <algorithm>

#include "runtime/include/bip/assert.hpp"

#include "compiler/model/model_builder.hpp"
#include "compiler/syntax/interaction_count.hpp"

namespace bip::model {

namespace {

// The largest choice below node `n` within `params`, appended to `out`; false if there is none.
bool largest(const ConnectorType& type, std::uint32_t n, const std::vector<std::uint32_t>& params,
             std::vector<std::uint32_t>& out) {
  BIP_ASSERT(n < type.define.size(), "node {} of {}", n, type.define.size());
  const DefineNode& node = type.define[n];
  if (node.is_leaf) {
    if (!std::binary_search(params.begin(), params.end(), node.param)) return false;
    out.push_back(node.param);
    return true;
  }
  const std::size_t before = out.size();
  bool has_triggers = false;
  bool has_chosen_trigger = false;
  bool all = true;
  for (const std::uint32_t child : node.children) {
    BIP_ASSERT(child > n, "`define` is in preorder: node {} below {}", child, n);
    has_triggers |= type.define[child].trigger;
    const bool chosen = largest(type, child, params, out);
    has_chosen_trigger |= chosen && type.define[child].trigger;
    all &= chosen;
  }
  const bool possible = has_triggers ? has_chosen_trigger : all && !node.children.empty();
  if (!possible) out.resize(before);
  return possible;
}

}  // namespace

std::vector<std::uint32_t> largest_interaction(const ConnectorType& type, const std::vector<std::uint32_t>& params) {
  BIP_ASSERT(std::is_sorted(params.begin(), params.end()), "parameters of an interaction are sorted");
  std::vector<std::uint32_t> out;
  if (!type.define.empty()) largest(type, 0, params, out);
  std::sort(out.begin(), out.end());
  BIP_ASSERT(std::includes(params.begin(), params.end(), out.begin(), out.end()),
             "an interaction is within what was asked");
  return out;
}

bool is_interaction(const ConnectorType& type, const std::vector<std::uint32_t>& params) {
  return !params.empty() && largest_interaction(type, params) == params;
}

std::vector<std::vector<std::uint32_t>> interactions_of(const ConnectorType& type, std::uint32_t n) {
  BIP_ASSERT(n < type.define.size(), "node {} of {}", n, type.define.size());
  using Set = std::vector<std::uint32_t>;
  const DefineNode& node = type.define[n];
  if (node.is_leaf) return {{node.param}};
  const bool has_triggers = std::any_of(node.children.begin(), node.children.end(),
                                        [&](std::uint32_t child) { return type.define[child].trigger; });
  // Without and with a trigger among them.
  std::vector<Set> plain{{}}, triggered;
  for (const std::uint32_t child : node.children) {
    const std::vector<Set> below = interactions_of(type, child);
    std::vector<Set> plain_now, triggered_now;
    if (has_triggers) {
      plain_now = plain;
      triggered_now = triggered;
    }
    const auto join = [&](const std::vector<Set>& left, std::vector<Set>& to) {
      for (const Set& set : left) {
        for (const Set& more : below) {
          to.push_back(set);
          to.back().insert(to.back().end(), more.begin(), more.end());
        }
      }
    };
    join(plain, has_triggers && type.define[child].trigger ? triggered_now : plain_now);
    join(triggered, triggered_now);
    plain = std::move(plain_now);
    triggered = std::move(triggered_now);
  }
  std::vector<Set> sets = has_triggers ? std::move(triggered) : std::move(plain);
  for (Set& set : sets) std::sort(set.begin(), set.end());
  return sets;
}

double interaction_count(const ConnectorType& type, std::uint32_t n) {
  BIP_ASSERT(n < type.define.size(), "node {} of {}", n, type.define.size());
  const DefineNode& node = type.define[n];
  if (node.is_leaf) return 1;
  syntax::GroupCount group;
  for (const std::uint32_t child : node.children) group.add(interaction_count(type, child), type.define[child].trigger);
  return group.count();
}

std::string interaction_text(const ConnectorType& type, const std::vector<std::uint32_t>& params) {
  std::string text;
  for (const std::uint32_t p : params) {
    BIP_ASSERT(p < type.params.size(), "parameter {} of {}", p, type.params.size());
    if (!text.empty()) text += ' ';
    text += type.params[p].name;
  }
  return text;
}

}  // namespace bip::model
