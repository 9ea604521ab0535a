// `@weight(3)`, `@weight(0.5)`, `@weight(rate)` before a transition or a connector (semantics.md, Weights).
#pragma once
#include "compiler/model/model_builder.hpp"

namespace bip::model {

/// Returns the weight of a transition of `atom`, whose parameters are there.
[[nodiscard]] Weight build_weight(ModelBuilder& b, const syntax::Transition& t, const AtomType& atom);
/// Returns the weight of a connector, which exports a port or not.
[[nodiscard]] double build_weight(ModelBuilder& b, const syntax::CompoundItem& connector, bool exports);

}  // namespace bip::model
