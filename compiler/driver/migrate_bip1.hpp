// BIP1 to BIP2, for `bipc migrate`.
#pragma once
#include <optional>
#include <string>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

struct Bip1Migration {
  std::string text;                      // in house style
  std::string header, source;            // C++; empty: none
  std::string header_path, source_path;  // beside the output
};

/// Migrates the source of `c`, a file of BIP1; nothing after an error of syntax. Constructs without counterpart are
/// errors in `c`, and comments in the text. `output`: where the text will be.
[[nodiscard]] std::optional<Bip1Migration> migrate_bip1(pipeline::Compilation& c, const std::string& output);

/// Writes the C++ files. False after a report: they cannot be written, or are there and not ours.
[[nodiscard]] bool write_cpp_files(pipeline::Compilation& c, const Bip1Migration& migration);

}  // namespace bip::driver
