// The class behind promela(), shared by the files for atoms, connectors and priorities. Internal to exchange/.
#pragma once
#include <set>

#include "compiler/exchange/exchange.hpp"
#include "compiler/exchange/promela_code.hpp"

namespace bip::exchange {

class PromelaWriter {
 public:
  PromelaWriter(const System& system, const Options& options)
      : system_(system), options_(options), code_(system, refusal_) {}
  Result<std::string> run();

 private:
  /// One interaction of a connector on top.
  struct Step {
    ConnectorId connector;
    std::size_t tree = 0;  // row of trees_
    std::string name;      // "3_1": of connector 3 the second
    Leaves leaves;
    std::vector<u32> params;  // that take part
  };

  // promela_atoms.cpp
  [[nodiscard]] const AtomType& type_of(AtomId atom) const { return system_.atom_types[system_.atoms[atom].type]; }
  [[nodiscard]] std::string variable_name(AtomId atom, u32 variable) const;
  [[nodiscard]] Names names_of(AtomId atom) const;
  [[nodiscard]] std::string marked(AtomId atom, const std::vector<u32>& places) const;
  [[nodiscard]] std::string enabled(AtomId atom, const Transition& t);
  [[nodiscard]] std::string both(AtomId atom, const Transition& a, const Transition& b);
  [[nodiscard]] std::string move(AtomId atom, const Transition& t, const std::string& indent);
  void declare(AtomId atom);
  void add_ports(AtomId atom);
  void add_settle(AtomId atom);
  void add_initial(AtomId atom, std::string& out);
  [[nodiscard]] std::string port_name(AtomId atom, u32 port) const {
    return "on" + std::to_string(atom.value) + '_' + std::to_string(port);
  }

  // promela_connectors.cpp
  void add_connector(ConnectorId connector);
  [[nodiscard]] std::string enabled(const ConnectorTree& tree, u32 root, const Leaves& leaves);
  [[nodiscard]] Names names_of(const ConnectorTree& tree, const ConnectorTree::Use& use,
                               const std::vector<std::uint8_t>& chosen,
                               std::function<std::string(u32 use, u32 variable)> frame) const;
  [[nodiscard]] std::string frame_name(ConnectorId connector, u32 variable) const;
  [[nodiscard]] std::string effect(const Step& step);
  void fire_use(const ConnectorTree& tree, u32 use, const std::vector<std::uint8_t>& chosen, std::string& out);
  [[nodiscard]] std::string record(AtomId atom, u32 port);
  [[nodiscard]] std::string fire(AtomId atom, u32 port);
  [[nodiscard]] std::string told(const Step& step) const;

  // promela_priorities.cpp
  [[nodiscard]] bool matches(const Priority& rule, bool high, const Step& step) const;
  void add_priorities();
  [[nodiscard]] bool has_cycle(const std::vector<std::set<std::size_t>>& next) const;

  const System& system_;
  const Options& options_;
  std::string refusal_;
  PromelaCode code_;
  std::string declarations_, macros_, inlines_;
  std::vector<ConnectorTree> trees_;  // of the connectors on top
  std::vector<Step> steps_;
};

}  // namespace bip::exchange
