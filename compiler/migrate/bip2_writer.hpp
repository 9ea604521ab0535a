// The declarations of a BIP1 model as lines of BIP2.
//
// A line knows where its source is, so that the comments of the source find their lines (`with_comments`).
#pragma once
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/migrate/bip2_names.hpp"
#include "compiler/migrate/cpp_functions.hpp"
#include "compiler/migrate/variables.hpp"
#include "compiler/syntax/bip1.hpp"

namespace bip::migrate {

class Bip2Writer {
 public:
  Bip2Writer(const syntax::bip1::Model& model, const SourceMap& sources, Diagnostics& diags);

  /// The package; `cpp_stem` names the files of C++.
  [[nodiscard]] std::string run(const std::string& cpp_stem);
  [[nodiscard]] const CppFunctions& cpp() const { return cpp_; }

 private:
  struct Line {
    int indent = 0;
    std::string text{};
    std::uint32_t begin = 0, end = 0;  // of its source; equal: none
  };
  /// One element of a compound, for the types of what its connectors bind.
  using Elements = std::map<std::string, std::string, std::less<>>;  // name to type

  // bip2_writer.cpp
  void decl(const syntax::bip1::Decl& d);
  void port_type(const syntax::bip1::Decl& d);
  void atom_type(const syntax::bip1::Decl& d);
  void atom_behavior(const syntax::bip1::Decl& d, const Variables& variables, const std::string& first_values);
  void transition(const syntax::bip1::Decl& d, const syntax::bip1::Transition& t, const Variables& variables);
  /// Null: data of a connector. Returns the statements that give the first values that need C++.
  std::string data(const syntax::bip1::Data& data, Variables& variables, const syntax::bip1::Decl* atom);
  void find_exported(const syntax::bip1::Decl& d, const syntax::bip1::Priority& p);
  void port(const syntax::bip1::Port& port, const Variables& variables);
  std::string params(const std::vector<syntax::bip1::Param>& params, Variables& variables);
  /// The port type of a connector's parameter.
  std::string port_type_of(const syntax::bip1::Param& param);
  std::string guards(const std::vector<syntax::bip1::Guard>& list, const Variables& variables,
                     const std::string& owner);
  /// The text of an expression; empty after a report.
  std::string value(const syntax::bip1::Guard& guard, const VariableType& type, const Variables& variables,
                    const std::string& owner);
  /// The same where BIP2 computes before the run and calls no C++.
  std::string constant(const syntax::bip1::Guard& guard, const VariableType& type, const Variables& variables);
  /// The statements of a block without its braces.
  std::string action(const syntax::bip1::Code& code, const Variables& variables, const std::string& owner);
  void headers(const std::vector<syntax::bip1::Code>& list);
  [[nodiscard]] VariableType known(ValueKind kind);
  /// The name of a port's type; a new one for a port without.
  std::string port_type_name(const syntax::bip1::Port& port, const Variables& variables);

  // write_connectors.cpp
  void connector_type(const syntax::bip1::Decl& d);
  void connector_body(const syntax::bip1::ConnectorBody& body, const std::vector<syntax::bip1::Path>& ports,
                      Variables& variables, const std::string& owner);
  std::string define(const syntax::bip1::ConnectorBody& body, const std::vector<syntax::bip1::Path>& ports);
  std::string term(const syntax::bip1::PortTerm& term) const;
  void clause(const syntax::bip1::Clause& clause, const Variables& variables, bool has_export,
              const std::string& owner);
  /// Adds the variables of a port of this type under `prefix`.
  void add_port_variables(const std::string& prefix, std::string_view type, Variables& to);

  // write_compounds.cpp
  void compound_type(const syntax::bip1::Decl& d);
  void instances(const syntax::bip1::Instances& list, const Variables& variables);
  void connector(const syntax::bip1::Connector& c, const Elements& elements);
  void priority(const syntax::bip1::Priority& p, const syntax::bip1::Decl& owner);
  std::string side(const syntax::bip1::PrioritySide& s, const syntax::bip1::Decl& owner, SourceRange at);
  void compound_export(const syntax::bip1::Export& e);
  void roots();
  /// Adds the variables of `a.p`, if they are to be seen.
  void add_bound_variables(const syntax::bip1::Path& port, const Elements& elements, Variables& to);

  // lines
  void line(std::string text, SourceRange source) {
    lines_.push_back({indent_, std::move(text), source.begin, source.end});
  }
  void open(std::string text, SourceRange source);
  void close(SourceRange source);
  /// Reports, and leaves a comment in the text.
  void no_counterpart(SourceRange at, const std::string& what, const std::string& why);
  [[nodiscard]] std::string place(SourceRange at) const;
  [[nodiscard]] std::string in_one_line(SourceRange at) const;
  [[nodiscard]] std::string with_comments(const std::vector<Line>& lines) const;

  const syntax::bip1::Model& model_;
  const SourceMap& sources_;
  Diagnostics& diags_;
  Bip2Names names_;
  CppFunctions cpp_;
  std::map<std::string_view, const syntax::bip1::Decl*> decls_;
  std::set<std::pair<std::string_view, std::string_view>> exported_;  // data of atom types, by type and name
  std::vector<Line> lines_;
  int indent_ = 0;
  std::map<std::string, std::string> port_types_;  // of ports without a type: by their parameters
};

}  // namespace bip::migrate
