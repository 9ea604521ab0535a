// file: URIs and paths. Other schemes (untitled:…) have no path; their whole text is used as one, so that such
// documents can be checked like files, without a folder of their own.
#pragma once
#include <string>
#include <string_view>

namespace bip::lsp {

/// The path of a file: URI with %XX decoded and dots removed; anything else as it is.
[[nodiscard]] std::string path_of(std::string_view uri);
/// The file: URI of an absolute path; what is no absolute path is returned as it is.
[[nodiscard]] std::string uri_of(std::string_view path);

}  // namespace bip::lsp
