// The four checks of a certificate (compiler/docs/certificate.md).
#pragma once
#include "tools/certcheck/model.hpp"

namespace certcheck {

/// What was accepted, in a few words. Throws Rejected or NotCheckable.
[[nodiscard]] std::string check(const Model& model, const std::string& certificate);

}  // namespace certcheck
