// Finds, compiles and loads the C++ code of a model: see ffi_build.hpp.
#include "compiler/driver/ffi_build.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "compiler/base/content_hash.hpp"
#include "compiler/driver/cache_folder.hpp"
#include "compiler/driver/compiler_errors.hpp"
#include "compiler/driver/host_compiler.hpp"
#include "compiler/lower/event_classes.hpp"

namespace bip::driver {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// Folders in which a file of `@cpp` may be, in the order in which they are tried.
std::vector<fs::path> folders_of(const Compilation& c, const CppFile& file) {
  std::vector<fs::path> folders{file.folder.empty() ? "." : file.folder};
  for (const std::string& folder : c.options.folders) folders.emplace_back(folder);
  std::vector<fs::path> all;
  for (const fs::path& folder : folders) {
    all.push_back(folder);
    all.push_back(folder / "ext-cpp");
  }
  return all;
}

// The file's path, and in `folder` the one under which it was found; empty if no folder has it.
std::string find_file(const Compilation& c, const CppFile& file, std::string& folder) {
  std::error_code error;
  for (const fs::path& candidate : folders_of(c, file)) {
    const fs::path path = fs::path(file.name).is_absolute() ? fs::path(file.name) : candidate / file.name;
    if (!fs::is_regular_file(path, error)) continue;
    folder = fs::absolute(candidate, error).lexically_normal().string();
    return fs::absolute(path, error).lexically_normal().string();
  }
  return {};
}

void add_once(std::vector<std::string>& list, const std::string& item) {
  if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

// Headers beside a header count, too: it may include them.
void add_headers(std::vector<std::string>& texts, const fs::path& folder) {
  std::vector<fs::path> headers;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".h" || extension == ".hpp" || extension == ".hh" || extension == ".hxx" || extension == ".inc")
      headers.push_back(entry.path());
  }
  std::sort(headers.begin(), headers.end());
  for (const fs::path& header : headers) {
    texts.push_back(header.string());
    texts.push_back(text_of(header));
  }
}

// The shared object's path, compiled if the cache has none; empty after a report. Without a cache it is in `work`.
std::string shared_object(Compilation& c, const emit_cpp::CppBuild& cpp, const TemporaryDirectory& work) {
  const RuntimeLocation runtime = find_runtime();
  if (runtime.directory.empty()) {
    std::string tried;
    for (const std::string& path : runtime.tried) tried += (tried.empty() ? "" : "`, `") + path;
    c.diags.report(Diag::kB5006, {}, tried);
    return {};
  }
  std::string tried;
  std::vector<std::string> command = find_host_compiler(tried);
  if (command.empty()) {
    c.diags.report(Diag::kB5002, {}, tried)
        .help("the model calls C++, which must be compiled; install one (`apt-get install g++`)");
    return {};
  }
  const std::string shim = emit_cpp::shim_text(*c.system, cpp.const_names);
  const std::string parent = fs::path(runtime.directory).parent_path().string();
  for (const char* flag : {"-std=c++20", "-O1", "-shared", "-fPIC", "-ffp-contract=off", "-w", "-Wl,-z,defs"})
    command.emplace_back(flag);
  command.insert(command.end(), {"-I" + runtime.directory + "/include", "-I" + parent});
  for (const std::string& dir : cpp.include_dirs) command.push_back("-I" + dir);
  std::vector<std::string> texts{BIPC_VERSION, shim};
  texts.insert(texts.end(), command.begin(), command.end());
  // So that messages are alike wherever we run.
  command.insert(command.begin(), {"env", "LC_ALL=C.UTF-8"});
  add_headers(texts, fs::path(runtime.directory) / "include/bip");
  for (const CppFile& file : c.system->code.cpp.includes) {
    std::string folder;
    if (const std::string path = find_file(c, file, folder); !path.empty())
      add_headers(texts, fs::path(path).parent_path());
  }
  for (const auto* files : {&cpp.sources, &cpp.objects}) {
    for (const std::string& file : *files) {
      texts.push_back(file);
      texts.push_back(text_of(file));
    }
  }
  const std::string hash = content_hash({texts.begin(), texts.end()});
  const fs::path kept = cache_folder(c.options.cache);
  const fs::path folder = kept.empty() ? fs::path(work.path()) : kept;
  const fs::path object = folder / (hash + ".so");
  std::error_code error;
  if (fs::exists(object, error)) {
    // What is used stays when the folder becomes too large.
    fs::last_write_time(object, fs::file_time_type::clock::now(), error);
    return object.string();
  }
  fs::create_directories(folder, error);
  const std::string source = work.path() + "/shim.cpp";
  const std::string said = work.path() + "/said";
  const fs::path fresh = folder / fmt::format("{}.{}", hash, ::getpid());
  if (const auto written = write_file(source, shim); !written) {
    c.diags.report(Diag::kB5004, {}, source, written.error());
    return {};
  }
  command.push_back(source);
  for (const auto* files : {&cpp.sources, &cpp.objects}) command.insert(command.end(), files->begin(), files->end());
  command.insert(command.end(), {"-o", fresh.string()});
  const Result<int> status = run_program(command, said);
  if (!status || *status != 0) {
    fs::remove(fresh, error);
    if (!status) c.diags.report(Diag::kB5012, {}, "cannot be compiled: " + status.error());
    else report_cpp_failure(c, text_of(said));
    return {};
  }
  fs::rename(fresh, object, error);
  if (error) {
    c.diags.report(Diag::kB5004, {}, object.string(), error.message());
    return {};
  }
  return object.string();
}

}  // namespace

