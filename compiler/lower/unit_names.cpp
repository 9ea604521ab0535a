// See unit_names.hpp.
#include "compiler/lower/unit_names.hpp"
#include "compiler/base/ascii.hpp"

namespace bip::lower {

namespace {

// Longer stems say nothing more to a reader, and a clause may name a thousand ports.
constexpr std::size_t kMaxStem = 96;

std::string identifier(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (is_letter(c) || is_digit(c)) {
      if (out.empty() && is_digit(c)) out += 'x';
      out += c;
    } else if (!out.empty() && out.back() != '_') {
      out += '_';
    }
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out.empty() ? "x" : out;
}

// Appends while the stem is short; the kind of the unit is added after the stem and is never cut.
void append(std::string& stem, const std::string& part) {
  if (stem.size() + part.size() < kMaxStem) stem += "_" + part;
}

}  // namespace

std::string UniqueNames::make(std::string_view text) {
  const std::string stem = identifier(text);
  if (used_.insert(stem).second) return stem;
  std::uint32_t& number = next_.try_emplace(stem, 2).first->second;
  for (;; ++number) {
    std::string name = stem + "_" + std::to_string(number);
    if (used_.insert(name).second) return name;
  }
}

std::string transition_name(const AtomType& type, const Transition& transition) {
  std::string stem = type.name;
  if (transition.port == Transition::kInternal) {
    stem += "_internal";
  } else {
    stem += "_on_" + type.ports[transition.port].name;
  }
  stem += "_from";
  for (const std::uint32_t place : transition.from) append(stem, type.places[place]);
  return stem;
}

std::string clause_name(const ConnectorType& type, const Clause& clause) {
  std::string stem = type.name + "_on";
  for (const std::uint32_t param : clause.params) append(stem, type.params[param].name);
  return stem;
}

}  // namespace bip::lower
