// A file that is parsed again with kept trees has the same tree as without them.
#include <catch2/catch.hpp>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "compiler/parse/cut_pieces.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/syntax/print.hpp"
#include "compiler/syntax/validate_syntax.hpp"

namespace {

using namespace bip;

struct Read {
  Read(const std::string& text, parse::PieceCache* kept)
      : file(sources.add("test.bip", text)), syntax(parse::parse_file(sources, file, diags, kept)) {}
  SourceMap sources;
  FileId file;
  Diagnostics diags;
  std::optional<syntax::Syntax> syntax;

  /// Places, names, comments and messages. The printer and the dump read each name and each range of the tree.
  [[nodiscard]] std::string all() const {
    std::string out = render(diags, sources, {.format = DiagnosticFormat::Short});
    if (!syntax.has_value() || syntax->package == nullptr) return out;
    for (const std::string& broken : syntax::validate(*syntax, sources)) out += "broken: " + broken;
    for (const syntax::Comment& c : syntax->comments) out += std::to_string(c.range.begin) + " ";
    return out + syntax::dump(*syntax, sources) + syntax::print(*syntax, sources);
  }
};

constexpr const char* kChangedFile = R"(// What it is.
@cpp(include="a.h") package p.q
use std.ports use other
const data string s = "a\tb", t = "port type"
port type P(int v)
/* compound type Commented() */
@SuppressWarning(x)
connector type K(P a, P b) define a' [b] on a b provided (a.v < b.v) up {} down { a.v = b.v; } end
function int f(int x) = x * 2 + 1
extern function int g(int)
extern data type T refine B as "std::T"
atom type A(int k)
  data int v = 0
  clock c unit millisecond
  @mark(a = "x\ty") export port P p(v)
  export port P q(v) as both
  place S, T
  final T
  initial to S do { v = k; }
  on p from S to T provided (v > 0 || k == 1) do { if (v > 1) then v = v - 1; else v = 0; fi }
  internal from T to S
  priority r p < p
  invariant ok at S provided (v > 0)
end
@mark(a,
  b)
compound type C(int m, bool b)
  component A a(1), b[m](m * 2)
  connector j(a.p, b[*].p) define [a.p, b[*].p]'
  for x in 0..m - 1 { component A z[x](x) connector K l[x](z[x].p, b[x].p) }
  priority high j:a.p, b.p < j:*
  connector u(a.q) data int s = 1 export port P e(s) define a.q on a.q up { s = a.q.v; }
  property q { always a.v > 0 }
  export port j.x as e
end
)";

TEST_CASE("only the declaration that changed is parsed again") {
  const std::string text = std::string(kChangedFile) + "end\n";
  parse::PieceCache kept;
  REQUIRE(Read(text, &kept).all() == Read(text, nullptr).all());
  REQUIRE(kept.whole == 0);
  // The beginning, `port type`, `connector type` (with what stands below it), `atom type`, `compound type`.
  REQUIRE(kept.parsed == 5);
  REQUIRE(parse::cut_pieces(text).size() == 5);
  std::string longer = text;
  longer.replace(longer.find("v = k;"), 6, "v = k + 12345;");
  const Read changed(longer, &kept);
  REQUIRE(kept.parsed == 6);
  REQUIRE(kept.reused == 4);
  REQUIRE(changed.all() == Read(longer, nullptr).all());
  // Texts of trees are those of the new map, not of one that may be freed.
  const std::string_view whole = changed.sources.text(changed.file);
  for (const syntax::Decl* d : changed.syntax->package->decls)
    REQUIRE((d->name.text.data() >= whole.data() && d->name.text.data() < whole.data() + whole.size()));
  // A line more above all of them parses the beginning only.
  const std::string below = "\n" + longer;
  REQUIRE(Read(below, &kept).all() == Read(below, nullptr).all());
  REQUIRE(kept.parsed == 7);
  // Pieces in another order are found by their texts.
  const std::size_t port = below.find("port type P"), mark = below.find("/* compound");
  std::string swapped = below;
  swapped.erase(port, mark - port);
  swapped.insert(swapped.find("@mark(a,"), below.substr(port, mark - port));
  REQUIRE(Read(swapped, &kept).all() == Read(swapped, nullptr).all());
}

