// The `.bip` files below the editor's folders that are not open: what they declare, and where they use a name.
//
// They are read from the disk when they are asked for, so an answer is as new as the files. Folders whose name begins
// with a dot, node_modules and symbolic links are passed over.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lsp/analysis.hpp"

namespace bip::lsp {

class UnopenedFiles {
 public:
  /// Files beyond this number are passed over: a home directory may be opened as a folder.
  static constexpr std::size_t kMostFiles = 5000;

  void add_root(const std::string& folder) { roots_.push_back(folder); }
  [[nodiscard]] bool contains(const std::string& path) const;
  /// The names in each file in whose text `name` occurs and that is not among `open`, by path; those texts replace the
  /// files of used packages. Reads all files and parses those that hold the name. Order: by path.
  [[nodiscard]] std::vector<Analysis> with_name(std::string_view name, const std::vector<std::string>& folders,
                                                const std::map<std::string, std::string>& open) const;
  /// What each file that is not among `open` declares, by path; a file is parsed again when it has changed. Valid until
  /// the next call.
  [[nodiscard]] const std::map<std::string, Analysis>& declarations(const std::map<std::string, std::string>& open);

 private:
  struct Version {
    std::filesystem::file_time_type time;
    std::uintmax_t size = 0;
    friend bool operator==(const Version&, const Version&) = default;
  };
  [[nodiscard]] std::map<std::string, Version> files() const;

  std::vector<std::string> roots_;
  std::map<std::string, Version> versions_;
  std::map<std::string, Analysis> declarations_;
};

}  // namespace bip::lsp
