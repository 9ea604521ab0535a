// See search_symmetry.hpp.
#include "compiler/verify/portfolio/search_symmetry.hpp"

#include <memory>

#include "compiler/verify/property/symmetric_property.hpp"

namespace bip::verify {

namespace {

// Less than a second. What takes longer has too many states for a search anyway.
constexpr rt::u64 kWork = 3'000'000;
// A node of a property is hashed and compared several times.
constexpr rt::u64 kWorkOfNode = 4;

}  // namespace

rt::SymmetryLimits symmetry_limits() {
  rt::SymmetryLimits limits;
  limits.work = kWork;
  return limits;
}

void use_symmetry(const Question& question, const rt::Image& image, rt::ExploreOptions& options) {
  options.symmetry = symmetry_limits();
  if (question.what == QuestionKind::State) {
    const Property& property = question.property;
    options.symmetry.named_atoms = atoms_of(property);
    options.symmetry.fixed_connectors = connectors_of(property);
    options.symmetry.work_per_exchange = kWorkOfNode * property.nodes.size();
    options.symmetry.preserves_predicate =
        [images = std::make_shared<const PropertyImages>(property)](const rt::AtomExchange& exchange) {
          return images->is_preserved_by(exchange);
        };
  }
  options.reduction = rt::StateReduction::Symmetry;
  if (rt::reduction_problem(image, options).empty()) return;
  options.reduction = rt::StateReduction::None;
  options.symmetry = {};
}

bool has_symmetry(const Question& question, const rt::Image& image) {
  rt::ExploreOptions options;
  use_symmetry(question, image, options);
  return options.reduction == rt::StateReduction::Symmetry;
}

bool has_symmetry(const rt::Image& image) { return has_symmetry(Question{}, image); }

}  // namespace bip::verify
