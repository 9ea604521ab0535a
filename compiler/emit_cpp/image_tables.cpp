// Emits the tables of types and of the image; tables_instances.cpp emits those of instances.
//
// Everything is a constant aggregate, one row per line, so that a compiler only copies it: 10,000 atoms compile in
// about a second. Linear in the image.
#include "compiler/emit_cpp/image_tables.hpp"

#include "compiler/emit_cpp/ffi_text.hpp"
#include "compiler/emit_cpp/ffi_event_classes.hpp"
#include "compiler/emit_cpp/table_text.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::emit_cpp {

namespace {

std::string cell_type_text(rt::CellType type) {
  if (rt::is_ffi(type)) return "CellType{" + std::to_string(static_cast<unsigned>(type)) + "}";
  switch (type) {
    case rt::CellType::Bool: return "CellType::Bool";
    case rt::CellType::Float: return "CellType::Float";
    case rt::CellType::String: return "CellType::String";
    case rt::CellType::Int: break;
  }
  return "CellType::Int";
}

const char* scope_text(rt::InvariantScope scope) {
  switch (scope) {
    case rt::InvariantScope::At: return "InvariantScope::At";
    case rt::InvariantScope::From: return "InvariantScope::From";
    case rt::InvariantScope::Always: break;
  }
  return "InvariantScope::Always";
}

std::vector<std::string> texts(const rt::Span<const char*>& items) {
  std::vector<std::string> rows;
  for (const char* text : items) rows.push_back(string_literal(text));
  return rows;
}

}  // namespace

std::string TableWriter::ranges(const std::string& name, const rt::Span<rt::RangeOp>& code) {
  static constexpr const char* kKinds[] = {"Constant", "Any", "Own", "Bound", "Neg", "Add", "Sub",   "Mul",   "Not",
                                           "And",      "Or",  "Eq",  "Ne",    "Lt",  "Le",  "Store", "Branch"};
  std::vector<std::string> rows;
  for (const rt::RangeOp& op : code) {
    rows.push_back(
        braces({std::string("RangeOpKind::") + kKinds[static_cast<std::size_t>(op.kind)], cell_type_text(op.type),
                row_text(op.row), row_text(op.otherwise), float_literal(op.number)}));
  }
  return table("RangeOp", name, rows);
}

TableWriter::TableWriter(const lower::LoweredSystem& lowered, CppWriter& out)
    : lowered_(lowered), image_(lowered.image), out_(out) {
  for (const lower::CodeUnit& unit : lowered.units) names_.reserve(unit.name);
  for (const char* taken : {"image", "kImage", "main", "span", "rows"}) names_.reserve(taken);
}

std::string TableWriter::table(const std::string& type, const std::string& name, const std::vector<std::string>& rows) {
  return rows.empty() ? "{}" : "span(" + array(type, name, rows) + ")";
}

std::string TableWriter::array(const std::string& type, const std::string& name, const std::vector<std::string>& rows) {
  const std::string unique = names_.make(name);
  out_.line("constexpr " + type + " " + unique + "[] = {");
  for (const std::string& row : rows) out_.line("    " + row + ",");
  out_.line("};");
  return unique;
}

std::string TableWriter::list(const std::string& name, const rt::Span<std::uint32_t>& items) {
  constexpr std::uint32_t kShort = 12;
  if (items.size == 0) return "{}";
  if (items.size <= kShort) return "rows<" + join(items) + ">";
  const std::string unique = names_.make(name);
  out_.line("constexpr std::uint32_t " + unique + "[] = {" + join(items) + "};");
  return "span(" + unique + ")";
}

std::string TableWriter::vars(const std::string& name, const rt::Span<rt::Var>& items) {
  std::vector<std::string> rows;
  for (const rt::Var& v : items) {
    rows.push_back(
        braces({string_literal(v.name), cell_type_text(v.type), bool_text(v.is_param), bool_text(v.exported)}));
  }
  return table("Var", name, rows);
}

void TableWriter::port_types() {
  std::vector<std::string> rows;
  for (const rt::PortType& type : image_.port_types) {
    const std::string name = type.name;
    rows.push_back(braces({string_literal(name), vars(name + "_vars", type.vars)}));
  }
  port_types_ = table("PortType", "port_types", rows);
}

