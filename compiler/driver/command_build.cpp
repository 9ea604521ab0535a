// `bipc build`: builds a stand-alone program from the emitted C++ and the runtime, with the host compiler.
//
// Requires a C++20 compiler on the host. The C++ is written to a temporary directory, which is always removed; errors
// of the compiler are reported at locations of the model (compiler_errors.hpp).
#include <algorithm>
#include <filesystem>

#include "compiler/base/read_file.hpp"
#include "compiler/base/visit_files.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/compiler_errors.hpp"
#include "compiler/pipeline/ffi_build.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/host_compiler.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/emit_cpp/emit_cpp.hpp"
#include "compiler/steps/derive_steps.hpp"

namespace bip::driver {
namespace {

const char* flag_of(Optimisation optimisation) {
  switch (optimisation) {
    case Optimisation::O0: return "-O0";
    case Optimisation::O1: return "-O1";
    case Optimisation::O2: return "-O2";
    // Loops of whole steps become vectors.
    case Optimisation::Auto: break;
  }
  return "-O3";
}

// Sorted, so that the compiler sees the same command every time.
std::vector<std::string> runtime_sources(const std::string& directory) {
  namespace fs = std::filesystem;
  std::vector<std::string> sources;
  for (const char* folder : {"core", "distributed", "engine", "explore", "trace"}) {
    std::error_code ignored;
    for (const fs::path& path : files_below(fs::path(directory) / folder, ignored)) {
      if (path.extension() == ".cpp") sources.push_back(path.string());
    }
  }
  std::sort(sources.begin(), sources.end());
  return sources;
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : std::string(between)) + word;
  return text;
}

bool build_program(Compilation& c, const BuildArguments& arguments) {
  if (!check_outputs(c, {arguments.output})) return false;
  if (c.options.refuses_cpp && uses_ffi(c)) {
    c.diags.report(Diag::kB5014, {}, "compile");
    return false;
  }
  std::string tried;
  std::vector<std::string> command = find_host_compiler(tried);
  if (command.empty()) {
    c.diags.report(Diag::kB5002, {}, tried)
        .help("install one (`apt-get install g++`) or name one in the environment variable CXX")
        .help("`bipc emit FILE -o DIR` writes the C++ without compiling it");
    return false;
  }
  const std::string compiler = command.front();
  const RuntimeLocation runtime = find_runtime();
  if (runtime.directory.empty()) {
    c.diags.report(Diag::kB5006, {}, joined(runtime.tried, "`, `"));
    return false;
  }
  if (arguments.serves && runtime.serve_library.empty()) {
    c.diags.report(Diag::kB5001, {}, "the library that programs of `--serve` link")
        .help("`tools/build bipc` builds all of bipc");
    return false;
  }
  const Result<TemporaryDirectory> work = TemporaryDirectory::make();
  if (!work) {
    c.diags.report(Diag::kB5004, {}, arguments.output, work.error());
    return false;
  }
  const std::string source = (*work).path() + "/model.cpp";
  emit_cpp::CppBuild cpp;
  if (!find_ffi_files(c, cpp)) return false;
  emit_cpp::Options options;
  options.const_names = cpp.const_names;
  options.mark_ffi = true;
  options.serves = arguments.serves;
  if (arguments.optimisation != Optimisation::O0) steps::derive_steps(*c.lowered);
  if (const auto written = write_file(source, emit_cpp::emit(*c.lowered, options)); !written) {
    c.diags.report(Diag::kB5004, {}, source, written.error());
    return false;
  }
  const std::string parent = std::filesystem::path(runtime.directory).parent_path().string();
  // At a fixed address: the tables need no relocation, so their pages stay the file's own.
  for (const std::string& word : {std::string("-std=c++20"), std::string(flag_of(arguments.optimisation)),
                                  std::string("-pthread"), std::string("-fno-pie"), std::string("-no-pie"),
                                  "-I" + runtime.directory + "/include", "-I" + parent, source}) {
    command.push_back(word);
  }
  // Before the runtime, which it needs. What it looks for by name in the program is exported.
  if (arguments.serves) command.insert(command.end(), {runtime.serve_library, "-rdynamic"});
  if (runtime.library.empty()) {
    for (std::string& file : runtime_sources(runtime.directory)) command.push_back(std::move(file));
  } else {
    command.push_back(runtime.library);
  }
  for (const std::string& dir : cpp.include_dirs) command.push_back("-I" + dir);
  command.push_back("-I" + runtime.directory + "/include/published");
  for (const std::string& file : cpp.sources) {
    // Without the option the C++ compiler takes a file of C for C++.
    if (std::filesystem::path(file).extension() == ".c") command.insert(command.end(), {"-x", "c", file, "-x", "none"});
    else command.push_back(file);
  }
  command.insert(command.end(), cpp.objects.begin(), cpp.objects.end());
  // Beside the goal, then renamed over it: a program that runs just now is replaced, not written into.
  Result<NewFile> program = NewFile::create(arguments.output);
  if (!program) {
    c.diags.report(Diag::kB5004, {}, arguments.output, program.error());
    return false;
  }
  command.insert(command.end(), {"-o", (*program).path().string()});
  const std::string said = (*work).path() + "/said";
  const Result<int> status = run_program(command, said);
  if (!status || *status != 0) {
    report_build_failure(c, compiler, status ? fmt::format("exit code {}", *status) : status.error(),
                         read_file(said).value_or(""), (*work).path());
    return false;
  }
  const Result<bool> placed = program->commit(Durability::Synced);
  if (!placed) c.diags.report(Diag::kB5004, {}, arguments.output, placed.error());
  return static_cast<bool>(placed);
}

// Sources and objects that options name. False: one is not there, which is reported.
bool add_extra_files(Compilation& c, const emit_cpp::CppBuild& extra, emit_cpp::CppBuild& cpp) {
  for (const auto& [from, to] : {std::pair(&extra.sources, &cpp.sources), std::pair(&extra.objects, &cpp.objects)}) {
    for (const std::string& file : *from) {
      std::error_code error;
      if (!std::filesystem::is_regular_file(file, error)) {
        c.diags.report(Diag::kB0090, {}, file, error ? error.message() : "it is no file");
        return false;
      }
      const std::string path = std::filesystem::absolute(file, error).lexically_normal().string();
      if (std::find(to->begin(), to->end(), path) == to->end()) to->push_back(path);
    }
  }
  return true;
}

}  // namespace

