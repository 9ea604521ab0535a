// See preprocess.hpp. A stack of open files, and for each file a stack of open #if's.
#include "compiler/genom/preprocess.hpp"

#include <filesystem>
#include <map>
#include <set>

#include "compiler/base/read_file.hpp"
#include "compiler/genom/condition.hpp"
#include "compiler/source/utf8.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxIncludeDepth = 64;
constexpr std::size_t kMaxTokens = 1u << 20;
constexpr std::size_t kMaxFileBytes = 16u << 20;

struct Branch {
  SourceRange range;
  bool active = false;  // this branch counts
  bool taken = false;   // one of the branches did
  bool has_else = false;
};
struct Open {
  std::string path;
  std::vector<Token> tokens;
  std::size_t at = 0;
  std::vector<Branch> branches;
};

class Preprocessor {
 public:
  Preprocessor(SourceMap& sources, const PreprocessOptions& options, Diagnostics& diags)
      : sources_(sources), options_(options), diags_(diags) {
    for (const auto& [name, value] : options.defines) {
      std::vector<Token> tokens = lex(sources_, sources_.add("<command line>", value), diags_);
      tokens.pop_back();
      macros_[name] = std::move(tokens);
    }
  }

  Preprocessed run(const std::string& path, FileId file) {
    open_.push_back({path, lex(sources_, file, diags_), 0, {}});
    while (!open_.empty()) {
      Open& top = open_.back();
      BIP_ASSERT(top.at < top.tokens.size(), "token {} of {}", top.at, top.tokens.size());
      const Token& token = top.tokens[top.at];
      if (token.kind == TokenKind::End) {
        close(top);
      } else if (token.starts_line && token.is("#")) {
        directive();
      } else {
        ++top.at;
        if (is_active(top)) emit(token, 0);
      }
      if (result_.tokens.size() > kMaxTokens) {
        diags_.report(Diag::kB6004, token.range, fmt::format("the text grows past {} words and signs", kMaxTokens));
        result_.tokens.push_back(Token{});
        break;
      }
    }
    return std::move(result_);
  }

 private:
  static bool is_active(const Open& file) { return file.branches.empty() || file.branches.back().active; }

  void close(Open& top) {
    for (const Branch& b : top.branches) diags_.report(Diag::kB6004, b.range, "this condition has no `#endif`");
    if (open_.size() == 1) result_.tokens.push_back(top.tokens[top.at]);
    open_.pop_back();
  }

  // Replacement is repeated within the replacement; a macro is not replaced within itself.
  void emit(const Token& token, std::size_t depth) {
    const auto macro = token.kind == TokenKind::Word ? macros_.find(token.text) : macros_.end();
    if (macro == macros_.end() || depth > kMaxIncludeDepth || hidden_.contains(token.text) ||
        ++replaced_ > kMaxTokens) {
      result_.tokens.push_back(token);
      return;
    }
    hidden_.insert(macro->first);
    BIP_ASSERT(depth <= kMaxIncludeDepth && hidden_.size() <= depth + 1, "{} macros are replaced at depth {}",
               hidden_.size(), depth);
    for (const Token& t : macro->second) {
      if (result_.tokens.size() > kMaxTokens) break;
      Token copy = t;
      copy.range = token.range;
      emit(copy, depth + 1);
    }
    hidden_.erase(macro->first);
  }

  // The tokens of a directive, without `#`.
  std::vector<Token> line() {
    Open& top = open_.back();
    std::vector<Token> tokens;
    for (++top.at; top.tokens[top.at].kind != TokenKind::End && !top.tokens[top.at].starts_line; ++top.at)
      tokens.push_back(top.tokens[top.at]);
    return tokens;
  }

