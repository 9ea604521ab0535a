// Promises of connector types: parameters, the define tree, clauses that are interactions of it, the exported port.
//
// A clause is checked by climbing from its leaves and counting, at each group met, the children and triggers that take
// part; groups that are not met cost nothing. So all clauses together cost what they write down times the depth.
#include <set>

#include "compiler/system/bsys_text.hpp"
#include "compiler/system/validate_problems.hpp"

namespace bip::system {
namespace {

constexpr std::uint32_t kNoRow = 0xffffffffu;

class DefineTree {
 public:
  DefineTree(const ConnectorType& type, Problems& problems)
      : type_(type),
        problems_(problems),
        parent_(type.define.size(), kNoRow),
        leaf_of_(type.params.size(), kNoRow),
        present_(type.define.size(), 0),
        triggers_(type.define.size(), 0),
        seen_(type.define.size(), false),
        trigger_children_(type.define.size(), 0) {}

  /// Preorder rows, each but the root the child of one group, each parameter one leaf.
  bool check_shape() {
    const std::vector<DefineNode>& nodes = type_.define;
    if (!problems_.expect(!nodes.empty() && !nodes[0].is_leaf, "a define has no group at its root")) return false;
    // The rows that preorder must bring next, last first.
    std::vector<std::uint32_t> expected{0};
    std::vector<std::uint32_t> depth(nodes.size(), 0);
    for (std::uint32_t row = 0; row < nodes.size(); ++row) {
      if (!problems_.expect(!expected.empty() && expected.back() == row, "a define is not a tree in preorder"))
        return false;
      expected.pop_back();
      if (!(nodes[row].is_leaf ? check_leaf(row) : check_group(row, depth))) return false;
      expected.insert(expected.end(), nodes[row].children.rbegin(), nodes[row].children.rend());
    }
    if (!problems_.expect(expected.empty(), "a define's child is no row")) return false;
    for (const std::uint32_t leaf : leaf_of_)
      if (!problems_.expect(leaf != kNoRow, "a parameter is missing in the define")) return false;
    return true;
  }

  /// True if `define` gives the interaction with exactly these parameters.
  bool gives(const std::vector<std::uint32_t>& params) {
    for (const std::uint32_t param : params) climb(leaf_of_[param]);
    bool is_interaction = !params.empty();
    for (const std::uint32_t row : touched_) {
      const bool joined =
          trigger_children_[row] == 0 ? present_[row] == type_.define[row].children.size() : triggers_[row] > 0;
      is_interaction = is_interaction && (type_.define[row].is_leaf || joined);
      present_[row] = 0;
      triggers_[row] = 0;
      seen_[row] = false;
    }
    touched_.clear();
    return is_interaction;
  }

 private:
  bool check_leaf(std::uint32_t row) {
    const DefineNode& node = type_.define[row];
    if (!problems_.expect(node.children.empty(), "a leaf of a define has children") ||
        !problems_.expect(node.param < type_.params.size(), "a define names no parameter") ||
        !problems_.expect(leaf_of_[node.param] == kNoRow, "a parameter is twice in the define"))
      return false;
    leaf_of_[node.param] = row;
    return true;
  }
  bool check_group(std::uint32_t row, std::vector<std::uint32_t>& depth) {
    const DefineNode& node = type_.define[row];
    if (!problems_.expect(!node.children.empty(), "a group of a define is empty") ||
        !problems_.expect(depth[row] < text::kMaxCodeDepth, "a define is nested too deep"))
      return false;
    for (const std::uint32_t child : node.children) {
      if (!problems_.expect(child > row && child < type_.define.size(), "a define's child is no later row") ||
          !problems_.expect(parent_[child] == kNoRow, "a row of a define has two parents"))
        return false;
      parent_[child] = row;
      depth[child] = depth[row] + 1;
      if (type_.define[child].trigger) ++trigger_children_[row];
    }
    return true;
  }
  void climb(std::uint32_t row) {
    while (row != kNoRow && !seen_[row]) {
      seen_[row] = true;
      touched_.push_back(row);
      const std::uint32_t up = parent_[row];
      if (up != kNoRow) {
        ++present_[up];
        if (type_.define[row].trigger) ++triggers_[up];
      }
      row = up;
    }
  }

  const ConnectorType& type_;
  Problems& problems_;
  std::vector<std::uint32_t> parent_, leaf_of_;
  std::vector<std::size_t> present_;
  std::vector<std::uint32_t> triggers_;
  std::vector<bool> seen_;
  std::vector<std::uint32_t> trigger_children_;
  std::vector<std::uint32_t> touched_;
};

bool check_params(const System& system, const ConnectorType& type, Problems& problems) {
  std::size_t bind = 0;
  for (const ConnectorParam& param : type.params) {
    check_loc(system, param.loc, problems);
    if (!problems.expect(system.port_types.contains(param.type), "a parameter's type is no row")) return false;
    problems.expect(param.first_bind == bind, "a parameter's first bind does not follow the one before");
    bind += system.port_types[param.type].variables.size();
  }
  for (const DataRead& read : type.data_reads) problems.expect(is_type(system, read.type), "a data read has no type");
  for (const DataVariable& variable : type.variables) {
    check_loc(system, variable.loc, problems);
    problems.expect(is_type(system, variable.type), "a variable has no type");
  }
  return true;
}

void check_clauses(const System& system, const ConnectorType& type, DefineTree& tree, Problems& problems) {
  std::set<std::vector<std::uint32_t>> seen;
  for (const Clause& clause : type.clauses) {
    check_loc(system, clause.loc, problems);
    bool sound = true;
    for (std::size_t k = 0; k < clause.params.size() && sound; ++k)
      sound =
          problems.expect(clause.params[k] < type.params.size(), "a clause's parameter is no row") &&
          problems.expect(k == 0 || clause.params[k - 1] < clause.params[k], "a clause's parameters are not sorted");
    if (!sound) continue;
    problems.expect(tree.gives(clause.params), "a clause is no interaction of the define");
    problems.expect(seen.insert(clause.params).second, "two clauses are about one interaction");
  }
}

void check_export(const System& system, const ConnectorType& type, Problems& problems) {
  if (!problems.expect(system.port_types.contains(type.export_type), "an exported port's type is no row")) return;
  const std::vector<Variable>& variables = system.port_types[type.export_type].variables;
  if (!problems.expect(type.export_variables.size() == variables.size(),
                       "an exported port has not one variable of the atom a variable"))
    return;
  for (std::size_t k = 0; k < variables.size(); ++k)
    if (problems.expect(type.export_variables[k] < type.variables.size(), "an exported port's variable is no row"))
      problems.expect(type.variables[type.export_variables[k]].type == variables[k].type,
                      "an exported port's variable has not the variable's type");
}

}  // namespace

void check_connector_types(const System& system, Problems& problems) {
  for (std::size_t k = 0; k < system.connector_types.size(); ++k) {
    const ConnectorType& type = system.connector_types.rows()[k];
    problems.at(Table::ConnectorTypes, k);
    check_loc(system, type.loc, problems);
    if (!check_params(system, type, problems)) continue;
    DefineTree tree(type, problems);
    if (tree.check_shape()) check_clauses(system, type, tree, problems);
    if (type.exports) check_export(system, type, problems);
  }
}

}  // namespace bip::system
