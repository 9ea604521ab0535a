// What is tried with any bytes at all. A crash, a sanitizer's report or a failed BIP_ASSERT speaks for itself; the
// other things that can be wrong are returned.
//
// The same functions run in three places: under libFuzzer (preset `fuzz`), over the kept crashers and over random edits
// of good sources (`bip-fuzz`, in every test run).
#pragma once
#include <string>
#include <string_view>

namespace bip::fuzz {

struct Verdict {
  std::string problem;       // one line; empty: nothing is wrong
  bool is_accepted = false;  // the input was good, so that all of the target was tried
};

/// Longest generated BIP text, in bytes, that a target checks: a check costs time linear in the text.
inline constexpr std::size_t kMaxBip = 400'000;
/// Returns the text up to its first line break.
[[nodiscard]] inline std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// `check` of a text: errors that can be read, or acceptance, never both, never neither. The system of each root is
/// sound, can be written and read back, and runs 20 steps in the interpreter.
[[nodiscard]] Verdict try_text(std::string_view input);

/// `.bsys`: a failure with a place, or a system that is sound, whose text reads back as itself, and that runs 20 steps.
[[nodiscard]] Verdict try_bsys(std::string_view input);

/// The formatter: what parses prints as something that parses, and that prints as itself.
[[nodiscard]] Verdict try_format(std::string_view input);

/// The language server: whatever comes, what it sends is JSON, nothing is an internal error, and the session goes on.
[[nodiscard]] Verdict try_lsp(std::string_view input);

/// `bipc genom`: errors that can be read, or BIP that `check` accepts without a warning.
[[nodiscard]] Verdict try_genom(std::string_view input);

/// `bipc rules` over two modules, likewise.
[[nodiscard]] Verdict try_rules(std::string_view input);

/// Properties for `verify` and `explore`: an error with its column, or one that can be evaluated, encoded and written.
[[nodiscard]] Verdict try_property(std::string_view input);

/// What peers of a distributed run send: a frame or a greeting that can be written and read again, or nothing.
[[nodiscard]] Verdict try_frame(std::string_view input);

/// `bipc migrate` of BIP1: an error that can be read, or BIP2 that parses, with all comments.
[[nodiscard]] Verdict try_bip1(std::string_view input);

/// "text", "bsys", "format", "lsp", "genom", "rules", "property", "frame" or "bip1"; nullptr for another name.
using Target = Verdict (*)(std::string_view);
[[nodiscard]] Target find_target(std::string_view name);

}  // namespace bip::fuzz
