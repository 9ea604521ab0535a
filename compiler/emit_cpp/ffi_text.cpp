// See ffi_text.hpp. Wrappers are named `call_f`, so that they never hide the function `f` that they call.
#include "compiler/emit_cpp/ffi_text.hpp"

#include "compiler/emit_cpp/ffi_event_classes.hpp"
#include "compiler/emit_cpp/writer.hpp"
#include "compiler/lower/unit_names.hpp"
#include "compiler/model/draws.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::emit_cpp {

namespace {

const char* native_type(Type type) {
  switch (type) {
    case Type::Bool: return "bool";
    case Type::Float: return "double";
    case Type::Int:
    case Type::String: break;
  }
  return "std::int32_t";
}

const char* operator_name(const std::string& sign) {
  static constexpr std::pair<const char*, const char*> kNames[] = {
      {"||", "or"},     {"&&", "and"},        {"|", "bit_or"},         {"^", "bit_xor"},
      {"&", "bit_and"}, {"==", "equal"},      {"!=", "not_equal"},     {"<", "less"},
      {">", "greater"}, {"<=", "less_equal"}, {">=", "greater_equal"}, {"+", "plus"},
      {"-", "minus"},   {"*", "times"},       {"/", "divide"},         {"%", "modulo"},
      {"!", "not"},     {"~", "complement"},  {"=", "assign"}};
  for (const auto& [text, name] : kNames) {
    if (sign == text) return name;
  }
  return "operator";
}

// A parameter as it is handed on: strings are rows until here.
std::string argument(const Function& function, std::size_t k) {
  const std::string name = "a" + std::to_string(k);
  if (function.params[k].type != Type::String) return name;
  const std::string text = "bip_context->text(" + name + ")";
  return function.kind == FunctionKind::Operator ? "std::string(" + text + ")" : text;
}

std::string call_text(const Function& function, const ConstNames& const_names, const std::string& result) {
  // The value of a clock for an `int`: the only conversion between native types that is not C++'s own.
  if (function.kind == FunctionKind::Cast && function.result == Type::Int && function.params[0].type == Type::Float)
    return "bip::rt::whole_units(" + argument(function, 0) + ")";
  if (function.kind == FunctionKind::Cast) return "static_cast<" + result + ">(" + argument(function, 0) + ")";
  if (function.kind == FunctionKind::Operator) {
    if (function.params.size() == 1) return function.name + argument(function, 0);
    return argument(function, 0) + " " + function.name + " " + argument(function, 1);
  }
  std::string text =
      function.is_const && const_names.contains(function.name) ? "const_" + function.name : function.name;
  text += "(";
  for (std::size_t k = 0; k < function.params.size(); ++k) text += (k == 0 ? "" : ", ") + argument(function, k);
  return text + ")";
}

std::string local(const std::string& qualified) {
  return qualified.starts_with("ffi::") ? qualified.substr(5) : qualified;
}

// "`int f(int)`, declared at model.bip:3", as a literal.
std::string note_text(const CodeTable& code, const Function& function, const FfiTextOptions& options) {
  std::string text = "`" + signature_text(code, function) + "`";
  if (function.loc.line != 0 && function.loc.file < options.files.size())
    text += ", declared at " + options.files[function.loc.file] + ":" + std::to_string(function.loc.line);
  return string_literal(text);
}

}  // namespace

FfiNames::FfiNames(const CodeTable& code) {
  lower::UniqueNames names;
  for (const char* taken : {"bip_context", "bip_note", "own_context", "names_crashes"}) names.reserve(taken);
  for (const FfiType& type : code.ffi_types) types_.push_back("ffi::" + names.make(type.name + "_type"));
  lower::UniqueNames draws;
  for (const Function& function : code.functions) {
    if (function.kind == FunctionKind::Draw) {
      functions_.push_back("draws::" + draws.make(function.name));
      continue;
    }
    std::string name = "call_" + function.name;
    if (function.kind == FunctionKind::Operator) name = std::string("operator_") + operator_name(function.name);
    if (function.kind == FunctionKind::Cast) name = "to_" + function.name;
    functions_.push_back("ffi::" + names.make(name));
  }
}

