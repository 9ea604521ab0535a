// States of two components that stand for any two of those that are like them, and of what is beside these. A state of
// the whole is allowed if each two of them, in either order, are in a listed state with what is beside them. That every
// step keeps this is checked of one pair and a third one, for any numbers that tell them apart: here it is checked that
// any three are to the rest as these three are. So a step of one of them, with others than its like, is a step of these
// three; and one in which all take part is for the three a step that they may take if the others can.
//
// After C. Flanagan, S. Qadeer: Thread-Modular Model Checking (2003).
#include <array>

#include "tools/certcheck/checked_model.hpp"

namespace certcheck {
namespace {

class PairReader {
 public:
  PairReader(const Model& model, const Certificate& certificate) : model_(model), proof_(certificate) {}

  PairModel run() {
    const std::size_t first = proof_.pair->first, second = proof_.pair->second;
    if (first == second || !contains(proof_.is_told[first], true) || !contains(proof_.is_told[second], true))
      throw Rejected("the states do not tell of two components");
    like_ = {first, second};
    for (std::size_t a = 0; a < model_.atoms.size(); ++a)
      if (!contains(proof_.is_told[a], true)) like_.push_back(a);
    if (like_.size() < 3) throw Rejected("no third component is like these two");
    for (std::size_t a : like_)
      if (model_.atoms[a].type != model_.atoms[first].type) fail(model_.atoms[a].path);
    if (!model_.priorities.empty() || !model_.tree.find({"resume"}).empty())
      throw NotCheckable("priorities or `resume` beside a pair of components");
    pair_.model = model_;
    std::copy_n(like_.begin(), 3, pair_.members.begin());
    compare_args();
    compare_connectors();
    leave_out();
    return std::move(pair_);
  }

 private:
  [[noreturn]] static void fail(Text path) { throw NotCheckable(quoted(path) + " does not treat all alike"); }
  [[nodiscard]] bool is_member(std::size_t atom) const { return contains(pair_.members, atom); }

  // Those that differ are numbers, each of them another one.
  void compare_args() {
    const Tree& args = *model_.atoms[like_[0]].args;
    for (std::size_t k = 1; k < args.items.size(); ++k) {
      std::vector<int> numbers;
      const bool differ =
          std::ranges::any_of(like_, [&](std::size_t a) { return model_.atoms[a].args->at(k) != args.at(k); });
      for (std::size_t a : differ ? like_ : Rows()) {
        const Tree& arg = model_.atoms[a].args->at(k);
        if (arg.is_string) fail(model_.atoms[a].path);
        numbers.push_back(arg.number(0x7fffffff));
      }
      if (!differ) continue;
      for (std::size_t j = 0; j < 3; ++j) pair_.args[j].push_back(&model_.atoms[like_[j]].args->at(k));
      if (std::set(numbers.begin(), numbers.end()).size() != numbers.size() ||
          (!pair_.numbers.empty() && pair_.numbers != numbers))
        fail(model_.atoms[like_[0]].path);
      pair_.numbers = std::move(numbers);
    }
  }

  // One of them and what is beside them: each has the same such connectors. Or all of them: by the same port.
  void compare_connectors() {
    using Use = std::tuple<std::size_t, Rows, Rows>;  // type; atom (its own: kNone) and port by parameter; data
    std::map<std::size_t, std::vector<Use>> uses;
    const std::vector<const Tree*> rows = model_.tree.all("connector");
    for (std::size_t c = 0; c < rows.size(); ++c) {
      const Connector& connector = model_.connectors[c];
      std::set<std::size_t, std::greater<>> tree{connector.root};
      for (std::size_t node : tree)
        for (const Edge& edge : model_.nodes[node].children) tree.insert(edge.node);
      Rows own, data, ports;
      for (std::size_t node : tree)
        if (model_.nodes[node].kind == Kind::Port && contains(like_, model_.atom_of_port[node])) own.push_back(node);
      for (const Tree* of : connector.data->all("of")) {
        data.insert(data.end(), {of->at(1).row(), of->at(2).row()});
        if (contains(like_, of->at(1).row())) fail(connector.path);
      }
      if (own.empty()) continue;
      const auto is_port = [&](const Edge& edge) { return model_.nodes[edge.node].kind == Kind::Port; };
      if (!model_.nodes[connector.root].is_step || !std::ranges::all_of(connector.params, is_port))
        fail(connector.path);
      const auto port_of = [&](std::size_t node) { return node - model_.first_port[model_.atom_of_port[node]]; };
      if (own.size() == 1) {
        const std::size_t atom = model_.atom_of_port[own[0]];
        for (const Edge& edge : connector.params) {
          const std::size_t of = model_.atom_of_port[edge.node];
          ports.insert(ports.end(), {of == atom ? kNone : of, port_of(edge.node)});
        }
        uses[atom].emplace_back(rows[c]->at(3).row(), std::move(ports), std::move(data));
        pair_.model.nodes[connector.root].is_step = is_member(atom);
        continue;
      }
      std::set<std::size_t> atoms;
      for (std::size_t node : own) atoms.insert(model_.atom_of_port[node]);
      const bool is_rendezvous = std::ranges::all_of(tree, [&](std::size_t node) {
        return model_.nodes[node].kind == Kind::Port || model_.nodes[node].kind == Kind::All;
      });
      const bool is_same = std::ranges::all_of(own, [&](std::size_t node) { return port_of(node) == port_of(own[0]); });
      if (own.size() != like_.size() || atoms.size() != like_.size() || !is_rendezvous || !is_same ||
          !connector.clauses.empty() || !data.empty())
        fail(connector.path);
      cut(pair_.model.connectors[c], tree);
    }
    for (std::size_t a : like_) {
      std::ranges::sort(uses[a]);
      if (uses[a] != uses[like_[0]]) fail(model_.atoms[a].path);
    }
  }
  // Only members take part.
  void cut(Connector& connector, const std::set<std::size_t, std::greater<>>& tree) {
    const auto is_other = [&](const Edge& edge) {
      if (model_.nodes[edge.node].kind != Kind::Port) return false;
      const std::size_t atom = model_.atom_of_port[edge.node];
      return contains(like_, atom) && !is_member(atom);
    };
    connector.is_cut = true;
    std::erase_if(connector.params, is_other);
    for (std::size_t node : tree) std::erase_if(pair_.model.nodes[node].children, is_other);
  }

  void leave_out() {
    AtomType other = empty_type("other");
    other.ports = model_.type_of(like_[0]).ports;
    for (std::size_t a : like_) {
      if (is_member(a)) continue;
      pair_.model.atoms[a].type = pair_.model.atom_types.size();
      for (std::size_t port = model_.first_port[a]; port < model_.first_port[a + 1]; ++port)
        pair_.model.nodes[port].is_step = false;
    }
    pair_.model.atom_types.push_back(std::move(other));
  }

  const Model& model_;
  const Certificate& proof_;
  Rows like_;  // the two, a third one, the others
  PairModel pair_;
};

}  // namespace

PairModel model_of_pair(const Model& model, const Certificate& certificate) {
  return PairReader(model, certificate).run();
}

}  // namespace certcheck
