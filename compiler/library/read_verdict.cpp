// See read_verdict.hpp.
#include "compiler/library/read_verdict.hpp"

#include <nlohmann/json.hpp>

namespace bip::library {

void read_verdict(const nlohmann::ordered_json& json, compiler::Verdict& verdict) {
  verdict.name = json.value("verdict", "");
  verdict.property = json.value("property", "");
  verdict.method = json.value("method", "");
  verdict.reason = json.value("reason", "");
  verdict.states = json.value("states", json.value("zones", std::uint64_t{0}));
  verdict.invariants = json.value("invariants", std::uint64_t{0});
  verdict.lemmas = json.value("lemmas", std::uint64_t{0});
}

}  // namespace bip::library
