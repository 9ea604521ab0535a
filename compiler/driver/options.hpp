// What the command line says, as data. Defaults are the commands' defaults.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "bip/run.hpp"
#include "compiler/diag/diagnostics.hpp"

namespace bip::driver {

enum class EmitKind : std::uint8_t { None, Tokens, Syntax, Model, System, Llvm, Asm, Cpp, Dot, Json };
[[nodiscard]] const char* name_of(EmitKind kind);

enum class ColorChoice : std::uint8_t { Auto, Always, Never };
enum class Backend : std::uint8_t { Auto, Jit, Interp };
/// Auto: -O2 for at most kMaxUnitsForO2 pieces of code, else -O0, so that a run starts within about 0.1 s either way.
enum class Optimisation : std::uint8_t { Auto, O0, O1, O2 };

/// Of every command that compiles.
struct CompileOptions {
  std::string root;  // "Ring(10)"; empty: the one parameterless compound nobody instantiates
  RenderOptions render;
  ColorChoice color = ColorChoice::Auto;
  bool warnings_are_errors = false;
  EmitKind emit = EmitKind::None;
  bool time_passes = false;
  bool verify_each = false;
};
struct RunArguments {
  CompileOptions compile;
  std::string file;
  Backend backend = Backend::Auto;
  Optimisation optimisation = Optimisation::Auto;
  rt::RunOptions run;
};
struct BuildArguments {
  CompileOptions compile;
  std::string file;
  std::string output;
  Optimisation optimisation = Optimisation::O2;
};
struct CheckArguments {
  CompileOptions compile;
  std::vector<std::string> files;
};
struct EmitArguments {
  CompileOptions compile;
  std::string file;
  std::string directory;  // empty: print the stage of compile.emit
  Optimisation optimisation = Optimisation::O2;
};
struct FmtArguments {
  CompileOptions compile;
  std::vector<std::string> files;
  bool check = false;
  bool in_place = false;
};

/// The published tools' own call: bipc -p Package -I DIR -d 'Root()' [--gencpp-output DIR].
struct PublishedArguments {
  std::string package;
  std::vector<std::string> folders;
  std::string declaration;
  std::string cpp_output;
};

}  // namespace bip::driver