  void directive() {
    const SourceRange range = open_.back().tokens[open_.back().at].range;
    const std::vector<Token> words = line();
    if (words.empty()) return;
    Open& top = open_.back();
    const std::string_view name = words.front().text;
    const std::vector<Token> rest(words.begin() + 1, words.end());
    if (name == "if" || name == "ifdef" || name == "ifndef") {
      bool holds = false;
      if (is_active(top)) holds = name == "if" ? condition(rest, range) : is_defined(rest, range) == (name == "ifdef");
      top.branches.push_back({range, is_active(top) && holds, !is_active(top) || holds, false});
    } else if (name == "elif" || name == "else" || name == "endif") {
      next_branch(top, name, rest, range);
    } else if (!is_active(top)) {
      return;
    } else if (name == "include") {
      include(rest, range);
    } else if (name == "define") {
      define(rest, range);
    } else if (name == "undef") {
      if (!rest.empty()) macros_.erase(std::string(rest.front().text));
    } else if (name == "error") {
      diags_.report(Diag::kB6004, range, "the description says `#error`");
    } else if (name == "pragma") {
      pragma(rest, range);
    } else if (name != "line" && name != "warning") {
      diags_.report(Diag::kB6004, words.front().range, fmt::format("`#{}` is no directive that is known here", name));
    }
  }

  // #pragma require "package >= 1.2" …
  void pragma(const std::vector<Token>& rest, SourceRange range) {
    if (rest.empty() || !(rest.front().is("require") || rest.front().is("requires")) || !options_.package_folders)
      return;
    for (std::size_t i = 1; i < rest.size(); ++i) {
      if (rest[i].is(",")) continue;
      if (rest[i].kind != TokenKind::String) {
        diags_.report(Diag::kB6004, rest[i].range, "packages in \"\" have to follow `#pragma require`");
        return;
      }
      const Result<std::vector<std::string>> folders = options_.package_folders(std::string(rest[i].text));
      if (folders) {
        for (const std::string& folder : *folders) packages_.emplace_back(folder);
      } else {
        diags_.report(Diag::kB6027, rest[i].range, folders.error())
            .help("$PKG_CONFIG_PATH says where more `.pc` files are; `-I DIR` adds a folder of headers");
      }
    }
    if (rest.size() == 1) diags_.report(Diag::kB6004, range, "packages in \"\" have to follow `#pragma require`");
  }

  void next_branch(Open& top, std::string_view name, const std::vector<Token>& rest, SourceRange range) {
    if (top.branches.empty() || (name != "endif" && top.branches.back().has_else)) {
      diags_.report(Diag::kB6004, range, fmt::format("`#{}` without `#if` before it", name));
      return;
    }
    Branch& branch = top.branches.back();
    BIP_ASSERT(!branch.active || branch.taken, "a branch counts that was not taken");
    if (name == "endif") {
      top.branches.pop_back();
      return;
    }
    branch.has_else = name == "else";
    branch.active = !branch.taken && (name == "else" || condition(rest, range));
    branch.taken = branch.taken || branch.active;
  }

  bool is_defined(const std::vector<Token>& rest, SourceRange range) {
    if (rest.empty() || rest.front().kind != TokenKind::Word) {
      diags_.report(Diag::kB6004, range, "a name has to follow");
      return false;
    }
    return macros_.contains(rest.front().text);
  }

