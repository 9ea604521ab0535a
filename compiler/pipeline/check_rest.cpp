// See check_rest.hpp. Dependences between declarations are approximated by the words of their texts: a word that is not
// a reference only makes the check skip more. Linear in the text.
#include "compiler/pipeline/check_rest.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "compiler/pipeline/load_packages.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::pipeline {
namespace {

bool begins_word(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_word(char c) { return begins_word(c) || (c >= '0' && c <= '9'); }

template <class F>
void each_word(std::string_view text, F f) {
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at + 1;
    if (is_word(text[at])) {
      while (end < text.size() && is_word(text[end])) ++end;
      if (begins_word(text[at])) f(text.substr(at, end - at));
    }
    at = end;
  }
}

class SoundPart {
 public:
  explicit SoundPart(Compilation& c) : compilation_(c), decls_(c.syntax->package->decls), dropped_(decls_.size()) {
    for (const syntax::Decl* decl : decls_) declared_.insert(decl->name.text);
  }

  /// The declarations that can be judged, in their order; empty if some error is outside of all of them.
  std::vector<const syntax::Decl*> find() {
    for (const Diagnostic* d : compilation_.diags.sorted())
      if (d->severity == Severity::Error && !drop_at(d->range)) return {};
    return close();
  }
  /// The same, where declarations with names that are not known cannot be judged. Other errors are ignored.
  std::vector<const syntax::Decl*> find_known(const std::vector<const Diagnostic*>& unknown) {
    for (const Diagnostic* d : unknown) (void)drop_at(d->range);
    return close();
  }

 private:
  // Drops what names a dropped declaration.
  std::vector<const syntax::Decl*> close() {
    for (std::size_t k = 0; k < decls_.size(); ++k) {
      if (dropped_[k]) continue;
      each_word(compilation_.sources.text(decls_[k]->range), [&](std::string_view word) { users_[word].push_back(k); });
    }
    while (!open_.empty()) {
      const std::string_view name = open_.back();
      open_.pop_back();
      const auto users = users_.find(name);
      if (users == users_.end()) continue;
      for (const std::size_t k : users->second)
        if (!dropped_[k]) drop(k);
    }
    std::vector<const syntax::Decl*> sound;
    for (std::size_t k = 0; k < decls_.size(); ++k)
      if (!dropped_[k]) sound.push_back(decls_[k]);
    return sound;
  }

  // What stands between two declarations belongs to the one before: recovery skips it.
  bool drop_at(SourceRange range) {
    if (!range.is_valid() || range.file != compilation_.file || decls_.empty() ||
        range.begin < decls_.front()->range.begin)
      return false;
    const auto behind =
        std::upper_bound(decls_.begin(), decls_.end(), range.begin,
                         [](std::uint32_t at, const syntax::Decl* decl) { return at < decl->range.begin; });
    const auto k = static_cast<std::size_t>(behind - decls_.begin()) - 1;
    if (dropped_[k]) return true;
    drop(k);
    const std::uint32_t end = k + 1 < decls_.size()
                                  ? decls_[k + 1]->range.begin
                                  : static_cast<std::uint32_t>(compilation_.sources.text(compilation_.file).size());
    // Declarations that recovery skipped: `atom type A`, `component A`, `function int f`. Components of a compound are
    // written alike, but their types are declared elsewhere.
    std::string_view before, earlier;
    each_word(compilation_.sources.text(SourceRange{compilation_.file, decls_[k]->range.begin, end}),
              [&](std::string_view word) {
                if ((before == "type" || before == "component" || earlier == "function") && !declared_.contains(word))
                  poison(word);
                earlier = std::exchange(before, word);
              });
    return true;
  }
  void drop(std::size_t k) {
    BIP_ASSERT(k < decls_.size() && !dropped_[k], "declaration {} of {} is dropped again", k, decls_.size());
    dropped_[k] = true;
    if (!decls_[k]->name.text.empty()) poison(decls_[k]->name.text);
    for (const syntax::DataDecl& data : decls_[k]->data)
      if (decls_[k]->kind == syntax::DeclKind::ConstData)
        for (const syntax::Var& var : data.vars) poison(var.name.text);
  }
  void poison(std::string_view name) {
    if (seen_.insert(name).second) open_.push_back(name);
  }

