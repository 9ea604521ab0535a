// The three renderers on small texts: exact output.
#include <catch2/catch.hpp>
#include <string>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/diag/explain.hpp"

using namespace bip;

namespace {

struct Fixture {
  SourceMap sources;
  FileId file;
  Diagnostics diags;

  explicit Fixture(const std::string& text) : file(sources.add("m.bip", text)) {}
  [[nodiscard]] SourceRange range(const std::string& part, std::size_t nth = 0) const {
    std::size_t at = sources.text(file).find(part);
    for (; nth > 0; --nth) at = sources.text(file).find(part, at + 1);
    return {file, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(at + part.size())};
  }
  [[nodiscard]] std::string frame(std::size_t cap = 20) const {
    return render(diags, sources, {.format = DiagnosticFormat::Frame, .color = Color::Off, .max_errors = cap});
  }
};

}  // namespace

TEST_CASE("the frame has lines, gaps, labels, notes and helps") {
  Fixture f("port type Tick()\n\n\n\n\n\n\n\n\n  on s up { x = r1.d; }\n");
  f.diags.add(Diag::kB0090, f.range("r1.d"), "`up` reads `r1.d`")
      .label("no `d` here")
      .label(f.range("Tick()"), "declared without parameters")
      .note("a note")
      .help("a help");
  REQUIRE(f.frame() ==
          "error[B0090]: `up` reads `r1.d`\n"
          "  --> m.bip:10:17\n"
          "   |\n"
          " 1 | port type Tick()\n"
          "   |           ------ declared without parameters\n"
          "   :\n"
          "10 |   on s up { x = r1.d; }\n"
          "   |                 ^^^^ no `d` here\n"
          "   = note: a note\n"
          "   = help: a help\n"
          "1 error\n");
}

TEST_CASE("marks of one line share a row unless they overlap") {
  Fixture f("alpha beta gamma\n");
  f.diags.add(Diag::kB0090, f.range("gamma"), "m")
      .label("third")
      .label(f.range("alpha"), "first")
      .label(f.range("beta"), "second");
  REQUIRE(f.frame() ==
          "error[B0090]: m\n --> m.bip:1:12\n  |\n1 | alpha beta gamma\n"
          "  | ----- ---- ^^^^^ third\n"
          "  | |     |\n"
          "  | |     second\n"
          "  | |\n"
          "  | first\n"
          "1 error\n");
  Fixture g("alpha beta\n");
  g.diags.add(Diag::kB0090, g.range("alpha beta"), "m").label("all").label(g.range("beta"), "part");
  REQUIRE(g.frame() ==
          "error[B0090]: m\n --> m.bip:1:1\n  |\n1 | alpha beta\n"
          "  | ^^^^^^^^^^ all\n"
          "  |       ---- part\n"
          "1 error\n");
}

TEST_CASE("tabs, wide characters and control characters keep the caret in place") {
  Fixture f("\tx\xE6\x97\xA5y \x1b[31m z\n");
  f.diags.add(Diag::kB0090, f.range("y"), "m");
  REQUIRE(f.frame() ==
          "error[B0090]: m\n --> m.bip:1:6\n  |\n1 |     x\xE6\x97\xA5y \xEF\xBF\xBD[31m z\n"
          "  |        ^\n1 error\n");
}

TEST_CASE("an empty range, a range over lines and a place at the end of the text have one mark") {
  Fixture f("ab\ncd");
  f.diags.add(Diag::kB0090, {f.file, 5, 5}, "end");
  f.diags.add(Diag::kB0090, {f.file, 1, 5}, "two lines");
  REQUIRE(f.frame() ==
          "error[B0090]: two lines\n --> m.bip:1:2\n  |\n1 | ab\n  |  ^\n"
          "error[B0090]: end\n --> m.bip:2:3\n  |\n2 | cd\n  |   ^\n2 errors\n");
}

TEST_CASE("long lines are cut around the mark") {
  Fixture f(std::string(5000, 'a') + "!" + std::string(5000, 'b') + "\n");
  f.diags.add(Diag::kB0090, f.range("!"), "m");
  const std::string text = f.frame();
  REQUIRE(text.size() < 500);
  REQUIRE(text.find("a!b") != std::string::npos);
  REQUIRE(text.find("…") != std::string::npos);
}

TEST_CASE("labels of another file follow under :::") {
  Fixture f("here\n");
  const FileId other = f.sources.add("o.bip", "x\nthere\n");
  f.diags.add(Diag::kB0090, f.range("here"), "m").label({other, 2, 7}, "and there");
  REQUIRE(f.frame() ==
          "error[B0090]: m\n --> m.bip:1:1\n  |\n1 | here\n  | ^^^^\n ::: o.bip:2:1\n  |\n2 | there\n  | ----- and "
          "there\n1 error\n");
}

TEST_CASE("order is by place, exact duplicates are dropped, errors are capped") {
  Fixture f("a b c d\n");
  f.diags.add(Diag::kB0090, f.range("c"), "third");
  f.diags.add(Diag::kB0090, f.range("a"), "first");
  f.diags.add(Diag::kB0090, f.range("b"), "second");
  f.diags.add(Diag::kB0090, f.range("a"), "first");
  f.diags.add(Diag::kB0090, {}, "a file is not there");
  REQUIRE(f.diags.error_count() == 5);
  REQUIRE(render(f.diags, f.sources, {.format = DiagnosticFormat::Short, .color = Color::Off, .max_errors = 3}) ==
          "error[B0090]: a file is not there\n"
          "m.bip:1:1: error[B0090]: first\n"
          "m.bip:1:3: error[B0090]: second\n"
          "4 errors (1 not shown)\n");
}

TEST_CASE("JSON is one object a line, with edits, and survives text that is not UTF-8") {
  Fixture f("a b\n");
  f.diags.add(Diag::kB0090, f.range("b"), "bad \xFF").label("l").help("write `c`", f.range("b"), "c");
  const std::string json =
      render(f.diags, f.sources, {.format = DiagnosticFormat::Json, .color = Color::Off, .max_errors = 0});
  REQUIRE(
      json ==
      "{\"severity\":\"error\",\"code\":\"B0090\",\"name\":\"unreadable-file\",\"message\":\"bad \xEF\xBF\xBD\","
      "\"range\":{\"file\":\"m.bip\",\"line\":1,\"column\":3,\"end_line\":1,\"end_column\":4,\"offset\":2,\"end_"
      "offset\":3},"
      "\"label\":\"l\",\"labels\":[],\"notes\":[],\"helps\":[{\"text\":\"write "
      "`c`\",\"edit\":{\"range\":{\"file\":\"m.bip\","
      "\"line\":1,\"column\":3,\"end_line\":1,\"end_column\":4,\"offset\":2,\"end_offset\":3},\"with\":\"c\"}}]}\n");
}

TEST_CASE("nothing is rendered for nothing") {
  const Fixture f("");
  REQUIRE(f.frame().empty());
}

TEST_CASE("explain pages are embedded and rendered without fences") {
  REQUIRE(find_page("R0005") != nullptr);
  REQUIRE(find_page("R9999") == nullptr);
  const std::string text = render_page({"X0001", "# X0001: title\n\nText.\n\n```bip wrong\nline\n\n```\n"}, Color::Off);
  REQUIRE(text == "X0001: title\n\nText.\n\n    line\n\n");
}
