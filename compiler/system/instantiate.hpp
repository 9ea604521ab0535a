// From types to instances: the root compound is unfolded into flat tables. Components are flattened, connectors stay
// symbolic. Reports what only instances show (bounds of arrays, a component twice in one interaction, cycles).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/model/model.hpp"
#include "compiler/system/system.hpp"

namespace bip::system {

/// Largest number of atoms, and of connectors, that is unfolded.
inline constexpr std::size_t kMaxInstances = 2'000'000;
inline constexpr std::size_t kMaxDepth = 200;

/// `root_type` empty: the one parameterless compound that nobody instantiates. `args` are constant expressions, one a
/// parameter; `root_range` is where problems of the root itself are reported.
[[nodiscard]] std::optional<System> instantiate(Model& model, const std::string& root_type,
                                                const std::vector<const syntax::Expr*>& args, Diagnostics& diags,
                                                SourceRange root_range);

}  // namespace bip::system
