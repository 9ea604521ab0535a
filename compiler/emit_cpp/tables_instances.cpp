// Emits the tables of instances: compounds, atoms with their arguments, connectors with ports and bound cells,
// priorities.
//
// One row per line; rows without a path name their owner in a comment.
#include "compiler/emit_cpp/emit_steps.hpp"
#include "compiler/emit_cpp/table_text.hpp"
#include "compiler/emit_cpp/image_tables.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::emit_cpp {

namespace {

std::string cell_text(const rt::Cell& cell, Type type) {
  if (type == Type::Float) return "float_cell(" + float_literal(cell.f) + ")";
  return "int_cell(" + int_literal(cell.i) + ")";
}

std::string port_ref_text(const rt::PortRef& ref) {
  return braces({row_text(ref.atom), row_text(ref.port), row_text(ref.connector), bool_text(ref.maximal_only),
                 row_text(ref.choice)});
}

// A row with whose it is in front.
std::string with_owner(const std::string& row, const std::string& owner) {
  return "/* " + comment_text(owner) + " */ " + row;
}

// A number that is no row: none is missing.
std::string number(std::uint32_t value) { return std::to_string(value) + "u"; }

// The last column of rows that stand for several.
std::string index_text(std::uint32_t index) { return index == rt::kNone ? "" : ", " + std::to_string(index); }

std::string bind_texts(const rt::Bind* first, std::uint32_t count) {
  std::string text;
  for (std::uint32_t k = 0; k < count; ++k) text += (k == 0 ? "{" : ", {") + row_text(first[k].cell) + "}";
  return text;
}

std::string joined(const std::vector<std::string>& cells) {
  std::string out;
  for (const std::string& cell : cells) {
    if (!out.empty()) out += ", ";
    out += cell;
  }
  return out;
}

}  // namespace

template <class T, class SlopeText>
std::string TableWriter::folded(const std::string& type, const std::string& name, const std::vector<std::string>& rows,
                                const rt::Rows<T>& table_rows, SlopeText slope_text) {
  const std::string stand = table(type, name + "s", rows);
  if (table_rows.repeats.size == 0) return stand;
  std::vector<std::string> repeats, slopes;
  for (const rt::Repeat& r : table_rows.repeats)
    repeats.push_back(braces({row_text(r.first), row_text(r.period), row_text(r.row), row_text(r.slope)}));
  for (const typename T::Slope& slope : table_rows.slopes) slopes.push_back(slope_text(slope));
  BIP_ASSERT(rows.size() == table_rows.rows.size && slopes.size() == table_rows.slopes.size, "{} rows of {}",
             rows.size(), table_rows.rows.size);
  const std::string repeat_span = table("Repeat", name + "_repeats", repeats);
  return braces(
      {stand, repeat_span, table(type + "::Slope", name + "_slopes", slopes), std::to_string(table_rows.size)});
}

