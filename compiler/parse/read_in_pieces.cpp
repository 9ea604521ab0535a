// See read_in_pieces.hpp. The upper levels of the grammar (`package`, `decl*`, `compoundType`) are parsed by hand, all
// below by the generated rules. These predict as they do inside a whole file, because prediction without context does
// not depend on what surrounds a rule.
#include "compiler/parse/read_in_pieces.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::parse {

using namespace syntax;

void give_up_at_errors(BipParser& parser) {
  parser.removeErrorListeners();
  parser.getInterpreter<antlr4::atn::ParserATNSimulator>()->setPredictionMode(antlr4::atn::PredictionMode::SLL);
  parser.setErrorHandler(std::make_shared<antlr4::BailErrorStrategy>());
}

void PieceReader::take(std::size_t type) {
  if (next() != type) throw antlr4::ParseCancellationException();
  if (type != antlr4::Token::EOF) stream_.consume();
}

Package PieceReader::read_head() {
  Package package;
  std::vector<BipParser::AnnotationContext*> marks;
  while (next() == BipParser::AT_SIGN) marks.push_back(parser_.annotation());
  if (next() == BipParser::PACKAGE) {
    std::vector<Path> uses;
    take(BipParser::PACKAGE);
    package.name = converter_.path(parser_.path());
    package.annotations = converter_.annotations(marks);
    while (next() == BipParser::USE) uses.push_back(converter_.path(parser_.use()->path()));
    package.uses = converter_.arena_.list(uses);
  } else {
    // They belong to the first declaration.
    stream_.seek(0);
  }
  package.range = {converter_.file_, 0, static_cast<std::uint32_t>(converter_.text_.size())};
  forget();
  return package;
}

void PieceReader::read_decls(std::size_t end, std::vector<const Decl*>& to) {
  while (stream_.index() < end && next() != BipParser::END) {
    [[maybe_unused]] const std::size_t before = stream_.index();
    if (const Decl* made = next() == BipParser::COMPOUND ? compound() : decl()) to.push_back(made);
    BIP_ASSERT(stream_.index() > before, "a declaration at token {} has no tokens", before);
  }
}

bool PieceReader::read_end(std::size_t end) {
  if (stream_.index() >= end || next() != BipParser::END) return false;
  BIP_ASSERT(end <= stream_.size(), "token {} of {}", end, stream_.size());
  take(BipParser::END);
  return true;
}

const Package* PieceReader::read() {
  Package package = read_head();
  const std::size_t end = stream_.size() - 1;
  std::vector<const Decl*> decls;
  read_decls(end, decls);
  if (!package.name.parts.empty()) take(BipParser::END);
  take(antlr4::Token::EOF);
  package.decls = converter_.arena_.list(decls);
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
