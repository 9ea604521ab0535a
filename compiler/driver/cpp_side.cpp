// Finding, compiling and loading the C++ side: see cpp_side.hpp.
#include "compiler/driver/cpp_side.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "compiler/driver/host_compiler.hpp"

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

// The file's path, and in `folder` the one under which it was found; empty after a report.
std::string find_file(Compilation& c, const CppFile& file, std::string& folder) {
  std::error_code error;
  for (const fs::path& candidate : folders_of(c, file)) {
    const fs::path path = fs::path(file.name).is_absolute() ? fs::path(file.name) : candidate / file.name;
    if (!fs::is_regular_file(path, error)) continue;
    folder = fs::absolute(candidate, error).lexically_normal().string();
    return fs::absolute(path, error).lexically_normal().string();
  }
  auto d = c.diags.report(Diag::kB5010, c.is_bsys() ? SourceRange{} : c.root_range, file.name);
  d.help("names are relative to the folder of the package's file, to its `ext-cpp`, or to a folder of -I");
  return {};
}

void add_once(std::vector<std::string>& list, const std::string& item) {
  if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

bool has_word(const std::string& text, const std::string& word) {
  const auto is_word = [](char ch) { return (ch >= 'a' && ch <= 'z') || (ch >= 'A' && ch <= 'Z') || (ch >= '0' && ch <= '9') || ch == '_'; };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || !is_word(text[at - 1])) && (end == text.size() || !is_word(text[end]))) return true;
  }
  return false;
}

// FNV-1a, twice with different starts: names in a cache, nothing that an enemy chooses.
class Hash {
 public:
  void add(std::string_view text) {
    for (const char ch : text) {
      a_ = (a_ ^ static_cast<unsigned char>(ch)) * kPrime;
      b_ = (b_ ^ static_cast<unsigned char>(ch)) * kPrime;
    }
    a_ = (a_ ^ 0x100) * kPrime;
    b_ = (b_ ^ text.size()) * kPrime;
  }
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}{:016x}", a_, b_); }

 private:
  static constexpr std::uint64_t kPrime = 1099511628211u;
  std::uint64_t a_ = 14695981039346656037u, b_ = 0x9e3779b97f4a7c15u;
};

// Headers beside a header count, too: it may include them.
void add_headers(Hash& hash, const fs::path& folder) {
  std::vector<fs::path> headers;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".h" || extension == ".hpp" || extension == ".hh" || extension == ".hxx" || extension == ".inc") headers.push_back(entry.path());
  }
  std::sort(headers.begin(), headers.end());
  for (const fs::path& header : headers) {
    hash.add(header.string());
    hash.add(text_of(header));
  }
}

fs::path cache_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  std::error_code error;
  if (cache != nullptr && *cache != '\0') return fs::path(cache) / "bipc";
  if (home != nullptr && *home != '\0') return fs::path(home) / ".cache" / "bipc";
  return fs::temp_directory_path(error) / fmt::format("bipc-cache-{}", ::getuid());
}

// The range of a place, up to the end of its line.
SourceRange range_of(const Compilation& c, const Loc& loc) {
  if (c.is_bsys() || loc.line == 0 || loc.file >= c.sources.size()) return {};
  const FileId file(loc.file);
  const std::string_view line = c.sources.line(file, loc.line);
  const auto start = static_cast<std::uint32_t>(line.data() - c.sources.text(file).data());
  const std::size_t close = line.find(')', loc.column - 1);
  const auto end = static_cast<std::uint32_t>(close == std::string_view::npos ? line.size() : close + 1);
  return {file, start + loc.column - 1, start + end};
}

// "filter.hpp:12: " of the first error, without folders and columns; empty if it has no place.
std::string place_of_error(const std::string& said) {
  const std::size_t at = said.find(": error: ");
  if (at == std::string::npos) return {};
  const std::size_t line = said.rfind('\n', at);
  const std::string place = said.substr(line == std::string::npos ? 0 : line + 1, at - (line == std::string::npos ? 0 : line + 1));
  const std::string name = place.substr(place.rfind('/') == std::string::npos ? 0 : place.rfind('/') + 1);
  const std::size_t first = name.find(':');
  return first == std::string::npos ? "" : name.substr(0, name.find(':', first + 1)) + ": ";
}

// What stands behind the first "error: ".
std::string first_error(const std::string& said) {
  std::size_t at = said.find("error: ");
  if (at == std::string::npos) return said.substr(0, said.find('\n'));
  at += 7;
  const std::string error = said.substr(at, said.find('\n', at) - at);
  // It would suggest our wrapper.
  return error.substr(0, error.find("; did you mean"));
}

