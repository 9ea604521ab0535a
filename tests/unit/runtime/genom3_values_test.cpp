// Values of GenoM 3's types in both mappings, C and C++: JSON, copies, and the bytes that are the same for both
// (bip/genom3_values.hpp, bip/genom3_bytes.hpp). The types are written as `bipc genom --codels` writes them.
#include <catch2/catch.hpp>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "bip/genom3_bytes.hpp"

// Of the file that `bipc genom --codels` writes.
extern "C" const genom_event genom_no_such_outport_id = "::genom::no_such_outport",
                             genom_no_such_inport_id = "::genom::no_such_inport";

namespace in_both {
enum Hue { RED, GREEN };
inline auto genom_enumerators(Hue) {
  static constexpr std::pair<const char*, Hue> kRows[] = {{"RED", RED}, {"GREEN", GREEN}};
  return std::span(kRows);
}
}  // namespace in_both
using in_both::Hue;

namespace in_cxx {
struct Named {
  double x{};
  std::string s{};
};
struct Point {
  double x{}, y{};
};
class Choice {
 public:
  Choice() { _d(Hue{}); }
  [[nodiscard]] Hue _d() const { return d_; }
  void _d(Hue d) {
    d_ = d;
    if (d == in_both::RED) {
      if (u_.index() != 1) u_.template emplace<1>();
    } else if (u_.index() != 2) {
      u_.template emplace<2>();
    }
  }
  double& a() { return std::get<1>(u_); }
  std::string& b() { return std::get<2>(u_); }

 private:
  Hue d_{};
  std::variant<std::monostate, double, std::string> u_;
};
struct All {
  std::vector<Named> list{};
  genom::bounded_vector<Point, 3> few{};
  genom::bounded_string<8> name{};
  std::optional<double> maybe{};
  std::array<std::array<int, 2>, 2> table{};
  std::vector<bool> flags{};
  Choice choice{};
  Hue hue{};
  bool is_so{};
};
template <class F>
void genom_cxx_members(Named& v, F f) {
  f("x", v.x), f("s", v.s);
}
template <class F>
void genom_cxx_members(Point& v, F f) {
  f("x", v.x), f("y", v.y);
}
template <class F>
void genom_cxx_members(Choice& v, F f) {
  auto d = v._d();
  f("_d", d);
  v._d(d);
  d == in_both::RED ? f("a", v.a()) : f("b", v.b());
}
template <class F>
void genom_cxx_members(All& v, F f) {
  f("list", v.list), f("few", v.few), f("name", v.name), f("maybe", v.maybe), f("table", v.table), f("flags", v.flags);
  f("choice", v.choice), f("hue", v.hue), f("is_so", v.is_so);
}
}  // namespace in_cxx

namespace in_c {
struct Named {
  double x;
  char* s;
};
struct Point {
  double x, y;
};
struct Choice {
  Hue _d;
  union {
    double a;
    char* b;
  } _u;
};
template <class T>
struct Sequence {
  uint32_t _maximum, _length;
  T* _buffer;
  void (*_release)(void*);
};
struct Few {
  uint32_t _maximum, _length;
  Point _buffer[3];
};
struct Maybe {
  bool _present;
  double _value;
};
struct All {
  Sequence<Named> list;
  Few few;
  char name[9];
  Maybe maybe;
  int table[2][2];
  Sequence<bool> flags;
  Choice choice;
  Hue hue;
  bool is_so;
};
template <class F>
void genom_members(Named& v, F f) {
  f("x", v.x), f("s", v.s);
}
template <class F>
void genom_members(Point& v, F f) {
  f("x", v.x), f("y", v.y);
}
template <class F>
void genom_members(Choice& v, F f) {
  f("_d", v._d);
  v._d == in_both::RED ? f("a", v._u.a) : f("b", v._u.b);
}
template <class F>
void genom_members(All& v, F f) {
  f("list", v.list), f("few", v.few), f("name", v.name), f("maybe", v.maybe), f("table", v.table), f("flags", v.flags);
  f("choice", v.choice), f("hue", v.hue), f("is_so", v.is_so);
}
}  // namespace in_c

namespace {

namespace values3 = bip::genom3;

constexpr const char* kValue =
    R"({"list":[{"x":1,"s":"a"},{"x":2,"s":"bb"}],"few":[{"x":1,"y":2}],"name":"eight888","maybe":3,"table":[[1,2],[3,4]],)"
    R"("flags":[true,false,true],"choice":{"_d":"GREEN","b":"hello"},"hue":"GREEN","is_so":true})";
constexpr const char* kNothing =
    R"({"list":[],"few":[],"name":"","maybe":null,"table":[[0,0],[0,0]],"flags":[],"choice":{"_d":"RED","a":0},"hue":"RED","is_so":false})";

template <class T>
std::string json_of(const T& v) {
  std::string out;
  values3::to_json(out, v);
  return out;
}
template <class T>
std::string problem_of(const std::string& text) {
  T v{};
  values3::clear(v);
  std::string problem;
  try {
    values3::from_json(values3::JsonReader::read(text), v, "v");
  } catch (const std::runtime_error& wrong) {
    problem = wrong.what();
  }
  values3::release(v);
  return problem;
}

}  // namespace

