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

  /// The package. Throws ParseCancellationException if the file is not sound; the caller then reads it whole, with
  /// messages.
  [[nodiscard]] const syntax::Package* read();

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

}  // namespace bip::parse
