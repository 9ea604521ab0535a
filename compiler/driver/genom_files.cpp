// See genom_files.hpp. Paths are those of the command line, or relative to the .rules file that names them.
#include "compiler/driver/genom_files.hpp"

#include <cstdio>
#include <filesystem>
#include <sstream>

#include "compiler/base/read_file.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/pipeline/host_compiler.hpp"
#include "compiler/syntax/print.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {
namespace {

namespace fs = std::filesystem;

void write(Compilation& c, const std::string& path, const std::string& text) {
  const Result<bool> written = write_file(path, text);
  if (!written) c.diags.report(Diag::kB5004, {}, path, written.error());
}

// Files that a person may have filled in already are never overwritten; the header is the generator's.
void write_skeleton(Compilation& c, const GenomArguments& a, const genom::Translation& result,
                    const std::string& package) {
  const fs::path folder = fs::path(a.output).parent_path();
  std::error_code ignored;
  for (const auto& [suffix, text] :
       {std::pair("_codels.hpp", &result.codel_header), std::pair("_codels.cpp", &result.codel_source)}) {
    const std::string path = (folder / (package + suffix)).string();
    if (text == &result.codel_source && fs::exists(path, ignored)) {
      print_words(path + " is there already and stays as it is");
    } else {
      write(c, path, *text);
    }
  }
}

std::string beside_output(const GenomArguments& a, const std::string& name) {
  return (fs::path(a.output).parent_path() / name).string();
}

// All that write_translation() may write.
std::vector<std::string> paths_of(const GenomArguments& a, const genom::Translation& translation,
                                  const std::string& package) {
  std::vector<std::string> paths{a.output};
  for (const auto& [name, file] : translation.c_files) paths.push_back(beside_output(a, name));
  if (a.skeleton) paths.push_back(beside_output(a, package + "_codels.hpp"));
  return paths;
}

std::vector<std::string> input_files_of(const GenomArguments& a) {
  std::vector<std::string> inputs = a.codels;
  inputs.push_back(a.side_file);
  return inputs;
}

// As pkg-config knows it. The package is one argument, whatever it is called.
Result<std::vector<std::string>> package_folders(const std::string& package) {
  auto folder = pipeline::TemporaryDirectory::make();
  if (!folder) return Failure{folder.error()};
  const std::string output = folder->path() + "/flags";
  const Result<int> code =
      pipeline::run_program({"pkg-config", "--silence-errors", "--cflags-only-I", "--", package}, output);
  if (!code) return Failure{fmt::format("pkg-config cannot be run, {}", code.error())};
  if (*code != 0) return Failure{fmt::format("pkg-config knows no `{}`", package)};
  std::vector<std::string> folders;
  std::istringstream flags(read_file(output).value_or(""));
  for (std::string flag; flags >> flag;) {
    if (flag.starts_with("-I")) folders.push_back(flag.substr(2));
  }
  return folders;
}

}  // namespace

genom::TranslateOptions translate_options(const GenomArguments& a, const std::vector<std::string>& files,
                                          const std::string& package) {
  genom::TranslateOptions o;
  o.preprocess.folders = a.compile.folders;
  o.preprocess.package_folders = package_folders;
  for (const std::string& define : a.defines) {
    const std::size_t equals = define.find('=');
    o.preprocess.defines.emplace_back(define.substr(0, equals),
                                      equals == std::string::npos ? "1" : define.substr(equals + 1));
  }
  o.instances = a.instances;
  o.generate.package = a.package;
  if (o.generate.package.empty() && !a.output.empty())
    o.generate.package = genom::bip_name(fs::path(a.output).stem().string());
  if (o.generate.package.empty()) o.generate.package = package;
  for (const std::string& file : files) o.generate.sources.push_back(fs::path(file).filename().string());
  if (a.executive || a.served) o.generate.executive = a.served ? genom::Executive::Served : genom::Executive::Cpp;
  o.generate.has_task_threads = a.task_threads;
  o.generate.calls_c = !a.codels.empty();
  o.codel_files = a.codels;
  o.generate.processes = {.are_own = a.processes, .kill_after_us = a.kill_after / 1000, .memory_mb = a.module_memory};
  for (const std::string& file : a.codels) {
    // As the package finds it.
    std::error_code ignored;
    const fs::path relative = fs::relative(file, fs::absolute(a.output).parent_path(), ignored);
    o.generate.c_sources.push_back(relative.empty() ? file : relative.string());
  }
  if (a.skeleton || a.executive || a.served || a.processes || !a.codels.empty() || a.flavour == "execution")
    o.generate.flavour = genom::Flavour::Execution;
  o.generate.lock = a.lock == "module"  ? genom::LockGranularity::Module
                    : a.lock == "codel" ? genom::LockGranularity::Codel
                                        : genom::LockGranularity::ByGeneration;
  o.generate.design = a.design == "first"      ? genom::Design::First
                      : a.design == "repaired" ? genom::Design::Repaired
                                               : genom::Design::Ours;
  o.generate.tick_us = static_cast<std::int64_t>(a.tick_ms * 1000.0);
  o.generate.control_period = a.control_period;
  o.generate.poster_period = a.poster_period;
  o.generate.oldest = a.oldest;
  return o;
}

std::string formatted(const std::string& text) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("generated", text);
  const auto syntax = parse::parse_file(sources, file, diags);
  // What we write must be BIP.
  BIP_ENSURE(syntax.has_value() && !diags.has_errors());
  return syntax::print(*syntax, sources);
}

std::optional<std::vector<genom::Module>> load_modules(Compilation& c, const std::vector<std::string>& files,
                                                       const std::string& side_file,
                                                       const genom::TranslateOptions& options) {
  std::vector<genom::Description> descriptions;
  for (const std::string& path : files) {
    const Result<FileId> file = genom::load_description(c.sources, path);
    if (file) {
      descriptions.push_back({path, *file});
    } else {
      c.diags.report(Diag::kB0090, {}, path, file.error());
    }
  }
  std::vector<genom::SideLine> side;
  if (!side_file.empty()) {
    const Result<FileId> file = genom::load_description(c.sources, side_file);
    if (file) {
      side = genom::parse_side_file(c.sources, *file, c.diags);
    } else {
      c.diags.report(Diag::kB0090, {}, side_file, file.error());
    }
  }
  if (c.diags.has_errors()) return std::nullopt;
  return genom::read_modules(c.sources, descriptions, std::move(side), options, c.diags);
}

void write_translation(Compilation& c, const GenomArguments& a, const genom::Translation& translation,
                       const std::string& package) {
  const std::string text = formatted(translation.bip);
  if (a.output.empty()) {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else if (check_outputs(c, paths_of(a, translation, package), input_files_of(a))) {
    write(c, a.output, text);
    for (const auto& [name, file] : translation.c_files) write(c, beside_output(a, name), file);
    if (a.skeleton) write_skeleton(c, a, translation, package);
  }
}

}  // namespace bip::driver
