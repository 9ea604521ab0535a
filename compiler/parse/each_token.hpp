// Runs a lexer that ANTLR generated over a part of a text, with positions in bytes of the whole: ANTLR counts code
// points. Linear in the part.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "antlr4-runtime.h"
#include "compiler/parse/token_list.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

/// Byte offset of each code point, one past the end included; empty if all are single bytes.
inline std::vector<std::uint32_t> code_point_offsets(std::string_view text) {
  const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  std::vector<std::uint32_t> offsets;
  if (ascii) return offsets;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xC0u) != 0x80u) offsets.push_back(static_cast<std::uint32_t>(i));
  }
  offsets.push_back(static_cast<std::uint32_t>(text.size()));
  return offsets;
}

/// ANTLR's lexer takes a lock and two function objects for each character, as its automaton is shared by all lexers of
/// a grammar. This one keeps the transitions that its thread has taken; states are never freed.
template <class Lexer>
class LexerSimulator final : public ::antlr4::atn::LexerATNSimulator {
 public:
  LexerSimulator(Lexer& lexer, ::antlr4::atn::LexerATNSimulator& other)
      : LexerATNSimulator(&lexer, lexer.getATN(), other._decisionToDFA, other.getSharedContextCache()) {}

 protected:
  ::antlr4::dfa::DFAState* getExistingTargetState(::antlr4::dfa::DFAState* state, std::size_t character) override {
    if (character > MAX_DFA_EDGE || _mode != Lexer::DEFAULT_MODE)
      return LexerATNSimulator::getExistingTargetState(state, character);
    thread_local std::vector<std::array<::antlr4::dfa::DFAState*, MAX_DFA_EDGE + 1>> targets;
    const auto row = static_cast<std::size_t>(state->stateNumber);
    if (row >= targets.size()) targets.resize(row + 1);
    ::antlr4::dfa::DFAState*& target = targets[row][character];
    if (target == nullptr) target = LexerATNSimulator::getExistingTargetState(state, character);
    return target;
  }
};

/// Calls `take` with the row of each token and comment of a text that lies at `begin` in its file.
template <class Lexer, class Take>
void each_token(std::string_view text, std::uint32_t begin, Take take) {
  const std::vector<std::uint32_t> offsets = code_point_offsets(text);
  auto byte = [&](std::size_t code_point) {
    BIP_ASSERT(offsets.empty() || code_point < offsets.size(), "code point {} of {}", code_point, offsets.size());
    return begin + (offsets.empty() ? static_cast<std::uint32_t>(code_point) : offsets[code_point]);
  };
  ::antlr4::ANTLRInputStream input{std::string(text)};
  Lexer lexer(&input);
  lexer.setInterpreter(
      new LexerSimulator<Lexer>(lexer, *lexer.template getInterpreter<::antlr4::atn::LexerATNSimulator>()));
  lexer.removeErrorListeners();
  for (auto token = lexer.nextToken(); token->getType() != ::antlr4::Token::EOF; token = lexer.nextToken()) {
    const TokenRow row{token->getType(), byte(token->getStartIndex()), byte(token->getStopIndex() + 1),
                       static_cast<std::uint32_t>(token->getLine())};
    BIP_ASSERT(row.begin <= row.end && row.end <= begin + text.size(), "token {}..{} of {} bytes", row.begin, row.end,
               begin + text.size());
    take(row);
  }
}

}  // namespace bip::parse