// A range or a view that is not moved would be seen late and seldom: it is looked for in the memory of all nodes.
TEST_CASE("nothing in a tree stays with the earlier text") {
  // A number of a file that no offset, size or letter has.
  const auto with_files = [](SourceMap& sources, std::size_t count) {
    while (sources.size() < count) sources.add("", "");
  };
  const std::string text = std::string(kChangedFile) + "end\n";
  constexpr std::size_t kEarlier = 70001;
  SourceMap earlier, later;
  Diagnostics diags;
  with_files(earlier, kEarlier);
  with_files(later, kEarlier + 1);
  parse::PieceCache kept;
  const FileId file = earlier.add("a.bip", text);
  REQUIRE(parse::parse_file(earlier, file, diags, &kept).has_value());
  // A range in a node: the number, and a part of the text behind it. Padding may hold the number alone, or an address.
  const auto is_range = [&text](const char* bytes, std::size_t left) {
    std::uint32_t words[3] = {};
    if (left < sizeof words) return false;
    std::memcpy(words, bytes, sizeof words);
    return words[0] == kEarlier && words[1] <= words[2] && words[2] != 0 && words[2] <= text.size();
  };
  // A view in a node: an address in the earlier text, and a size behind it.
  const auto is_view = [](const char* bytes, std::size_t left, std::string_view old) {
    std::uintptr_t words[2] = {};
    if (left < sizeof words) return false;
    std::memcpy(words, bytes, sizeof words);
    const std::uintptr_t at = words[0] - reinterpret_cast<std::uintptr_t>(old.data());
    return at < old.size() && words[1] != 0 && words[1] <= old.size() - at;
  };
  const auto stale = [&] {
    const std::string_view old = earlier.text(file);
    std::size_t found = 0;
    for (const parse::CachedPiece& piece : kept.pieces) {
      for (const parse::MadeNodes& nodes : piece.made) {
        const char* const bytes = static_cast<const char*>(nodes.first);
        for (std::size_t at = 0; at < nodes.count * nodes.size; at += 4) {
          const std::size_t left = nodes.size - at % nodes.size;
          found += is_range(bytes + at, left) ? 1 : 0;
          found += at % 8 == 0 && is_view(bytes + at, left, old) ? 1 : 0;
        }
      }
    }
    return found;
  };
  REQUIRE(stale() > 300);
  // Each piece stays, and is moved: the first word of the file is in the first piece, so that one is parsed again.
  REQUIRE(parse::parse_file(later, later.add("a.bip", " " + text), diags, &kept).has_value());
  REQUIRE(kept.parsed == 6);
  REQUIRE(stale() == 0);
}

TEST_CASE("a file that is not sound is read as a whole, and what was kept stays") {
  const std::string text = std::string(kChangedFile) + "end\n";
  parse::PieceCache kept;
  REQUIRE(Read(text, &kept).all() == Read(text, nullptr).all());
  for (const char* odd : {"atom", "}", "/*", "\"", "\xff", "\xe2\x80\xaa// x\n", "end", "atom type X() end"}) {
    std::string broken = text;
    broken.insert(broken.find("  place S"), odd);
    REQUIRE(Read(broken, &kept).all() == Read(broken, nullptr).all());
  }
  REQUIRE(kept.whole + kept.partly == 8);
  REQUIRE(kept.partly >= 3);
  const std::uint64_t parsed = kept.parsed;
  REQUIRE(Read(text, &kept).all() == Read(text, nullptr).all());
  REQUIRE(kept.parsed == parsed);
}

TEST_CASE("comments and strings are not cut") {
  REQUIRE(parse::cut_pieces("").size() == 1);
  REQUIRE(parse::cut_pieces("/*\natom type A()\n*/ \"\natom type B()\n// \"\natom\ttype C()\n").size() == 3);
  REQUIRE(parse::cut_pieces("\"/*\"\nport type P()\n@a\n// c\n\n@b(\nport type\n)\nport type Q()").size() == 3);
  REQUIRE(parse::cut_pieces("x\nport typeX\nport x\n  port\t type X\n") == std::vector<std::uint32_t>{0, 20});
}

