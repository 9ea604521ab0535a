// See unopened_files.hpp.
#include "tools/lsp/unopened_files.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <utility>

#include "compiler/base/visit_files.hpp"
#include "compiler/pipeline/load_packages.hpp"

namespace bip::lsp {
namespace {

namespace fs = std::filesystem;

// Entries of folders that are looked at: the largest tree that does not hold up an answer.
constexpr std::size_t kMostEntries = 200'000;

enum class Used : std::uint8_t { Loaded, Ignored };

Analysis names_in(const std::string& path, const std::vector<std::string>& folders,
                  const std::map<std::string, std::string>& open, Used used) {
  pipeline::CompileOptions options;
  options.folders = folders;
  auto c = std::make_unique<pipeline::Compilation>(std::move(options));
  for (const auto& [other, text] : open) c->open_texts.emplace(other, text);
  (void)pipeline::compile(*c, path, pipeline::Stage::Syntax);
  if (c->syntax.has_value() && c->syntax->package != nullptr && used == Used::Loaded && c->packages.empty())
    (void)pipeline::load_packages(*c);
  Analysis names = take_names(std::move(c));
  forget_products(*names.compilation);
  return names;
}

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

bool UnopenedFiles::contains(const std::string& path) const {
  return std::any_of(roots_.begin(), roots_.end(), [&](const std::string& root) {
    const fs::path relative = fs::path(path).lexically_relative(root);
    return !relative.empty() && *relative.begin() != "..";
  });
}

std::map<std::string, UnopenedFiles::Version> UnopenedFiles::files() const {
  std::map<std::string, Version> found;
  std::size_t entries = 0;
  for (const std::string& root : roots_) {
    visit_files(root, [&](const FolderEntry& entry) {
      if (++entries > kMostEntries || found.size() >= kMostFiles) return Visit::Stop;
      std::error_code gone;
      const std::string name = entry.path.filename().string();
      if (entry.is_folder) return name.starts_with('.') || name == "node_modules" ? Visit::SkipFolder : Visit::GoOn;
      if (name.ends_with(".bip") && fs::is_regular_file(entry.path, gone)) {
        const Version version{fs::last_write_time(entry.path, gone), fs::file_size(entry.path, gone)};
        if (!gone) found.emplace(entry.path.lexically_normal().string(), version);
      }
      return Visit::GoOn;
    });
  }
  return found;
}

std::vector<Analysis> UnopenedFiles::with_name(std::string_view name, const std::vector<std::string>& folders,
                                               const std::map<std::string, std::string>& open) const {
  std::vector<Analysis> found;
  for (const auto& [path, version] : files()) {
    if (!open.contains(path) && text_of(path).find(name) != std::string::npos)
      found.push_back(names_in(path, folders, open, Used::Loaded));
  }
  return found;
}

const std::map<std::string, Analysis>& UnopenedFiles::declarations(const std::map<std::string, std::string>& open) {
  std::map<std::string, Version> now = files();
  std::erase_if(now, [&](const auto& row) { return open.contains(row.first); });
  std::erase_if(declarations_, [&](const auto& row) {
    const auto same = now.find(row.first);
    return same == now.end() || same->second != versions_[row.first];
  });
  for (const auto& [path, version] : now) {
    if (!declarations_.contains(path)) declarations_.emplace(path, names_in(path, {}, {}, Used::Ignored));
  }
  versions_ = std::move(now);
  return declarations_;
}

}  // namespace bip::lsp
