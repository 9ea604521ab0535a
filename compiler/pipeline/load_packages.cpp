// Follows `use` depth first with an explicit stack, so that a chain of packages may have any length.
#include "compiler/pipeline/load_packages.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include "compiler/base/visit_files.hpp"
#include "compiler/pipeline/parts.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::pipeline {
namespace {

namespace fs = std::filesystem;

// Names for "similar name" helps are looked for among this many files at most.
constexpr std::size_t kMaxListed = 2000;
constexpr int kMaxListedDepth = 4;

std::string text_of(const syntax::Path& path) {
  std::string text;
  for (const syntax::PathPart& part : path.parts) text += (text.empty() ? "" : ".") + std::string(part.name.text);
  return text;
}

std::string package_of_file(std::string relative) {
  relative.resize(relative.size() - std::string_view(".bip").size());
  std::replace(relative.begin(), relative.end(), '/', '.');
  return relative;
}

// One load: the folders, what was met so far, and the chain of `use` lines to where we are.
class Loader {
 public:
  explicit Loader(Compilation& c) : compilation_(c) {
    for (const std::string& folder : c.options.folders) add_folder(folder);
    add_folder(own_folder());
    if (const std::string standard = find_stdlib(); !standard.empty()) {
      library_ = fs::path(standard).lexically_normal();
      add_folder(standard);
    }
  }

  void load_all() {
    enter(*compilation_.syntax, text_of(compilation_.syntax->package->name), {});
    while (!stack_.empty()) {
      Visit& top = stack_.back();
      const auto uses = top.syntax->package->uses;
      if (top.next == uses.size()) {
        BIP_ASSERT(states_[top.name] == State::Open, "package `{}` is done twice", top.name);
        states_[top.name] = State::Done;
        compilation_.packages.push_back(top.syntax);
        stack_.pop_back();
      } else {
        use(uses[top.next++]);
      }
    }
  }

 private:
  enum class State : std::uint8_t { Open, Done, Failed };
  struct Visit {
    const syntax::Syntax* syntax;
    std::string name;
    SourceRange from;  // the `use` that led here
    std::size_t next = 0;
  };

  void add_folder(const std::string& folder) {
    const fs::path path = fs::path(folder.empty() ? "." : folder).lexically_normal();
    if (std::find(folders_.begin(), folders_.end(), path) == folders_.end()) folders_.push_back(path);
  }

  [[nodiscard]] std::string own_folder() const {
    return folder_of_packages(compilation_.path, text_of(compilation_.syntax->package->name));
  }

  void enter(const syntax::Syntax& syntax, const std::string& name, SourceRange from) {
    states_[name] = State::Open;
    stack_.push_back({&syntax, name, from});
  }

  void use(const syntax::Path& path) {
    const std::string name = text_of(path);
    const auto known = states_.find(name);
    if (known == states_.end()) {
      if (const syntax::Syntax* syntax = read(path, name)) {
        enter(*syntax, name, path.range);
      } else {
        states_[name] = State::Failed;
      }
    } else if (known->second == State::Open) {
      report_circle(path, name);
    }
  }

  void report_circle(const syntax::Path& path, const std::string& name) {
    if (stack_.back().name == name) {
      compilation_.diags.report(Diag::kB1065, path.range, name).help("remove this line");
      return;
    }
    BIP_ASSERT(std::any_of(stack_.begin(), stack_.end(), [&](const Visit& v) { return v.name == name; }),
               "package `{}` is open, and not on the stack", name);
    const auto first = std::find_if(stack_.begin(), stack_.end(), [&](const Visit& v) { return v.name == name; });
    std::string chain;
    for (auto it = first; it != stack_.end(); ++it) chain += "`" + it->name + "` -> ";
    auto d = compilation_.diags.report(Diag::kB1061, path.range, chain + "`" + name + "`");
    for (auto it = std::next(first); it != stack_.end(); ++it)
      d.label(it->from, fmt::format("`{}` uses `{}`", std::prev(it)->name, it->name));
    d.help("put what both need into a third package");
  }

  const syntax::Syntax* read(const syntax::Path& path, const std::string& name) {
    const std::string file_name = file_of_package(name);
    std::error_code ignored;
    for (const fs::path& folder : folders_) {
      const fs::path candidate = (folder / file_name).lexically_normal();
      if (!fs::is_regular_file(candidate, ignored)) continue;
      // The library's files are called the same on every machine, for traces are.
      return parse(candidate.string(), folder == library_ ? file_name : candidate.string(), path, name);
    }
    report_missing(path, name);
    return nullptr;
  }

