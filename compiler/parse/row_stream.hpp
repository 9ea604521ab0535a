// The token list as a token stream of ANTLR: a token is 40 bytes in one vector, where ANTLR's are 150 bytes allocated
// one by one.
//
// Positions are byte offsets, the end excluded. The last token is the end of file; lookahead beyond it returns it
// again.
#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "antlr4-runtime.h"
#include "compiler/parse/token_list.hpp"

namespace bip::parse {

class RowToken final : public antlr4::Token {
 public:
  RowToken(std::size_t type, std::uint32_t begin, std::uint32_t end, std::uint32_t line, std::uint32_t index)
      : type_(type), begin_(begin), end_(end), line_(line), index_(index) {}

  [[nodiscard]] std::string getText() const override { return {}; }
  [[nodiscard]] std::size_t getType() const override { return type_; }
  [[nodiscard]] std::size_t getLine() const override { return line_; }
  [[nodiscard]] std::size_t getCharPositionInLine() const override { return 0; }
  [[nodiscard]] std::size_t getChannel() const override { return DEFAULT_CHANNEL; }
  [[nodiscard]] std::size_t getTokenIndex() const override { return index_; }
  [[nodiscard]] std::size_t getStartIndex() const override { return begin_; }
  [[nodiscard]] std::size_t getStopIndex() const override { return end_; }
  [[nodiscard]] antlr4::TokenSource* getTokenSource() const override { return nullptr; }
  [[nodiscard]] antlr4::CharStream* getInputStream() const override { return nullptr; }
  [[nodiscard]] std::string toString() const override { return {}; }

 private:
  std::size_t type_;
  std::uint32_t begin_;
  std::uint32_t end_;
  std::uint32_t line_;
  std::uint32_t index_;
};

class RowStream final : public antlr4::TokenStream {
 public:
  RowStream(const std::vector<TokenRow>& rows, std::size_t file_size);

  void consume() override;
  std::size_t LA(ssize_t k) override { return LT(k)->getType(); }
  antlr4::Token* LT(ssize_t k) override;
  ssize_t mark() override { return 0; }
  void release(ssize_t /*marker*/) override {}
  std::size_t index() override { return at_; }
  void seek(std::size_t index) override { at_ = std::min(index, tokens_.size() - 1); }
  std::size_t size() override { return tokens_.size(); }
  [[nodiscard]] std::string getSourceName() const override { return {}; }
  [[nodiscard]] antlr4::Token* get(std::size_t index) const override { return &tokens_[index]; }
  [[nodiscard]] antlr4::TokenSource* getTokenSource() const override { return nullptr; }
  std::string getText(const antlr4::misc::Interval& /*interval*/) override { return {}; }
  std::string getText() override { return {}; }
  std::string getText(antlr4::RuleContext* /*context*/) override { return {}; }
  std::string getText(antlr4::Token* /*start*/, antlr4::Token* /*stop*/) override { return {}; }

 private:
  // ANTLR hands out pointers to tokens that are not const, and changes none.
  mutable std::vector<RowToken> tokens_;
  std::size_t at_ = 0;
};

}  // namespace bip::parse
