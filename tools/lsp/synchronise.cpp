// Documents as the client has them: open, change, close, save.
#include "tools/lsp/language_server.hpp"
#include "tools/lsp/uri.hpp"

namespace bip::lsp {
namespace {

/// Applies one change. False if it makes no sense; then the text is as before.
bool apply(Text& text, const Json& change, Encoding encoding) {
  const std::string* with = string_member(change, "text");
  if (with == nullptr) return false;
  const Json* range = member(change, "range");
  if (range == nullptr || range->is_null()) {
    if (with->size() > SourceMap::kMaxFileBytes) return false;
    text = Text(*with);
    return true;
  }
  const auto from = position_of(member(*range, "start"));
  const auto to = position_of(member(*range, "end"));
  if (!from || !to) return false;
  // Editors may name the line after the last one.
  const std::uint32_t begin = text.clamped_offset(*from, encoding);
  const std::uint32_t end = text.clamped_offset(*to, encoding);
  if (begin > end || text.str().size() + with->size() > SourceMap::kMaxFileBytes) return false;
  text.replace(begin, end, *with);
  return true;
}

}  // namespace

void Server::did_open(const Json& params) {
  const Json* document = member(params, "textDocument");
  const std::string* uri = document == nullptr ? nullptr : string_member(*document, "uri");
  const std::string* text = document == nullptr ? nullptr : string_member(*document, "text");
  if (uri == nullptr || text == nullptr) return log("`didOpen` without a URI or a text");
  if (text->size() > SourceMap::kMaxFileBytes) return log("the document is larger than a file may be");
  const std::string path = workspace_.open(*uri, *text, int_member(*document, "version").value_or(0)).path;
  check(path);
}

void Server::did_change(const Json& params) {
  const Json* document = member(params, "textDocument");
  const std::string* uri = document == nullptr ? nullptr : string_member(*document, "uri");
  Document* d = uri == nullptr ? nullptr : workspace_.find(*uri);
  const Json* changes = member(params, "contentChanges");
  if (d == nullptr || changes == nullptr || !changes->is_array())
    return log("`didChange` of what is not open, or without changes");
  // All or nothing: half of a change is no state that the client was ever in.
  Text text = d->text;
  for (const Json& change : *changes) {
    if (!apply(text, change, workspace_.encoding))
      return log("`didChange` with a change that makes no sense; the document stays as it was");
  }
  d->text = std::move(text);
  ++d->edits;
  d->version = int_member(*document, "version").value_or(d->version);
  check_later(d->path);
}

void Server::did_close(const Json& params) {
  const Json* document = member(params, "textDocument");
  const std::string* uri = document == nullptr ? nullptr : string_member(*document, "uri");
  if (uri == nullptr || workspace_.find(*uri) == nullptr) return log("`didClose` of what is not open");
  workspace_.close(*uri);
  // Who uses it reads the file from now on.
  check(path_of(*uri));
}

void Server::did_save(const Json& params) {
  const Json* document = member(params, "textDocument");
  const std::string* uri = document == nullptr ? nullptr : string_member(*document, "uri");
  if (uri == nullptr || workspace_.find(*uri) == nullptr) return log("`didSave` of what is not open");
  // Packages on disk may have changed with it.
  check(path_of(*uri));
}

}  // namespace bip::lsp
