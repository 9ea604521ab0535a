// See build_id.hpp. The notes of a loaded file are found by its program headers.
#include "compiler/base/build_id.hpp"

#include <elf.h>
#include <link.h>

#include <cstdint>
#include <cstring>
#include <string_view>

namespace bip {

namespace {

struct BuildIdSearch {
  std::uintptr_t address;
  std::string id;
};

bool contains_address(const dl_phdr_info& info, std::uintptr_t address) {
  for (int k = 0; k < info.dlpi_phnum; ++k) {
    const ElfW(Phdr)& part = info.dlpi_phdr[k];
    const std::uintptr_t begin = info.dlpi_addr + part.p_vaddr;
    if (part.p_type == PT_LOAD && address >= begin && address < begin + part.p_memsz) return true;
  }
  return false;
}

std::string digits_of(const unsigned char* bytes, std::size_t size) {
  std::string text;
  for (std::size_t k = 0; k < size; ++k) {
    text += "0123456789abcdef"[bytes[k] >> 4];
    text += "0123456789abcdef"[bytes[k] & 15];
  }
  return text;
}

constexpr std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

// The build id among the notes, or nothing.
std::string build_id_in(const unsigned char* notes, std::size_t size) {
  while (size >= sizeof(ElfW(Nhdr))) {
    ElfW(Nhdr) head;
    std::memcpy(&head, notes, sizeof head);
    const std::size_t whole = sizeof head + padded(head.n_namesz) + padded(head.n_descsz);
    if (whole > size) return {};
    const auto* name = reinterpret_cast<const char*>(notes + sizeof head);
    if (head.n_type == NT_GNU_BUILD_ID && std::string_view(name, head.n_namesz) == std::string_view("GNU", 4))
      return digits_of(notes + sizeof head + padded(head.n_namesz), head.n_descsz);
    notes += whole;
    size -= whole;
  }
  return {};
}

extern "C" int bip_look_for_build_id(dl_phdr_info* info, std::size_t, void* context) {
  auto& search = *static_cast<BuildIdSearch*>(context);
  if (!contains_address(*info, search.address)) return 0;
  for (int k = 0; k < info->dlpi_phnum && search.id.empty(); ++k) {
    const ElfW(Phdr)& part = info->dlpi_phdr[k];
    if (part.p_type != PT_NOTE) continue;
    search.id = build_id_in(reinterpret_cast<const unsigned char*>(info->dlpi_addr + part.p_vaddr), part.p_memsz);
  }
  return 1;
}

}  // namespace

std::string build_id_of(const void* address) {
  BuildIdSearch search{reinterpret_cast<std::uintptr_t>(address), {}};
  ::dl_iterate_phdr(bip_look_for_build_id, &search);
  return search.id;
}

}  // namespace bip
