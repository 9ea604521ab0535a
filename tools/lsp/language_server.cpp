// The protocol: which messages are valid in which state, and which function answers them.
#include "tools/lsp/language_server.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "tools/lsp/features.hpp"
#include "tools/lsp/uri.hpp"

namespace bip::lsp {
namespace {

const std::string* uri_in(const Json& params) {
  const Json* document = member(params, "textDocument");
  return document == nullptr ? nullptr : string_member(*document, "uri");
}

Json capabilities(Encoding encoding) {
  return {{"positionEncoding", encoding == Encoding::Utf8 ? "utf-8" : "utf-16"},
          {"textDocumentSync", {{"openClose", true}, {"change", 2}, {"save", {{"includeText", false}}}}},
          {"definitionProvider", true},
          {"referencesProvider", true},
          {"hoverProvider", true},
          {"documentSymbolProvider", true},
          {"renameProvider", {{"prepareProvider", true}}},
          {"completionProvider", {{"triggerCharacters", {".", "@"}}}},
          {"documentFormattingProvider", true},
          {"codeActionProvider", {{"codeActionKinds", {"quickfix"}}}},
          {"codeLensProvider", {{"resolveProvider", false}}},
          {"foldingRangeProvider", true},
          {"documentHighlightProvider", true},
          {"selectionRangeProvider", true},
          {"workspaceSymbolProvider", true},
          {"documentLinkProvider", {{"resolveProvider", false}}},
          {"signatureHelpProvider", {{"triggerCharacters", {"(", ","}}}},
          {"inlayHintProvider", true},
          {"diagnosticProvider", {{"interFileDependencies", true}, {"workspaceDiagnostics", false}}},
          {"semanticTokensProvider", {{"legend", semantic_legend()}, {"full", true}, {"range", true}}}};
}

}  // namespace

void Server::send(const Json& message) { send_(message.dump(-1, ' ', false, Json::error_handler_t::replace)); }
void Server::notify(const char* method, Json params) {
  send({{"jsonrpc", "2.0"}, {"method", method}, {"params", std::move(params)}});
}
void Server::log(const std::string& text) {
  notify("window/logMessage", {{"type", 2}, {"message", "bipc-lsp: " + text}});
}
void Server::fail(const Json& id, ErrorCode code, const std::string& message) {
  send({{"jsonrpc", "2.0"}, {"id", id}, {"error", {{"code", static_cast<int>(code)}, {"message", message}}}});
}

void Server::handle(const Framing::Frame& frame, Queue queue) {
  switch (frame.kind) {
    case Framing::Kind::Message: return handle(frame.body, queue);
    case Framing::Kind::BadHeader:
      return fail(nullptr, ErrorCode::ParseError, "a message begins with `Content-Length: N` and an empty line");
    case Framing::Kind::TooLong:
      return fail(nullptr, ErrorCode::InvalidRequest, "the message is longer than this server takes");
  }
}

void Server::handle(std::string_view body, Queue queue) {
  if (is_finished()) return;
  const Json message = Json::parse(body, nullptr, /*allow_exceptions=*/false);
  if (message.is_discarded()) return fail(nullptr, ErrorCode::ParseError, "the message is not JSON");
  const std::string* method = string_member(message, "method");
  // Answers come after the diagnostics of all changes before them, but for questions about names in large documents.
  const bool is_change = method != nullptr && *method == "textDocument/didChange";
  const bool takes_old_names = method != nullptr && *method == "textDocument/completion" && can_wait();
  if (!is_change && !takes_old_names && !(method != nullptr && can_wait() && read_names(needs_of(*method), message)))
    check_changed();
  dispatch(message);
  if (queue == Queue::Empty && !can_wait()) check_changed();
}

Server::Needs Server::needs_of(std::string_view method) {
  constexpr std::string_view kOfAll[] = {"textDocument/references", "textDocument/rename", "textDocument/prepareRename",
                                         "workspace/symbol"};
  constexpr std::string_view kOfOne[] = {
      "textDocument/documentSymbol",    "textDocument/semanticTokens/full", "textDocument/semanticTokens/range",
      "textDocument/codeLens",          "textDocument/foldingRange",        "textDocument/selectionRange",
      "textDocument/documentLink",      "textDocument/definition",          "textDocument/hover",
      "textDocument/documentHighlight", "textDocument/signatureHelp",       "textDocument/formatting",
      "textDocument/inlayHint"};
  const auto is_among = [method](const auto& list) {
    return std::find(std::begin(list), std::end(list), method) != std::end(list);
  };
  return is_among(kOfOne) ? Needs::OwnNames : is_among(kOfAll) ? Needs::AllNames : Needs::Check;
}

bool Server::read_names(Needs needs, const Json& message) {
  switch (needs) {
    case Needs::Check: return false;
    case Needs::OwnNames: {
      const Json* params = member(message, "params");
      const std::string* uri = params == nullptr ? nullptr : uri_in(*params);
      Document* const d = uri == nullptr ? nullptr : workspace_.find(*uri);
      // Another document that changed may be a package that this one uses.
      return d != nullptr && changed_.size() == 1 && changed_.front() == d->path && workspace_.read_names(*d);
    }
    case Needs::AllNames:
      // The users of a changed package have to be read again as well: their check does that.
      return std::all_of(changed_.begin(), changed_.end(), [this](const std::string& path) {
        Document* const d = workspace_.find_path(path);
        return d != nullptr && !workspace_.is_used_by_others(path) && workspace_.read_names(*d);
      });
  }
  return false;
}

void Server::catch_up() {
  check_changed();
  finish();
}

// A check of a large document takes longer than a person needs for a key.
bool Server::can_wait() {
  return std::any_of(changed_.begin(), changed_.end(), [this](const std::string& path) {
    const Document* const d = workspace_.find_path(path);
    return d != nullptr && Workspace::is_large(*d);
  });
}

void Server::check_later(const std::string& path) {
  if (std::find(changed_.begin(), changed_.end(), path) == changed_.end()) changed_.push_back(path);
}

void Server::check_changed() {
  const std::vector<std::string> paths = std::exchange(changed_, {});
  try {
    for (const std::string& path : paths) check(path);
  } catch (const std::exception& e) {
    log(std::string("a check failed: ") + e.what());
  }
}

void Server::dispatch(const Json& message) {
  const Json* id = member(message, "id");
  // An id is echoed, so nothing else than the protocol's kinds is taken.
  const bool is_good_id = id == nullptr || id->is_string() || id->is_number() || id->is_null();
  const Json echoed = id != nullptr && is_good_id ? *id : Json(nullptr);
  const std::string* method = string_member(message, "method");
  const std::string* version = string_member(message, "jsonrpc");
  if (method == nullptr && id != nullptr &&
      (member(message, "result") != nullptr || member(message, "error") != nullptr))
    return;
  if (!is_good_id || method == nullptr || version == nullptr || *version != "2.0") {
    return fail(echoed, ErrorCode::InvalidRequest,
                "a message is an object with `jsonrpc`: \"2.0\", a `method` and, for a request, an `id`");
  }
  static const Json kNone;
  const Json* params = member(message, "params");
  try {
    if (id != nullptr) {
      request(echoed, *method, params == nullptr ? kNone : *params);
    } else {
      notification(*method, params == nullptr ? kNone : *params);
    }
  } catch (const std::exception& e) {
    // A bug of ours or no memory: the session goes on.
    if (id != nullptr) return fail(echoed, ErrorCode::InternalError, e.what());
    log(std::string("`") + *method + "` failed: " + e.what());
  }
}

void Server::request(const Json& id, const std::string& method, const Json& params) {
  if (state_ == State::Fresh && method != "initialize")
    return fail(id, ErrorCode::NotInitialized, "`initialize` comes first");
  if (state_ == State::ShutDown) return fail(id, ErrorCode::InvalidRequest, "after `shutdown` comes `exit`");
  Reply reply = answer(method, params);
  if (const RpcError* error = std::get_if<RpcError>(&reply)) return fail(id, error->code, error->message);
  if (const JsonText* result = std::get_if<JsonText>(&reply))
    return send_(R"({"jsonrpc":"2.0","id":)" + id.dump() + R"(,"result":)" + result->text + '}');
  send({{"jsonrpc", "2.0"}, {"id", id}, {"result", std::move(std::get<Json>(reply))}});
}

Reply Server::answer(const std::string& method, const Json& params) {
  if (method == "initialize") return initialize(params);
  if (method == "shutdown") {
    state_ = State::ShutDown;
    return Json(nullptr);
  }
  if (method == "workspace/symbol") {
    const std::string* query = string_member(params, "query");
    if (query == nullptr) return bad_params("`query` is missing");
    workspace_.read_names_of_checks();
    return workspace_symbols(workspace_, *query);
  }
  // For tests: which requests read a document again, and how much of it.
  if (method == "bip/checks") return workspace_.work_done();
  constexpr std::string_view kOfDocuments = "textDocument/";
  if (!method.starts_with(kOfDocuments)) return RpcError{ErrorCode::MethodNotFound, "no method `" + method + "`"};
  const std::string name = method.substr(kOfDocuments.size());
  const bool is_whole = name == "documentSymbol" || name == "formatting" || name == "semanticTokens/full" ||
                        name == "codeAction" || name == "codeLens" || name == "foldingRange" ||
                        name == "selectionRange" || name == "documentLink" || name == "diagnostic" ||
                        name == "semanticTokens/range" || name == "inlayHint";
  const bool is_at = name == "definition" || name == "references" || name == "hover" || name == "rename" ||
                     name == "prepareRename" || name == "completion" || name == "documentHighlight" ||
                     name == "signatureHelp";
  if (!is_whole && !is_at) return RpcError{ErrorCode::MethodNotFound, "no method `" + method + "`"};
  if (name != "diagnostic" && name != "codeAction" && name != "formatting") workspace_.read_names_of_checks();
  if (is_at) return at_position(name, params);
  const std::string* uri = uri_in(params);
  if (uri == nullptr) return bad_params("`textDocument.uri` is missing");
  const Document* d = workspace_.find(*uri);
  if (d == nullptr) return bad_params("the document is not open");
  if (name == "documentSymbol") return document_symbols(workspace_, *d);
  if (name == "formatting") return formatting(workspace_, *d);
  if (name == "semanticTokens/full") return semantic_tokens(workspace_, *d);
  if (name == "codeLens") return code_lenses(workspace_, *d);
  if (name == "foldingRange") return folding_ranges(workspace_, *d);
  if (name == "documentLink") return document_links(workspace_, *d);
  if (name == "diagnostic") return Json{{"kind", "full"}, {"items", workspace_.diagnostics_in(*d)}};
  if (name == "selectionRange") return selection_ranges(*d, params);
  const Json* range = member(params, "range");
  const auto begin = range == nullptr ? std::nullopt : position_of(member(*range, "start"));
  const auto end = range == nullptr ? std::nullopt : position_of(member(*range, "end"));
  if (!begin || !end) return bad_params("`range` is two positions");
  if (name == "semanticTokens/range")
    return semantic_tokens(workspace_, *d, d->text.clamped_offset(*begin, workspace_.encoding),
                           d->text.clamped_offset(*end, workspace_.encoding));
  if (name == "inlayHint")
    return inlay_hints(workspace_, *d, d->text.clamped_offset(*begin, workspace_.encoding),
                       d->text.clamped_offset(*end, workspace_.encoding));
  return code_actions(workspace_, *d, d->text.clamped_offset(*begin, workspace_.encoding),
                      d->text.clamped_offset(*end, workspace_.encoding));
}

Reply Server::selection_ranges(const Document& d, const Json& params) {
  const Json* positions = member(params, "positions");
  if (positions == nullptr || !positions->is_array()) return bad_params("`positions` is a list");
  Json out = Json::array();
  for (const Json& position : *positions) {
    const auto at = position_of(&position);
    if (!at) return bad_params("`positions` is a list of positions");
    out.push_back(selection_range(workspace_, d, d.text.clamped_offset(*at, workspace_.encoding)));
  }
  return out;
}

Reply Server::at_position(const std::string& method, const Json& params) {
  const std::string* uri = uri_in(params);
  if (uri == nullptr) return bad_params("`textDocument.uri` is missing");
  const Document* d = workspace_.find(*uri);
  if (d == nullptr) return bad_params("the document is not open");
  const auto at = position_of(member(params, "position"));
  if (!at) return bad_params("`position` is a line and a character, from 0 to 2147483647");
  const auto offset = d->text.offset(*at, workspace_.encoding);
  if (!offset)
    return bad_params("the document has " + std::to_string(d->text.line_count()) + " lines, there is no line " +
                      std::to_string(at->line));
  if (method == "definition") return definition(workspace_, *d, *offset);
  if (method == "documentHighlight") return document_highlights(workspace_, *d, *offset);
  if (method == "signatureHelp") return signature_help(workspace_, *d, *offset);
  if (method == "hover") return hover(workspace_, *d, *offset);
  if (method == "completion") return completion(workspace_, *d, *offset);
  if (method == "prepareRename") return prepare_rename(workspace_, *d, *offset);
  if (method == "rename") {
    const std::string* name = string_member(params, "newName");
    return name == nullptr ? Reply(bad_params("`newName` is missing")) : rename(workspace_, *d, *offset, *name);
  }
  const Json* context = member(params, "context");
  const Json* with = context == nullptr ? nullptr : member(*context, "includeDeclaration");
  const bool is_asked = with != nullptr && with->is_boolean() && with->get<bool>();
  return references(workspace_, *d, *offset, is_asked ? Declarations::Included : Declarations::Excluded);
}

Reply Server::initialize(const Json& params) {
  if (state_ != State::Fresh) return RpcError{ErrorCode::InvalidRequest, "`initialize` comes once"};
  const Json* client = member(params, "capabilities");
  const Json* general = client == nullptr ? nullptr : member(*client, "general");
  const Json* encodings = general == nullptr ? nullptr : member(*general, "positionEncodings");
  if (encodings != nullptr && encodings->is_array()) {
    for (const Json& e : *encodings) {
      if (e.is_string() && e.get_ref<const std::string&>() == "utf-8") workspace_.encoding = Encoding::Utf8;
    }
  }
  const Json* options = member(params, "initializationOptions");
  const Json* folders = options == nullptr ? nullptr : member(*options, "packageFolders");
  const std::string* root = string_member(params, "rootUri");
  if (folders != nullptr && folders->is_array()) {
    for (const Json& f : *folders) {
      if (!f.is_string()) continue;
      std::filesystem::path folder(f.get_ref<const std::string&>());
      if (folder.is_relative() && root != nullptr) folder = std::filesystem::path(path_of(*root)) / folder;
      workspace_.folders.push_back(folder.lexically_normal().string());
    }
  }
  const Json* explains = options == nullptr ? nullptr : member(*options, "explain");
  workspace_.client_explains = explains != nullptr && explains->is_boolean() && explains->get<bool>();
  const Json* editor_folders = member(params, "workspaceFolders");
  if (editor_folders != nullptr && editor_folders->is_array()) {
    for (const Json& folder : *editor_folders) {
      if (const std::string* uri = string_member(folder, "uri"); uri != nullptr) add_root(*uri);
    }
  } else if (root != nullptr) {
    add_root(*root);
  }
  state_ = State::Running;
  return Json{{"capabilities", capabilities(workspace_.encoding)}, {"serverInfo", {{"name", "bipc-lsp"}}}};
}

// Only a folder on the disk has files that are not open.
void Server::add_root(const std::string& uri) {
  const std::filesystem::path folder = path_of(uri);
  if (folder.is_absolute() && folder.has_relative_path())
    workspace_.unopened.add_root(folder.lexically_normal().string());
}

void Server::notification(const std::string& method, const Json& params) {
  if (method == "exit") {
    exit_code_ = state_ == State::ShutDown ? 0 : 1;
    state_ = State::Finished;
    return;
  }
  // Notifications have no answer: out of order they are dropped, as the protocol says.
  if (state_ != State::Running) return;
  if (method == "textDocument/didOpen") return did_open(params);
  if (method == "textDocument/didChange") return did_change(params);
  if (method == "textDocument/didClose") return did_close(params);
  if (method == "textDocument/didSave") return did_save(params);
}

void Server::check(const std::string& path) {
  for (Json& params : workspace_.check(path)) notify("textDocument/publishDiagnostics", std::move(params));
}

}  // namespace bip::lsp
