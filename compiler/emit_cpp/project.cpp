// Writes a directory that can be built by itself: model.cpp, CMakeLists.txt, copies of the runtime with its licence,
// and of the model's C++ files.
//
// Files whose text is unchanged are not written, so that a second emission rebuilds only what changed.
#include <algorithm>
#include <filesystem>
#include <sstream>
#include <vector>

#include "compiler/base/read_file.hpp"
#include "compiler/base/visit_files.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/emit_cpp/copy_ffi_files.hpp"

namespace bip::emit_cpp {

namespace {

namespace fs = std::filesystem;

// Paths below `runtime_dir` of all its sources and headers, sorted.
Result<std::vector<fs::path>> runtime_files(const fs::path& runtime_dir) {
  std::vector<fs::path> files;
  for (const char* part : {"include", "core", "distributed", "engine", "explore", "trace"}) {
    std::error_code error;
    for (const fs::path& path : files_below(runtime_dir / part, error)) {
      const fs::path extension = path.extension();
      if (extension == ".cpp" || extension == ".hpp" || extension == ".h")
        files.push_back(path.lexically_relative(runtime_dir));
    }
    if (error)
      return Failure{"cannot read the runtime's sources in " + (runtime_dir / part).string() + ": " + error.message()};
  }
  std::sort(files.begin(), files.end());
  return files;
}

// A file name that needs no quoting anywhere.
std::string plain_name(const std::string& name) {
  std::string out;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
                       c == '-' || (c == '.' && !out.empty());
    out += plain ? c : '_';
  }
  return out.empty() ? "model" : out;
}

// Within quotes of CMake.
std::string in_quotes(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '$') out += '\\';
    out += c;
  }
  return out;
}

std::string cmake_text(const std::vector<fs::path>& runtime, const std::string& program_name, const CppBuild& cpp,
                       const ProjectOptions& options) {
  std::ostringstream out;
  out << "# Emitted by bipc. Build: cmake -S . -B build && cmake --build build; run: build/" << plain_name(program_name)
      << "\n"
      << "cmake_minimum_required(VERSION 3.16)\n"
      << "project(bip_program LANGUAGES CXX)\n\n"
      << "if(NOT CMAKE_BUILD_TYPE)\n  set(CMAKE_BUILD_TYPE Release)\nendif()\n"
      << "set(CMAKE_CXX_STANDARD 20)\n"
      << "set(CMAKE_CXX_STANDARD_REQUIRED ON)\n"
      << "set(CMAKE_CXX_EXTENSIONS OFF)\n"
      << "set(CMAKE_CXX_FLAGS_RELEASE \"-O3\")\n"
      << "find_package(Threads REQUIRED)\n\n"
      << "# The runtime: compiled before, or as one source.\n"
      << "set(BIP_RUNTIME_LIBRARY \"" << options.runtime_library << "\" CACHE FILEPATH \"the runtime as a library\")\n"
      << "if(NOT EXISTS \"${BIP_RUNTIME_LIBRARY}\")\n"
      << "  add_library(bip_runtime STATIC\n";
  for (const fs::path& file : runtime) {
    if (file.extension() == ".cpp") out << "    runtime/" << file.generic_string() << "\n";
  }
  out << "  )\n"
      << "  set_target_properties(bip_runtime PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)\n"
      << "  target_include_directories(bip_runtime PRIVATE . runtime/include)\n"
      << "  target_compile_options(bip_runtime PRIVATE -ffp-contract=off)\n"
      << "  set(BIP_RUNTIME_LIBRARY bip_runtime)\n"
      << "endif()\n\n"
      << (options.with_main ? "add_executable(bip_program\n  model.cpp\n"
                            : "add_library(bip_program STATIC\n  model.cpp\n");
  out << ")\n"
      << "target_include_directories(bip_program PRIVATE . runtime/include)\n"
      << "# Floats are rounded after each operation, as in every other executor.\n"
      << "target_compile_options(bip_program PRIVATE -ffp-contract=off)\n"
      << "target_link_libraries(bip_program PRIVATE ${BIP_RUNTIME_LIBRARY} Threads::Threads)\n";
  if (!cpp.include_dirs.empty() || !cpp.sources.empty() || !cpp.objects.empty()) {
    out << "# The C++ side of the model: copies of what `@cpp` names.\n";
    const auto list = [&out](const char* command, const std::vector<std::string>& paths) {
      if (paths.empty()) return;
      out << command << "(bip_program PRIVATE";
      for (const std::string& path : paths) out << " \"${CMAKE_CURRENT_SOURCE_DIR}/" << path << "\"";
      out << ")\n";
    };
    std::vector<std::string> include_dirs = cpp.include_dirs;
    include_dirs.push_back("runtime/include/published");
    list("target_include_directories", include_dirs);
    list("target_sources", cpp.sources);
    list("target_link_libraries", cpp.objects);
  }
  const auto words = [&out](const char* command, const std::vector<std::string>& all) {
    if (all.empty()) return;
    out << command << "(bip_program PRIVATE";
    for (const std::string& word : all) out << " \"" << in_quotes(word) << "\"";
    out << ")\n";
  };
  words("target_link_directories", options.link_folders);
  words("target_link_libraries", options.libraries);
  out << "set_target_properties(bip_program PROPERTIES OUTPUT_NAME \"" << plain_name(program_name) << "\")\n";
  return out.str();
}

}  // namespace

Result<bool> update_file(const fs::path& path, const std::string& text) {
  if (read_file(path) == text) return true;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  const Result<bool> written = write_file(path, text);
  if (!written) return Failure{path.string() + ": " + written.error()};
  return true;
}

Result<bool> emit_project(const lower::LoweredSystem& lowered, const std::string& directory,
                          const std::string& runtime_dir, const std::string& program_name, const CppBuild& cpp,
                          const ProjectOptions& project) {
  const Result<std::vector<fs::path>> runtime = runtime_files(runtime_dir);
  if (!runtime) return Failure{runtime.error()};
  const fs::path root(directory);
  for (const fs::path& file : *runtime) {
    const std::optional<std::string> text = read_file(fs::path(runtime_dir) / file);
    if (!text) return Failure{"cannot read " + (fs::path(runtime_dir) / file).string()};
    Result<bool> written = update_file(root / "runtime" / file, *text);
    if (!written) return written;
  }
  // Beside the runtime's sources in an installation, one folder up in ours.
  for (const char* licence : {"LICENSE", "../LICENSE"}) {
    const std::optional<std::string> text = read_file(fs::path(runtime_dir) / licence);
    if (!text) continue;
    Result<bool> written = update_file(root / "runtime/LICENSE", *text);
    if (!written) return written;
    break;
  }
  const Result<CppBuild> copied = copy_ffi_files(cpp, root);
  if (!copied) return Failure{copied.error()};
  Result<bool> written = update_file(root / "CMakeLists.txt", cmake_text(*runtime, program_name, *copied, project));
  if (!written) return written;
  Options options;
  options.const_names = cpp.const_names;
  options.with_main = project.with_main;
  return update_file(root / "model.cpp", emit(lowered, options));
}

}  // namespace bip::emit_cpp