// The shared object's path, compiled if the cache has none; empty after a report.
std::string shared_object(Compilation& c, const emit_cpp::CppBuild& cpp) {
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
    c.diags.report(Diag::kB5002, {}, tried).help("the model calls C++, which must be compiled; install one (`apt-get install g++`)");
    return {};
  }
  const std::string shim = emit_cpp::shim_text(c.system->code, cpp.const_names);
  const std::string parent = fs::path(runtime.directory).parent_path().string();
  for (const char* flag : {"-std=c++20", "-O1", "-shared", "-fPIC", "-ffp-contract=off", "-w", "-Wl,-z,defs"}) command.emplace_back(flag);
  command.insert(command.end(), {"-I" + runtime.directory + "/include", "-I" + parent});
  for (const std::string& dir : cpp.include_dirs) command.push_back("-I" + dir);
  Hash hash;
  hash.add(BIPC_VERSION);
  for (const std::string& word : command) hash.add(word);
  hash.add(shim);
  // So that messages are alike wherever we run.
  command.insert(command.begin(), {"env", "LC_ALL=C.UTF-8"});
  add_headers(hash, fs::path(runtime.directory) / "include/bip");
  for (const CppFile& file : c.system->code.cpp.includes) {
    std::string folder;
    const std::string path = find_file(c, file, folder);
    add_headers(hash, fs::path(path).parent_path());
  }
  for (const auto* files : {&cpp.sources, &cpp.objects}) {
    for (const std::string& file : *files) {
      hash.add(file);
      hash.add(text_of(file));
    }
  }
  const fs::path folder = cache_folder();
  const fs::path object = folder / (hash.text() + ".so");
  std::error_code error;
  if (fs::exists(object, error)) return object.string();
  fs::create_directories(folder, error);
  const Result<TemporaryDirectory> work = TemporaryDirectory::make();
  if (!work) {
    c.diags.report(Diag::kB5012, {}, "cannot be compiled: " + work.error());
    return {};
  }
  const std::string source = (*work).path() + "/shim.cpp";
  const std::string said = (*work).path() + "/said";
  const fs::path fresh = folder / fmt::format("{}.{}", hash.text(), ::getpid());
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

bool has_cpp_side(const Compilation& c) { return c.system && emit_cpp::ForeignNames::is_needed(c.system->code); }

bool find_cpp_side(Compilation& c, emit_cpp::CppBuild& out) {
  if (!has_cpp_side(c)) return true;
  const CodeTable& code = c.system->code;
  std::vector<std::string> texts;
  std::string folder;
  for (const CppFile& file : code.cpp.includes) {
    const std::string path = find_file(c, file, folder);
    if (path.empty()) return false;
    add_once(out.include_dirs, folder);
    texts.push_back(text_of(path));
  }
  for (const auto& [files, paths] : {std::pair(&code.cpp.sources, &out.sources), {&code.cpp.objects, &out.objects}}) {
    for (const CppFile& file : *files) {
      const std::string path = find_file(c, file, folder);
      if (path.empty()) return false;
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

void report_cpp_failure(Compilation& c, const std::string& said) {
  const CodeTable& code = c.system->code;
  const std::string error = first_error(said);
  constexpr std::string_view kTypeMark = "bip-type-";
  if (const std::string place = place_of_error(said); place.starts_with(kTypeMark)) {
    const std::size_t row = std::strtoul(place.c_str() + kTypeMark.size(), nullptr, 10);
    if (row < code.extern_types.size()) {
      const ExternType& type = code.extern_types[row];
      c.diags.report(Diag::kB5011, range_of(c, type.loc), fmt::format("type `{}`", type.name)).note("C++: " + error);
      return;
    }
  }
  constexpr std::string_view kMark = "bip-prototype-";
  if (const std::size_t at = said.find(kMark); at != std::string::npos) {
    const std::size_t row = std::strtoul(said.c_str() + at + kMark.size(), nullptr, 10);
    if (row < code.functions.size()) {
      const Function& function = code.functions[row];
      c.diags.report(Diag::kB5011, range_of(c, function.loc), fmt::format("`{}`", emit_cpp::signature_text(code, function))).note("C++: " + error);
      return;
    }
  }
  for (const char* marker : {"undefined reference to `", "undefined symbol: "}) {
    const std::size_t at = said.find(marker);
    if (at == std::string::npos) continue;
    const std::size_t begin = at + std::string_view(marker).size();
    const std::string symbol = said.substr(begin, said.find_first_of("'\n", begin) - begin);
    for (const Function& function : code.functions) {
      if (!has_word(symbol.substr(0, symbol.find('(')), function.name)) continue;
      c.diags.report(Diag::kB5011, range_of(c, function.loc), fmt::format("`{}`", emit_cpp::signature_text(code, function)))
          .note(fmt::format("C++: `{}` is declared but no `src` or `obj` defines it", symbol));
      return;
    }
  }
  c.diags.report(Diag::kB5012, {}, "does not compile").note("C++: " + place_of_error(said) + error);
}

bool load_cpp_side(Compilation& c) {
  if (!has_cpp_side(c)) return true;
  emit_cpp::CppBuild cpp;
  if (!find_cpp_side(c, cpp)) return false;
  const std::string path = shared_object(c, cpp);
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
    lowered.functions[row] = reinterpret_cast<rt::ForeignFn>(::dlsym(library, fmt::format("bip_call_{}", row).c_str()));
  }
  const auto* types = static_cast<const rt::ExternType*>(::dlsym(library, "bip_extern_types"));
  for (std::size_t row = 0; row < lowered.extern_types.size(); ++row) {
    const char* name = lowered.extern_types[row].name;
    lowered.extern_types[row] = types[row];
    lowered.extern_types[row].name = name;
  }
  // Results of extern types need a place between a call and its use; calls do not nest in themselves.
  const CodeTable& code = c.system->code;
  if (!lowered.extern_types.empty()) lowered.temporaries.assign(code.exprs.size(), rt::Slot{});
  for (std::size_t row = 0; row < lowered.temporaries.size(); ++row) {
    const Expr& e = code.exprs[ExprId(row)];
    if (e.op != Op::Call || !code.functions[e.index].has_result || !is_extern(code.functions[e.index].result)) continue;
    lowered.temporaries[row] = rt::object_slot(lowered.extern_types[extern_row(code.functions[e.index].result)].make());
  }
  return true;
}

}  // namespace bip::driver
