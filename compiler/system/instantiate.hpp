// From types to instances: the root compound is unfolded into flat tables. Components are flattened, connectors stay
// symbolic. Reports what only instances show (bounds of arrays, a component twice in one interaction, cycles).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compiler/model/model.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::system {

/// Bounds on what is unfolded, since a slip in a size or a loop's bound would otherwise fill the memory.
struct UnfoldingLimits {
  /// Of atoms, of compounds, of connectors, of priorities, of alternatives below one connector.
  std::size_t instances = 2'000'000;
  /// A round of a loop may declare nothing: all rounds, for each instance that is allowed.
  std::size_t rounds_per_instance = 10;
};
/// Largest limit: instances are numbered with 32 bits, and some numbers have a meaning of their own.
inline constexpr std::size_t kMostInstances = 1'000'000'000;
inline constexpr std::size_t kMaxDepth = 200;

/// `root_type` empty: the one parameterless compound that nothing instantiates. `args` are constant expressions, one a
/// parameter; `root_range` is where problems of the root itself are reported.
[[nodiscard]] std::optional<System> instantiate(Model& model, const std::string& root_type,
                                                const std::vector<const syntax::Expr*>& args, Diagnostics& diags,
                                                SourceRange root_range, const UnfoldingLimits& limits = {});

}  // namespace bip::system
