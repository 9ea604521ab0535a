// What the runtime's tests ask of a core: the candidates as text.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "runtime/core/core.hpp"
#include "tests/unit/runtime/builder.hpp"

namespace bip::rt::testing {

/// An interaction by its number in canonical order: `2_i`.
constexpr InteractionId operator""_i(unsigned long long number) { return InteractionId(std::size_t{number}); }

/// "c: a.p b.q", or "a.p" for an internal port; names without ROOT.
inline std::string text_of(Core& core, const Candidate& candidate) {
  const auto strip = [](const std::string& path) { return path.substr(5); };
  std::vector<Participant> who;
  core.participants(candidate, who);
  std::string out =
      candidate.connector == kNone ? "" : strip(core.image().connectors[candidate.connector].path()) + ":";
  for (const Participant& p : who) {
    if (!out.empty()) out += ' ';
    out += strip(core.image().atoms[p.atom].path()) + "." + core.tables().atom_type(p.atom).ports[p.port].name;
  }
  return out;
}
inline std::vector<std::string> candidates(Core& core) {
  std::vector<std::string> out;
  for (std::uint64_t k = 0; k < core.candidate_count(); ++k) out.push_back(text_of(core, core.candidate(k)));
  return out;
}
using Strings = std::vector<std::string>;

}  // namespace bip::rt::testing
