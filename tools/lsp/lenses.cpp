// What an editor shows beside the text: lenses over compounds and over `// verify:` lines, foldable ranges, links of
// `use`, names of all files, and other uses of the name at a position.
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "tools/lsp/features.hpp"
#include "tools/lsp/uri.hpp"

namespace bip::lsp {
namespace {

using index::Index;
using index::Symbol;
using index::SymbolId;
using index::SymbolKind;
using index::UseKind;

Json lens(const Json& range, const char* title, const char* command, Json arguments) {
  return {{"range", range}, {"command", {{"title", title}, {"command", command}, {"arguments", std::move(arguments)}}}};
}

// A line `// verify: VERDICT [options]`, or `// verify: PROPERTY`.
struct VerifyLine {
  std::string expected;  // empty: none is said
  std::vector<std::string> options;
};

// As a shell splits them: quotes keep blanks.
std::vector<std::string> split_options(std::string_view text) {
  std::vector<std::string> words;
  char quote = 0;
  bool is_begun = false;
  for (const char c : text) {
    if (quote != 0 ? c == quote : c == '\'' || c == '"') {
      quote = quote != 0 ? '\0' : c;
    } else if (quote == 0 && (c == ' ' || c == '\t')) {
      is_begun = false;
      continue;
    } else {
      if (!is_begun) words.emplace_back();
      words.back() += c;
      is_begun = true;
      continue;
    }
    if (!std::exchange(is_begun, true)) words.emplace_back();
  }
  return words;
}

std::optional<VerifyLine> verify_line(std::string_view line) {
  constexpr std::string_view kWord = "verify:";
  const std::size_t slashes = line.find_first_not_of(" \t");
  if (slashes == std::string_view::npos || !line.substr(slashes).starts_with("//")) return std::nullopt;
  line.remove_prefix(slashes + 2);
  const std::size_t word = line.find_first_not_of(" \t");
  if (word == std::string_view::npos || !line.substr(word).starts_with(kWord)) return std::nullopt;
  line.remove_prefix(word + kWord.size());
  const std::size_t begin = line.find_first_not_of(" \t"), end = line.find_last_not_of(" \t\r");
  if (begin == std::string_view::npos) return std::nullopt;
  line = line.substr(begin, end - begin + 1);
  const std::string_view first = line.substr(0, line.find_first_of(" \t"));
  for (const std::string_view verdict : {"free", "deadlock", "holds", "violated", "unknown"}) {
    if (first == verdict) return VerifyLine{std::string(first), split_options(line.substr(first.size()))};
  }
  return VerifyLine{{}, {"--property", std::string(line)}};
}

bool has_parameters(const Index& index, const Symbol& s) {
  return std::any_of(s.members.begin(), s.members.end(),
                     [&](SymbolId m) { return index.symbols[m].kind == SymbolKind::Parameter; });
}

}  // namespace

// Commands are the client's: each gets the document's URI, and the root, or the expected verdict and the options.
Reply code_lenses(Workspace& w, const Document& d) {
  Json out = Json::array();
  const Index& index = d.analysis.index;
  for (const SymbolId id : index.file_symbols) {
    const Symbol& s = index.symbols[id];
    // What takes arguments is not run by its name alone.
    if (s.kind != SymbolKind::CompoundType || s.name_range.file != d.analysis.file || has_parameters(index, s))
      continue;
    const Json range = w.range(d.analysis, s.name_range);
    const Json arguments = {d.uri, std::string(s.name) + "()"};
    for (const auto& [title, command] : {std::pair{"run", "bip.run"},
                                         {"verify", "bip.verify"},
                                         {"explore", "bip.explore"},
                                         {"debug", "bip.debug"},
                                         {"view", "bip.view"}})
      out.push_back(lens(range, title, command, arguments));
  }
  const std::string_view text = d.text.str();
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    if (const std::optional<VerifyLine> asked = verify_line(text.substr(at, end - at))) {
      const Position begin = d.text.position(static_cast<std::uint32_t>(at), w.encoding);
      const Position last = d.text.position(static_cast<std::uint32_t>(end), w.encoding);
      const Json range = {{"start", {{"line", begin.line}, {"character", begin.character}}},
                          {"end", {{"line", last.line}, {"character", last.character}}}};
      out.push_back(lens(range, "verify this", "bip.verifyLine", {d.uri, asked->expected, asked->options}));
    }
    at = end + 1;
  }
  return out;
}

