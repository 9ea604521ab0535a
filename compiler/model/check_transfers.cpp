// Warnings about transfers: a `down` that changes nothing, a guard that its own transfer or a transfer to its port
// outdates.
//
// Guards are evaluated when interactions are computed and never again before firing, so a `down` may make one false
// that was the reason to fire. What a transfer changes is found once a connector type; each pair of connector type and
// atom type is looked at once, however many instances there are.
#include <algorithm>

#include "compiler/model/code_uses.hpp"
#include "compiler/model/compound_builder.hpp"

namespace bip::model {

namespace {

std::size_t bind_count(const Model& model, const ConnectorType& type) { return type.bind_count(model.port_types); }

}  // namespace

void check_clauses(ModelBuilder& b, const syntax::ConnectorBody& body, const ConnectorType& type,
                   syntax::Annotations annotations) {
  const CodeTable& code = b.model.code;
  const std::size_t binds = bind_count(b.model, type);
  for (std::size_t c = 0; c < type.clauses.size(); ++c) {
    const Clause& row = type.clauses[c];
    const syntax::Clause& written = body.clauses[c];
    const auto is_silent = [&](const char* warning) {
      return is_suppressed(annotations, warning) || is_suppressed(written.annotations, warning);
    };
    std::vector<bool> read(binds), changed(binds), own(type.variables.size());
    if (written.down.present) {
      bool calls = false;
      for_each_stmt(code, row.down, [&](const Stmt& s) {
        for_each_expr(code, s.value, [&](const Expr& e) { calls |= e.op == Op::Call; });
      });
      mark_writes(code, row.down, Op::LoadBind, changed);
      if (!calls && std::find(changed.begin(), changed.end(), true) == changed.end() && !is_silent("uselessdown")) {
        b.diags.report(Diag::kB2033, written.down.range, interaction_text(type, row.params))
            .note(written.down.stmts.empty() ? "it is empty"
                                             : "the connector's own data do not outlive the interaction");
      }
    }
    if (!row.guard.is_valid()) continue;
    mark_reads(code, row.guard, Op::LoadSelf, own);
    for (std::size_t s = 0; s < own.size(); ++s) {
      if (own[s])
        b.diags.report(Diag::kB2034, written.guard->range, type.variables[s].name)
            .help("`up` runs after the guard: compare the ports' variables");
    }
    mark_reads(code, row.guard, Op::LoadBind, read);
    for (const std::uint32_t p : row.params) {
      if (!type.exports || !type.params[p].type.is_valid()) continue;
      const std::vector<Variable>& variables = b.model.port_types[type.params[p].type].variables;
      for (std::size_t v = 0; v < variables.size(); ++v) {
        const std::size_t bind = type.params[p].first_bind + v;
        if (!read[bind] || !changed[bind] || is_silent("modifiedvariableinteraction")) continue;
        b.diags
            .report(Diag::kB2035, written.down.range, type.params[p].name + "." + variables[v].name,
                    interaction_text(type, row.params))
            .label(written.guard->range, "this guard is not evaluated again");
      }
    }
  }
}

namespace {

struct Modified {
  CompoundBuilder& self;
  const syntax::CompoundItem& item;
  const ConnectorType& type;
  const syntax::ConnectorBody& body;

  // The port that the path means, down to atoms: `changed` says which of its variables the clause writes.
  void visit(const std::vector<ComponentFamily>& components, const PortPath& path, const std::vector<bool>& changed,
             const syntax::Clause& clause) {
    if (path.is_connector) return;
    const ComponentFamily& family = components[path.element.family];
    const Model& model = self.b.model;
    if (family.is_compound) {
      const CompoundType& compound = model.compound_types[family.compound];
      for (const PortPath& target : compound.exports[path.port].targets)
        visit(compound.components, target, changed, clause);
      return;
    }
    const AtomType& atom = model.atom_types[family.atom];
    if (path.port < atom.ports.size()) return check_port(family.atom, path.port, changed, clause);
    for (const std::uint32_t port : atom.merged[path.port - atom.ports.size()].ports)
      check_port(family.atom, port, changed, clause);
  }

  void check_port(AtomTypeId id, std::uint32_t port, const std::vector<bool>& changed, const syntax::Clause& clause) {
    if (!self.all.modified.insert({clause.range.file.value, clause.range.begin, id.value, port}).second) return;
    const AtomType& atom = self.b.model.atom_types[id];
    const syntax::Decl* decl = self.all.atom_decls[id.value];
    if (decl->notation == syntax::Notation::Paper) return;  // its own first listing is written so
    const std::vector<std::uint32_t>& variables = atom.ports[port].variables;
    for (std::size_t t = 0; t < atom.transitions.size(); ++t) {
      if (atom.transitions[t].port != port || !atom.transitions[t].guard.is_valid()) continue;
      std::vector<bool> read(atom.variables.size());
      mark_reads(self.b.model.code, atom.transitions[t].guard, Op::LoadSelf, read);
      for (std::size_t v = 0; v < variables.size(); ++v) {
        if (!changed[v] || !read[variables[v]]) continue;
        if (is_suppressed(decl->annotations, "modifiedvariabletransition") ||
            is_suppressed(decl->transitions[t].annotations, "modifiedvariabletransition"))
          return;
        self.b.diags
            .report(Diag::kB2036, item.name.range, item.name.text, atom.variables[variables[v]].name, atom.name,
                    atom.ports[port].name)
            .label(decl->transitions[t].guard->range, "this guard is not evaluated again")
            .label(clause.down.present ? clause.down.range : clause.action.range, "changed here")
            .help("`@SuppressWarning(modifiedvariabletransition)` before the transition, if that is meant");
        break;
      }
    }
  }

  void check(const CompoundItem& row) {
    const CodeTable& code = self.b.model.code;
    for (std::size_t c = 0; c < type.clauses.size() && c < body.clauses.size(); ++c) {
      const Clause& clause = type.clauses[c];
      if (!clause.down.is_valid() || is_suppressed(body.clauses[c].annotations, "modifiedvariabletransition")) continue;
      std::vector<bool> changed(bind_count(self.b.model, type));
      mark_writes(code, clause.down, Op::LoadBind, changed);
      for (const std::uint32_t p : clause.params) {
        if (!type.params[p].type.is_valid()) continue;
        const auto first = changed.begin() + type.params[p].first_bind;
        const std::vector<bool> bound(
            first, first + static_cast<std::ptrdiff_t>(self.b.model.port_types[type.params[p].type].variables.size()));
        if (std::find(bound.begin(), bound.end(), true) != bound.end())
          visit(self.out.components, row.ports[p], bound, body.clauses[c]);
      }
    }
  }
};

}  // namespace

void CompoundBuilder::warn_modified(const std::vector<CompoundItem>& rows) {
  for (const CompoundItem& row : rows) {
    warn_modified(row.items);
    if (row.kind != ItemKind::Connector || row.has_star || !row.type.is_valid()) continue;
    if (is_suppressed(row.syntax->annotations, "modifiedvariabletransition")) continue;
    const ConnectorType& type = b.model.connector_types[row.type];
    const syntax::Decl* typed = row.syntax->inline_body == nullptr ? all.connector_decls[row.type.value] : nullptr;
    const syntax::ConnectorBody* body = typed == nullptr ? row.syntax->inline_body : typed->connector;
    if (body == nullptr || row.ports.size() != type.params.size() ||
        (typed != nullptr && is_suppressed(typed->annotations, "modifiedvariabletransition")))
      continue;
    Modified{*this, *row.syntax, type, *body}.check(row);
  }
}

}  // namespace bip::model