bool uses_ffi(const Compilation& c) {
  return c.system && (emit_cpp::FfiNames::is_needed(c.system->code) || !lower::event_class_uses(*c.system).empty());
}

bool find_ffi_files(Compilation& c, emit_cpp::CppBuild& out) {
  if (!uses_ffi(c)) return true;
  const CodeTable& code = c.system->code;
  std::vector<std::string> texts;
  std::string folder;
  for (const CppFile& file : code.cpp.includes) {
    const std::string path = find_file(c, file, folder);
    // A header of the system or of a library: the C++ compiler finds it, or reports it (compiler_errors.hpp).
    if (path.empty()) continue;
    add_once(out.include_dirs, folder);
    add_once(out.headers, path);
    texts.push_back(text_of(path));
  }
  for (const auto& [files, paths] : {std::pair(&code.cpp.sources, &out.sources), {&code.cpp.objects, &out.objects}}) {
    for (const CppFile& file : *files) {
      const std::string path = find_file(c, file, folder);
      if (path.empty()) {
        report_missing_file(c, file.name);
        return false;
      }
      add_once(*paths, path);
      add_once(out.include_dirs, fs::path(path).parent_path().string());
    }
  }
  for (const Function& function : code.functions) {
    const auto has_const = [&](const std::string& text) { return has_word(text, "const_" + function.name); };
    if (std::any_of(texts.begin(), texts.end(), has_const)) out.const_names.insert(function.name);
  }
  return true;
}

bool load_ffi(Compilation& c) {
  if (!uses_ffi(c)) return true;
  emit_cpp::CppBuild cpp;
  if (!find_ffi_files(c, cpp)) return false;
  const Result<TemporaryDirectory> work = TemporaryDirectory::make();
  if (!work) {
    c.diags.report(Diag::kB5012, {}, "cannot be compiled: " + work.error());
    return false;
  }
  const std::string path = shared_object(c, cpp, *work);
  if (path.empty()) return false;
  // Stays for the life of the process: objects of its types may outlive everything here.
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = ::dlerror();
    c.diags.report(Diag::kB5012, {}, std::string("does not load: ") + (reason != nullptr ? reason : "unknown reason"));
    return false;
  }
  lower::LoweredSystem& lowered = *c.lowered;
  for (std::size_t row = 0; row < lowered.functions.size(); ++row) {
    lowered.functions[row] =
        reinterpret_cast<rt::FfiFunction>(::dlsym(library, fmt::format("bip_call_{}", row).c_str()));
  }
  const auto* types = static_cast<const rt::FfiType*>(::dlsym(library, "bip_ffi_types"));
  for (std::size_t row = 0; row < lowered.ffi_types.size(); ++row) {
    const char* name = lowered.ffi_types[row].name;
    lowered.ffi_types[row] = types[row];
    lowered.ffi_types[row].name = name;
  }
  const auto* classes = static_cast<const rt::EventClass*>(::dlsym(library, "bip_event_classes"));
  for (std::size_t row = 0; row < lowered.event_classes.size(); ++row) lowered.event_classes[row] = classes[row];
  return true;
}

}  // namespace bip::driver
