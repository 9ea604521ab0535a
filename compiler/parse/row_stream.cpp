// See row_stream.hpp. ANTLR asks for the token before the first one (null) and may not consume the end of file.
#include "compiler/parse/row_stream.hpp"

#include <algorithm>

#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

RowStream::RowStream(const std::vector<TokenRow>& rows, std::size_t file_size) {
  tokens_.reserve(rows.size() + 1);
  for (const TokenRow& row : rows) {
    tokens_.emplace_back(row.type, row.begin, row.end, row.line, static_cast<std::uint32_t>(tokens_.size()));
  }
  BIP_ASSERT(
      std::is_sorted(rows.begin(), rows.end(), [](const TokenRow& a, const TokenRow& b) { return a.begin < b.begin; }),
      "tokens are in the order of the text");
  BIP_ASSERT(rows.empty() || rows.back().end <= file_size, "token ends at {} of {} bytes", rows.back().end, file_size);
  const auto end = static_cast<std::uint32_t>(file_size);
  const std::uint32_t line = rows.empty() ? 1 : rows.back().line + 1;
  tokens_.emplace_back(antlr4::Token::EOF, end, end, line, static_cast<std::uint32_t>(tokens_.size()));
}

void RowStream::consume() {
  if (at_ + 1 == tokens_.size()) throw antlr4::IllegalStateException("cannot consume EOF");
  ++at_;
}

antlr4::Token* RowStream::LT(ssize_t k) {
  BIP_ASSERT(at_ < tokens_.size(), "token {} of {}", at_, tokens_.size());
  if (k > 0) return &tokens_[std::min(at_ + static_cast<std::size_t>(k) - 1, tokens_.size() - 1)];
  const auto back = static_cast<std::size_t>(-k);
  return back == 0 || back > at_ ? nullptr : &tokens_[at_ - back];
}

}  // namespace bip::parse