void TableWriter::types() {
  out_.line("// ---- port types");
  port_types();
  for (const rt::AtomType& type : image_.atom_types) atom_type(type);
  atom_types_ = table("AtomType", "atom_types", atom_rows_);
  for (const rt::ConnectorType& type : image_.connector_types) connector_type(type);
  connector_types_ = table("ConnectorType", "connector_types", connector_rows_);
}

void TableWriter::atom_type(const rt::AtomType& type) {
  const std::string name = type.name;
  out_.line();
  out_.line("// ---- atom type " + comment_text(name));
  const std::string cells = vars(name + "_vars", type.variables);
  std::vector<std::string> rows;
  for (const rt::Port& port : type.ports) {
    const std::string port_variables = list(name + "_" + port.name + "_variables", port.variables);
    rows.push_back(braces({string_literal(port.name), row_text(port.type), port_variables, bool_text(port.exported),
                           loc_text(port.loc)}));
  }
  const std::string ports = table("Port", name + "_ports", rows);
  const std::string places = table("const char*", name + "_places", texts(type.places));
  const std::string initial = list(name + "_initial_places", type.initial);
  rows.clear();
  for (const rt::Transition& t : type.transitions) {
    const std::string from = list(name + "_from", t.from);
    const std::string to = list(name + "_to", t.to);
    rows.push_back(braces({row_text(t.port), from, to, row_text(t.guard), row_text(t.action), loc_text(t.loc)}));
  }
  const std::string transitions = table("Transition", name + "_transitions", rows);
  rows.clear();
  for (const rt::AtomPriority& p : type.priorities) {
    rows.push_back(
        braces({string_literal(p.name), row_text(p.low), row_text(p.high), row_text(p.guard), loc_text(p.loc)}));
  }
  const std::string priorities = table("AtomPriority", name + "_priorities", rows);
  rows.clear();
  for (const rt::Invariant& i : type.invariants) {
    const std::string at = list(name + "_" + i.name + "_places", i.places);
    rows.push_back(braces({string_literal(i.name), scope_text(i.scope), at, row_text(i.condition), loc_text(i.loc)}));
  }
  const std::string invariants = table("Invariant", name + "_invariants", rows);
  const std::string time = atom_time(name, type.time);
  std::string rest = time.empty() ? invariants : invariants + ", " + time;
  if (type.final_places.size != 0 || type.draws != rt::kNone || type.guards_call)
    rest += (time.empty() ? ", nullptr, " : ", ") + list(name + "_final_places", type.final_places);
  if (type.draws != rt::kNone || type.guards_call) rest += ", " + row_text(type.draws);
  if (type.guards_call) rest += ", true";
  atom_rows_.push_back(braces({string_literal(name), cells, ports, places, initial, row_text(type.initial_action),
                               transitions, loc_text(type.loc), priorities, rest}));
}

void TableWriter::connector_type(const rt::ConnectorType& type) {
  const std::string name = type.name;
  out_.line();
  out_.line("// ---- connector type " + comment_text(name));
  std::vector<std::string> rows;
  for (const rt::ConnectorParam& p : type.params) {
    rows.push_back(braces({string_literal(p.name), row_text(p.type), row_text(p.first_bind)}));
  }
  const std::string params = table("ConnectorParam", name + "_params", rows);
  const std::string cells = vars(name + "_vars", type.variables);
  rows.clear();
  for (const rt::DefineNode& node : type.define) {
    const std::string children = list(name + "_children", node.children);
    rows.push_back(braces({bool_text(node.is_leaf), bool_text(node.trigger), row_text(node.param), children}));
  }
  const std::string define = table("DefineNode", name + "_define", rows);
  rows.clear();
  for (const rt::Clause& c : type.clauses) {
    const std::string clause_params = list(name + "_clause_params", c.params);
    std::string rest = bool_text(c.may_fault) + ", " + bool_text(c.guard_may_fault);
    if (c.has_ranges)
      rest +=
          ", true, " + ranges(name + "_guard_ranges", c.guard_ranges) + ", " + ranges(name + "_up_ranges", c.up_ranges);
    rows.push_back(braces({clause_params, row_text(c.guard), row_text(c.up), row_text(c.down), loc_text(c.loc), rest}));
  }
  const std::string clauses = table("Clause", name + "_clauses", rows);
  const std::string export_variables = list(name + "_export_variables", type.export_variables);
  connector_rows_.push_back(
      braces({string_literal(name), params, cells, define, clauses, bool_text(type.exports),
              string_literal(type.export_name), row_text(type.export_type), export_variables,
              loc_text(type.loc) + (type.resume_sync || type.is_total ? ", " + bool_text(type.resume_sync) : "") +
                  (type.is_total ? ", true" : "")}));
}

