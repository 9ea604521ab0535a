// Reads one line of JSON whose shape is known: a cursor with a function for each thing that may come next. Strict (RFC
// 8259), never recursive, allocates only strings. The first thing that is wrong is remembered and everything after it
// is refused, so callers check once.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace bip::rt {

class JsonLine {
 public:
  explicit JsonLine(std::string_view text) : text_(text) {}

  enum class Kind : std::uint8_t { Object, Array, String, Number, Bool, Null, Other };
  /// Of what comes next.
  [[nodiscard]] Kind kind();
  /// Takes `sign`, one of `{}[]:,`; an error if something else comes.
  bool take(char sign);
  /// Takes it if it comes.
  bool try_take(char sign);
  std::string string();
  bool boolean();
  /// A number as it is written, checked.
  std::string_view number();
  /// A number without fraction and exponent that fits.
  std::int64_t integer();
  double real();
  /// Of an object that comes next; nothing is taken. Empty: there is none.
  [[nodiscard]] std::string first_key() const;
  /// Nothing but white space is left.
  bool at_end();

  /// Steps through the members of an object: `for (bool more = j.open('{'); more; more = j.next('}'))`.
  bool open(char bracket) { return take(bracket) && !try_take(bracket == '{' ? '}' : ']'); }
  bool next(char bracket) { return ok() && (try_take(',') || (take(bracket) && false)); }

  [[nodiscard]] bool ok() const { return error_.empty(); }
  void fail(std::string what);
  /// "a string was expected (column 7)"
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  void skip_space();
  bool take_word(std::string_view word);
  bool escape(std::string& out);
  bool hex(std::uint32_t& value);

  std::string_view text_;
  std::size_t at_ = 0;
  std::string error_;
};

}  // namespace bip::rt
