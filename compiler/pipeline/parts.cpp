// See parts.hpp.
#include "compiler/pipeline/parts.hpp"

#include <dlfcn.h>
#include <sys/auxv.h>

#include <string_view>

namespace bip::pipeline {

namespace fs = std::filesystem;

fs::path program_file() {
  std::error_code error;
  fs::path path = fs::read_symlink("/proc/self/exe", error);
  // Without /proc: what the program was started as.
  if (error) path = fs::canonical(reinterpret_cast<const char*>(::getauxval(AT_EXECFN)), error);
  return path;
}

fs::path own_file() {
  std::error_code error;
  Dl_info info{};
  const fs::path program = program_file();
  if (::dladdr(reinterpret_cast<const void*>(&own_file), &info) == 0 || info.dli_fname == nullptr) return program;
  // Of the program itself dladdr knows only the words of the command line.
  if (!std::string_view(info.dli_fname).ends_with(".so") &&
      std::string_view(info.dli_fname).find(".so.") == std::string_view::npos)
    return program;
  const fs::path file = fs::canonical(info.dli_fname, error);
  return error ? program : file;
}

std::vector<fs::path> places_of_part(const std::string& name) {
  const fs::path folder = own_file().parent_path();
  if (folder.empty()) return {};
  // bin/, lib/ and lib/<triplet>/ of an installation.
  std::vector<fs::path> places{folder / name};
  for (const fs::path& prefix : {folder.parent_path(), folder.parent_path().parent_path()}) {
    places.push_back(prefix / "lib/bipc" / name);
    places.push_back(prefix / "share/bipc" / name);
  }
  places.push_back(folder.parent_path() / name);
  return places;
}

}  // namespace bip::pipeline
