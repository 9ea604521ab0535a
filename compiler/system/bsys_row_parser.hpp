// Rows of .bsys: from an opened list to a row of a table. Internal to system/.
//
// Elements of a row come in the order in which `print` writes them; references point to rows above. After an error the
// reader gives harmless defaults, so what is returned is then not to be used.
#pragma once
#include "compiler/system/bsys_reader.hpp"

namespace bip::system::text {

class BsysRowParser {
 public:
  explicit BsysRowParser(const Tree& tree) : tree_(tree), reader_(tree, system_) {}

  PortType port_type(List& list);
  AtomType atom_type(List& list);
  ConnectorType connector_type(List& list);
  Compound compound(List& list);
  Atom atom(List& list);
  Choice choice(List& list);
  ShownPort shown_port(List& list, ConnectorTypeId type);
  Connector connector(List& list);
  Priority priority(List& list);

 protected:
  const Tree& tree_;
  System system_;
  BsysReader reader_;

 private:
  PortTypeId port_type_ref(List& list);
  /// The rest of the list as rows of `rows`, whose elements have a name or are one.
  template <class Rows>
  std::vector<std::uint32_t> refs(List& list, const Rows& rows, const char* what) {
    std::vector<std::uint32_t> out;
    while (reader_.more(list))
      out.push_back(reader_.ref(list, rows.size(), what, [&](std::uint32_t k) -> const std::string& {
        if constexpr (requires { rows[k].name; }) {
          return rows[k].name;
        } else {
          return rows[k];
        }
      }));
    reader_.close(list);
    return out;
  }
  template <class Rows>
  std::vector<std::uint32_t> sub_refs(List& list, const char* head, const Rows& rows, const char* what) {
    std::optional<List> found = reader_.sub(list, head);
    return found ? refs(*found, rows, what) : std::vector<std::uint32_t>();
  }
  CompoundId parent(List& list);
  CompoundId compound_ref(List& list);
  AtomId atom_ref(List& list);
  ConnectorId connector_ref(List& list);
  std::vector<DataRef> data(List& list);
  ExprId guard(List& list, const CodeScope& scope);
  StmtId body(List& list, const char* head, const CodeScope& scope);
  std::vector<DataVariable> variables(List& list);
  Clock clock(List& list, const AtomType& type);
  TimeGuard when(List& list, const AtomType& type, const CodeScope& scope);
  Resume resume(List& list, const AtomType& type, const CodeScope& scope);
  Async async(List& list, const AtomType& type);
  Weight weight(List& list, const AtomType& type);
  double number(List& list);
  void event(List& list, Port& port);
  Transition transition(List& list, const AtomType& type, const CodeScope& scope);
  AtomPriority atom_priority(List& list, const AtomType& type, const CodeScope& scope);
  Invariant invariant(List& list, const AtomType& type, const CodeScope& scope);
  MergedPort merged(List& list, const AtomType& type);
  /// Nodes in preorder: a stack of the groups whose lists are not yet at their end.
  void define(List& root, ConnectorType& type);
  /// In a choice, connectors stand below and are checked by `validate`.
  enum class PortPlace : std::uint8_t { Choice, Connector };
  PortRef port_ref(std::uint32_t node, PortPlace place);
  Pattern pattern(List& list, const char* head);
};

}  // namespace bip::system::text
