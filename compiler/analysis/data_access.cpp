// See data_access.hpp. A variable is observed if a guard reads it, or if an observed variable is computed from it.
#include "compiler/analysis/data_access.hpp"

#include <algorithm>
#include <optional>

#include "compiler/model/code_uses.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::analysis {

namespace {

using model::for_each_assigned;
using model::for_each_expr;
using model::for_each_stmt;

class DataAccessScan {
 public:
  explicit DataAccessScan(const System& system) : system_(system), code_(system.code) {
    for (const AtomType& type : system.atom_types) {
      DataAccess access;
      access.written.resize(type.ports.size());
      access.observed.assign(type.variables.size(), 0);
      access.unfollowed.assign(type.variables.size(), 0);
      access.read.resize(type.ports.size());
      access.read_anywhere.assign(type.variables.size(), 0);
      rows_.push_back(std::move(access));
    }
  }

  std::vector<DataAccess> scan() {
    for (const Connector& connector : system_.connectors) scan_connector(connector);
    for (const Priority& priority : system_.priorities) {
      for (const DataRef& ref : priority.data) access_of(ref.atom).read_anywhere[ref.variable] = 1;
      for (const DataRef& ref : priority.data) give_away(ref, priority.guard, ref_number(priority.data, ref));
    }
    for (std::size_t row = 0; row < rows_.size(); ++row) scan_type(system_.atom_types[AtomTypeId(row)], rows_[row]);
    for (DataAccess& access : rows_) {
      for (std::vector<std::vector<std::uint32_t>>* lists : {&access.written, &access.read}) {
        for (std::vector<std::uint32_t>& variables : *lists) {
          std::sort(variables.begin(), variables.end());
          variables.erase(std::unique(variables.begin(), variables.end()), variables.end());
        }
      }
    }
    for (const Connector& connector : system_.connectors) observe_constants(connector);
    BIP_ASSERT(rows_.size() == system_.atom_types.size(), "{} rows for {} atom types", rows_.size(),
               system_.atom_types.size());
    return std::move(rows_);
  }

 private:
  static std::uint32_t ref_number(const std::vector<DataRef>& data, const DataRef& ref) {
    return static_cast<std::uint32_t>(&ref - data.data());
  }
  DataAccess& access_of(AtomId atom) { return rows_[system_.atoms[atom].type.value]; }

  // Bind variables that C++ gets a reference to in this expression.
  void references(ExprId expr, std::vector<std::uint32_t>& binds, std::vector<std::uint32_t>& selves) const {
    for_each_expr(code_, expr, [&](const Expr& e) {
      if (e.op != Op::Call) return;
      const Function& function = code_.functions[e.index];
      const std::span<const ExprId> args = code_.args_of(e);
      for (std::size_t k = 0; k < args.size(); ++k) {
        if (!function.params[k].by_reference) continue;
        const Expr& arg = code_.exprs[args[k]];
        if (arg.op == Op::LoadBind) binds.push_back(arg.index);
        if (arg.op == Op::LoadSelf) selves.push_back(arg.index);
      }
    });
  }
  void references(StmtId body, std::vector<std::uint32_t>& binds, std::vector<std::uint32_t>& selves) const {
    for_each_stmt(code_, body, [&](const Stmt& s) { references(s.value, binds, selves); });
  }

  void give_away(const DataRef& ref, ExprId guard, std::uint32_t number) {
    std::vector<std::uint32_t> binds, selves;
    references(guard, binds, selves);
    for (std::uint32_t bind : binds) {
      if (bind == number) access_of(ref.atom).unfollowed[ref.variable] = 1;
    }
  }

  // A variable of what is bound: see(access, port, variable) of each atom's port that it may be.
  template <class See>
  void each_variable(const PortRef& ref, std::uint32_t variable, const See& see) {
    if (ref.kind == PortRef::Kind::Choice) {
      for (const PortRef& alternative : system_.choices[ref.choice].ports) each_variable(alternative, variable, see);
    } else if (ref.kind == PortRef::Kind::Atom) {
      const Port& port = system_.atom_types[system_.atoms[ref.atom].type].ports[ref.port];
      if (variable < port.variables.size()) see(access_of(ref.atom), ref.port, port.variables[variable]);
    }
  }