// Declarations of several lines, and comments of several lines.
Reply folding_ranges(Workspace& w, const Document& d) {
  Json out = Json::array();
  for (std::uint32_t row = 0; row < d.analysis.index.symbols.size(); ++row) {
    const Symbol& s = d.analysis.index.symbols[SymbolId(row)];
    if (s.range.file != d.analysis.file || !d.analysis.file.is_valid()) continue;
    const Position begin = d.text.position(s.range.begin, w.encoding), end = d.text.position(s.range.end, w.encoding);
    // The last line is its `end`, which stays.
    if (end.line > begin.line + 1) out.push_back({{"startLine", begin.line}, {"endLine", end.line - 1}});
  }
  const std::string_view text = d.text.str();
  std::uint32_t line = 0, first = 0, count = 0;
  const auto close = [&] {
    if (count > 1) out.push_back({{"startLine", first}, {"endLine", first + count - 1}, {"kind", "comment"}});
    count = 0;
  };
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::size_t word = text.find_first_not_of(" \t", at);
    if (word != std::string_view::npos && word < end && text.substr(word).starts_with("//")) {
      if (count++ == 0) first = line;
    } else {
      close();
    }
    at = end + 1;
  }
  close();
  return out;
}

Reply document_highlights(Workspace& w, const Document& d, std::uint32_t offset) {
  const index::Use* at = d.analysis.file.is_valid() ? d.analysis.index.use_at(d.analysis.file, offset) : nullptr;
  if (at == nullptr) return Json(nullptr);
  Json out = Json::array();
  for (const index::Use& u : d.analysis.index.uses_of(at->symbol))
    if (u.range.file == d.analysis.file)
      out.push_back({{"range", w.range(d.analysis, u.range)}, {"kind", u.kind == UseKind::Read ? 2 : 3}});
  return out;
}

// From the name at the position to the declarations around it.
Json selection_range(Workspace& w, const Document& d, std::uint32_t offset) {
  const Index& index = d.analysis.index;
  std::vector<SourceRange> around;
  if (d.analysis.file.is_valid()) {
    if (const index::Use* at = index.use_at(d.analysis.file, offset); at != nullptr) around.push_back(at->range);
    for (std::uint32_t row = 0; row < index.symbols.size(); ++row) {
      const SourceRange r = index.symbols[SymbolId(row)].range;
      if (r.file == d.analysis.file && r.begin <= offset && offset <= r.end) around.push_back(r);
    }
  }
  // A package's own declaration is its line; the whole text is around all.
  std::sort(around.begin(), around.end(),
            [](const SourceRange& a, const SourceRange& b) { return a.end - a.begin > b.end - b.begin; });
  const Position end = d.text.position(static_cast<std::uint32_t>(d.text.str().size()), w.encoding);
  Json made{
      {"range",
       {{"start", {{"line", 0}, {"character", 0}}}, {"end", {{"line", end.line}, {"character", end.character}}}}}};
  SourceRange last{d.analysis.file, 0, static_cast<std::uint32_t>(d.text.str().size())};
  for (const SourceRange& r : around) {
    if (r.begin < last.begin || r.end > last.end || (r.begin == last.begin && r.end == last.end)) continue;
    made = Json{{"range", w.range(d.analysis, r)}, {"parent", std::move(made)}};
    last = r;
  }
  return made;
}

// Names of all open documents and of the files below the editor's folders that have the letters of the query in their
// order.
Reply workspace_symbols(Workspace& w, const std::string& query) {
  constexpr std::size_t kMost = 1000;
  Json out = Json::array();
  const auto matches = [&](std::string_view name) {
    std::size_t at = 0;
    for (const char c : query) {
      const auto lower = [](char letter) {
        return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
      };
      while (at < name.size() && lower(name[at]) != lower(c)) ++at;
      if (at++ >= name.size()) return false;
    }
    return true;
  };
  const auto add = [&](const Analysis& a) {
    for (std::uint32_t row = 0; row < a.index.symbols.size() && out.size() < kMost; ++row) {
      const Symbol& s = a.index.symbols[SymbolId(row)];
      const int kind = outline_kind(s.kind);
      if (kind == 0 || s.name_range.file != a.file || !a.file.is_valid() || !matches(s.name)) continue;
      Json found{{"name", s.name}, {"kind", kind}, {"location", w.location(a, s.name_range)}};
      if (s.parent.is_valid()) found["containerName"] = a.index.symbols[s.parent].name;
      out.push_back(std::move(found));
    }
  };
  for (const auto& [path, document] : w.documents()) add(document->analysis);
  for (const auto& [path, analysis] : w.unopened.declarations(w.open_texts())) add(analysis);
  return out;
}

// Packages in `use`, where they are declared.
Reply document_links(Workspace& w, const Document& d) {
  Json out = Json::array();
  for (const index::Use& u : d.analysis.index.uses) {
    const Symbol& s = d.analysis.index.symbols[u.symbol];
    if (u.range.file != d.analysis.file || s.kind != SymbolKind::Package || u.kind == UseKind::Declaration) continue;
    const std::string* path = d.analysis.path_of(s.name_range.file);
    if (path == nullptr || s.name_range.file == d.analysis.file) continue;
    out.push_back({{"range", w.range(d.analysis, u.range)}, {"target", uri_of(*path)}});
  }
  return out;
}

}  // namespace bip::lsp