TEST_CASE("of a text with an error only its surroundings are read") {
  std::string text = "package many\n  port type S()\n";
  for (int k = 0; k < 12; ++k) {
    const std::string n = std::to_string(k);
    text += "  // The one with number " + n + ".\n  @mark(a = " + n + ")\n  atom type A" + n +
            "()\n    data int x = 1\n    export port S p(), q()\n    place P, Q\n    initial to P do { x = 2; }\n"
            "    on p from P to Q provided (x > 0) do { if (x > 1) then x = 0; fi }\n    on q from Q to P\n  end\n";
    if (k % 3 == 2)
      text += "  compound type C" + n + "()\n    component A" + n +
              " a(), b()\n    connector k(a.p, b.p) define a.p' b.p\n  end\n";
  }
  text += "end\n";
  const char* const words[] = {"end",
                               "atom",
                               "(",
                               ")",
                               "{",
                               "}",
                               "\"",
                               "@",
                               ";",
                               "on",
                               "to",
                               "x",
                               "port type",
                               "component",
                               "if",
                               "fi",
                               "/*",
                               "package",
                               "$",
                               "end\n  end",
                               "on p from",
                               "when",
                               "property x {",
                               "compound type Z()",
                               "connector k(",
                               "1..",
                               "é"};
  std::mt19937 random(3);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  parse::PieceCache kept;
  for (int step = 0; step < 1000; ++step) {
    if (step % 2 == 0) REQUIRE(Read(text, &kept).all().size() > 1000);
    std::string broken = text;
    const std::size_t at = below(text.size());
    if (below(3) == 0) broken.erase(at, 1 + below(8));
    else broken.insert(at, words[below(std::size(words))]);
    if (below(4) == 0) broken.insert(std::min(broken.size(), at + below(30)), words[below(std::size(words))]);
    const std::string want = Read(broken, nullptr).all();
    INFO(broken);
    REQUIRE(Read(broken, &kept).all() == want);
  }
  REQUIRE(kept.partly > 250);
}

// Random edits of all models: as a person makes them, most of them undone after a while.
TEST_CASE("trees of edited models are those of fresh parses") {
  std::vector<std::string> models;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(BIP_TEST_SOURCE_DIR "/models")) {
    if (entry.path().extension() != ".bip") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    models.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  REQUIRE(models.size() > 20);
  std::mt19937 random(1);
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const char* const words[] = {" ",
                               "\n",
                               "x",
                               "(",
                               ")",
                               "end",
                               "end\n",
                               "when ",
                               "on",
                               "as",
                               "atom type Z()",
                               "\natom type Z() place S initial to S end\n",
                               "component ",
                               "\"",
                               "/*",
                               "*/",
                               "//",
                               "{",
                               "}",
                               "@a ",
                               "port type Q()\n",
                               "property q {",
                               "if ",
                               " fi",
                               "é"};
  std::uint64_t reused = 0, sound = 0;
  for (const std::string& model : models) {
    parse::PieceCache kept;
    std::string text = model;
    for (int step = 0; step < 40; ++step) {
      const std::size_t at = below(text.size() + 1);
      switch (below(5)) {
        case 0: text.erase(at, below(4)); break;
        case 1: {
          // A line to another place.
          const std::size_t line = text.rfind('\n', at) == std::string::npos ? 0 : text.rfind('\n', at) + 1;
          const std::size_t end = std::min(text.find('\n', line), text.size());
          const std::string moved = text.substr(line, end - line) + "\n";
          text.insert(std::min(text.find('\n', below(text.size() + 1)), text.size() - 1) + 1, moved);
          break;
        }
        case 2: text = model; break;
        default: text.insert(at, words[below(std::size(words))]);
      }
      const Read fresh(text, nullptr);
      sound += fresh.diags.has_errors() ? 0 : 1;
      INFO(text);
      REQUIRE(Read(text, &kept).all() == fresh.all());
    }
    reused += kept.reused;
  }
  REQUIRE(reused > 1000);
  REQUIRE(sound > 300);
}

}  // namespace
