// What a compilation is asked for, with the defaults of the commands.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/diag/diagnostics.hpp"

namespace bip::pipeline {

enum class EmitKind : std::uint8_t { None, Tokens, Syntax, Model, System, Llvm, Asm, Cpp, Dot, Json };
[[nodiscard]] const char* name_of(EmitKind kind);

/// Passes whose product has a text form.
enum class PrintAfter : std::uint8_t { None, Parse, BuildModel, Instantiate };

enum class ColorChoice : std::uint8_t { Auto, Always, Never };
enum class Backend : std::uint8_t { Auto, Jit, Interp };
/// Auto: `run` begins interpreted and goes on at -O2 (tiers.hpp). Elsewhere -O2 for at most kMaxUnitsForO2 pieces of
/// code, else -O0, so that the start takes about 0.1 s either way.
enum class Optimisation : std::uint8_t { Auto, O0, O1, O2 };

/// Options of the cache on disk, which holds machine code and proofs.
struct CacheOptions {
  bool is_off = false;
  std::string folder;             // empty: the user's cache folder
  std::uint64_t megabytes = 256;  // at most so much is kept
};
/// Of every command that compiles.
struct CompileOptions {
  std::string root;                  // "Ring(10)"; empty: the parameterless compound that no other one instantiates
  std::vector<std::string> folders;  // -I: where packages are, before the file's own folder and the standard library
  std::string package;               // -p: what the file must be; empty: anything
  RenderOptions render;
  ColorChoice color = ColorChoice::Auto;
  bool warnings_are_errors = false;
  std::vector<std::string> fatal_warnings;  // --Werror=CODE; "true" is all of them
  bool explain = false;                     // the page of the first error follows
  EmitKind emit = EmitKind::None;
  std::string cpp_namespace;  // of C++ code without main(); empty: a program's code
  PrintAfter print_after = PrintAfter::None;
  bool time_passes = false;
  CacheOptions cache;
  bool verify_each = false;
  std::uint64_t max_instances = 0;  // of atoms, of connectors ...; 0: what free memory holds
  bool refuses_cpp = false;         // the model's C++ is neither compiled nor loaded
};

}  // namespace bip::pipeline
