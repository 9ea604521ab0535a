// See codel_mapping.hpp. Only lines `#include "FILE"` count; the folder before the name does not.
#include "compiler/genom/codel_mapping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "compiler/base/read_file.hpp"

namespace bip::genom {
namespace {

// {name of a header: a file that includes it}
std::map<std::string, std::string> included_headers(const std::vector<std::string>& files) {
  std::map<std::string, std::string> headers;
  for (const std::string& file : files) {
    const std::string text = read_file(file).value_or("");
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      std::string_view line = std::string_view(text).substr(at, end - at);
      at = end + 1;
      const auto skip_blanks = [&] {
        while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
      };
      skip_blanks();
      if (!line.starts_with('#')) continue;
      line.remove_prefix(1);
      skip_blanks();
      if (!line.starts_with("include")) continue;
      line.remove_prefix(7);
      skip_blanks();
      if (line.empty() || (line.front() != '"' && line.front() != '<')) continue;
      const std::size_t close = line.find(line.front() == '"' ? '"' : '>', 1);
      if (close == std::string_view::npos) continue;
      line = line.substr(1, close - 1);
      headers.try_emplace(std::string(line.substr(line.rfind('/') + 1)), file);
    }
  }
  return headers;
}

}  // namespace

void find_mappings(std::vector<Module>& modules, const std::vector<std::string>& codel_files, Diagnostics& diags) {
  const std::map<std::string, std::string> headers = included_headers(codel_files);
  for (Module& m : modules) {
    if (!m.component) continue;
    idl::Component& c = *m.component;
    if (c.language != "c" && c.language != "C" && c.language != "c++" && c.language != "C++") {
      diags.report(Diag::kB6150, c.language_range, m.name.text, c.language);
      continue;
    }
    const auto find = [&](const std::string& first, const std::string& second) {
      const auto found = headers.find(first);
      return found == headers.end() ? headers.find(second) : found;
    };
    const auto in_c = find("ac" + c.name + ".h", c.name + "_c_types.h");
    const auto in_cxx = find("ac" + c.name + ".hpp", c.name + "_cxx_types.hpp");
    c.is_cxx = in_cxx != headers.end();
    if (!c.is_cxx || in_c == headers.end()) continue;
    diags.report(Diag::kB6151, m.name.range, m.name.text)
        .note(fmt::format("{} includes {}, {} includes {}", in_c->second, in_c->first, in_cxx->second, in_cxx->first));
  }
}

}  // namespace bip::genom
