// What certcheck reads of a proof for all sizes: rows that say how the system of the description's least size grows,
// and the certificate (compiler/docs/certificate.md, "All sizes").
#pragma once
#include <string>

#include "compiler/verify/sizes/word_problem.hpp"

namespace bip::verify {

/// Returns the list that stands after the .bsys text of the instance of the description's least size.
[[nodiscard]] std::string for_all_rows(const SizedCompound& sized, const Model& model, const CompoundType& type);

/// Returns the certificate of all sizes from the description's least one on. `net`: of the instance of that size;
/// `root_name`: what it is called.
[[nodiscard]] std::string certificate_of_sizes(const SizedCompound& sized, const Net& net, const WordAnswer& answer,
                                               const std::string& root_name);

}  // namespace bip::verify
