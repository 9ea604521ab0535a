// The open documents, and the compiler's diagnostics for each.
//
// Every change is followed by a full check with the code of `bipc check`, so both report the same diagnostics. A
// document that uses the package of a changed one is checked again. Open texts replace the files on disk. Of large
// documents no more is read than an answer needs.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/lsp/analysis.hpp"
#include "tools/lsp/json_rpc.hpp"
#include "tools/lsp/unopened_files.hpp"

namespace bip::lsp {

struct Document {
  std::string uri;
  std::string path;
  std::int64_t version = 0;
  // Edits of the text, of the one whose names are known, and of the one that was checked.
  std::uint64_t edits = 0, named_edits = 0, checked_edits = 0;
  Text text{std::string()};
  std::map<std::string, parse::PieceCache> kept;  // of this file and those it uses, by path
  Analysis analysis;                              // its names
  Findings findings;
  /// The names of the text that was checked last are still to be read, from the trees that `findings.own` has. They
  /// are valid until the next parse with `kept`.
  bool has_unread_names = false;
  bool has_products = false;  // that nothing needs any more, and that take their time to be freed
  /// Names as they were when the text could last be read: for completion while it cannot.
  index::Index last_names;
  std::unique_ptr<pipeline::Compilation> last_compilation;
};

class Workspace {
 public:
  Encoding encoding = Encoding::Utf16;
  std::vector<std::string> folders;  // as -I
  /// The client shows the page of a code: it has the command `bip.explain` and reads addresses `bip-explain:/CODE.md`.
  bool client_explains = false;
  UnopenedFiles unopened;
  std::uint64_t checks = 0;  // of documents so far: what a session costs

  Document& open(std::string uri, std::string text, std::int64_t version);
  void close(const std::string& uri);
  [[nodiscard]] Document* find(const std::string& uri);
  [[nodiscard]] Document* find_path(const std::string& path);
  [[nodiscard]] std::map<std::string, std::unique_ptr<Document>>& documents() { return documents_; }

  /// The text of each open document, by path.
  [[nodiscard]] std::map<std::string, std::string> open_texts() const;

  /// Checks the document and those that use its package. Returns the parameters of publishDiagnostics that are due.
  [[nodiscard]] std::vector<Json> check(const std::string& path);

  /// Reads the names of a document that changed, without a check; its diagnostics stay those of the last one. False if
  /// it has to be read as a whole for that: then a check may as well do it.
  [[nodiscard]] bool read_names(Document& d);

  /// A check of a large document leaves the names of its text unread, as its diagnostics do not need them: they are
  /// here, for all documents. Call it before answers from names.
  void read_names_of_checks();
  /// That, and what else the last answers left undone.
  void finish();
  [[nodiscard]] bool is_unfinished() const;
  [[nodiscard]] static bool is_large(const Document& d);
  /// Does another open document use the file as a package?
  [[nodiscard]] bool is_used_by_others(const std::string& path) const;

  /// The numbers of checks so far, and of the pieces of open documents that were parsed, that were not parsed again,
  /// and of the texts that were read as a whole.
  [[nodiscard]] Json work_done() const;

  /// The text of a document that has been checked in the standard layout; nothing if it cannot be read as a whole.
  [[nodiscard]] std::optional<std::string> formatted(const std::string& uri);

  /// What the check of an open document found in it.
  [[nodiscard]] Json diagnostics_in(const Document& d) const;
  /// A range of an analysis in the protocol's form. Files that are not open are read from the analysis' own text.
  [[nodiscard]] Json range(const Analysis& a, SourceRange r) const;
  [[nodiscard]] Json range(const Findings& f, SourceRange r) const;
  /// {uri, range}
  [[nodiscard]] Json location(const Analysis& a, SourceRange r) const;

 private:
  void analyse(Document& d);
  static void read_names_of_check(Document& d);
  [[nodiscard]] static bool uses(const Document& d, const std::string& path);
  [[nodiscard]] std::unique_ptr<pipeline::Compilation> compilation_of(Document& d) const;
  enum class Texts : std::uint8_t { Equal, Unknown };
  [[nodiscard]] Json range(const pipeline::Compilation* c, const std::string* path, SourceRange r, Texts texts) const;
  [[nodiscard]] Json diagnostic(const Document& d, const Diagnostic& from) const;
  [[nodiscard]] std::vector<Json> publish();

  std::map<std::string, std::unique_ptr<Document>> documents_;  // by path
  std::map<std::string, std::string> published_;                // by URI: what was sent last, without the version
};

}  // namespace bip::lsp