  [[nodiscard]] bool is_constant(const AtomType& type, const DataAccess& access, std::uint32_t variable) const {
    if (access.unfollowed[variable] != 0) return false;
    for (const std::vector<std::uint32_t>& variables : access.written) {
      if (std::find(variables.begin(), variables.end(), variable) != variables.end()) return false;
    }
    bool is_stored = false;
    for (const Transition& t : type.transitions) {
      for_each_assigned(code_, t.action, Op::LoadSelf, [&](std::uint32_t other) { is_stored |= other == variable; });
    }
    return !is_stored;
  }
  // What never changes costs no modes; where it is given to observed data it says what that is.
  void observe_constants(const Connector& connector) {
    const ConnectorType& type = system_.connector_types[connector.type];
    const auto source_of = [&](std::uint32_t bind) -> std::optional<std::pair<AtomId, std::uint32_t>> {
      for (std::size_t p = type.params.size(); p-- > 0;) {
        const PortRef& ref = connector.ports[p];
        if (bind < type.params[p].first_bind) continue;
        if (ref.kind != PortRef::Kind::Atom) return std::nullopt;
        const std::vector<std::uint32_t>& variables =
            system_.atom_types[system_.atoms[ref.atom].type].ports[ref.port].variables;
        const std::uint32_t variable = bind - type.params[p].first_bind;
        return variable < variables.size() ? std::optional(std::pair(ref.atom, variables[variable])) : std::nullopt;
      }
      return std::nullopt;
    };
    for (const Clause& clause : type.clauses) {
      for_each_stmt(code_, clause.down, [&](const Stmt& s) {
        const std::optional<std::uint32_t> bind = model::assigned_variable(s, Op::LoadBind);
        if (!bind) return;
        const auto target = source_of(*bind);
        if (!target || access_of(target->first).observed[target->second] == 0) return;
        for_each_expr(code_, s.value, [&](const Expr& e) {
          const auto source = e.op == Op::LoadBind ? source_of(e.index) : std::nullopt;
          if (!source) return;
          DataAccess& access = access_of(source->first);
          if (access.observed[source->second] != 0) return;
          const AtomType& source_type = system_.atom_types[system_.atoms[source->first].type];
          if (is_constant(source_type, access, source->second)) access.observed[source->second] = 1;
        });
      });
    }
  }

