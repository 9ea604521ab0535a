// See load_properties.hpp. The text between the braces is what a compound may state: the same function expands it.
#include "compiler/pipeline/load_properties.hpp"

#include <algorithm>
#include <string_view>

#include "compiler/base/ascii.hpp"
#include "compiler/pipeline/check_properties.hpp"
#include "compiler/system/expand_property.hpp"
#include "compiler/system/system.hpp"

namespace bip::pipeline {

namespace {

class PropertyFileReader {
 public:
  PropertyFileReader(Compilation& c, FileId file) : compilation_(c), file_(file), text_(c.sources.text(file)) {}

  bool run() {
    for (skip_blanks(); at_ < text_.size(); skip_blanks()) {
      if (!read_property()) return false;
    }
    return true;
  }

 private:
  void skip_blanks() {
    while (at_ < text_.size()) {
      const std::string_view two = text_.substr(at_, 2);
      if (two == "//" || two == "/*") {
        const std::size_t end = text_.find(two == "//" ? "\n" : "*/", at_ + 2);
        at_ = end == std::string_view::npos ? text_.size() : end + (two == "//" ? 1 : 2);
      } else if (two.find_first_of(" \t\r\n") == 0) {
        ++at_;
      } else {
        return;
      }
    }
  }
  std::string_view word() {
    const std::size_t first = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || text_[at_] == '_' || is_digit(text_[at_]))) ++at_;
    return text_.substr(first, at_ - first);
  }
  // The brace that closes a property, outside of comments and strings.
  [[nodiscard]] std::size_t find_brace(std::size_t at) const {
    for (; at < text_.size() && text_[at] != '}'; ++at) {
      const std::string_view two = text_.substr(at, 2);
      const std::string_view close = two == "//" ? "\n" : two == "/*" ? "*/" : text_[at] == '"' ? "\"" : "";
      if (close.empty()) continue;
      at = text_.find(close, at + (text_[at] == '"' ? 1 : 2));
      if (at == std::string_view::npos) return at;
      at += close.size() - 1;
    }
    return at < text_.size() ? at : std::string_view::npos;
  }
  [[nodiscard]] SourceRange range(std::size_t begin, std::size_t end) const {
    return {file_, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end)};
  }
  bool fail(std::size_t at, const char* what) {
    compilation_.diags.report(Diag::kB4031, range(at, std::min(std::max(at_, at + 1), text_.size())), what);
    return false;
  }

  bool read_property() {
    const std::size_t start = at_;
    if (word() != "property") return fail(start, "`property` was expected here");
    skip_blanks();
    const std::size_t name_begin = at_;
    const std::string name(word());
    if (name.empty()) return fail(name_begin, "the name of a property was expected here");
    const std::size_t name_end = at_;
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != '{') return fail(at_, "`{` was expected here");
    const std::size_t begin = ++at_;
    const std::size_t end = find_brace(begin);
    if (end == std::string_view::npos) return fail(begin - 1, "no `}` closes this property");
    at_ = end + 1;
    std::vector<StatedProperty>& properties = compilation_.system->properties;
    if (std::any_of(properties.begin(), properties.end(), [&](const StatedProperty& p) { return p.name == name; })) {
      compilation_.diags.report(Diag::kB4015, range(name_begin, name_end), name);
      return false;
    }
    Result<system::ExpandedProperty> expanded = system::expand_property(text_.substr(begin, end - begin), "", {}, {});
    if (!expanded) {
      compilation_.diags.report(Diag::kB4030, range(begin, end), name, expanded.error());
      return false;
    }
    StatedProperty& stated = properties.emplace_back();
    stated.name = name;
    stated.text = expanded->text;
    stated.file = file_;
    for (const std::uint32_t offset : expanded->source)
      stated.source.push_back(static_cast<std::uint32_t>(begin) + offset);
    return true;
  }

  Compilation& compilation_;
  FileId file_;
  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace

bool load_properties(Compilation& c, const std::string& path) {
  const Result<FileId> file = load_text(c, path);
  if (!file) {
    c.diags.report(Diag::kB0090, {}, path, file.error());
    return false;
  }
  if (!PropertyFileReader(c, *file).run()) return false;
  check_properties(*c.system, c.diags);
  return !c.diags.has_errors();
}

}  // namespace bip::pipeline
