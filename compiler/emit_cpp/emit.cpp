// One .cpp file: functions, tables, image() and, if wanted, main().
//
// Everything but image() is in an unnamed namespace inside the options' one, so files of several models can be one
// translation unit. The file is made for `g++ -std=c++20 -ffp-contract=off`: floats must not be contracted.
#include "compiler/emit_cpp/emit_cpp.hpp"
#include "compiler/emit_cpp/ffi_event_classes.hpp"
#include "compiler/emit_cpp/functions.hpp"
#include "compiler/emit_cpp/emit_steps.hpp"
#include "compiler/emit_cpp/image_tables.hpp"
#include "compiler/model/operators.hpp"
#include "compiler/system/system.hpp"

namespace bip::emit_cpp {

namespace {

bool has_places(const lower::LoweredSystem& lowered) {
  for (const lower::CodeUnit& unit : lowered.units) {
    if (unit.loc.line != 0) return true;
  }
  return false;
}

// "robot::base": robot_base.
std::string c_name(const std::string& namespace_name) {
  std::string name;
  for (const char c : namespace_name) {
    if (c != ':') {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  return name;
}

}  // namespace

std::string emit(const lower::LoweredSystem& lowered, const Options& options) {
  CppWriter out(lowered.system->files, options.line_directives && has_places(lowered));
  out.line("// " + comment_text(lowered.image.name) +
           ": emitted by bipc; the source is in the .bip that the rows name.");
  out.line("// First the code of the types, then the constant tables that bip::rt reads.");
  out.line("// Compile with -ffp-contract=off: floats are IEEE doubles, rounded after each operation.");
  out.line("#include <cstdint>");
  out.line("#include <limits>");
  out.line();
  const CodeTable& code = lowered.system->code;
  const bool has_ffi = lowered.image.ffi != nullptr;
  out.line("#include \"bip/emitted.hpp\"");
  if (options.with_main) out.line(options.serves ? "#include \"bip/serve.hpp\"" : "#include \"bip/run_main.hpp\"");
  if (options.with_c_image) out.line("#include \"bip/bip.h\"");
  if (!lowered.steps.shapes.empty()) out.line("#include \"bip/step_loop.hpp\"");
  out.line();
  if (has_ffi) out.line("#include \"bip/ffi_state.hpp\"\n" + ffi_includes(code));
  if (code.has_draws()) out.line("#include \"bip/draws.hpp\"");
  const std::vector<lower::EventClassUse> classes = lower::event_class_uses(*lowered.system);
  if (!classes.empty()) out.line("#include \"bip/event_source.hpp\"");
  out.line("namespace " + options.namespace_name + " {");
  if (has_ffi)
    out.line(ffi_text(code, options.const_names,
                      {.mark = options.mark_ffi, .names_crashes = options.with_main, .files = lowered.system->files}));
  if (code.has_draws()) out.line(draws_text(code));
  if (!classes.empty())
    out.line(event_class_text(*lowered.system, classes, options.mark_ffi ? LineMarks::OfUses : LineMarks::None));
  out.line("namespace {");
  out.line();
  // Not the whole namespace yet: a variable of the model may be called like one of its types.
  for (const char* name : {"BoolVar", "CodeFault", "FloatVar", "IntVar", "Cell", "StringVar"})
    out.line(std::string("using bip::rt::") + name + ";");
  for (const OperatorInfo& op : kOperators) {
    if (op.function != nullptr) out.line(std::string("using bip::rt::") + op.function + ";");
  }
  if (has_ffi) out.line("using bip::rt::FfiVariable;");
  emit_functions(lowered, out);
  emit_steps(lowered, out);
  out.line();
  out.line("using namespace bip::rt;");
  out.line();
  out.line("// The tables. Columns are those of bip/image.hpp; kNone is no row, {0, 0, 0} no place.");
  out.line();
  TableWriter tables(lowered, out);
  tables.types();
  tables.instances();
  tables.image();
  out.line();
  out.line("}  // namespace");
  out.line();
  out.line("const bip::rt::Image& image() { return kImage; }");
  out.line();
  out.line("}  // namespace " + options.namespace_name);
  if (options.with_c_image) {
    out.line();
    out.line("// For C, with bip/bip.h.");
    out.line("extern \"C\" const bip_image* " + c_name(options.namespace_name) + "_image(void) {");
    out.line("  return reinterpret_cast<const bip_image*>(&" + options.namespace_name + "::image());");
    out.line("}");
  }
  if (options.serves && has_ffi) {
    out.line();
    out.line(watch_text());
  }
  if (options.with_main) {
    out.line();
    out.line("// A program around the model has a main of its own.");
    out.line("#ifndef BIP_NO_MAIN");
    out.line(std::string("int main(int argc, char** argv) { return bip::") +
             (options.serves ? "serve_main(" : "rt::run_main(") + options.namespace_name + "::image(), argc, argv); }");
    out.line("#endif");
  }
  return out.take();
}

}  // namespace bip::emit_cpp
