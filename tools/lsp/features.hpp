// The answers to requests, one function per request. The document must be open; offsets are in its text.
#pragma once
#include "tools/lsp/workspace.hpp"

namespace bip::lsp {

// navigate.cpp
[[nodiscard]] Reply definition(Workspace& w, const Document& d, std::uint32_t offset);
enum class Declarations : std::uint8_t { Excluded, Included };
[[nodiscard]] Reply references(Workspace& w, const Document& d, std::uint32_t offset, Declarations declarations);
[[nodiscard]] Reply prepare_rename(Workspace& w, const Document& d, std::uint32_t offset);
[[nodiscard]] Reply rename(Workspace& w, const Document& d, std::uint32_t offset, const std::string& name);

// hover.cpp
[[nodiscard]] Reply hover(Workspace& w, const Document& d, std::uint32_t offset);

// lenses.cpp
[[nodiscard]] Reply code_lenses(Workspace& w, const Document& d);
[[nodiscard]] Reply folding_ranges(Workspace& w, const Document& d);
[[nodiscard]] Reply document_highlights(Workspace& w, const Document& d, std::uint32_t offset);
[[nodiscard]] Json selection_range(Workspace& w, const Document& d, std::uint32_t offset);
[[nodiscard]] Reply workspace_symbols(Workspace& w, const std::string& query);
[[nodiscard]] Reply document_links(Workspace& w, const Document& d);

// inlay_hints.cpp
/// Of the declarations between the offsets.
[[nodiscard]] Reply inlay_hints(Workspace& w, const Document& d, std::uint32_t begin, std::uint32_t end);

// signature.cpp
/// The parameters of what is called or instantiated at the offset.
[[nodiscard]] Reply signature_help(Workspace& w, const Document& d, std::uint32_t offset);

// symbols.cpp
/// The protocol's SymbolKind; 0: not in an outline.
[[nodiscard]] int outline_kind(index::SymbolKind kind);
[[nodiscard]] Reply document_symbols(Workspace& w, const Document& d);
/// Of the names between the offsets.
[[nodiscard]] Reply semantic_tokens(Workspace& w, const Document& d, std::uint32_t begin = 0,
                                    std::uint32_t end = ~std::uint32_t{0});
[[nodiscard]] Json semantic_legend();

// completion.cpp
[[nodiscard]] Reply completion(Workspace& w, const Document& d, std::uint32_t offset);

// format.cpp
[[nodiscard]] Reply formatting(Workspace& w, const Document& d);
/// Edits that the diagnostics in the range suggest.
[[nodiscard]] Reply code_actions(Workspace& w, const Document& d, std::uint32_t begin, std::uint32_t end);

/// Everything that a name may mean at the offset, innermost first.
[[nodiscard]] std::vector<index::SymbolId> names_in_scope(const index::Index& index, FileId file, std::uint32_t offset);

}  // namespace bip::lsp
