// `bipc simulate --query`: what is asked of the runs of a model, in the notation of PRISM and SBIP.
//
//   query  = 'P' '=?' '[' path ']' | 'P' ('>=' | '<=') SHARE '[' path ']' | 'E' '=?' '[' OBSERVER ']'
//   path   = ('F' | 'G') [bound] EXPR | EXPR 'U' [bound] EXPR
//   bound  = '<=' LIMIT | '{' LIMIT '}' | '[' '0' ',' LIMIT ']'         LIMIT: a number of steps, or a time as 500ms
//
// EXPR is a condition on states (compiler/verify/property), OBSERVER a line of `--observe` (read_observer.hpp).
#pragma once
#include <string>

#include "compiler/base/result.hpp"
#include "compiler/system/system_ids.hpp"
#include "runtime/engine/simulate.hpp"

namespace bip::library {

enum class QueryKind : std::uint8_t { Probability, AtLeast, AtMost, Expectation };
struct Query {
  std::string text;  // as it was asked
  QueryKind kind = QueryKind::Probability;
  double share = 0;       // AtLeast, AtMost
  rt::PathQuery path;     // all but Expectation
  rt::Observer observer;  // Expectation
};

/// Parses a query and resolves its names. The error is a phrase.
[[nodiscard]] Result<Query> read_query(const std::string& text, const System& system);

}  // namespace bip::library
