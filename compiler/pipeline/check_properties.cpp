// See check_properties.hpp.
#include "compiler/pipeline/check_properties.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <utility>

#include "compiler/system/system.hpp"
#include "compiler/verify/property/formula.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::pipeline {

namespace {

// "column 7: there is no …": the byte and what is wrong with it.
struct Problem {
  std::size_t offset = 0;
  std::string what;
};
Problem split_column(const std::string& error) {
  constexpr std::string_view kWord = "column ";
  const std::size_t colon = error.find(": ");
  Problem problem{0, error};
  if (!error.starts_with(kWord) || colon == std::string::npos) return problem;
  std::size_t column = 1;
  std::from_chars(error.data() + kWord.size(), error.data() + colon, column);
  return {column - 1, error.substr(colon + 2)};
}

}  // namespace

void check_properties(const System& system, Diagnostics& diags) {
  if (system.properties.empty()) return;
  // A property in a loop is told once.
  std::set<std::pair<std::size_t, std::uint32_t>> told;
  const verify::PropertyReader reader(system);
  for (const StatedProperty& stated : system.properties) {
    const Result<verify::ParsedProperty> parsed = reader.read(stated.text);
    if (parsed) continue;
    BIP_ASSERT(stated.source.size() == stated.text.size() + 1, "{} places of {} signs", stated.source.size(),
               stated.text.size());
    const Problem problem = split_column(parsed.error());
    const std::size_t begin = std::min(problem.offset, stated.text.size());
    const std::uint32_t at = stated.source[begin];
    // Of the word that begins there; an empty text has none.
    const std::size_t word_end = std::min(stated.text.find(' ', begin), stated.text.size());
    const std::uint32_t end = std::max(at + 1, word_end == 0 ? at : stated.source[word_end - 1] + 1);
    if (!told.emplace(stated.file.value, at).second) continue;
    auto diagnostic = diags.report(Diag::kB4030, SourceRange{stated.file, at, end}, stated.name, problem.what);
    if (!stated.text.empty()) diagnostic.note("of the whole model this is `" + stated.text + "`");
  }
}

}  // namespace bip::pipeline
