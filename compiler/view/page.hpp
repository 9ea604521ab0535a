// One HTML page with the pictures of a model and a run of it. It makes no request: pictures, data, style and scripts
// are in it. Equal models and runs give equal pages.
#pragma once
#include <string>

#include <nlohmann/json.hpp>

#include "compiler/graph/graph.hpp"
#include "compiler/system/system.hpp"

namespace bip::view {

/// Returns the page. `run`: of record_run, or null. Structures of systems with nested compounds are in it several
/// times, one for each depth, up to kMostPicture bytes each.
[[nodiscard]] std::string page(const System& system, const std::string& title, const graph::PictureOptions& options,
                               const nlohmann::ordered_json& run = nullptr);

inline constexpr std::size_t kMostPicture = std::size_t{6} << 20, kMostFirstPicture = std::size_t{1} << 20;

}  // namespace bip::view
