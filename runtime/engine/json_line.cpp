// See json_line.hpp.
#include "runtime/engine/json_line.hpp"

#include <charconv>

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"

namespace bip::rt {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

void append_utf8(std::string& out, std::uint32_t code) {
  BIP_ASSERT(code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF), "the code {} is no character", code);
  if (code < 0x80) {
    out += static_cast<char>(code);
    return;
  }
  const int more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
  constexpr std::uint32_t kLead[] = {0, 0xC0, 0xE0, 0xF0};
  out += static_cast<char>(kLead[more] | code >> (6 * more));
  for (int k = more - 1; k >= 0; --k) out += static_cast<char>(0x80 | (code >> (6 * k) & 0x3F));
}

}  // namespace

void JsonLine::fail(std::string what) {
  BIP_ASSERT(at_ <= text_.size(), "position {} of {}", at_, text_.size());
  if (!ok()) return;
  error_ = std::move(what) + " (column ";
  append_number(error_, at_ + 1);
  error_ += ')';
}

void JsonLine::skip_space() {
  while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r' || text_[at_] == '\n'))
    ++at_;
}

JsonLine::Kind JsonLine::kind() {
  skip_space();
  if (!ok() || at_ >= text_.size()) return Kind::Other;
  switch (text_[at_]) {
    case '{': return Kind::Object;
    case '[': return Kind::Array;
    case '"': return Kind::String;
    case 't':
    case 'f': return Kind::Bool;
    case 'n': return Kind::Null;
    default: return text_[at_] == '-' || is_digit(text_[at_]) ? Kind::Number : Kind::Other;
  }
}

bool JsonLine::try_take(char sign) {
  skip_space();
  if (!ok() || at_ >= text_.size() || text_[at_] != sign) return false;
  ++at_;
  return true;
}

bool JsonLine::take(char sign) {
  if (try_take(sign)) return true;
  fail(std::string("`") + sign + "` was expected");
  return false;
}

bool JsonLine::take_word(std::string_view word) {
  if (text_.substr(at_, word.size()) != word) return false;
  at_ += word.size();
  return true;
}

bool JsonLine::boolean() {
  if (kind() == Kind::Bool) {
    if (take_word("true")) return true;
    if (take_word("false")) return false;
  }
  fail("true or false was expected");
  return false;
}

bool JsonLine::hex(std::uint32_t& value) {
  const char* const first = text_.data() + at_;
  if (text_.size() - at_ < 4) return false;
  value = 0;
  const auto read = std::from_chars(first, first + 4, value, 16);
  at_ += 4;
  return read.ec == std::errc() && read.ptr == first + 4;
}

bool JsonLine::escape(std::string& out) {
  constexpr std::string_view kSigns = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
  if (at_ >= text_.size()) return false;
  const char sign = text_[at_++];
  if (const std::size_t k = kSigns.find(sign); k != std::string_view::npos) {
    out += kMeant[k];
    return true;
  }
  std::uint32_t code = 0, low = 0;
  if (sign != 'u' || !hex(code)) return false;
  if (code >= 0xD800 && code < 0xDC00) {
    // Half of a pair.
    if (!take_word("\\u") || !hex(low) || low < 0xDC00 || low > 0xDFFF) return false;
    code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
  } else if (code >= 0xDC00 && code < 0xE000) {
    return false;
  }
  append_utf8(out, code);
  return true;
}

std::string JsonLine::string() {
  std::string out;
  if (kind() != Kind::String) {
    fail("a string was expected");
    return out;
  }
  for (++at_; at_ < text_.size();) {
    const char c = text_[at_++];
    if (c == '"') return out;
    if (c == '\\') {
      if (!escape(out)) break;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      break;
    } else {
      out += c;
    }
  }
  fail("the string does not end well");
  return {};
}

std::string_view JsonLine::number() {
  if (kind() != Kind::Number) {
    fail("a number was expected");
    return {};
  }
  const std::size_t first = at_;
  const auto digits = [this] {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_digit(text_[at_])) ++at_;
    return at_ > begin;
  };
  BIP_ASSERT(at_ < text_.size(), "a number at {} of {}", at_, text_.size());
  if (text_[at_] == '-') ++at_;
  const bool leads_with_zero = at_ < text_.size() && text_[at_] == '0';
  const std::size_t whole = at_;
  bool good = digits() && !(leads_with_zero && at_ - whole > 1);
  if (good && at_ < text_.size() && text_[at_] == '.') {
    ++at_;
    good = digits();
  }
  if (good && at_ < text_.size() && (text_[at_] == 'e' || text_[at_] == 'E')) {
    ++at_;
    if (at_ < text_.size() && (text_[at_] == '+' || text_[at_] == '-')) ++at_;
    good = digits();
  }
  if (!good) fail("a number was expected");
  return good ? text_.substr(first, at_ - first) : std::string_view();
}

std::int64_t JsonLine::integer() {
  const std::string_view text = number();
  std::int64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ok() && (read.ec != std::errc() || read.ptr != text.data() + text.size())) fail("a whole number was expected");
  return value;
}

double JsonLine::real() {
  const std::string_view text = number();
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (ok() && read.ec != std::errc()) fail("the number is too large");
  return value;
}

std::string JsonLine::first_key() const {
  JsonLine ahead(text_.substr(at_));
  return ahead.open('{') ? ahead.string() : std::string();
}

bool JsonLine::at_end() {
  skip_space();
  if (ok() && at_ < text_.size()) fail("nothing more was expected");
  return ok();
}

}  // namespace bip::rt
