// `bipc genom`: descriptions of robot modules to one BIP package (compiler/genom does the work).
#include <cstdio>
#include <filesystem>

#include "compiler/base/assert.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/exit_codes.hpp"
#include "compiler/driver/host_compiler.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/translate.hpp"
#include "compiler/syntax/print.hpp"

namespace bip::driver {
namespace {

namespace fs = std::filesystem;

genom::TranslateOptions options_of(const GenomArguments& a) {
  genom::TranslateOptions o;
  o.preprocess.folders = a.compile.folders;
  for (const std::string& define : a.defines) {
    const std::size_t equals = define.find('=');
    o.preprocess.defines.emplace_back(define.substr(0, equals), equals == std::string::npos ? "1" : define.substr(equals + 1));
  }
  o.instances = a.instances;
  o.generate.package = a.package;
  if (o.generate.package.empty() && !a.output.empty()) o.generate.package = genom::bip_name(fs::path(a.output).stem().string());
  for (const std::string& file : a.files) o.generate.sources.push_back(fs::path(file).filename().string());
  if (a.skeleton || a.flavour == "execution") o.generate.flavour = genom::Flavour::Execution;
  o.generate.lock = a.lock == "module" ? genom::LockGranularity::Module : a.lock == "codel" ? genom::LockGranularity::Codel : genom::LockGranularity::ByGeneration;
  o.generate.tick_us = static_cast<std::int64_t>(a.tick_ms * 1000.0);
  o.generate.control_period = a.control_period;
  o.generate.poster_period = a.poster_period;
  o.generate.oldest = a.oldest;
  return o;
}

// In house style; what we write must be BIP.
std::string formatted(const std::string& text) {
  SourceMap sources;
  Diagnostics diags;
  const FileId file = sources.add("generated", text);
  const auto syntax = parse::parse_file(sources, file, diags);
  BIP_ASSERT(syntax.has_value() && !diags.has_errors());
  return syntax::print(*syntax, sources);
}

std::optional<genom::Translation> translated(Compilation& c, const GenomArguments& a) {
  std::vector<genom::Description> files;
  for (const std::string& path : a.files) {
    const Result<FileId> file = genom::load_description(c.sources, path);
    if (file) {
      files.push_back({path, *file});
    } else {
      c.diags.report(Diag::kB0090, {}, path, file.error());
    }
  }
  std::vector<genom::SideLine> side;
  if (!a.side_file.empty()) {
    const Result<FileId> file = genom::load_description(c.sources, a.side_file);
    if (file) {
      side = genom::parse_side_file(c.sources, *file, c.diags);
    } else {
      c.diags.report(Diag::kB0090, {}, a.side_file, file.error());
    }
  }
  if (c.diags.has_errors()) return std::nullopt;
  std::optional<genom::Translation> result = genom::translate(c.sources, files, std::move(side), options_of(a), c.diags);
  if (result) result->bip = formatted(result->bip);
  return result;
}

void write(Compilation& c, const std::string& path, const std::string& text) {
  const Result<bool> written = write_file(path, text);
  if (!written) c.diags.report(Diag::kB5004, {}, path, written.error());
}

// What somebody may have filled in already is never written over.
void write_skeleton(Compilation& c, const GenomArguments& a, const genom::Translation& result) {
  const fs::path folder = fs::path(a.output).parent_path();
  const std::string package = options_of(a).generate.package;
  std::error_code ignored;
  for (const auto& [suffix, text] : {std::pair("_codels.hpp", &result.codel_header), std::pair("_codels.cpp", &result.codel_source)}) {
    const std::string path = (folder / (package + suffix)).string();
    if (fs::exists(path, ignored)) {
      std::printf("%s is there already and stays as it is\n", path.c_str());
    } else {
      write(c, path, *text);
    }
  }
}

}  // namespace

int command_genom(const GenomArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.skeleton && arguments.output.empty()) {
    std::fputs("bipc: `--skeleton` writes files beside the output\n  = help: add `-o FILE`\n", stderr);
    return kUsage;
  }
  const std::optional<genom::Translation> result = translated(c, arguments);
  if (result && arguments.output.empty()) std::fwrite(result->bip.data(), 1, result->bip.size(), stdout);
  if (result && !arguments.output.empty()) write(c, arguments.output, result->bip);
  if (result && arguments.skeleton) write_skeleton(c, arguments, *result);
  return report(c);
}

}  // namespace bip::driver
