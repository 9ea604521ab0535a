// Reads commands: on a terminal with editing, history and completion (libedit, if it is built in), else lines as they
// come. The only folder that includes libedit.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace bip::debug {

class LineReader {
 public:
  /// Offers the words that begin with `word`, for Tab.
  using Complete = std::function<std::vector<std::string>(const std::string& word)>;
  explicit LineReader(Complete complete);
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;
  ~LineReader();

  [[nodiscard]] bool is_terminal() const { return is_terminal_; }
  /// The next line without its end; nothing at the end of the input.
  [[nodiscard]] std::optional<std::string> read(const std::string& prompt);

 private:
  Complete complete_;
  bool is_terminal_;
};

}  // namespace bip::debug