  Compilation& compilation_;
  std::span<const syntax::Decl* const> decls_;
  std::vector<bool> dropped_;
  std::unordered_map<std::string_view, std::vector<std::size_t>> users_;
  std::set<std::string_view> declared_, seen_;
  std::vector<std::string_view> open_;
};

DiagnosticBuilder copy(const Diagnostic& from, Diagnostics& to) {
  DiagnosticBuilder d = to.add(from.kind, from.range, from.message);
  if (!from.label.empty()) d.label(from.label);
  for (const Label& label : from.labels) d.label(label.range, label.text);
  for (const std::string& note : from.notes) d.note(note);
  for (const Help& help : from.helps) d.help(help.text, help.replace, help.with);
  return d;
}

// Errors that a package which is not there may cause: its types, functions, constants and operators are not known.
bool is_unknown_name(const Diagnostic& d) {
  constexpr Diag kUnknown[] = {Diag::kB1001, Diag::kB1003, Diag::kB1005, Diag::kB1006, Diag::kB1042};
  return std::find(std::begin(kUnknown), std::end(kUnknown), d.kind) != std::end(kUnknown);
}

// "`Thing`, `Two`": names of which nothing is known, in the order of the file.
std::string listed_names(const std::vector<const Diagnostic*>& unknown, const SourceMap& sources) {
  constexpr std::size_t kListed = 8;
  std::vector<std::string_view> names;
  for (const Diagnostic* d : unknown) {
    const std::string_view name = sources.text(d->range);
    if (!name.empty() && begins_word(name.front()) && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  }
  std::string text;
  for (std::size_t k = 0; k < std::min(names.size(), kListed); ++k)
    text += fmt::format("{}`{}`", k == 0 ? "" : ", ", names[k]);
  return text + (names.size() > kListed ? ", …" : "");
}

}  // namespace

void check_rest(Compilation& c) {
  if (!c.syntax || c.syntax->package == nullptr) return;
  const std::vector<const syntax::Decl*> sound = SoundPart(c).find();
  if (sound.empty()) return;
  // Packages that cannot be read are no business of a broken file: then nothing more is said.
  Diagnostics syntax_errors;
  std::swap(syntax_errors, c.diags);
  const bool loaded = load_packages(c);
  Diagnostics others;
  if (loaded) {
    const syntax::Package* whole = c.syntax->package;
    syntax::Package part = *whole;
    part.decls = sound;
    c.syntax->package = &part;
    (void)model::build_model(c.packages, c.sources, others);
    c.syntax->package = whole;
  }
  c.packages.clear();
  c.used.clear();
  std::swap(syntax_errors, c.diags);
  for (const Diagnostic* d : others.sorted())
    if (d->severity == Severity::Error) (void)copy(*d, c.diags);
}

void check_without_missing(Compilation& c) {
  const auto is_missing = [&](const Diagnostic* d) { return d->kind == Diag::kB1060 && d->range.file == c.file; };
  const std::vector<const Diagnostic*> reported = c.diags.sorted();
  if (reported.empty() || !std::all_of(reported.begin(), reported.end(), is_missing)) return;
  Diagnostics others;
  (void)model::build_model(c.packages, c.sources, others);
  std::vector<const Diagnostic*> unknown;
  for (const Diagnostic* d : others.sorted())
    // `p.v` is a variable of a port, whose type is known or told itself.
    if (is_unknown_name(*d) && d->range.file == c.file && c.sources.text(d->range).find('.') == std::string_view::npos)
      unknown.push_back(d);
  const std::vector<const syntax::Decl*> sound = SoundPart(c).find_known(unknown);
  const auto is_judged = [&](SourceRange range) {
    return std::any_of(sound.begin(), sound.end(), [&](const syntax::Decl* decl) {
      return decl->range.file == range.file && decl->range.begin <= range.begin && range.begin < decl->range.end;
    });
  };
  Diagnostics all;
  const std::string names = listed_names(unknown, c.sources);
  for (const Diagnostic* d : reported) {
    DiagnosticBuilder missing = copy(*d, all);
    if (d == reported.front() && !names.empty()) missing.note("not known without it: " + names);
  }
  for (const Diagnostic* d : others.sorted())
    if (d->severity == Severity::Error && is_judged(d->range)) (void)copy(*d, all);
  std::swap(c.diags, all);
}

}  // namespace bip::pipeline
