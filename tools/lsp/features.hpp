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

// symbols.cpp
[[nodiscard]] Reply document_symbols(Workspace& w, const Document& d);
[[nodiscard]] Reply semantic_tokens(Workspace& w, const Document& d);
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
