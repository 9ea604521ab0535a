// Fairness: which infinite runs count.
//
//   fairness = 'none' | term (',' term)*
//   term     = ('weak' | 'strong') (':' what)?
//   what     = 'atoms' | CONNECTOR | COMPONENT.PORT | COMPONENT        `[*]` in a path: each position of an array
//
// Weak: what is possible in every state from some point on happens infinitely often. Strong: what is possible
// infinitely often happens infinitely often (Lehmann, Pnueli, Stavi 1981). A term is about each interaction, that is a
// set of ports of one connector; about each atom: possible if some interaction with it is; or about one connector, port
// or atom: possible if some interaction of it is, happens if one of them does, as `can` and `happens` of properties
// have it (the actions of Lamport, The Temporal Logic of Actions, 1994). Nothing is asked of what no term is about.
// Possible means enabled and hidden by no priority, so a candidate, and that its step does not end in a run-time error.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::verify {

enum class FairnessKind : std::uint8_t { Weak, Strong };
/// What a term is about: each interaction, each atom, or one thing with a name.
enum class FairnessUnit : std::uint8_t { Interactions, Atoms, Connector, Port, Atom };
struct FairnessTerm {
  FairnessKind kind = FairnessKind::Weak;
  FairnessUnit unit = FairnessUnit::Interactions;
  std::string path = {};    // of a thing with a name: without ROOT
  std::uint32_t owner = 0;  // Connector: its row; Port, Atom: that of the atom
  std::uint32_t port = 0;   // Port
  [[nodiscard]] bool has_name() const { return unit >= FairnessUnit::Connector; }
  [[nodiscard]] bool is_strong() const { return kind == FairnessKind::Strong; }
};
/// A term as it was written: `[*]` makes several of one.
struct WrittenTerm {
  FairnessKind kind = FairnessKind::Weak;
  std::string what = {};  // empty: each interaction
};
struct Fairness {
  std::vector<FairnessTerm> terms;  // none: all runs count
  std::vector<WrittenTerm> written;
  [[nodiscard]] bool is_none() const { return terms.empty(); }
  [[nodiscard]] bool has(FairnessKind kind) const;
  /// Is it about each interaction?
  [[nodiscard]] bool has_interactions() const;
};

struct RowsOfPaths;

/// Reads the text and resolves its names. The error begins with the column of the problem.
[[nodiscard]] Result<Fairness> read_fairness(std::string_view text, const System& system);
/// The same of the text from `begin` on.
[[nodiscard]] Result<Fairness> read_fairness(std::string_view text, std::size_t begin, const System& system,
                                             const RowsOfPaths& rows);
/// What is wrong with the text whatever the system; empty: nothing.
[[nodiscard]] std::string problem_of_fairness(std::string_view text);
/// Fairness of each interaction.
[[nodiscard]] Fairness fairness_of_interactions(FairnessKind kind);

/// Returns the text that read_fairness reads.
[[nodiscard]] std::string name_of(const Fairness& fairness);
/// Returns it in words: "no fairness is assumed", "weak fairness of interactions, strong fairness of `p.enter`".
[[nodiscard]] std::string words_of(const Fairness& fairness);
/// Returns the term as certificates have it: "weak", "strong:atoms", "strong:port:ROOT.p.enter".
[[nodiscard]] std::string certificate_text(const FairnessTerm& term, const System& system);
/// The row of certificates: the terms, or "none".
[[nodiscard]] std::string certificate_text(const Fairness& fairness, const System& system);

}  // namespace bip::verify
