// What is tried with any bytes at all. Each function returns what is wrong in one line, empty if nothing is; a crash, a
// sanitizer's report or a failed BIP_ASSERT speaks for itself.
//
// The same functions run in three places: under libFuzzer (preset `fuzz`), over the kept crashers and over random edits of
// good sources (`bip-fuzz`, in every test run).
#pragma once
#include <string>
#include <string_view>

namespace bip::fuzz {

/// Text -> tree -> model -> system: a diagnostic or a system, never both, never neither; a system is sound, can be written
/// and read back, and can be lowered.
[[nodiscard]] std::string try_text(std::string_view input);

/// `.bsys`: a failure with a place, or a system that is sound and whose text reads back as itself.
[[nodiscard]] std::string try_bsys(std::string_view input);

/// The formatter: what parses prints as something that parses, and that prints as itself.
[[nodiscard]] std::string try_format(std::string_view input);

/// "text", "bsys" or "format"; nullptr for another name.
using Target = std::string (*)(std::string_view);
[[nodiscard]] Target find_target(std::string_view name);

}  // namespace bip::fuzz
