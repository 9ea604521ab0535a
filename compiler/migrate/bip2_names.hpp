// Names of BIP1 that are reserved words of BIP2 get an underscore; new names differ from all of the source.
#pragma once
#include <set>
#include <string>
#include <string_view>

#include "compiler/syntax/bip1.hpp"

namespace bip::migrate {

class Bip2Names {
 public:
  /// `text`: the whole source; every word of it counts as a name.
  explicit Bip2Names(std::string_view text);
  [[nodiscard]] std::string name(std::string_view bip1) const;
  [[nodiscard]] std::string path(const syntax::bip1::Path& path) const;
  /// `wish`, or with a number behind it. Not given twice.
  [[nodiscard]] std::string fresh(std::string wish);

 private:
  std::set<std::string, std::less<>> taken_;
};

}  // namespace bip::migrate
