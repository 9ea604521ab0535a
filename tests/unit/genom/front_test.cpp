// The inside of the front end that goldens would need many files for: constants, numbers, macros, bytes.
#include <catch2/catch.hpp>

#include "compiler/genom/c_structs.hpp"
#include "compiler/genom/condition.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/preprocess.hpp"
#include "compiler/genom/translate.hpp"

using namespace bip;
using namespace bip::genom;

namespace {

std::optional<std::int64_t> value_of(const std::string& text) {
  SourceMap sources;
  Diagnostics diags;
  std::vector<Token> tokens = lex(sources, sources.add("e", text), diags);
  tokens.pop_back();
  return constant_value(tokens);
}

// The words and signs that come out, joined by blanks.
std::string replaced(const std::string& text, Diagnostics& diags, const PreprocessOptions& options = {}) {
  SourceMap sources;
  const Preprocessed result = preprocess(sources, "/nowhere/x.gen", sources.add("x.gen", text), options, diags);
  std::string joined;
  for (const Token& t : result.tokens) joined += (joined.empty() || t.text.empty() ? "" : " ") + std::string(t.text);
  return joined;
}

// "NAME(TAG): type name[3], …", a line each.
std::string structs_of(const std::string& text) {
  SourceMap sources;
  Diagnostics diags;
  std::string out;
  for (const CStruct& s : read_c_structs(lex(sources, sources.add("s", text), diags))) {
    out += s.name + "(" + s.tag + "):";
    for (const CMember& m : s.members) {
      out += " " + m.type + " " + m.name;
      for (const std::int64_t length : m.dimensions) out += "[" + std::to_string(length) + "]";
      out += ",";
    }
    out += "\n";
  }
  return out;
}

}  // namespace

TEST_CASE("C structs are read as far as they are data") {
  CHECK(structs_of("struct P { double x, y; unsigned long int n[0x10][K]; };") ==
        "P(P): double x, double y, unsigned long n[16][-1],\n");
  CHECK(structs_of("typedef struct P_ { const char name[8]; struct Q q; } P;") == "P(P_): char name[8], struct Q q,\n");
  CHECK(
      structs_of("typedef double metres; typedef enum E { A, B } E; typedef struct { metres m; E e; enum F f; } S;") ==
      "S(): double m, int e, int f,\n");
  // With a pointer, a bit field, a function or a struct inside it is no message.
  for (const char* member : {"int *p;", "int b : 3;", "int (*f)(int);", "struct { int i; } s;", "int;"})
    CHECK(structs_of(std::string("struct P { int a; ") + member + " int z; }; struct Q { int q; };") ==
          "Q(Q): int q,\n");
  for (const char* text :
       {"struct", "struct {", "typedef struct A { int", "typedef", "struct A { ; } ; } }", "typedef enum {"})
    CHECK_NOTHROW((void)structs_of(text));
}

TEST_CASE("a poster's data are names with paths") {
  const auto text = [](const std::vector<std::string>& words) {
    std::string out;
    for (const DataRef& ref : read_data_refs(words)) {
      out += ref.name + "=";
      for (const std::string& step : ref.path) out += "." + step;
      out += " ";
    }
    return out;
  };
  CHECK(text({"a", "::", "b", ",", "c", "::", "d", ".", "e"}) == "a=.b c=.d.e ");
  CHECK(text({"a", "::", "all"}) == "a= ");
  CHECK(text({"a"}).empty());
  CHECK(text({"a", "::", "b", "c"}).empty());
  CHECK(text({"POS", "a", "."}).empty());
}

TEST_CASE("constant expressions have C's precedence and no undefined corner") {
  CHECK(value_of("1 + 2 * 3") == 7);
  CHECK(value_of("1 << 2 + 1") == 8);
  CHECK(value_of("-16 >> 2 < 0") == 1);
  CHECK(!value_of("1 << 64"));
  CHECK(!value_of("1 < < 2"));
  CHECK(value_of("(1 + 2) * 3") == 9);
  CHECK(value_of("10 - 4 - 3") == 3);
  CHECK(value_of("1 || 0 && 0") == 1);
  CHECK(value_of("!0 + -2") == -1);
  CHECK(value_of("7 % 4 == 3") == 1);
  CHECK(value_of("NAME") == 0);
  CHECK(value_of("0x10") == 16);
  CHECK(value_of("09001") == 9001);
  CHECK(value_of("-4611686018427387904 * 4 / -1").has_value());
  CHECK_FALSE(value_of("1 / 0").has_value());
  CHECK_FALSE(value_of("1 +").has_value());
  CHECK_FALSE(value_of("(1").has_value());
  CHECK_FALSE(value_of("1.5").has_value());
  CHECK_FALSE(value_of("").has_value());
  CHECK_FALSE(value_of(std::string(5000, '(') + "1").has_value());
  CHECK_FALSE(value_of(std::string(5000, '!') + "1").has_value());
}

TEST_CASE("macros are replaced within replacements, and never within themselves") {
  Diagnostics diags;
  CHECK(replaced("#define A B\n#define B 3\nA B", diags) == "3 3");
  CHECK(replaced("#define A A B\n#define B A\nA", diags) == "A A");
  CHECK(replaced("#define A\nx A y", diags) == "x y");
  CHECK(replaced("#define F(x) x\nF", diags) == "F");
  CHECK(replaced("#ifdef A\n1\n#elif 1\n2\n#else\n3\n#endif", diags) == "2");
  CHECK(replaced("A", diags, {.folders = {}, .defines = {{"A", "1 2"}}}) == "1 2");
  CHECK(replaced("a \\\n b // c\n/* d */ e", diags) == "a b e");
  CHECK_FALSE(diags.has_errors());
}

TEST_CASE("macros that double each other end") {
  std::string text = "#define a0\n";
  for (int i = 1; i < 60; ++i)
    text += "#define a" + std::to_string(i) + " a" + std::to_string(i - 1) + " a" + std::to_string(i - 1) + "\n";
  Diagnostics diags;
  CHECK(replaced(text + "a59", diags).size() < (64u << 20));
}

TEST_CASE("bytes that are no UTF-8 are Latin-1") {
  CHECK(as_utf8("caf\xe9") == "caf\xc3\xa9");
  CHECK(as_utf8("caf\xc3\xa9") == "caf\xc3\xa9");
}

TEST_CASE("names of a description become names of BIP") {
  CHECK(bip_name("end") == "end_");
  CHECK(bip_name("laser-rf") == "laser_rf");
  CHECK(type_name("laser_rf2") == "LaserRf2");
  Scope scope;
  CHECK(scope.claim("a", "task") == "a");
  CHECK(scope.claim("a", "task") == "a_task");
  CHECK(scope.claim("a", "task") == "a_task2");
}

TEST_CASE("the generation is told by what stands at the top level") {
  SourceMap sources;
  Diagnostics diags;
  const auto module_of = [&](const std::string& text) {
    return read_module(sources, {"/nowhere/m.gen", sources.add("m.gen", text)}, {}, diags);
  };
  CHECK(module_of("module m { number: 1; internal_data: D; };").generation == 2);
  const Module m = module_of("component c { task t { period 2 ms; codel<start> f() yield ether; }; };");
  CHECK(m.generation == 3);
  REQUIRE(m.tasks.size() == 1);
  CHECK(m.tasks[0].period_us == 2000);
  CHECK_FALSE(diags.has_errors());
}
