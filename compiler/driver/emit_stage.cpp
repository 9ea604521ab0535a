// Prints the product of one stage. The switch below selects the stage and the function that prints it.
#include "compiler/driver/emit_stage.hpp"

#include <cstdio>

#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/emit_cpp/emit_cpp.hpp"
#include "compiler/steps/derive_steps.hpp"
#include "compiler/syntax/print.hpp"
#include "compiler/system/bsys.hpp"

namespace bip::driver {
namespace {

Stage stage_of(EmitKind kind) {
  switch (kind) {
    case EmitKind::None:
    case EmitKind::Tokens: return Stage::Source;
    case EmitKind::Syntax: return Stage::Syntax;
    case EmitKind::Model: return Stage::Model;
    case EmitKind::System:
    case EmitKind::Dot:
    case EmitKind::Json: return Stage::System;
    case EmitKind::Llvm:
    case EmitKind::Asm:
    case EmitKind::Cpp: return Stage::Image;
  }
  return Stage::Image;
}

// The text of the last stage, or a failure that says which part could not make it.
Result<std::string> text_of(Compilation& c, EmitKind kind, Optimisation optimisation) {
  switch (kind) {
    case EmitKind::Tokens: return parse::dump_tokens(c.sources, c.file);
    case EmitKind::Syntax: return syntax::dump(*c.syntax, c.sources);
    case EmitKind::Model: return model::dump(*c.model);
    case EmitKind::System: return system::print(*c.system);
    case EmitKind::Llvm:
    case EmitKind::Asm: {
      const Result<JitPlugin> plugin = load_jit();
      if (!plugin) {
        c.diags.report(Diag::kB5001, {}, fmt::format("`--emit={}`", name_of(kind))).note(plugin.error());
        return std::string();
      }
      const jit::OptLevel level = opt_level(*c.lowered, optimisation);
      return kind == EmitKind::Llvm ? (*plugin).emit_llvm(*c.lowered, level) : (*plugin).emit_asm(*c.lowered, level);
    }
    case EmitKind::Cpp: {
      emit_cpp::CppBuild cpp;
      if (!find_ffi_files(c, cpp)) return std::string();
      emit_cpp::Options options_of_text;
      options_of_text.const_names = cpp.const_names;
      if (!c.options.cpp_namespace.empty()) {
        options_of_text.namespace_name = c.options.cpp_namespace;
        options_of_text.with_main = false;
        options_of_text.with_c_image = true;
      }
      steps::derive_steps(*c.lowered);
      return emit_cpp::emit(*c.lowered, options_of_text);
    }
    case EmitKind::Dot: return graph::dot(*c.system);
    case EmitKind::Json: return graph::json(*c.system);
    case EmitKind::None: break;
  }
  return Failure{"no such stage"};
}

}  // namespace

void emit_stage(Compilation& c, const std::string& path, Optimisation optimisation) {
  const EmitKind kind = c.options.emit;
  if (path.ends_with(".bsys") && stage_of(kind) < Stage::System) {
    c.diags.report(Diag::kB5008, {}, path, name_of(kind));
    return;
  }
  if (!compile(c, path, stage_of(kind))) return;
  const Result<std::string> text = text_of(c, kind, optimisation);
  if (!text) {
    c.diags.report(Diag::kB5007, {}, name_of(kind), text.error());
    return;
  }
  std::fwrite((*text).data(), 1, (*text).size(), stdout);
}

}  // namespace bip::driver