std::string FfiNames::type(Type type) const { return is_ffi(type) ? types_[ffi_row(type)] : native_type(type); }

std::string signature_text(const CodeTable& code, const Function& function) {
  std::string text = function.has_result ? code.type_name(function.result) + " " : "";
  text += (function.kind == FunctionKind::Operator ? "operator " : "") + function.name + "(";
  for (std::size_t k = 0; k < function.params.size(); ++k)
    text += (k == 0 ? "" : ", ") + code.type_name(function.params[k].type);
  return text + ")";
}

std::string ffi_includes(const CodeTable& code) {
  std::string out;
  const auto line = [&](const std::string& text) { out += text + "\n"; };
  for (const char* header : {"algorithm", "cmath", "cstdio", "cstdlib", "iostream", "string", "vector"})
    line(std::string("#include <") + header + ">");
  line("");
  line("#include \"bip/ffi_calls.hpp\"");
  // In quotes: what no folder of the model has, C++ looks up as it does `<name>`.
  for (const CppFile& file : code.cpp.includes) line("#include \"" + file.name + "\"");
  return out;
}

std::string ffi_text(const CodeTable& code, const ConstNames& const_names, const FfiTextOptions& options) {
  const FfiNames names(code);
  std::string out;
  const auto line = [&](const std::string& text) { out += text + "\n"; };
  line("// The C++ that the model calls. An exception is a fault of the call at its site.");
  line("namespace ffi {");
  line("using namespace std;");
  if (options.names_crashes) line("inline const bool names_crashes = bip::rt::name_crashes();");
  if (options.own_context) line("inline bip::rt::FfiState own_context;");
  line(std::string("inline bip::rt::FfiContext* bip_context = ") +
       (options.own_context ? "&own_context;" : "nullptr;"));
  for (std::size_t k = 0; k < code.ffi_types.size(); ++k) {
    if (options.mark) line("#line 1 \"bip-type-" + std::to_string(k) + "\"");
    line("using " + local(names.type(ffi_type(k))) + " = " + code.ffi_types[k].cpp + ";");
  }
  if (options.mark) line("#line 1 \"bip-shim\"");
  for (std::size_t k = 0; k < code.functions.size(); ++k) {
    if (code.functions[k].kind == FunctionKind::Draw) continue;
    BIP_ASSERT(names.function(k).starts_with("ffi::"), "function `{}` is out of its namespace", names.function(k));
    const Function& function = code.functions[k];
    const std::string result = function.has_result ? local(names.type(function.result)) : "void";
    std::string head = "inline " + result + " " + local(names.function(k)) + "(";
    for (std::size_t p = 0; p < function.params.size(); ++p) {
      const FunctionParam& param = function.params[p];
      const std::string type = local(names.type(param.type));
      head += (is_ffi(param.type) && !param.by_reference ? "const " : "") + type +
              (is_ffi(param.type) || param.by_reference ? "&" : "") + " a" + std::to_string(p) + ", ";
    }
    line("");
    line(head + "[[maybe_unused]] std::uint32_t site) try {");
    if (options.mark) line("#line 1 \"bip-prototype-" + std::to_string(k) + "\"");
    const std::string call = call_text(function, const_names, result);
    if (options.names_crashes)
      line("  const bip::rt::CallNote bip_note(" + note_text(code, function, options) + ", bip_context->site(site));");
    if (!function.has_result) line("  " + call + ";");
    else if (function.result == Type::String) line("  return bip_context->intern(" + call + ");");
    else if (is_ffi(function.result)) line("  return " + call + ";");
    else line("  return static_cast<" + result + ">(" + call + ");");
    if (options.mark) line("#line 1 \"bip-shim\"");
    line("} catch (...) {");
    line("  bip::rt::raise(*bip_context, site);");
    line("}");
  }
  line("}  // namespace ffi");
  return out;
}