  void scan_connector(const Connector& connector) {
    const ConnectorType& type = system_.connector_types[connector.type];
    const std::uint32_t variables =
        type.bind_count(system_.port_types) - static_cast<std::uint32_t>(type.data_reads.size());
    // Which parameter, and which of its variables, a Bind number is.
    const auto param_of = [&](std::uint32_t bind) {
      std::uint32_t param = 0;
      while (param + 1 < type.params.size() && type.params[param + 1].first_bind <= bind) ++param;
      return param;
    };
    const auto changes = [&](std::uint32_t bind, const Clause* clause) {
      if (bind >= variables) {
        if (bind - variables < connector.data.size()) {
          const DataRef& ref = connector.data[bind - variables];
          access_of(ref.atom).unfollowed[ref.variable] = 1;
        }
        return;
      }
      const std::uint32_t param = param_of(bind);
      BIP_ASSERT(param < connector.ports.size(), "parameter {} of {}", param, connector.ports.size());
      bool takes_part = false;
      if (clause != nullptr) {
        for (std::uint32_t other : clause->params) takes_part |= other == param;
      }
      each_variable(connector.ports[param], bind - type.params[param].first_bind,
                    [takes_part](DataAccess& access, auto port, std::uint32_t variable) {
                      if (takes_part) access.written[port].push_back(variable);
                      else access.unfollowed[variable] = 1;
                    });
    };
    // The variable that an expression reads: of_port(access, port, variable), or of_data(access, variable).
    const auto read = [&](const Expr& e, const auto& of_port, const auto& of_data) {
      if (e.op != Op::LoadBind) return;
      if (e.index < variables) {
        const std::uint32_t param = param_of(e.index);
        each_variable(connector.ports[param], e.index - type.params[param].first_bind, of_port);
      } else if (e.index - variables < connector.data.size()) {
        const DataRef& ref = connector.data[e.index - variables];
        of_data(access_of(ref.atom), ref.variable);
      }
    };
    const auto reads = [&](const Expr& e) {
      read(
          e,
          [](DataAccess& access, auto port, std::uint32_t variable) {
            std::vector<std::uint32_t>& of_port = access.read[port];
            if (of_port.empty() || of_port.back() != variable) of_port.push_back(variable);
          },
          [](DataAccess& access, std::uint32_t variable) { access.read_anywhere[variable] = 1; });
    };
    const auto observes = [&](const Expr& e) {
      read(
          e, [](DataAccess& access, auto, std::uint32_t variable) { access.observed[variable] = 1; },
          [](DataAccess& access, std::uint32_t variable) { access.observed[variable] = 1; });
    };
    for (const Clause& clause : type.clauses) {
      for_each_assigned(code_, clause.down, Op::LoadBind, [&](std::uint32_t bind) { changes(bind, &clause); });
      for_each_expr(code_, clause.guard, reads);
      for (StmtId body : {clause.up, clause.down}) {
        for_each_stmt(code_, body, [&](const Stmt& s) { for_each_expr(code_, s.value, reads); });
      }
      std::vector<std::uint32_t> binds, selves;
      references(clause.guard, binds, selves);
      references(clause.up, binds, selves);
      references(clause.down, binds, selves);
      for (std::uint32_t bind : binds) changes(bind, nullptr);
      for_each_assigned(code_, clause.up, Op::LoadBind, [&](std::uint32_t bind) { changes(bind, nullptr); });
      for_each_expr(code_, clause.guard, observes);
    }
  }

  // Does the value of an action's statement decide what comes next, or what observed data hold?
  [[nodiscard]] static bool decides(const Stmt& s, const DataAccess& access) {
    if (const std::optional<std::uint32_t> self = model::assigned_variable(s, Op::LoadSelf))
      return access.observed[*self] != 0;
    return !model::assigned_variable(s, Op::LoadBind) && !model::is_evaluation(s);
  }
  void scan_type(const AtomType& type, DataAccess& access) {
    std::vector<std::uint32_t> binds, selves;
    const auto reads = [&](ExprId expr) {
      bool is_new = false;
      for_each_expr(code_, expr, [&](const Expr& e) {
        if (e.op != Op::LoadSelf || access.observed[e.index] != 0) return;
        access.observed[e.index] = 1;
        is_new = true;
      });
      return is_new;
    };
    references(type.initial_action, binds, selves);
    for (const Transition& t : type.transitions) {
      reads(t.guard);
      references(t.guard, binds, selves);
      references(t.action, binds, selves);
    }
    for (const AtomPriority& p : type.priorities) {
      reads(p.guard);
      references(p.guard, binds, selves);
    }
    for (const Invariant& i : type.invariants) references(i.condition, binds, selves);
    for (std::uint32_t variable : selves) access.unfollowed[variable] = 1;
    for (bool changed = true; changed;) {
      changed = false;
      const auto close = [&](StmtId body) {
        for_each_stmt(code_, body, [&](const Stmt& s) {
          if (decides(s, access)) changed |= reads(s.value);
        });
      };
      close(type.initial_action);
      for (const Transition& t : type.transitions) close(t.action);
    }
  }

  const System& system_;
  const CodeTable& code_;
  std::vector<DataAccess> rows_;
};

}  // namespace

std::vector<DataAccess> analyze_data_access(const System& system) { return DataAccessScan(system).scan(); }

}  // namespace bip::analysis
