// See parts.hpp.
#include "compiler/pipeline/parts.hpp"

#include <link.h>
#include <sys/auxv.h>

#include <cstdint>
#include <span>
#include <string>

namespace bip::pipeline {

namespace fs = std::filesystem;

fs::path program_file() {
  std::error_code error;
  fs::path path = fs::read_symlink("/proc/self/exe", error);
  // Without /proc: what the program was started as.
  if (error) path = fs::canonical(reinterpret_cast<const char*>(::getauxval(AT_EXECFN)), error);
  return path;
}

namespace {

// The file of the shared library that holds an address; empty if the program itself does. dladdr would also look for
// the nearest of the names that the program exports, which are thirty thousand.
std::string library_at(std::uintptr_t address) {
  struct Search {
    std::uintptr_t address;
    std::string file;
  } search{address, {}};
  ::dl_iterate_phdr(
      [](dl_phdr_info* object, std::size_t, void* data) {
        auto& sought = *static_cast<Search*>(data);
        for (const ElfW(Phdr) & part : std::span(object->dlpi_phdr, object->dlpi_phnum)) {
          const std::uintptr_t begin = object->dlpi_addr + part.p_vaddr;
          if (part.p_type != PT_LOAD || sought.address < begin || sought.address - begin >= part.p_memsz) continue;
          sought.file = object->dlpi_name;
          return 1;
        }
        return 0;
      },
      &search);
  return search.file;
}

}  // namespace

fs::path own_file() {
  const std::string library = library_at(reinterpret_cast<std::uintptr_t>(&own_file));
  std::error_code error;
  const fs::path file = library.empty() ? fs::path() : fs::canonical(library, error);
  return file.empty() || error ? program_file() : file;
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
