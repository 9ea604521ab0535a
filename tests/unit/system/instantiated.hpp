// A text, its model and its system, and the system in a few words, for tests of the unfolding.
#pragma once
#include <string>

#include "compiler/parse/parse.hpp"
#include "compiler/system/instantiate.hpp"
#include "compiler/system/system.hpp"

namespace bip::test {

struct Instantiated {
  explicit Instantiated(const std::string& text, const std::string& root = {})
      : file(sources.add("test.bip", text)), syntax(parse::parse_file(sources, file, diags)) {
    if (!syntax || diags.has_errors()) return;
    model = model::build_model(*syntax, sources, diags);
    if (!model || diags.has_errors()) return;
    std::optional<parse::RootSpec> spec;
    if (!root.empty()) spec = parse::parse_root(sources, root, diags);
    if (diags.has_errors()) return;
    system = system::instantiate(*model, spec ? spec->type : "", spec ? spec->args : std::vector<const syntax::Expr*>(),
                                 diags, {file, 0, 0});
  }
  SourceMap sources;
  FileId file;
  Diagnostics diags;
  std::optional<syntax::Syntax> syntax;
  std::optional<Model> model;
  std::optional<System> system;

  /// Codes of the errors: warnings about ports that nobody binds are no matter here.
  [[nodiscard]] std::string codes() const {
    std::string out;
    for (const Diagnostic* d : diags.sorted()) {
      if (d->severity == Severity::Error) out += (out.empty() ? "" : " ") + std::string(info(d->kind).code);
    }
    return out;
  }

  [[nodiscard]] std::string text(const PortRef& ref) const {
    switch (ref.kind) {
      case PortRef::Kind::Atom: {
        const Atom& atom = system->atoms[ref.atom];
        return atom.path + "." + system->atom_types[atom.type].ports[ref.port].name;
      }
      case PortRef::Kind::Connector: return (ref.maximal_only ? "max " : "") + system->connectors[ref.connector].path;
      case PortRef::Kind::Choice: break;
    }
    std::string out;
    for (const PortRef& one : system->choices[ref.choice].ports) out += (out.empty() ? "one of " : " | ") + text(one);
    return out;
  }

  /// A line an atom, `ROOT.a: A(1)`, then a line a connector, `ROOT.k: C(ROOT.a.p, …)`, ` bound` if another one binds
  /// it.
  [[nodiscard]] std::string shape() const {
    if (!system) return codes();
    std::string out;
    for (const Atom& atom : system->atoms) {
      out += atom.path + ": " + system->atom_types[atom.type].name + "(";
      for (std::size_t k = 0; k < atom.args.size(); ++k) {
        const Value& v = atom.args[k];
        out += (k > 0 ? ", " : "") +
               (v.type == Type::Float ? fmt::format("{}", v.float_value) : fmt::format("{}", v.int_value));
      }
      out += ")\n";
    }
    for (const Connector& connector : system->connectors) {
      out += connector.path + ":";
      for (const PortRef& ref : connector.ports) out += " (" + text(ref) + ")";
      out += connector.bound ? " bound\n" : "\n";
    }
    return out;
  }
};

/// Types that the tests unfold: an atom `A(int k)` with ports p, q, connectors of one, two and, with an export, two
/// ports.
inline std::string with_types(const std::string& compounds) {
  return R"(package t
port type P()
connector type One(P a) define a end
connector type Two(P a, P b) define a b end
connector type Weak(P a, P b) define a' b end
connector type Joined(P a, P b) export port P x() define a b end
connector type Maybe(P a, P b) export port P x() define a' b end
atom type A(int k)
  export port P p(), q()
  place S
  initial to S
  on p from S to S
  on q from S to S
end
)" + compounds +
         "\nend\n";
}

}  // namespace bip::test
