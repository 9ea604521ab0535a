// Parses a correct file piece by piece: each declaration, or item of a compound, is parsed, converted and freed, so
// that the parse tree of a large file never exists as a whole. That tree has 50 times the size of the text, and freeing
// it costs as much as parsing.
#pragma once
#include "compiler/parse/convert.hpp"
#include "compiler/parse/row_stream.hpp"

namespace bip::parse {

class PieceReader {
 public:
  /// `parser` reads `stream`, predicts without context and gives up at the first error.
  PieceReader(BipParser& parser, RowStream& stream, Converter& converter)
      : parser_(parser), stream_(stream), converter_(converter) {}

  // All of them throw ParseCancellationException if the text is not sound; the caller then reads the file whole, with
  // messages.

  /// The package.
  [[nodiscard]] const syntax::Package* read();
  /// What a file begins with: a package without declarations, or one without a name and nothing read.
  [[nodiscard]] syntax::Package read_head();
  /// Declarations, up to the end of the package or to the token at `end`.
  void read_decls(std::size_t end, std::vector<const syntax::Decl*>& to);
  /// Reads the `end` of a package if that comes next before the token at `end`.
  [[nodiscard]] bool read_end(std::size_t end);

 private:
  [[nodiscard]] std::size_t next() { return stream_.LA(1); }
  void take(std::size_t type);
  void forget() { parser_.getTreeTracker().reset(); }
  const syntax::Decl* decl();
  const syntax::Decl* compound();

  BipParser& parser_;
  RowStream& stream_;
  Converter& converter_;
};

/// Makes `parser` predict without context and give up at the first error.
void give_up_at_errors(BipParser& parser);

}  // namespace bip::parse
