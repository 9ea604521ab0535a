// Diagnostics as data: what is wrong, where, why, and how to correct it. Renderers turn them into text.
//
// Codes live in kinds.def. A stage reports through `Diagnostics::report(Kind, range, args...)` and adds labels, notes
// and helps to the result. Output is in source order, duplicates at one place are dropped, and at most 20 errors are
// printed (the rest is counted).
#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/source.hpp"

namespace bip {

enum class Severity : std::uint8_t { Error, Warning };

enum class Diag : std::uint16_t {
#define BIP_DIAG(code, severity, slug, message) k##code,
#include "compiler/diag/kinds.def"
#undef BIP_DIAG
};

struct DiagInfo {
  const char* code;  // "B1003"
  Severity severity;
  const char* slug;     // "unknown-name"; for warnings also the name in @SuppressWarning if it has one
  const char* message;  // fmt format string
};
[[nodiscard]] const DiagInfo& info(Diag kind);
/// All kinds in the order of kinds.def.
[[nodiscard]] const std::vector<Diag>& all_diags();
[[nodiscard]] std::optional<Diag> find_diag(std::string_view code);

struct Label {
  SourceRange range;
  std::string text;
};
struct Help {
  std::string text;
  // The replacement that would mend it: empty range = no edit.
  SourceRange replace;
  std::string with;
};
struct Diagnostic {
  Diag kind;
  Severity severity;
  SourceRange range;
  std::string message;
  std::string label;  // text under the primary range, may be empty
  std::vector<Label> labels;
  std::vector<std::string> notes;
  std::vector<Help> helps;
};

/// Builder over the diagnostic that `report` just added. Use at once, do not keep.
class DiagnosticBuilder {
 public:
  explicit DiagnosticBuilder(Diagnostic& d) : diagnostic_(&d) {}
  DiagnosticBuilder& label(std::string text) {
    diagnostic_->label = std::move(text);
    return *this;
  }
  DiagnosticBuilder& label(SourceRange at, std::string text) {
    diagnostic_->labels.push_back({at, std::move(text)});
    return *this;
  }
  DiagnosticBuilder& note(std::string text) {
    diagnostic_->notes.push_back(std::move(text));
    return *this;
  }
  DiagnosticBuilder& help(std::string text) {
    diagnostic_->helps.push_back({std::move(text), {}, {}});
    return *this;
  }
  DiagnosticBuilder& help(std::string text, SourceRange replace, std::string with) {
    diagnostic_->helps.push_back({std::move(text), replace, std::move(with)});
    return *this;
  }

 private:
  Diagnostic* diagnostic_;
};

class Diagnostics {
 public:
  template <class... Args>
  DiagnosticBuilder report(Diag kind, SourceRange range, const Args&... args) {
    return add(kind, range, fmt::format(fmt::runtime(info(kind).message), args...));
  }
  DiagnosticBuilder add(Diag kind, SourceRange range, std::string message);

  [[nodiscard]] bool has_errors() const { return error_count_ > 0; }
  [[nodiscard]] std::size_t error_count() const { return error_count_; }
  [[nodiscard]] std::size_t warning_count() const { return warning_count_; }
  /// In source order (file, offset, then as reported), without exact duplicates.
  [[nodiscard]] std::vector<const Diagnostic*> sorted() const;

 private:
  std::vector<std::unique_ptr<Diagnostic>> all_;
  std::size_t error_count_ = 0;
  std::size_t warning_count_ = 0;
};

enum class Color : std::uint8_t { Off, On };
enum class DiagnosticFormat : std::uint8_t { Frame, Short, Json, Sarif };
struct RenderOptions {
  DiagnosticFormat format = DiagnosticFormat::Frame;
  Color color = Color::Off;
  std::size_t max_errors = 20;
};
/// The text of all diagnostics, closing line included ("2 errors, 1 warning"); empty if there are none.
[[nodiscard]] std::string render(const Diagnostics& diags, const SourceMap& sources, const RenderOptions& options);

/// The names among `known` that a person may have meant by `wrong` (edit distance), best first, at most 2.
[[nodiscard]] std::vector<std::string> similar_names(std::string_view wrong, const std::vector<std::string>& known);

}  // namespace bip
