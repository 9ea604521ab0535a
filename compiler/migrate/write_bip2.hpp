// Writes a BIP1 model in BIP2.
#pragma once
#include <string>

#include "compiler/diag/diagnostics.hpp"
#include "compiler/syntax/bip1.hpp"

namespace bip::migrate {

struct Bip2Text {
  std::string bip;     // parses as BIP2; not in house style
  std::string header;  // C++; empty: the model needs none
  std::string source;  // C++ beside `header`
};

/// Reports each construct without counterpart (B6140), which is a comment in the text. `stem`: the C++ files are called
/// `stem.hpp` and `stem.cpp`. Linear in the model.
[[nodiscard]] Bip2Text write_bip2(const syntax::bip1::Model& model, const SourceMap& sources, const std::string& stem,
                                  Diagnostics& diags);

}  // namespace bip::migrate
