// What of C is said in BIP2, and how; what is left to C++; depth and comments.
#include <catch2/catch.hpp>

#include <string>

#include "compiler/migrate/write_bip2.hpp"
#include "compiler/parse/parse.hpp"
#include "compiler/parse/bip1/parse_bip1.hpp"

using namespace bip;

namespace {

struct Migrated {
  explicit Migrated(const std::string& text) : file(sources.add("old.bip", text)) {
    const auto model = parse::parse_bip1(sources, file, diags);
    if (!model) return;
    is_read = true;
    made = migrate::write_bip2(*model, sources, "new", diags);
  }
  [[nodiscard]] std::string messages() const { return render(diags, sources, {.format = DiagnosticFormat::Short}); }

  SourceMap sources;
  Diagnostics diags;
  FileId file;
  bool is_read = false;
  migrate::Bip2Text made;
};

/// What an action `code` becomes; "C++" and the function's head if it is left in C.
std::string action(const std::string& code) {
  const Migrated m(
      "model M atomic type A(int k) data int i, j data bool b, c data float f data string s data char ch\n"
      "behavior initial to S state S on p do {" +
      code + "} to S end end end");
  REQUIRE(m.is_read);
  const std::size_t head = m.made.source.find(") {");
  if (head != std::string::npos) {
    const std::size_t line = m.made.source.rfind('\n', head) + 1;
    return "C++ " + m.made.source.substr(line, head + 1 - line);
  }
  const std::size_t begin = m.made.bip.find(" do { ");
  if (begin == std::string::npos) return m.messages();
  return m.made.bip.substr(begin + 6, m.made.bip.find("}\n", begin) - begin - 7);
}

std::string guard(const std::string& code) {
  const Migrated m(
      "model M atomic type A data int i data bool b data float f behavior initial to S state S on p provided " + code +
      " to S end end end");
  REQUIRE(m.is_read);
  const std::size_t begin = m.made.bip.find("provided (");
  return m.made.source.empty() ? m.made.bip.substr(begin + 10, m.made.bip.find(")\n", begin) - begin - 10) : "C++";
}

}  // namespace

TEST_CASE("statements of C that BIP2 has") {
  CHECK(action("i = j;") == "i = j;");
  CHECK(action("i = j") == "i = j;");
  CHECK(action("i += 2; j *= i - 1;") == "i = i + 2; j = j * (i - 1);");
  CHECK(action("i++; --j; ;") == "i = i + 1; j = j - 1;");
  CHECK(action("if (i) j = 1; else if (!b) { j = 2; } else j = 3;") ==
        "if ((i != 0)) then j = 1; else if (!b) then j = 2; else j = 3; fi fi");
  CHECK(action("{ i = 1; { j = 2; } }") == "i = 1; j = 2;");
  CHECK(action("b = 1; c = i;") == "b = true; c = (i != 0);");
  CHECK(action("i = 0x1F + 017 + '0';") == "i = 31 + 15 + 48;");
  CHECK(action("f = i; s = \"a\\n\";") == "f = i; s = \"a\\n\";");
  CHECK(action("i = - -1;") == "i = - -1;");
  CHECK(action("i = k;") == "i = k;");
}

TEST_CASE("statements that are left to C++, with the parameters of what they use") {
  CHECK(action("i = f;") == "C++ void A_p_code(int& i, double f)");
  CHECK(action("i = b;") == "C++ void A_p_code(int& i, bool b)");
  CHECK(action("i = i > 2 ? j : 3;") == "C++ void A_p_code(int& i, int j)");
  CHECK(action("while (i < 3) i++;") == "C++ void A_p_code(int& i)");
  CHECK(action("g(&i, j, \"k }\"); // k\n") == "C++ void A_p_code(int& i, int j)");
  CHECK(action("b = g(i) == i;") == "C++ bool A_p_code(bool b, int i)");
  CHECK(action("ch = 1;") == "C++ void A_p_code(char& ch)");
  CHECK(action("int n = 3; i = n;") == "C++ void A_p_code(int& i)");
  CHECK(action("p->i = j; x.j = j;") == "C++ void A_p_code(int j)");
  CHECK(action("i <<= 1;") == "C++ void A_p_code(int& i)");
  CHECK(action("s = \"\\x41\";") == "C++ std::string A_p_code(std::string s)");
}

TEST_CASE("two results are one too many") { CHECK(action("b = g(); c = b;").find("B6140") != std::string::npos); }

TEST_CASE("conditions") {
  CHECK(guard("i") == "(i != 0)");
  CHECK(guard("(i == 1 && !b)") == "(i == 1 && !b)");
  CHECK(guard("{# b == 1 || 0 != b #}") == "b == true || false != b");
  CHECK(guard("i < f * 2") == "i < f * 2");
  CHECK(guard("1") == "true");
  CHECK(guard("!i") == "!(i != 0)");
  CHECK(guard("b + 1 > 1") == "C++");
  CHECK(guard("1 < i < 3") == "C++");
  CHECK(guard("b == i") == "C++");
  CHECK(guard("unknown") == "C++");
}

TEST_CASE("text that is nested too deeply is refused, or left in C") {
  const std::string open(300, '('), close(300, ')');
  CHECK(action("i = " + open + "j" + close + ";").starts_with("C++"));
  const Migrated deep("model M atomic type A data int i = " + open + "1" + close + " end end");
  CHECK(!deep.is_read);
  CHECK(deep.messages().find("B0008") != std::string::npos);
  std::string blocks;
  for (int n = 0; n < 100; ++n) blocks += "{";
  CHECK(action(blocks + "i = 1;" + std::string(100, '}')).starts_with("C++"));
}

TEST_CASE("words that begin a construct in one place only are names elsewhere") {
  const Migrated m(
      "model M port type header(int clock) atomic type include data int reset export port header when(reset)\n"
      "behavior initial to in state in on when to eager state eager end end end");
  INFO(m.messages());
  REQUIRE(m.is_read);
  CHECK(m.made.bip.find("export port header when(reset)") != std::string::npos);
}

TEST_CASE("each comment is written once") {
  const Migrated m(
      "// a\nmodel M // b\n/* c */ atomic type A // d\n// e\nbehavior initial to S state S // f\non p do { /* g */ "
      "x(); } to S\n"
      "on q do { ; /* h */ } to S\n// i\nend end // j\nend // k\n// l\n");
  REQUIRE(m.is_read);
  for (char c = 'a'; c <= 'l'; ++c) {
    const bool is_block = c == 'c' || c == 'h' || c == 'g';
    const std::string comment = is_block ? std::string("/* ") + c : std::string("// ") + c;
    const std::string& text = c == 'g' ? m.made.source : m.made.bip;
    INFO(comment << "\n" << m.made.bip);
    const std::size_t at = text.find(comment);
    REQUIRE(at != std::string::npos);
    CHECK(text.find(comment, at + 1) == std::string::npos);
  }
}
