// Decides deadlock-freedom of a compound for every size: `bipc verify --for-all n`. Small sizes are decided one by one,
// by the engines for one system, all others at once (compiler/verify/sizes). A certificate is those of the small sizes,
// one after the other, and the one of all others.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "compiler/library/decide.hpp"

namespace bip::library {

/// `n`, or `n >= 3`.
struct SizeQuestion {
  std::string parameter;
  std::optional<std::int32_t> least;  // none: the first size that compiles
};
[[nodiscard]] Result<SizeQuestion> read_size_question(const std::string& text);

struct SizeVerdict {
  Verdict verdict;
  std::string usage_error;               // not empty: no compound type is meant
  std::unique_ptr<Compilation> refused;  // not null: no size compiles, its diagnostics say why
};
/// Answers for the compound type that the root names, or the only one whose one parameter is the size. `model`: the
/// file compiled up to Stage::Model, without a root.
[[nodiscard]] SizeVerdict decide_for_all_sizes(const VerifyRequest& request, const Compilation& model,
                                               const std::string& root, const SizeQuestion& asked,
                                               const verify::CancellationToken& token);

/// Returns, as the text of a verdict, the systems that certcheck reads beside the certificate: of each size below the
/// description's least one, from the first on; of that one, with what says how it grows; and of two greater ones.
[[nodiscard]] SizeVerdict print_all_sizes(const Compilation& model, const std::string& root, const SizeQuestion& asked);

}  // namespace bip::library