int command_build(const BuildArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.compile.emit != EmitKind::None) {
    emit_stage(c, arguments.file, arguments.optimisation);
  } else if (compile(c, arguments.file, Stage::Image)) {
    (void)build_program(c, arguments);
  }
  return report(c);
}

int command_emit(const EmitArguments& arguments) {
  Compilation c(arguments.compile);
  if (arguments.directory.empty()) {
    if (c.options.emit == EmitKind::None) c.options.emit = EmitKind::Cpp;
    emit_stage(c, arguments.file, arguments.optimisation);
    return report(c);
  }
  const RuntimeLocation runtime = find_runtime();
  if (runtime.directory.empty()) {
    c.diags.report(Diag::kB5006, {}, joined(runtime.tried, "`, `"));
  } else if (compile(c, arguments.file, Stage::Image)) {
    const std::string program = std::filesystem::path(arguments.file).stem().string();
    emit_cpp::CppBuild cpp;
    if (!find_ffi_files(c, cpp) || !add_extra_files(c, arguments.extra, cpp)) return report(c);
    const std::filesystem::path folder(arguments.directory);
    if (!check_outputs(c, {folder / "model.cpp", folder / "CMakeLists.txt"})) return report(c);
    steps::derive_steps(*c.lowered);
    const auto written = emit_cpp::emit_project(*c.lowered, arguments.directory, runtime.directory, program, cpp,
                                                {.with_main = !arguments.has_no_main,
                                                 .runtime_library = runtime.library,
                                                 .link_folders = arguments.link_folders,
                                                 .libraries = arguments.libraries});
    if (!written) c.diags.report(Diag::kB5004, {}, arguments.directory, written.error());
  }
  return report(c);
}

}  // namespace bip::driver
