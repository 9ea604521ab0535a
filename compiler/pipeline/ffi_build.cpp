// Finds, compiles and loads the C++ code of a model: see ffi_build.hpp.
#include "compiler/pipeline/ffi_build.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <optional>

#include "bip/assert.hpp"
#include "compiler/base/content_cache.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/base/content_hash.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/pipeline/cache_folder.hpp"
#include "compiler/pipeline/compiler_errors.hpp"
#include "compiler/pipeline/ffi_cache.hpp"
#include "compiler/pipeline/host_compiler.hpp"
#include "compiler/lower/event_classes.hpp"
#include "compiler/system/system.hpp"

namespace bip::pipeline {

namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& path) { return read_file(path).value_or(""); }

// Folders in which a file of `@cpp` may be, in the order in which they are tried.
std::vector<fs::path> folders_of(const Compilation& c, const CppFile& file) {
  std::vector<fs::path> folders;
  // A .bsys file may have its C++ beside it, wherever both are.
  const fs::path beside = fs::path(c.path).parent_path() / file.folder;
  if (c.is_bsys() && !beside.empty() && !fs::path(file.folder).is_absolute()) folders.push_back(beside);
  folders.emplace_back(file.folder.empty() ? "." : file.folder);
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

// Variables with which compilers find other files than those that the command names.
constexpr const char* kCompilerVariables[] = {"CPATH",        "C_INCLUDE_PATH", "CPLUS_INCLUDE_PATH",
                                              "LIBRARY_PATH", "COMPILER_PATH",  "GCC_EXEC_PREFIX"};

// One compilation of a model's C++: a unit for each source and the wrappers, then the library.
class LibraryBuild {
 public:
  LibraryBuild(Compilation& c, const emit_cpp::CppBuild& cpp, const TemporaryDirectory& work)
      : compilation_(c), cpp_(cpp), work_(work.path()) {}

  // The library's path in the folder for temporary files; empty after a report.
  std::string run(const CacheOptions& options) {
    if (!find_tools()) return {};
    ContentCache cache(ContentKind::Library, cache_folder(options).string(), options.megabytes << 20);
    const std::string name = cache.is_on() ? key() : std::string();
    if (!write(shim_path_, shim_)) return {};
    const std::string texts = cache.is_on() ? hash_of_texts() : std::string();
    if (const std::optional<std::string> entry = cache.load(name)) {
      if (const std::optional<std::string_view> bytes = unpack_library(texts, *entry)) return write_library(*bytes);
    }
    const fs::file_time_type start = fs::file_time_type::clock::now();
    if (!build()) return {};
    std::error_code error;
    // A file that was changed during the compilation may have been read before the change.
    const bool is_settled = std::all_of(read_.begin(), read_.end(), [&](const std::string& file) {
      return fs::last_write_time(file, error) < start && !error;
    });
    if (!texts.empty() && is_settled) (void)cache.store(name, pack_library(texts, text_of(library_)));
    return library_;
  }

 private:
  bool find_tools() {
    const RuntimeLocation runtime = find_runtime();
    std::string tried;
    if (runtime.directory.empty()) {
      for (const std::string& path : runtime.tried) tried += (tried.empty() ? "" : "`, `") + path;
      compilation_.diags.report(Diag::kB5006, {}, tried);
      return false;
    }
    compiler_ = find_host_compiler(tried);
    if (compiler_.empty()) {
      compilation_.diags.report(Diag::kB5002, {}, tried)
          .help("the model calls C++, which must be compiled; install one (`apt-get install g++`)");
      return false;
    }
    // So that messages are alike wherever we run.
    compiler_.insert(compiler_.begin(), {"env", "LC_ALL=C.UTF-8"});
    flags_ = {"-std=c++20", "-O1", "-fPIC", "-ffp-contract=off", "-w"};
    flags_.push_back("-I" + runtime.directory + "/include");
    flags_.push_back("-I" + fs::path(runtime.directory).parent_path().string());
    for (const std::string& dir : cpp_.include_dirs) flags_.push_back("-I" + dir);
    // Last, so that a model's own files of these names are found first.
    flags_.push_back("-I" + runtime.directory + "/include/published");
    shim_ = emit_cpp::shim_text(*compilation_.system, cpp_.const_names);
    return true;
  }

  // Of everything but what the compiler reads, of which the entry has the hash. A compiler may be a script.
  std::string key() {
    std::vector<std::string> command = compiler_;
    command.emplace_back("--version");
    const std::string version = work_ + "/version";
    (void)run_program(command, version);
    std::vector<std::string> texts{cache_version(), shim_, text_of(version)};
    for (const std::string& word : compiler_) texts.push_back(blake2b(text_of(find_program(word))));
    for (const std::vector<std::string>* words :
         std::initializer_list<const std::vector<std::string>*>{&compiler_, &flags_, &cpp_.sources, &cpp_.objects}) {
      texts.insert(texts.end(), words->begin(), words->end());
      texts.emplace_back();
    }
    for (const char* variable : kCompilerVariables) {
      const char* value = std::getenv(variable);
      texts.emplace_back(value == nullptr ? "" : value);
    }
    return content_hash({texts.begin(), texts.end()});
  }

  // Of all units behind the preprocessor, and of the objects. What files there are, which of them an `#include` finds
  // in which folder, and what `__has_include` says has its effect there, by whatever change; the files alone do not say
  // which names were looked for in vain. Empty: the preprocessor reports an error. Cost: about 45 ms a unit.
  std::string hash_of_texts() {
    std::vector<std::string> hashes;
    const std::string text = work_ + "/preprocessed", said = work_ + "/said";
    for (const std::string& unit : units()) {
      std::vector<std::string> command = compiler_;
      const std::vector<std::string> flags = flags_of(unit);
      command.insert(command.end(), flags.begin(), flags.end());
      // Without lines that name the files: the wrappers' folder has a new name each time.
      command.insert(command.end(), {"-E", "-P", unit, "-o", text});
      const Result<int> status = run_program(command, said);
      if (!status || *status != 0) return {};
      hashes.push_back(blake2b(text_of(text)));
    }
    for (const std::string& object : cpp_.objects) hashes.push_back(blake2b(text_of(object)));
    return content_hash({hashes.begin(), hashes.end()});
  }

  [[nodiscard]] std::vector<std::string> units() const {
    std::vector<std::string> all{shim_path_};
    all.insert(all.end(), cpp_.sources.begin(), cpp_.sources.end());
    return all;
  }
  [[nodiscard]] std::vector<std::string> flags_of(const std::string& unit) const {
    std::vector<std::string> flags = flags_;
    // The C++ compiler compiles a file of C as C++ unless `-x c` stands before it.
    if (fs::path(unit).extension() == ".c") {
      std::replace(flags.begin(), flags.end(), std::string("-std=c++20"), std::string("-std=gnu17"));
      flags.insert(flags.end(), {"-x", "c"});
    }
    return flags;
  }

  bool build() {
    std::vector<std::string> objects;
    for (const std::string& unit : units()) {
      objects.push_back(fmt::format("{}/{}.o", work_, objects.size()));
      const std::string rule = objects.back() + ".d";
      std::vector<std::string> command = flags_of(unit);
      command.insert(command.end(), {"-c", unit, "-o", objects.back(), "-MD", "-MF", rule});
      if (!compile(command)) return false;
      const std::vector<std::string> files = prerequisites(text_of(rule));
      // The wrappers are part of the key.
      std::copy_if(files.begin(), files.end(), std::back_inserter(read_),
                   [&](const std::string& file) { return file != shim_path_; });
    }
    objects.insert(objects.end(), cpp_.objects.begin(), cpp_.objects.end());
    read_.insert(read_.end(), cpp_.objects.begin(), cpp_.objects.end());
    objects.insert(objects.end(), {"-shared", "-Wl,-z,defs", "-o", library_});
    return compile(objects);
  }
  bool compile(const std::vector<std::string>& arguments) {
    const std::string said = work_ + "/said";
    std::vector<std::string> command = compiler_;
    command.insert(command.end(), arguments.begin(), arguments.end());
    const Result<int> status = run_program(command, said);
    if (status && *status == 0) return true;
    if (!status) compilation_.diags.report(Diag::kB5012, {}, "cannot be compiled: " + status.error());
    else report_cpp_failure(compilation_, text_of(said), near_miss(text_of(said)));
    return false;
  }
  // A function with C linkage in a header, which a source defines with other parameters: for C++ that is another one.
  std::string near_miss(const std::string& said) {
    const std::string name = missing_c_function(said);
    if (name.empty()) return {};
    for (const std::string& unit : cpp_.sources) {
      std::vector<std::string> command = compiler_;
      for (const std::string& flag : flags_of(unit)) {
        if (flag != "-w") command.push_back(flag);
      }
      command.insert(command.end(), {"-Wmissing-declarations", "-fsyntax-only", unit});
      const std::string warnings = work_ + "/warnings";
      if (!run_program(command, warnings)) continue;
      if (std::string found = other_declaration(text_of(warnings), name); !found.empty()) return found;
    }
    return {};
  }
  std::string write_library(std::string_view bytes) {
    return write(library_, std::string(bytes)) ? library_ : std::string();
  }
  bool write(const std::string& path, const std::string& text) {
    const Result<bool> written = write_file(path, text);
    if (!written) compilation_.diags.report(Diag::kB5004, {}, path, written.error());
    return static_cast<bool>(written);
  }

  Compilation& compilation_;
  const emit_cpp::CppBuild& cpp_;
  const std::string work_, library_ = work_ + "/library.so", shim_path_ = work_ + "/shim.cpp";
  std::vector<std::string> compiler_, flags_;
  std::string shim_;
  std::vector<std::string> read_;  // what went in, but for the wrappers
};

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

bool load_ffi(Compilation& c, const CacheOptions& cache) {
  if (!uses_ffi(c)) return true;
  if (c.options.refuses_cpp) {
    c.diags.report(Diag::kB5014, {}, "compile and load");
    return false;
  }
  emit_cpp::CppBuild cpp;
  if (!find_ffi_files(c, cpp)) return false;
  const Result<TemporaryDirectory> work = TemporaryDirectory::make();
  if (!work) {
    c.diags.report(Diag::kB5012, {}, "cannot be compiled: " + work.error());
    return false;
  }
  const std::string path = LibraryBuild(c, cpp, *work).run(cache);
  if (path.empty()) return false;
  // Stays for the life of the process: objects of its types may outlive everything here.
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* reason = ::dlerror();
    c.diags.report(Diag::kB5012, {}, std::string("does not load: ") + (reason != nullptr ? reason : "unknown reason"));
    return false;
  }
  lower::LoweredSystem& lowered = *c.lowered;
  lowered.library = library;
  for (std::size_t row = 0; row < lowered.functions.size(); ++row) {
    if (c.system->code.functions[row].kind == FunctionKind::Draw) continue;
    lowered.functions[row] =
        reinterpret_cast<rt::FfiFunction>(::dlsym(library, fmt::format("bip_call_{}", row).c_str()));
    BIP_ASSERT(lowered.functions[row] != nullptr, "the library has no call {} of {}", row, lowered.functions.size());
  }
  const auto* types = static_cast<const rt::FfiType*>(::dlsym(library, "bip_ffi_types"));
  BIP_ASSERT(lowered.ffi_types.empty() || types != nullptr, "the library has none of {} types",
             lowered.ffi_types.size());
  for (std::size_t row = 0; row < lowered.ffi_types.size(); ++row) {
    const char* name = lowered.ffi_types[row].name;
    lowered.ffi_types[row] = types[row];
    lowered.ffi_types[row].name = name;
  }
  const auto* classes = static_cast<const rt::EventClass*>(::dlsym(library, "bip_event_classes"));
  BIP_ASSERT(lowered.event_classes.empty() || classes != nullptr, "the library has none of {} classes",
             lowered.event_classes.size());
  for (std::size_t row = 0; row < lowered.event_classes.size(); ++row) lowered.event_classes[row] = classes[row];
  return true;
}

}  // namespace bip::pipeline
