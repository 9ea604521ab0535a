// See check_line.hpp. Events of the library's parser: its own way without exceptions says of a line only that it is
// not sound.
#include "compiler/serve/check_line.hpp"

#include <nlohmann/json.hpp>

namespace bip::serve {

namespace {

using Json = nlohmann::ordered_json;
constexpr int kOutOfRange = 406;  // the library's number for this error

// Takes values of all kinds, and notes what the outermost one is and where the parser stops.
class Check final : public nlohmann::json_sax<Json> {
 public:
  explicit Check(std::size_t size) : size_(size) {}
  [[nodiscard]] LineCheck take() { return std::move(check_); }

  bool null() override { return note(false); }
  bool boolean(bool) override { return note(false); }
  bool number_integer(number_integer_t) override { return note(false); }
  bool number_unsigned(number_unsigned_t) override { return note(false); }
  bool number_float(number_float_t, const string_t&) override { return note(false); }
  bool string(string_t&) override { return note(false); }
  bool binary(binary_t&) override { return note(false); }
  bool start_object(std::size_t) override { return note(true); }
  bool key(string_t&) override { return true; }
  bool end_object() override { return true; }
  bool start_array(std::size_t) override { return note(false); }
  bool end_array() override { return true; }
  bool parse_error(std::size_t position, const std::string& token, const nlohmann::detail::exception& error) override {
    const bool is_number = error.id == kOutOfRange;
    if (!is_number) check_.is_object = false;
    if (is_number) check_.problem = "the number " + token + " is too large";
    else if (position > size_) check_.problem = "a line is an object of JSON: this one ends too early";
    else
      check_.problem =
          "a line is an object of JSON: character " + std::to_string(position) + " is not what can stand there";
    return false;
  }

 private:
  bool note(bool is_object) {
    if (!is_first_) return true;
    is_first_ = false;
    check_.is_object = is_object;
    if (!is_object) check_.problem = "a line is an object of JSON";
    return is_object;
  }

  std::size_t size_;  // of the line
  LineCheck check_;
  bool is_first_ = true;
};

}  // namespace

LineCheck check_line(const std::string& line) {
  Check check(line.size());
  (void)Json::sax_parse(line, &check);
  return check.take();
}

}  // namespace bip::serve