void TableWriter::image() {
  out_.line();
  out_.line("// ---- the image");
  std::vector<std::string> codes, sites;
  for (const lower::CodeUnit& unit : lowered_.units) {
    codes.push_back("/* " + std::to_string(codes.size()) + " */ {&" + unit.name + ", nullptr}");
  }
  for (const rt::Site& site : image_.sites) {
    sites.push_back(
        "{" + loc_text(site.loc) +
        (site.function == nullptr ? "}" : ", " + string_literal(site.function) + (site.is_draw ? ", true}" : "}")));
  }
  BIP_ASSERT(codes.size() == image_.codes.size, "{} codes, the image has {}", codes.size(), image_.codes.size);
  const FfiNames ffi(lowered_.system->code);
  std::vector<std::string> ffi_types;
  for (std::size_t k = 0; k < lowered_.ffi_types.size(); ++k) {
    ffi_types.push_back("ffi_type_of<" + ffi.type(ffi_type(k)) + ">(" + string_literal(lowered_.ffi_types[k].name) +
                        ")");
  }
  const std::string ffi_span = table("FfiType", "ffi_types", ffi_types);
  const std::vector<lower::EventClassUse> uses = lower::event_class_uses(*lowered_.system);
  std::vector<std::string> event_classes;
  for (std::size_t k = 0; k < uses.size(); ++k) event_classes.push_back(event_class_row(*lowered_.system, uses, k));
  const std::string event_class_span = table("EventClass", "event_classes", event_classes);
  const std::string files = table("const char*", "files", texts(image_.files));
  const std::string strings = table("const char*", "strings", texts(image_.strings));
  const std::string code_span = table("Code", "codes", codes);
  const std::string site_span = table("Site", "sites", sites);
  std::vector<std::string> weights;
  for (const rt::TransitionWeight& w : image_.transition_weights)
    weights.push_back(braces({row_text(w.type), row_text(w.transition), float_literal(w.value), row_text(w.param)}));
  const std::string transition_weights = table("TransitionWeight", "transition_weights", weights);
  weights.clear();
  for (const rt::ConnectorWeight& w : image_.connector_weights)
    weights.push_back(braces({row_text(w.connector), float_literal(w.value)}));
  const std::string connector_weights = table("ConnectorWeight", "connector_weights", weights);
  out_.line("constexpr bip::rt::Image kImage = {");
  const auto field = [&](const char* name, const std::string& value) {
    out_.line(std::string("    .") + name + " = " + value + ",");
  };
  field("name", string_literal(image_.name));
  field("files", files);
  field("strings", strings);
  field("codes", code_span);
  field("sites", site_span);
  field("port_types", port_types_);
  field("atom_types", atom_types_);
  field("connector_types", connector_types_);
  field("compounds", compounds_);
  field("atoms", atoms_);
  field("args", args_);
  field("connectors", connectors_);
  field("port_refs", port_refs_);
  field("binds", binds_);
  field("priorities", priorities_);
  field("cell_count", std::to_string(image_.cell_count));
  field("choices", choices_);
  if (image_.shown_ports.size != 0) field("shown_ports", shown_ports_);
  if (image_.transition_weights.size != 0) field("transition_weights", transition_weights);
  if (image_.connector_weights.size != 0) field("connector_weights", connector_weights);
  if (!lowered_.steps.shapes.empty()) {
    field("step_fns", step_fns_);
    field("step_runs", step_runs_);
    field("step_operands", step_operands_);
    field("step_entries", step_entries_);
    if (!steps_fn_.empty()) field("steps_fn", "&" + steps_fn_);
    if (!step_columns_.empty()) {
      field("step_columns", step_columns_);
      field("step_cells", std::to_string(lowered_.steps.cells.count));
      field("step_cells_pay", std::to_string(lowered_.steps.cells.pay));
    }
    if (!inner_steps_.empty()) field("inner_steps", inner_steps_);
  }
  if (image_.ffi != nullptr) {
    field("ffi_types", ffi_span);
    field("ffi", "&ffi::own_context");
    if (!uses.empty()) field("event_classes", event_class_span);
  }
  out_.line("};");
}

}  // namespace bip::emit_cpp