std::string draws_text(const CodeTable& code) {
  const FfiNames names(code);
  std::string out = "// The distributions that the model draws from.\nnamespace draws {\n";
  for (std::size_t k = 0; k < code.functions.size(); ++k) {
    const Function& function = code.functions[k];
    const rt::ProbabilityDistribution* distribution = model::distribution_of(function);
    if (distribution == nullptr) continue;
    out += "inline " + names.type(function.result) + " " + names.function(k).substr(7) + "(";
    std::string given;
    for (std::size_t p = 0; p < function.params.size(); ++p) {
      out += names.type(function.params[p].type) + (p == 0 ? "& a" : " a") + std::to_string(p) + ", ";
      if (p != 0) given += ", a" + std::to_string(p);
    }
    out += "std::uint32_t site) {\n  return bip::rt::draw(bip::rt::" + std::string(distribution->function) +
           ", a0, site" + given + ")." + (function.result == Type::Float ? "f" : "i") +
           (function.result == Type::Bool ? " != 0" : "") + ";\n}\n";
  }
  return out + "}  // namespace draws\n";
}

std::string watch_text() {
  return "// For who watches a thread from outside.\n"
         "extern \"C\" const std::atomic<const char*>* bip_called_now() { return &bip::rt::called_now; }\n"
         "extern \"C\" void bip_set_crash_hook(void (*hook)(const char*)) { bip::rt::crash::hook.store(hook); }\n";
}

std::string shim_text(const System& system, const ConstNames& const_names) {
  const CodeTable& code = system.code;
  const FfiNames names(code);
  const std::vector<lower::EventClassUse> classes = lower::event_class_uses(system);
  std::string out = ffi_includes(code);
  if (!classes.empty()) out += "#include \"bip/event_source.hpp\"\n";
  out += "\n" + ffi_text(code, const_names,
                         {.own_context = false, .mark = true, .names_crashes = true, .files = system.files});
  if (!classes.empty()) out += event_class_text(system, classes, LineMarks::OfUses);
  const auto line = [&](const std::string& text) { out += text + "\n"; };
  out += watch_text();
  for (std::size_t k = 0; k < code.functions.size(); ++k) {
    const Function& function = code.functions[k];
    if (function.kind == FunctionKind::Draw) continue;
    line("");
    line("extern \"C\" std::int32_t bip_call_" + std::to_string(k) +
         "(bip::rt::FfiContext* ffi_context, [[maybe_unused]] bip::rt::Cell* result, "
         "[[maybe_unused]] bip::rt::Cell* const* args) {");
    line("  ffi::bip_context = ffi_context;");
    line("  try {");
    std::string call = names.function(k) + "(";
    for (std::size_t p = 0; p < function.params.size(); ++p) {
      const std::string cell = "args[" + std::to_string(p) + "]";
      const Type type = function.params[p].type;
      if (is_ffi(type)) call += "bip::rt::object_in<" + names.type(type) + ">(*" + cell + "), ";
      else call += cell + (type == Type::Float ? "->f, " : type == Type::Bool ? "->i != 0, " : "->i, ");
    }
    call += "static_cast<std::uint32_t>(args[" + std::to_string(function.params.size()) + "]->i))";
    if (!function.has_result) line("    " + call + ";");
    else if (is_ffi(function.result))
      line("    bip::rt::object_in<" + names.type(function.result) + ">(*result) = " + call + ";");
    else if (function.result == Type::Float) line("    *result = bip::rt::float_cell(" + call + ");");
    else line("    *result = bip::rt::int_cell(" + call + (function.result == Type::Bool ? " ? 1 : 0);" : ");"));
    line("    return 0;");
    line("  } catch (...) {");
    line("    return 1;");
    line("  }");
    line("}");
  }
  if (!classes.empty()) line("\nextern \"C\" const bip::rt::EventClass bip_event_classes[] = {");
  for (std::size_t k = 0; k < classes.size(); ++k) line("    " + event_class_row(system, classes, k) + ",");
  if (!classes.empty()) line("};");
  if (code.ffi_types.empty()) return out;
  line("");
  line("extern \"C\" const bip::rt::FfiType bip_ffi_types[] = {");
  for (std::size_t k = 0; k < code.ffi_types.size(); ++k) {
    line("    bip::rt::ffi_type_of<" + names.type(ffi_type(k)) + ">(" + string_literal(code.ffi_types[k].name) + "),");
  }
  line("};");
  return out;
}

}  // namespace bip::emit_cpp