  const syntax::Syntax* parse(const std::string& location, const std::string& file_name, const syntax::Path& path,
                              const std::string& name) {
    const Result<FileId> file = load_text(compilation_, location, file_name);
    if (!file) {
      compilation_.diags.report(Diag::kB0090, path.range, file_name, file.error());
      return nullptr;
    }
    std::optional<syntax::Syntax> syntax = parse_text(compilation_, *file);
    if (!syntax || syntax->package == nullptr) return nullptr;
    const syntax::Path& found = syntax->package->name;
    if (found.parts.empty()) {
      compilation_.diags.report(Diag::kB1063, path.range, file_name, name)
          .help(fmt::format("begin the file with `package {}`", name));
      return nullptr;
    }
    if (const std::string written = text_of(found); written != name) {
      compilation_.diags.report(Diag::kB1062, found.range, written, name)
          .label(path.range, "read for this `use`")
          .help(fmt::format("name it `{}`", name), found.range, name);
      return nullptr;
    }
    compilation_.used.push_back(std::move(*syntax));
    return &compilation_.used.back();
  }

  void report_missing(const syntax::Path& path, const std::string& name) {
    auto d = compilation_.diags.report(Diag::kB1060, path.range, name);
    std::string tried;
    // The library's place is no one's choice, so it is not listed as one.
    for (const fs::path& folder : folders_) {
      const bool is_library = folder == library_;
      if (is_library) {
        if (name.starts_with("std."))
          tried += (tried.empty() ? "`" : ", `") + file_of_package(name) + "` of the standard library";
        continue;
      }
      tried += (tried.empty() ? "`" : ", `") + (folder / file_of_package(name)).lexically_normal().string() + "`";
    }
    d.note("looked for " + tried);
    for (const std::string& similar : similar_names(name, packages_below(folders_)))
      d.help(fmt::format("there is `{}`", similar), path.range, similar);
    d.help("`-I DIR` adds a folder in which packages are looked for");
  }

  Compilation& compilation_;
  std::vector<fs::path> folders_;
  fs::path library_;
  std::map<std::string, State> states_;
  std::vector<Visit> stack_;
};

}  // namespace

bool load_packages(Compilation& c) {
  c.packages.clear();
  c.used.clear();
  if (!c.syntax || c.syntax->package == nullptr) return false;
  if (const std::string& wanted = c.options.package; !wanted.empty() && text_of(c.syntax->package->name) != wanted) {
    const syntax::Path& name = c.syntax->package->name;
    if (name.parts.empty()) {
      c.diags.report(Diag::kB1063, {}, c.path, wanted).help(fmt::format("begin the file with `package {}`", wanted));
    } else {
      c.diags.report(Diag::kB1062, name.range, text_of(name), wanted)
          .help(fmt::format("name it `{}`", wanted), name.range, wanted);
    }
    return false;
  }
  Loader(c).load_all();
  return !c.diags.has_errors();
}

std::vector<std::string> packages_below(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  std::size_t seen = 0;
  for (const fs::path& folder : folders) {
    visit_files(folder, [&](const FolderEntry& entry) {
      if (seen++ >= kMaxListed) return Visit::Stop;
      if (entry.path.extension() == ".bip")
        names.push_back(package_of_file(entry.path.lexically_relative(folder).string()));
      return entry.depth >= kMaxListedDepth ? Visit::SkipFolder : Visit::GoOn;
    });
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string folder_of_packages(const fs::path& path, const std::string& package) {
  fs::path expected(file_of_package(package));
  fs::path folder = path;
  for (; !expected.empty(); expected = expected.parent_path(), folder = folder.parent_path()) {
    if (expected.filename() != folder.filename()) return path.parent_path().string();
  }
  return folder.string();
}

std::string find_stdlib() {
  std::error_code ignored;
  // In a build tree CMake leaves a link `stdlib` to the sources beside the program.
  for (const fs::path& candidate : places_of_part("stdlib")) {
    if (fs::is_directory(candidate / "std", ignored)) return candidate.string();
  }
  return {};
}

std::string file_of_package(const std::string& package) {
  std::string file = package;
  std::replace(file.begin(), file.end(), '.', '/');
  return file + ".bip";
}

}  // namespace bip::pipeline
