// See read_in_pieces.hpp. The upper levels of the grammar (`package`, `decl*`, `compoundType`) are parsed by hand, all
// below by the generated rules. These predict as they do inside a whole file, because prediction without context does
// not depend on what surrounds a rule.
#include "compiler/parse/read_in_pieces.hpp"

namespace bip::parse {

using namespace syntax;

void PieceReader::take(std::size_t type) {
  if (next() != type) throw antlr4::ParseCancellationException();
  if (type != antlr4::Token::EOF) stream_.consume();
}

const Package* PieceReader::read() {
  Package package;
  std::vector<BipParser::AnnotationContext*> marks;
  while (next() == BipParser::AT_SIGN) marks.push_back(parser_.annotation());
  const bool is_package = next() == BipParser::PACKAGE;
  std::vector<Path> uses;
  if (is_package) {
    take(BipParser::PACKAGE);
    package.name = converter_.path(parser_.path());
    package.annotations = converter_.annotations(marks);
    while (next() == BipParser::USE) uses.push_back(converter_.path(parser_.use()->path()));
  } else {
    // They belong to the first declaration.
    stream_.seek(0);
  }
  forget();
  std::vector<const Decl*> decls;
  while (next() != BipParser::END && next() != antlr4::Token::EOF) {
    if (const Decl* made = next() == BipParser::COMPOUND ? compound() : decl()) decls.push_back(made);
  }
  if (is_package) take(BipParser::END);
  take(antlr4::Token::EOF);
  package.uses = converter_.arena_.list(uses);
  package.decls = converter_.arena_.list(decls);
  package.range = {converter_.file_, 0, static_cast<std::uint32_t>(converter_.text_.size())};
  return converter_.arena_.make(package);
}

const Decl* PieceReader::decl() {
  const Decl* made = converter_.decl(parser_.decl());
  forget();
  return made;
}

const Decl* PieceReader::compound() {
  Decl d;
  d.kind = DeclKind::CompoundType;
  const SourceRange first = converter_.range(stream_.LT(1));
  take(BipParser::COMPOUND);
  take(BipParser::TYPE);
  d.name = converter_.name(parser_.id());
  take(BipParser::LPAREN);
  if (next() != BipParser::RPAREN) d.params = converter_.params(parser_.params());
  take(BipParser::RPAREN);
  forget();
  Converter::Items items;
  converter_.open_body(d, "compound type");
  while (next() != BipParser::END) {
    converter_.body_item(parser_.bodyItem(), items);
    forget();
  }
  d.range = {first.file, first.begin, converter_.range(stream_.LT(1)).end};
  take(BipParser::END);
  converter_.close_body(d, items);
  return converter_.arena_.make(d);
}

}  // namespace bip::parse
