// A cache on disk of machine code and proofs: files in a folder, named by the hash of all inputs.
//
// A look-up returns the bytes that were stored under the name, or nothing: a truncated, changed or renamed file is
// detected by the hash of name and contents at its beginning and counts as absent. (A user who can write to the folder
// can forge the hash as well: it is made with mode 0700, and used only if it is the user's and not writable by others.)
// Several processes may use a folder at the same time, since files are renamed into place. No function fails: a folder
// that cannot be written is an empty cache. Cost: reading and hashing the file.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bip {

/// Object: machine code of the JIT. Library: compiled C++ of a model. Proof: what the prover found.
enum class ContentKind : std::uint8_t { Object, Library, Proof };

class ContentCache {
 public:
  /// An empty folder: nothing is ever found or kept.
  ContentCache(ContentKind kind, std::string folder, std::uint64_t most_bytes)
      : kind_(kind), folder_(std::move(folder)), most_bytes_(most_bytes) {}
  /// Removes what was not used longest, of all kinds, if more than most_bytes are kept and this object added some.
  ~ContentCache();
  ContentCache(const ContentCache&) = delete;
  ContentCache& operator=(const ContentCache&) = delete;

  [[nodiscard]] bool is_on() const { return !folder_.empty(); }
  [[nodiscard]] std::optional<std::string> load(const std::string& name);
  /// True: it is kept.
  bool store(const std::string& name, std::string_view bytes);
  /// Files that were no good.
  [[nodiscard]] const std::vector<std::string>& broken() const { return broken_; }

 private:
  void tidy() const;
  ContentKind kind_;
  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  bool has_stored_ = false;
  std::vector<std::string> broken_;
};

}  // namespace bip
