// Why a line of a client is no object of JSON.
#pragma once
#include <string>

namespace bip::serve {

struct LineCheck {
  bool is_object = false;  // it begins as an object, and no character of it breaks the rules of JSON
  std::string problem;     // a sentence; empty: it is one, and holds what can be read
};

/// O(line). Requires that it is not nested deeper than the stack allows.
[[nodiscard]] LineCheck check_line(const std::string& line);

}  // namespace bip::serve