void TableWriter::instances() {
  const System& system = *lowered_.system;
  out_.line();
  out_.line("// ---- instances");
  std::vector<std::string> rows;
  for (const rt::Compound& c : image_.compounds) rows.push_back(braces({string_literal(c.path), row_text(c.parent)}));
  compounds_ = table("Compound", "compounds", rows);

  rows.clear();
  std::vector<std::string> args;
  for (const rt::Atom& a : image_.atoms.rows) {
    rows.push_back(braces({string_literal(a.name), row_text(a.type), row_text(a.first_cell), row_text(a.args),
                           loc_text(a.loc) + index_text(a.index)}));
  }
  atoms_ = folded("Atom", "atom", rows, image_.atoms, [](const rt::Atom::Slope& s) {
    return braces({number(s.first_cell), number(s.args)});
  });
  for (std::uint32_t row = 0; row < image_.atoms.size; ++row) {
    const rt::Atom a = image_.atoms[row];
    const std::vector<Value>& values = system.atoms[AtomId(row)].args;
    BIP_ASSERT(a.args + values.size() <= image_.args.size, "atom {} has arguments {} to {}", row, a.args,
               a.args + values.size());
    std::vector<std::string> cells;
    for (std::size_t k = 0; k < values.size(); ++k) cells.push_back(cell_text(image_.args[a.args + k], values[k].type));
    if (!cells.empty()) args.push_back(with_owner(joined(cells), a.path()));
  }
  args_ = table("Cell", "args", args);

  rows.clear();
  std::vector<std::string> refs, binds;
  for (const rt::Connector& c : image_.connectors.rows) {
    rows.push_back(braces({string_literal(c.name), row_text(c.type), row_text(c.first_cell), row_text(c.ports),
                           row_text(c.binds), row_text(c.bind_count), bool_text(c.bound), loc_text(c.loc),
                           row_text(c.parent) + index_text(c.index)}));
  }
  connectors_ = folded("Connector", "connector", rows, image_.connectors, [](const rt::Connector::Slope& s) {
    return braces({number(s.first_cell), number(s.ports), number(s.binds), number(s.parent)});
  });
  const bool are_folded = image_.port_refs.repeats.size != 0, are_binds_folded = image_.binds.repeats.size != 0;
  for (std::uint32_t k = 0; are_folded && k < image_.port_refs.rows.size; ++k)
    refs.push_back(port_ref_text(image_.port_refs.rows[k]));
  for (const rt::Connector& c : image_.connectors) {
    const rt::ConnectorType& type = image_.connector_types[c.type];
    for (std::uint32_t k = 0; !are_folded && k < type.params.size; ++k) {
      refs.push_back(with_owner(port_ref_text(image_.port_refs[c.ports + k]), c.path() + " " + type.params[k].name));
    }
    if (c.bind_count > 0 && !are_binds_folded)
      binds.push_back(with_owner(bind_texts(image_.binds.rows.data + c.binds, c.bind_count), c.path()));
  }
  for (const rt::Priority& p : image_.priorities) {
    if (p.bind_count > 0 && !are_binds_folded)
      binds.push_back(with_owner(bind_texts(image_.binds.rows.data + p.binds, p.bind_count), p.name));
  }
  for (std::uint32_t k = 0; are_binds_folded && k < image_.binds.rows.size; ++k)
    binds.push_back(bind_texts(image_.binds.rows.data + k, 1));
  port_refs_ = folded("PortRef", "port_ref", refs, image_.port_refs, [](const rt::PortRef::Slope& s) {
    return braces({number(s.atom), number(s.connector), number(s.choice)});
  });
  binds_ =
      folded("Bind", "bind", binds, image_.binds, [](const rt::Bind::Slope& s) { return braces({number(s.cell)}); });
  choices();
  shown_ports();
  priorities();
  steps();
}

void TableWriter::steps() {
  std::vector<std::string> functions, runs, operands, entries;
  for (std::size_t shape = 0; shape < lowered_.steps.shapes.size(); ++shape)
    functions.push_back("&" + step_name(shape));
  for (const rt::StepRun& run : lowered_.steps.runs) {
    runs.push_back(braces({row_text(run.first), row_text(run.count), row_text(run.distance), row_text(run.shape),
                           row_text(run.operands)}));
  }
  for (const rt::StepOperand& operand : lowered_.steps.operands) {
    operands.push_back(braces({std::to_string(operand.base) + "u", std::to_string(operand.stride) + "u"}));
  }
  for (const rt::StepEntry& entry : lowered_.steps.entries) {
    entries.push_back(braces(
        {row_text(entry.shape), row_text(entry.operand), row_text(entry.repeats), std::to_string(entry.stride) + "u"}));
  }
  BIP_ASSERT(runs.size() == image_.step_runs.size && operands.size() == image_.step_operands.size,
             "{} runs, the image has {}", runs.size(), image_.step_runs.size);
  step_fns_ = table("StepFn", "step_fns", functions);
  step_runs_ = table("StepRun", "step_runs", runs);
  step_entries_ = table("StepEntry", "step_entries", entries);
  step_operands_ = "{}";
  if (operands.empty()) return;
  const std::string rows = array("StepOperand", "step_operands", operands);
  step_operands_ = "span(" + rows + ")";
  const std::string loop = names_.make("take_many_steps");
  const lower::StepCells& cells = lowered_.steps.cells;
  inner_steps();
  if (emit_step_loop(lowered_, loop, cells.empty() ? rows : cell_operands(), out_)) steps_fn_ = loop;
}

