// See workspace.hpp. Cost: a check of the document and of each open document that uses it.
#include "tools/lsp/workspace.hpp"

#include <algorithm>
#include <utility>

#include "compiler/pipeline/load_packages.hpp"
#include "compiler/syntax/print.hpp"
#include "tools/lsp/uri.hpp"

namespace bip::lsp {

Document& Workspace::open(std::string uri, std::string text, std::int64_t version) {
  const std::string path = lsp::path_of(uri);
  auto document = std::make_unique<Document>();
  document->uri = std::move(uri);
  document->path = path;
  document->version = version;
  document->text = Text(std::move(text));
  std::unique_ptr<Document>& variable = documents_[path];
  variable = std::move(document);
  return *variable;
}

void Workspace::close(const std::string& uri) { documents_.erase(lsp::path_of(uri)); }

Document* Workspace::find(const std::string& uri) { return find_path(lsp::path_of(uri)); }

Document* Workspace::find_path(const std::string& path) {
  const auto found = documents_.find(path);
  return found == documents_.end() ? nullptr : found->second.get();
}

std::map<std::string, std::string> Workspace::open_texts() const {
  std::map<std::string, std::string> texts;
  for (const auto& [path, document] : documents_) texts.emplace(path, document->text.str());
  return texts;
}

std::unique_ptr<pipeline::Compilation> Workspace::compilation_of(Document& d) const {
  pipeline::CompileOptions options;
  options.folders = folders;
  // An editor keeps the memory of its person: what is larger is said to be.
  options.max_instances = 2'000'000;
  auto c = std::make_unique<pipeline::Compilation>(std::move(options));
  c->kept = &d.kept;
  for (const auto& [path, other] : documents_) c->open_texts.emplace(path, other->text.str());
  return c;
}

bool Workspace::is_large(const Document& d) {
  constexpr std::size_t kLarge = std::size_t{256} << 10;
  return d.text.str().size() > kLarge;
}

bool Workspace::uses(const Document& d, const std::string& path) {
  const auto has = [&path](const pipeline::Compilation* c) {
    return c != nullptr &&
           std::any_of(c->paths.begin(), c->paths.end(), [&path](const auto& row) { return row.second == path; });
  };
  return has(d.analysis.compilation.get()) || has(d.findings.compilation);
}

bool Workspace::is_used_by_others(const std::string& path) const {
  return std::any_of(documents_.begin(), documents_.end(),
                     [&path](const auto& row) { return row.first != path && uses(*row.second, path); });
}

bool Workspace::read_names(Document& d) {
  if (d.named_edits == d.edits && d.analysis.compilation != nullptr) return true;
  // They are of an earlier text, and parsing ends its trees.
  if (std::exchange(d.has_unread_names, false)) forget_products(*d.findings.own);
  std::unique_ptr<pipeline::Compilation> c = compilation_of(d);
  c->path = d.path;
  const Result<FileId> file = pipeline::load_text(*c, d.path);
  if (!file) return false;
  c->file = *file;
  Diagnostics known_by_check;
  c->syntax = parse::parse_incrementally(c->sources, *file, known_by_check, d.kept[d.path]);
  if (!c->syntax.has_value() || c->syntax->package == nullptr) return false;
  (void)pipeline::load_packages(*c);
  if (d.findings.compilation != nullptr && d.findings.own == nullptr)
    d.findings.own = std::move(d.analysis.compilation);
  d.analysis = take_names(std::move(c));
  d.has_products = true;
  d.last_names = {};
  d.last_compilation.reset();
  d.named_edits = d.edits;
  return true;
}

void Workspace::analyse(Document& d) {
  ++checks;
  const bool has_names = d.named_edits == d.edits && d.edits != d.checked_edits && d.analysis.compilation != nullptr;
  d.checked_edits = d.edits;
  d.has_unread_names = false;
  std::unique_ptr<pipeline::Compilation> c = compilation_of(d);
  (void)pipeline::check(*c, d.path);
  Findings findings = take_findings(*c);
  const bool has_tree = c->syntax.has_value() && c->syntax->package != nullptr;
  if (has_names && has_tree) {
    d.has_products = true;
    findings.own = std::move(c);
    d.findings = std::move(findings);
    return;
  }
  // `check` stops at the first stage with errors; names are wanted whatever it found. Diagnostics were complete before.
  if (has_tree && c->packages.empty()) (void)pipeline::load_packages(*c);
  findings.own = std::move(c);
  d.findings = std::move(findings);
  d.has_unread_names = true;
  if (!is_large(d)) read_names_of_check(d);
}

void Workspace::read_names_of_check(Document& d) {
  if (!std::exchange(d.has_unread_names, false)) return;
  const bool has_tree = d.findings.own->syntax.has_value() && d.findings.own->syntax->package != nullptr;
  Analysis a = take_names(std::move(d.findings.own));
  if (!has_tree && d.analysis.index.symbols.size() > 0) {
    d.last_names = std::move(d.analysis.index);
    d.last_compilation = std::move(d.analysis.compilation);
  } else if (has_tree) {
    d.last_names = {};
    d.last_compilation.reset();
  }
  d.analysis = std::move(a);
  d.named_edits = d.checked_edits;
  d.has_products = true;
}

void Workspace::read_names_of_checks() {
  for (const auto& [path, document] : documents_) read_names_of_check(*document);
}

void Workspace::finish() {
  read_names_of_checks();
  for (const auto& [path, document] : documents_) {
    if (!std::exchange(document->has_products, false)) continue;
    for (pipeline::Compilation* c : {document->analysis.compilation.get(), document->findings.own.get()}) {
      if (c != nullptr) forget_products(*c);
    }
  }
}

bool Workspace::is_unfinished() const {
  return std::any_of(documents_.begin(), documents_.end(),
                     [](const auto& row) { return row.second->has_unread_names || row.second->has_products; });
}

std::vector<Json> Workspace::check(const std::string& path) {
  for (auto& [other, document] : documents_) {
    // A package that was missing may have appeared.
    const bool misses_one = std::any_of(document->findings.diagnostics.begin(), document->findings.diagnostics.end(),
                                        [](const Diagnostic* d) { return d->kind == Diag::kB1060; });
    if (other == path || uses(*document, path) || misses_one) analyse(*document);
  }
  return publish();
}

Json Workspace::work_done() const {
  std::uint64_t parsed = 0, reused = 0, partly = 0, whole = 0;
  for (const auto& [path, document] : documents_) {
    const auto kept = document->kept.find(path);
    if (kept == document->kept.end()) continue;
    parsed += kept->second.parsed;
    reused += kept->second.reused;
    partly += kept->second.partly;
    whole += kept->second.whole;
  }
  return {{"checks", checks}, {"parsed", parsed}, {"reused", reused}, {"partly", partly}, {"whole", whole}};
}

std::optional<std::string> Workspace::formatted(const std::string& uri) {
  Document* const d = find(uri);
  if (d == nullptr) return std::nullopt;
  // Of an error of syntax something is missing in the tree. Where the check knows of one the text is not read again.
  const FileId file = d->findings.file;
  const bool is_whole =
      d->edits != d->checked_edits ||
      std::none_of(d->findings.diagnostics.begin(), d->findings.diagnostics.end(), [file](const Diagnostic* found) {
        return found->severity == Severity::Error && found->range.file == file && found->kind < Diag::kB0090;
      });
  if (!is_whole) return std::nullopt;
  // Parsing ends the trees that they would be read from.
  read_names_of_check(*d);
  pipeline::Compilation c{pipeline::CompileOptions()};
  c.kept = &d->kept;
  c.open_texts.emplace(d->path, d->text.str());
  if (!pipeline::compile(c, d->path, pipeline::Stage::Syntax) || !c.syntax || c.syntax->package == nullptr)
    return std::nullopt;
  return syntax::print(*c.syntax, c.sources);
}

Json Workspace::range(const pipeline::Compilation* c, const std::string* path, SourceRange r, Texts texts) const {
  const auto open = path == nullptr ? documents_.end() : documents_.find(*path);
  // An open document was read with the text that it has: any other text here would be a stale answer.
  // To compare the texts for each range would be quadratic.
  if (open != documents_.end() && (texts == Texts::Equal || c->sources.text(r.file) == open->second->text.str())) {
    const Text& text = open->second->text;
    return {{"start", json_of(text.position(r.begin, encoding))}, {"end", json_of(text.position(r.end, encoding))}};
  }
  const Text text{r.is_valid() && c != nullptr ? std::string(c->sources.text(r.file)) : std::string()};
  return {{"start", json_of(text.position(r.begin, encoding))}, {"end", json_of(text.position(r.end, encoding))}};
}

Json Workspace::range(const Analysis& a, SourceRange r) const {
  const std::string* path = a.path_of(r.file);
  const auto open = path == nullptr ? documents_.end() : documents_.find(*path);
  const bool is_own = open != documents_.end() && &open->second->analysis == &a && r.file == a.file &&
                      open->second->edits == open->second->named_edits;
  return range(a.compilation.get(), path, r, is_own ? Texts::Equal : Texts::Unknown);
}

Json Workspace::range(const Findings& f, SourceRange r) const {
  const std::string* path = f.path_of(r.file);
  const auto open = path == nullptr ? documents_.end() : documents_.find(*path);
  const bool is_own = open != documents_.end() && &open->second->findings == &f && r.file == f.file &&
                      open->second->edits == open->second->checked_edits;
  return range(f.compilation, path, r, is_own ? Texts::Equal : Texts::Unknown);
}

Json Workspace::location(const Analysis& a, SourceRange r) const {
  const std::string* path = a.path_of(r.file);
  if (path == nullptr) return nullptr;
  const auto open = documents_.find(*path);
  return {{"uri", open == documents_.end() ? uri_of(*path) : open->second->uri}, {"range", range(a, r)}};
}

Json Workspace::diagnostic(const Document& d, const Diagnostic& from) const {
  Json to{{"code", info(from.kind).code},
          {"severity", from.severity == Severity::Error ? 1 : 2},
          {"source", "bipc"},
          {"message", from.message}};
  to["range"] = range(d.findings, from.range);
  if (client_explains) to["codeDescription"]["href"] = "bip-explain:/" + std::string(info(from.kind).code) + ".md";
  Json related = Json::array();
  const auto add = [&](SourceRange at, const std::string& text) {
    const std::string* path = d.findings.path_of(at.file);
    const auto open = path == nullptr ? documents_.end() : documents_.find(*path);
    const std::string uri = path == nullptr ? d.uri : open == documents_.end() ? uri_of(*path) : open->second->uri;
    Json where{{"uri", uri}, {"range", range(d.findings, path == nullptr ? SourceRange{} : at)}};
    related.push_back({{"location", std::move(where)}, {"message", text}});
  };
  if (!from.label.empty()) add(from.range, from.label);
  for (const Label& label : from.labels) add(label.range, label.text);
  for (const std::string& note : from.notes) add(from.range, "note: " + note);
  for (const Help& help : from.helps) add(help.replace.is_valid() ? help.replace : from.range, "help: " + help.text);
  if (!related.empty()) to["relatedInformation"] = std::move(related);
  return to;
}

Json Workspace::diagnostics_in(const Document& d) const {
  Json list = Json::array();
  for (const Diagnostic* found : d.findings.diagnostics) {
    const std::string* in = d.findings.path_of(found->range.file);
    if (in == nullptr || *in == d.path) list.push_back(diagnostic(d, *found));
  }
  return list;
}

std::vector<Json> Workspace::publish() {
  // A document shows its own check; a package that is not open shows what the checks of its users found in it.
  std::map<std::string, Json> found;
  for (const auto& [path, document] : documents_) found[document->uri] = Json::array();
  for (const auto& [path, document] : documents_) {
    for (const Diagnostic* d : document->findings.diagnostics) {
      const std::string* in = document->findings.path_of(d->range.file);
      const bool is_own = in == nullptr || *in == path;
      if (!is_own && documents_.contains(*in)) continue;
      Json& list = found.try_emplace(is_own ? document->uri : uri_of(*in), Json::array()).first->second;
      Json made = diagnostic(*document, *d);
      if (is_own || std::find(list.begin(), list.end(), made) == list.end()) list.push_back(std::move(made));
    }
  }
  for (const auto& [uri, text] : published_) found.try_emplace(uri, Json::array());
  std::vector<Json> messages;
  for (auto& [uri, list] : found) {
    const auto open = documents_.find(lsp::path_of(uri));
    std::string now = list.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (open != documents_.end()) now += "#" + std::to_string(open->second->version);
    const auto before = published_.find(uri);
    if (before != published_.end() && before->second == now) continue;
    if (open == documents_.end() && list.empty()) {
      published_.erase(uri);
    } else {
      published_[uri] = now;
    }
    Json message{{"uri", uri}, {"diagnostics", std::move(list)}};
    if (open != documents_.end()) message["version"] = open->second->version;
    messages.push_back(std::move(message));
  }
  return messages;
}

}  // namespace bip::lsp
