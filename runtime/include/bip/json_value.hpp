// JSON as a value, for inputs of requests. Header only; reading throws.
#pragma once
#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bip {

/// A JSON value. Numbers stay texts, so that 64 bits are kept.
struct JsonMember;
struct JsonValue {
  enum class Kind { Null, Bool, Number, Text, Array, Object } kind = Kind::Null;
  bool is_true = false;
  std::string text;
  std::vector<JsonValue> items;
  std::vector<JsonMember> members;
  [[nodiscard]] const JsonValue* find(std::string_view name) const;
};
struct JsonMember {
  std::string name;
  JsonValue value;
};
inline const JsonValue* JsonValue::find(std::string_view name) const {
  for (const JsonMember& member : members) {
    if (member.name == name) return &member.value;
  }
  return nullptr;
}

/// Throws std::runtime_error with what is wrong and where.
class JsonReader {
 public:
  static JsonValue read(std::string_view text) {
    JsonReader reader(text);
    JsonValue value = reader.value(0);
    reader.blanks();
    if (reader.at_ != text.size()) reader.fail("nothing more");
    return value;
  }

 private:
  explicit JsonReader(std::string_view text) : text_(text) {}
  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error(std::string("this is no JSON: expected ") + what + " at byte " + std::to_string(at_));
  }
  void blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
  }
  bool accept(char c) {
    blanks();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c, const char* what) {
    if (!accept(c)) fail(what);
  }
  bool accept_word(std::string_view word) {
    if (text_.substr(at_, word.size()) != word) return false;
    at_ += word.size();
    return true;
  }
  JsonValue value(int depth) {
    if (depth > 64) fail("a value that is not so deep");
    JsonValue v;
    if (accept('{')) {
      v.kind = JsonValue::Kind::Object;
      while (!accept('}')) {
        if (!v.members.empty()) expect(',', "`,`");
        std::string name = string();
        expect(':', "`:`");
        v.members.push_back({std::move(name), value(depth + 1)});
      }
      return v;
    }
    if (accept('[')) {
      v.kind = JsonValue::Kind::Array;
      while (!accept(']')) {
        if (!v.items.empty()) expect(',', "`,`");
        v.items.push_back(value(depth + 1));
      }
      return v;
    }
    if (at_ < text_.size() && text_[at_] == '"') {
      v.kind = JsonValue::Kind::Text;
      v.text = string();
      return v;
    }
    if (accept_word("null")) return v;
    if (accept_word("true") || accept_word("false")) {
      v.kind = JsonValue::Kind::Bool;
      v.is_true = text_[at_ - 2] == 'u';
      return v;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && std::string_view("+-.eE0123456789").find(text_[at_]) != std::string_view::npos) ++at_;
    if (begin == at_) fail("a value");
    v.kind = JsonValue::Kind::Number;
    v.text = text_.substr(begin, at_ - begin);
    return v;
  }
  std::string string() {
    expect('"', "a text");
    std::string out;
    while (true) {
      if (at_ >= text_.size()) fail("`\"`");
      const char c = text_[at_++];
      if (c == '"') return out;
      if (c != '\\') {
        out += c;
        continue;
      }
      const char escape = at_ < text_.size() ? text_[at_++] : ' ';
      constexpr std::string_view kEscapes = "\"\\/bfnrt", kMeanings = "\"\\/\b\f\n\r\t";
      if (escape == 'u') code_point(out);
      else if (const std::size_t known = kEscapes.find(escape); known != std::string_view::npos)
        out += kMeanings[known];
      else fail("an escape of JSON");
    }
  }
  unsigned unit() {
    unsigned code = 0;
    const char* const begin = text_.data() + at_;
    if (at_ + 4 > text_.size() || std::from_chars(begin, begin + 4, code, 16).ptr != begin + 4) fail("four hex digits");
    at_ += 4;
    return code;
  }
  void code_point(std::string& out) {
    unsigned code = unit();
    if (code >= 0xd800 && code < 0xdc00 && accept_word("\\u"))
      code = 0x10000 + ((code - 0xd800) << 10) + (unit() & 0x3ff);
    const auto byte = [&](unsigned value) { out += static_cast<char>(value); };
    if (code < 0x80) return byte(code);
    if (code < 0x800) byte(0xc0 | (code >> 6));
    else if (code < 0x10000) byte(0xe0 | (code >> 12)), byte(0x80 | ((code >> 6) & 0x3f));
    else byte(0xf0 | (code >> 18)), byte(0x80 | ((code >> 12) & 0x3f)), byte(0x80 | ((code >> 6) & 0x3f));
    byte(0x80 | (code & 0x3f));
  }
  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace bip
