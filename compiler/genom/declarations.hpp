// Names that one scope declares once.
#pragma once
#include <map>
#include <string>
#include <utility>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/source/source.hpp"

namespace bip::genom {

class Declarations {
 public:
  /// Reports a second declaration of `scoped_name` (B6013), with `kind` and `name` for the reader. A file that is
  /// included twice declares nothing twice: its second reading has the same offsets.
  void add(Diagnostics& diags, const char* kind, const std::string& name, std::string scoped_name, SourceRange range) {
    const auto [known, is_new] = ranges_.try_emplace(std::move(scoped_name), range);
    const SourceRange& first = known->second;
    if (is_new || (first.begin == range.begin && first.end == range.end)) return;
    diags.report(Diag::kB6013, range, kind, name).label(first, "the first one");
  }

 private:
  std::map<std::string, SourceRange> ranges_;
};

}  // namespace bip::genom
