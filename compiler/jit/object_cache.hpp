// Machine code kept on disk: object files in a folder, named by the hash of all that they were made from.
//
// Whoever asks for a name gets bytes that were stored under it, or nothing: a file that is cut or changed is recognised by
// the hash it begins with and counts as none. Several processes may use a folder at a time, since files appear by renaming.
// Nothing here fails: a folder that cannot be written is one that never has anything. Cost: reading and hashing the file.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bip::jit {

/// 64 hexadecimal digits (BLAKE3) of texts, told apart where one ends and the next begins.
[[nodiscard]] std::string content_hash(const std::vector<std::string_view>& texts);

class ObjectCache {
 public:
  /// An empty folder: nothing is ever found or kept.
  ObjectCache(std::string folder, std::uint64_t most_bytes) : folder_(std::move(folder)), most_bytes_(most_bytes) {}
  /// Removes what was not used longest if more than most_bytes are kept and this object added some.
  ~ObjectCache();
  ObjectCache(const ObjectCache&) = delete;
  ObjectCache& operator=(const ObjectCache&) = delete;

  [[nodiscard]] bool is_on() const { return !folder_.empty(); }
  [[nodiscard]] std::optional<std::string> load(const std::string& name);
  void store(const std::string& name, std::string_view bytes);
  /// Files that were no good.
  [[nodiscard]] const std::vector<std::string>& broken() const { return broken_; }

 private:
  void tidy() const;
  std::filesystem::path folder_;
  std::uint64_t most_bytes_;
  bool has_stored_ = false;
  std::vector<std::string> broken_;
};

}  // namespace bip::jit
