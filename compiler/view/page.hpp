// One HTML page with the pictures of a model and a run of it. It makes no request: pictures, data, style and scripts
// are in it. Equal models and runs give equal pages. A live page (compiler/live) connects to the session that it shows.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include "compiler/graph/graph.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::view {

struct PageOptions {
  std::string connects_to;       // of a live page: the source that it connects to, `ws://127.0.0.1:1234`
  std::string attached_role;     // of a page of a served model: what it may do (compiler/serve); empty: it is none
  nlohmann::ordered_json proof;  // of record_proof, or null
};

/// Returns the page. `run`: of record_run, or null. Structures of systems with nested compounds are in it several
/// times, one for each depth, up to kMostPicture bytes each.
[[nodiscard]] std::string page(const System& system, const std::string& title, const graph::PictureOptions& options,
                               const nlohmann::ordered_json& run = nullptr, const PageOptions& more = {});

inline constexpr std::size_t kMostPicture = std::size_t{6} << 20, kMostFirstPicture = std::size_t{1} << 20;

}  // namespace bip::view