void TableWriter::inner_steps() {
  const lower::InnerStepRows& inner = lowered_.steps.inner;
  if (inner.runs.empty()) return;
  const auto numbers = [&](const char* name, const std::vector<std::uint32_t>& rows) {
    std::vector<std::string> texts;
    for (const std::uint32_t row : rows) texts.push_back(row_text(row));
    return table("std::uint32_t", name, texts);
  };
  std::vector<std::string> runs;
  for (const rt::StepRun& run : inner.runs) {
    runs.push_back(braces({row_text(run.first), row_text(run.count), row_text(run.distance), row_text(run.shape),
                           row_text(run.operands)}));
  }
  const std::string atoms = numbers("inner_atoms", inner.atoms);
  const std::string interactions = numbers("inner_interactions", inner.interactions);
  const std::string cells = numbers("inner_cells", inner.cells);
  const std::string run_of = numbers("inner_run_of", inner.run_of);
  const std::string rows = table("StepRun", "inner_runs", runs);
  inner_steps_ = braces({atoms, interactions, cells, run_of, rows, std::to_string(inner.pay)});
}

// Where data are in columns: what the loop over steps knows there.
std::string TableWriter::cell_operands() {
  const lower::StepCells& cells = lowered_.steps.cells;
  std::vector<std::string> operands, columns;
  for (const rt::StepOperand& operand : cells.operands) {
    operands.push_back(braces({std::to_string(operand.base) + "u", std::to_string(operand.stride) + "u"}));
  }
  for (const rt::StepColumn& column : cells.columns) {
    columns.push_back(braces({std::to_string(column.cell), std::to_string(column.distance),
                              std::to_string(column.column_cell), std::to_string(column.count)}));
  }
  step_columns_ = table("StepColumn", "step_columns", columns);
  return array("StepOperand", "step_cell_operands", operands);
}

void TableWriter::choices() {
  std::vector<std::string> rows;
  for (const rt::Choice& choice : image_.choices) {
    std::vector<std::string> refs;
    for (const rt::PortRef& ref : choice.ports) refs.push_back(port_ref_text(ref));
    const std::string ports = table("PortRef", std::string(choice.name) + "_ports", refs);
    rows.push_back(braces({string_literal(choice.name), ports}));
  }
  choices_ = table("Choice", "choices", rows);
}

void TableWriter::shown_ports() {
  std::vector<std::string> rows;
  for (const rt::ShownPort& shown : image_.shown_ports)
    rows.push_back(braces({row_text(shown.port_ref), row_text(shown.compound), string_literal(shown.name)}));
  shown_ports_ = table("ShownPort", "shown_ports", rows);
}

void TableWriter::priorities() {
  std::vector<std::string> rows;
  for (const rt::Priority& p : image_.priorities) {
    const std::string low = pattern(std::string(p.name) + "_low", p.low);
    const std::string high = pattern(std::string(p.name) + "_high", p.high);
    rows.push_back(braces({string_literal(p.name), row_text(p.parent), low, high, row_text(p.guard), row_text(p.binds),
                           row_text(p.bind_count), loc_text(p.loc)}));
  }
  priorities_ = table("Priority", "priorities", rows);
}

std::string TableWriter::pattern(const std::string& name, const rt::Pattern& pattern) {
  const std::string params = list(name, pattern.params);
  return braces(
      {bool_text(pattern.any_connector), row_text(pattern.connector), bool_text(pattern.any_interaction), params});
}

}  // namespace bip::emit_cpp
