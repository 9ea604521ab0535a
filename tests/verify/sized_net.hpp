// Random systems of any size, for the lemmas that are learnt from small ones.
#pragma once
#include <cstdint>
#include <string>

namespace bip::verify::test {

/// The text of a model with an array of `size` components, at least 2, and a component beside it. Texts of one seed
/// differ in the size only.
[[nodiscard]] std::string sized_net(std::uint64_t seed, std::uint32_t size);

}  // namespace bip::verify::test
