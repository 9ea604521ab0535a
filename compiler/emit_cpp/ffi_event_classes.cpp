// See ffi_event_classes.hpp.
#include "compiler/emit_cpp/ffi_event_classes.hpp"

#include "compiler/emit_cpp/writer.hpp"
#include "compiler/system/system.hpp"

namespace bip::emit_cpp {

namespace {

const Port& port_of(const System& system, const lower::EventClassUse& use) {
  return system.atom_types[use.type].ports[use.port];
}

const char* cell_function(Type type) {
  switch (type) {
    case Type::Float: return "bip::rt::float_cell(";
    case Type::String: return "bip::rt::event_cell(strings, ";
    case Type::Int:
    case Type::Bool: break;
  }
  return "bip::rt::int_cell(";
}

}  // namespace

std::string event_class_text(const System& system, const std::vector<lower::EventClassUse>& uses, LineMarks marks) {
  std::string out = "namespace ffi {\n";
  for (std::size_t k = 0; k < uses.size(); ++k) {
    const std::string name = "event_class_" + std::to_string(k);
    if (marks == LineMarks::OfUses) out += "#line 1 \"bip-class-" + std::to_string(k) + "\"\n";
    out += "using " + name + " = " + port_of(system, uses[k]).event_class + ";\n";
    out += "template <class Source>\ninline void event_values_" + std::to_string(k) +
           "([[maybe_unused]] Source& source, [[maybe_unused]] bip::rt::Cell* out, [[maybe_unused]] "
           "bip::rt::FfiContext& strings) {\n";
    std::size_t row = 0;
    for (const Variable& v : system.port_types[port_of(system, uses[k]).type].variables) {
      const std::string to = "out[" + std::to_string(row++) + "] = " + cell_function(v.type) + "source.";
      const std::string end = v.name + "()" + (v.type == Type::Bool ? " ? 1 : 0" : "") + ");\n";
      out += "  if constexpr (requires { source.event_get_" + v.name + "(); }) " + to + "event_get_" + end;
      out += "  else " + to + "get_" + end;
    }
    out += "}\n";
  }
  if (marks == LineMarks::OfUses) out += "#line 1 \"bip-shim\"\n";
  return out + "}  // namespace ffi\n";
}

std::string event_class_row(const System& system, const std::vector<lower::EventClassUse>& uses, std::size_t k) {
  const std::string number = std::to_string(k);
  return "bip::rt::event_class_of<ffi::event_class_" + number + ", &ffi::event_values_" + number +
         "<ffi::event_class_" + number + ">>(" + string_literal(port_of(system, uses[k]).event_class) + ")";
}

}  // namespace bip::emit_cpp
