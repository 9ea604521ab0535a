// See copy_ffi_files.hpp. Includes are followed without a preprocessor: a header in a branch that is not taken is
// copied as well, one whose name is a macro is not found, and system headers are not copied. Linear in the files.
#include "compiler/emit_cpp/copy_ffi_files.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "compiler/base/read_file.hpp"

namespace bip::emit_cpp {
namespace {

namespace fs = std::filesystem;

struct Include {
  std::string name;
  bool is_quoted = false;
};

// The files that `#include` lines name.
std::vector<Include> includes_of(const std::string& text) {
  std::vector<Include> found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const auto skip_blanks = [&](std::size_t from) { return std::min(text.find_first_not_of(" \t", from), end); };
    std::size_t next = skip_blanks(at);
    at = end + 1;
    if (next >= end || text[next] != '#') continue;
    next = skip_blanks(next + 1);
    if (text.compare(next, 7, "include") != 0) continue;
    next = skip_blanks(next + 7);
    if (next >= end || (text[next] != '"' && text[next] != '<')) continue;
    const std::size_t close = text.find(text[next] == '"' ? '"' : '>', next + 1);
    if (close < end) found.push_back({text.substr(next + 1, close - next - 1), text[next] == '"'});
  }
  return found;
}

/// Folders that all of `path` lie in.
fs::path common_folder(const fs::path& a, const fs::path& b) {
  fs::path common;
  for (auto [x, y] = std::pair(a.begin(), b.begin()); x != a.end() && y != b.end() && *x == *y; ++x, ++y) common /= *x;
  return common;
}

}  // namespace

Result<CppBuild> copy_ffi_files(const CppBuild& cpp, const fs::path& project) {
  std::vector<fs::path> open;
  for (const auto* files : {&cpp.headers, &cpp.sources, &cpp.objects})
    open.insert(open.end(), files->begin(), files->end());
  const std::set<std::string> objects(cpp.objects.begin(), cpp.objects.end());
  std::map<fs::path, std::string> texts;  // sorted: the same files are written in the same order
  while (!open.empty()) {
    const fs::path path = open.back();
    open.pop_back();
    if (texts.contains(path)) continue;
    std::optional<std::string> text = read_file(path);
    if (!text) return Failure{"cannot read " + path.string()};
    const std::vector<Include> includes = objects.contains(path.string()) ? std::vector<Include>() : includes_of(*text);
    texts.emplace(path, std::move(*text));
    for (const Include& include : includes) {
      std::vector<fs::path> folders(cpp.include_dirs.begin(), cpp.include_dirs.end());
      if (include.is_quoted) folders.insert(folders.begin(), path.parent_path());
      for (const fs::path& folder : folders) {
        const fs::path candidate = (folder / include.name).lexically_normal();
        std::error_code error;
        if (!fs::is_regular_file(candidate, error)) continue;
        open.push_back(candidate);
        break;
      }
    }
  }
  if (texts.empty())
    return CppBuild{.include_dirs = {}, .sources = {}, .objects = {}, .headers = {}, .const_names = cpp.const_names};
  fs::path top = texts.begin()->first.parent_path();
  for (const auto& [path, text] : texts) top = common_folder(top, path.parent_path());
  for (const std::string& dir : cpp.include_dirs) top = common_folder(top, fs::path(dir));
  const auto moved = [&top](const fs::path& path) {
    return (fs::path("ffi") / path.lexically_relative(top)).lexically_normal();
  };
  for (const auto& [path, text] : texts) {
    const Result<bool> written = update_file(project / moved(path), text);
    if (!written) return Failure{written.error()};
  }
  CppBuild out{.include_dirs = {}, .sources = {}, .objects = {}, .headers = {}, .const_names = cpp.const_names};
  for (const auto& [from, to] : {std::pair(&cpp.include_dirs, &out.include_dirs),
                                 {&cpp.sources, &out.sources},
                                 {&cpp.objects, &out.objects},
                                 {&cpp.headers, &out.headers}})
    for (const std::string& path : *from) to->push_back(moved(path).generic_string());
  return out;
}

}  // namespace bip::emit_cpp
