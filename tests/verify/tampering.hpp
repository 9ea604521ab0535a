// What an enemy or a bad disk does to kept proofs: bytes that flip, ends that are lost, and rows that say something
// else under a right hash.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace bip::verify::test {

/// Names of the proofs that a folder keeps, sorted.
[[nodiscard]] std::vector<std::string> kept_names(const std::filesystem::path& folder);
/// Bytes of each file changed or cut, mostly: no hash is right any more.
void damage(const std::filesystem::path& folder, std::uint64_t seed);
/// Each file's rows changed, lost, doubled or exchanged, and the hash made right again; some become `foreign`. What the
/// last one was before.
[[nodiscard]] std::string forge(const std::filesystem::path& folder, const std::string& foreign, std::uint64_t seed);

}  // namespace bip::verify::test