  // Names that are no macros count as 0, as in C.
  bool condition(const std::vector<Token>& words, SourceRange range) {
    std::vector<Token> replaced;
    std::swap(replaced, result_.tokens);
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (!words[i].is("defined")) {
        emit(words[i], 0);
        continue;
      }
      const std::size_t name = i + 1 < words.size() && words[i + 1].is("(") ? i + 2 : i + 1;
      Token value = words[i];
      value.kind = TokenKind::Number;
      value.text = name < words.size() && macros_.contains(words[name].text) ? "1" : "0";
      result_.tokens.push_back(value);
      i = name == i + 2 ? i + 3 : name;
    }
    std::swap(replaced, result_.tokens);
    const std::optional<std::int64_t> value = constant_value(replaced);
    if (!value) diags_.report(Diag::kB6004, range, "this is no condition that can be computed");
    return value.value_or(0) != 0;
  }

  void define(const std::vector<Token>& rest, SourceRange range) {
    if (rest.empty() || rest.front().kind != TokenKind::Word) {
      diags_.report(Diag::kB6004, range, "a name has to follow `#define`");
      return;
    }
    const bool has_parameters = rest.size() > 1 && rest[1].is("(") && rest[1].range.begin == rest[0].range.end;
    // Headers define functions for C; a description has no use for them.
    if (has_parameters) return;
    macros_[std::string(rest.front().text)] = {rest.begin() + 1, rest.end()};
  }

  void include(const std::vector<Token>& rest, SourceRange range) {
    std::string name;
    const bool in_quotes = !rest.empty() && rest.front().kind == TokenKind::String;
    if (in_quotes) name = rest.front().text;
    if (!in_quotes && rest.size() > 2 && rest.front().is("<")) {
      for (std::size_t i = 1; i < rest.size() && !rest[i].is(">"); ++i) name += rest[i].text;
    }
    if (name.empty()) {
      diags_.report(Diag::kB6004, range, "a file in \"\" or <> has to follow `#include`");
      return;
    }
    if (open_.size() >= kMaxIncludeDepth) {
      diags_.report(Diag::kB6004, range, fmt::format("files include each other more than {} deep", kMaxIncludeDepth));
      return;
    }
    const SourceRange where{rest.front().range.file, rest.front().range.begin, rest.back().range.end};
    const std::string path = find(name);
    const Result<FileId> file =
        path.empty() ? Result<FileId>(Failure{"it is in none of the folders"}) : load_description(sources_, path);
    if (file) {
      BIP_ASSERT(open_.size() < kMaxIncludeDepth, "{} files are open", open_.size());
      open_.push_back({path, lex(sources_, *file, diags_), 0, {}});
      return;
    }
    result_.header_missing = true;
    if (missing_.insert(name).second)
      diags_.report(Diag::kB6001, where, name).help("`-I DIR` adds a folder in which headers are looked for");
  }

  [[nodiscard]] std::string find(const std::string& name) const {
    std::vector<fs::path> folders{fs::path(open_.back().path).parent_path()};
    folders.insert(folders.end(), options_.folders.begin(), options_.folders.end());
    folders.insert(folders.end(), packages_.begin(), packages_.end());
    std::error_code ignored;
    for (const fs::path& folder : folders) {
      const fs::path path = folder / name;
      if (fs::is_regular_file(path, ignored)) return path.string();
    }
    return {};
  }

  SourceMap& sources_;
  const PreprocessOptions& options_;
  Diagnostics& diags_;
  Preprocessed result_;
  std::vector<Open> open_;
  std::map<std::string, std::vector<Token>, std::less<>> macros_;
  std::set<std::string, std::less<>> hidden_;
  std::set<std::string> missing_;
  std::vector<fs::path> packages_;  // folders of those that were required
  std::size_t replaced_ = 0;        // macros so far: they may double each other and yet leave nothing
};

}  // namespace

Preprocessed preprocess(SourceMap& sources, const std::string& path, FileId file, const PreprocessOptions& options,
                        Diagnostics& diags) {
  return Preprocessor(sources, options, diags).run(path, file);
}

std::string as_utf8(std::string bytes) {
  if (!first_bad_utf8(bytes)) return bytes;
  std::string text;
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0 | (byte >> 6));
      text += static_cast<char>(0x80 | (byte & 0x3F));
    }
  }
  return text;
}

Result<FileId> load_description(SourceMap& sources, const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return Failure{fs::exists(path, error) ? "not a file" : "no such file"};
  if (fs::file_size(path, error) > kMaxFileBytes) return Failure{"larger than 16 MB"};
  std::optional<std::string> bytes = read_file(path);
  if (!bytes) return Failure{"not readable"};
  return sources.add(path, as_utf8(std::move(*bytes)));
}

}  // namespace bip::genom
