// See plain_name.hpp.
#include "compiler/exchange/plain_name.hpp"

#include <string_view>

namespace bip::exchange {

std::string plain_name(const std::string& name) {
  std::string out = name;
  for (char& c : out) {
    const bool stays = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("_.[](), -").find(c) != std::string_view::npos;
    if (!stays) c = '_';
  }
  return out;
}

}  // namespace bip::exchange
