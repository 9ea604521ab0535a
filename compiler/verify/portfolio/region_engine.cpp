// See region_engine.hpp.
#include "compiler/verify/portfolio/region_engine.hpp"

#include "compiler/model/code_uses.hpp"
#include "compiler/system/system.hpp"
#include "compiler/verify/regions/refute_bad_states.hpp"
#include "runtime/explore/explore.hpp"

namespace bip::verify {

namespace {

// Do connectors read or write data of the components that they join? Else numbers are no concern of neighbours, and
// other engines do as well.
bool passes_data(const System& system) {
  bool passes = false;
  const auto see = [&](const Expr& e) { passes |= e.op == Op::LoadBind; };
  for (const ConnectorType& type : system.connector_types) {
    for (const Clause& clause : type.clauses) {
      model::for_each_expr(system.code, clause.guard, see);
      model::for_each_assigned(system.code, clause.down, Op::LoadBind, [&](std::uint32_t) { passes = true; });
    }
  }
  return passes;
}

bool has_regions(const ProofContext& context) {
  const rt::Image& image = context.parts.image();
  const bool is_about_states =
      context.question.what == QuestionKind::State || context.question.what == QuestionKind::DeadlockFreedom;
  return is_about_states && context.limits.may_search && image.ffi == nullptr && !rt::has_time(image) &&
         passes_data(context.parts.system()) && is_plain_rendezvous(context.parts.system());
}

EngineResult prove_by_regions(ProofContext& context, const Budget& budget, const CancellationToken& cancellation) {
  EngineResult result;
  const CancellationToken share = cancellation.within(budget.seconds);
  const System& system = context.parts.system();
  const rt::Image& image = context.parts.image();
  const Property* const property = context.question.what == QuestionKind::State ? &context.question.property : nullptr;
  RegionSearch found;
  if (context.limits.wants_certificate) {
    // What holds whatever connectors write is checked much sooner.
    for (const Writing writing : {Writing::Anything, Writing::Followed}) {
      const CancellationToken part = writing == Writing::Anything ? share.within(budget.seconds / 2) : share;
      found = refute_bad_states(build_region_net(system, image, writing), property, part, RegionRows::Yes);
      if (found.proof) break;
    }
  } else {
    found = refute_bad_states(build_region_net(system, image), property, share);
  }
  if (!found.proof) {
    result.retry = found.is_complete ? Retry::Pointless : Retry::Useful;
    return result;
  }
  result.outcome = Outcome::Holds;
  result.evidence = RegionProof{found.proof->local_states, found.proof->explored, found.proof->implications,
                                std::move(found.proof->reasons), std::move(found.proof->rows)};
  return result;
}

}  // namespace

const Engine kRegionEngine{"regions", has_regions, prove_by_regions};

}  // namespace bip::verify
