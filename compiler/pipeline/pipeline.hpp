// One compilation, and the pipeline that drives it from a file to the input of an executor.
//
// A Compilation owns everything: texts, diagnostics, and the product of each stage. There is no global state, so two
// compilations in one process are independent. The pipeline neither prints nor exits: commands do.
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/pipeline/options.hpp"
#include "compiler/lower/lower.hpp"
#include "compiler/model/model.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/syntax/syntax.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::pipeline {

/// How far to go; each stage needs those before it.
enum class Stage : std::uint8_t { Source, Syntax, Model, System, Image };

struct PassTime {
  std::string name;
  double seconds = 0;
};

struct Compilation {
  explicit Compilation(CompileOptions o);
  ~Compilation();
  Compilation(const Compilation&) = delete;
  Compilation& operator=(const Compilation&) = delete;

  CompileOptions options;
  SourceMap sources;
  Diagnostics diags;
  std::map<std::string, std::string> open_texts;             // by path: what an editor holds, read instead of the files
  std::map<std::string, parse::PieceCache>* kept = nullptr;  // by path: what an editor keeps of earlier texts
  std::map<FileId, std::string> paths;                       // where each file was read; messages may call it otherwise
  std::vector<PassTime> times;
  std::string printed;  // text of the products that --print-after names; the command prints it

  // Products, in the order of the stages. A .bsys file has no syntax and no model.
  std::string path;
  FileId file;
  std::optional<parse::RootSpec> root;
  SourceRange root_range;
  std::string root_name;  // "Ring(10)"
  std::optional<syntax::Syntax> syntax;
  std::deque<syntax::Syntax> used;              // of the packages that the file uses, directly or not
  std::vector<const syntax::Syntax*> packages;  // a package after those it uses; the file's own last
  std::optional<Model> model;
  std::unique_ptr<System> system;
  std::unique_ptr<lower::LoweredSystem> lowered;

  [[nodiscard]] bool is_bsys() const { return path.ends_with(".bsys"); }
};

/// A file of this compilation, from `open_texts` or from disk, with the same demands on its text.
/// `name`: what it is called in messages; empty: its path.
[[nodiscard]] Result<FileId> load_text(Compilation& c, const std::string& path, std::string name = {});

/// Parses a file of this compilation; reuses the kept trees of declarations that did not change.
[[nodiscard]] std::optional<syntax::Syntax> parse_text(Compilation& c, FileId file);

/// Runs the stages up to `last` on a .bip or .bsys file. False as soon as one reported an error.
[[nodiscard]] bool compile(Compilation& c, const std::string& path, Stage last);

/// As `compile` up to System, but a file of types without a root is fine: `bipc check`. Every parameterless compound
/// that nothing instantiates is instantiated.
[[nodiscard]] bool check(Compilation& c, const std::string& path);

}  // namespace bip::pipeline