TEST_CASE("genom3 values: both mappings read and write the same JSON") {
  in_cxx::All cxx;
  in_c::All c;
  values3::clear(c);
  CHECK(json_of(cxx) == kNothing);
  CHECK(json_of(c) == kNothing);
  values3::from_json(values3::JsonReader::read(kValue), cxx, "v");
  values3::from_json(values3::JsonReader::read(kValue), c, "v");
  CHECK(json_of(cxx) == kValue);
  CHECK(json_of(c) == kValue);
  values3::clear(cxx);
  CHECK(json_of(cxx) == kNothing);
  values3::release(c);
}

TEST_CASE("genom3 values: both mappings refuse the same JSON") {
  for (const char* text :
       {R"({"list":3})", R"({"few":[{},{},{},{}]})", R"({"name":"nine99999"})", R"({"maybe":true})",
        R"({"table":[[1,2]]})", R"({"table":[[1,2],[3,4.5]]})", R"({"flags":[0]})", R"({"choice":{"_d":"BLUE"}})",
        R"({"choice":{"_d":"RED","b":"x"}})", R"({"hue":7})", R"({"gone":1})", R"({"list":[{"s":1}]})",
        R"({"name":"a\u0000b"})", R"({"list":[{"s":"a\u0000"}]})", R"({"maybe":1e400})"}) {
    CAPTURE(text);
    CHECK(problem_of<in_cxx::All>(text) == problem_of<in_c::All>(text));
    CHECK(!problem_of<in_cxx::All>(text).empty());
  }
}

TEST_CASE("genom3 values: numbers are in the range of their type") {
  CHECK(problem_of<float>("1e39") == "`v` is a number from -3.4028235e+38 to 3.4028235e+38");
  CHECK(problem_of<float>("-3.5e38") == "`v` is a number from -3.4028235e+38 to 3.4028235e+38");
  CHECK(problem_of<double>("1e309") == "`v` is a number from -1.7976931348623157e+308 to 1.7976931348623157e+308");
  CHECK(problem_of<float>("\"1\"") == "`v` is a number");
  CHECK(problem_of<std::uint8_t>("256") == "`v` is a whole number from 0 to 255");
  CHECK(problem_of<std::int16_t>("-32769") == "`v` is a whole number from -32768 to 32767");
  for (const char* text : {"3.4028235e+38", "-3.4028235e+38", "1e-46", "-1e-300", "1e-400", "0", "1e-45"}) {
    CAPTURE(text);
    CHECK(problem_of<float>(text).empty());
    CHECK(problem_of<double>(text).empty());
  }
  float small = 1;
  values3::from_json(values3::JsonReader::read("1e-60"), small, "v");
  CHECK(small == 0);
}

TEST_CASE("genom3 values: bytes of one mapping are read by the other") {
  in_cxx::All cxx;
  values3::from_json(values3::JsonReader::read(kValue), cxx, "v");
  std::string bytes, again;
  values3::put(bytes, cxx);
  in_c::All c;
  values3::clear(c);
  bip::processes::Taker taker(bytes);
  REQUIRE(values3::take(taker, c));
  CHECK(taker.rest().empty());
  CHECK(json_of(c) == kValue);
  values3::put(again, c);
  CHECK(again == bytes);
  in_cxx::All back;
  bip::processes::Taker other(again);
  REQUIRE(values3::take(other, back));
  CHECK(json_of(back) == kValue);
  values3::release(c);
}

TEST_CASE("genom3 values: bytes that end too early are none") {
  in_cxx::All cxx;
  values3::from_json(values3::JsonReader::read(kValue), cxx, "v");
  std::string bytes;
  values3::put(bytes, cxx);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string_view cut = std::string_view(bytes).substr(0, size);
    bip::processes::Taker one(cut), two(cut);
    in_cxx::All into;
    in_c::All other;
    values3::clear(other);
    CHECK(!values3::take(one, into));
    CHECK(!values3::take(two, other));
    values3::release(other);
  }
}

TEST_CASE("genom3 values: what is bounded says when it is full") {
  genom::bounded_vector<int, 2> two{1, 2};
  CHECK_THROWS_AS(two.push_back(3), std::length_error);
  CHECK_THROWS_AS(two.resize(3), std::length_error);
  CHECK_THROWS_AS(two.at(2), std::out_of_range);
  two.pop_back();
  CHECK(two == genom::bounded_vector<int, 2>{1});
  genom::bounded_string<3> text = "abc";
  CHECK_THROWS_AS(text.assign("abcd"), std::length_error);
  CHECK(text.str() == "abc");
  text = std::string("x");
  CHECK((text.size() == 1 && text == genom::bounded_string<3>("x")));
}
