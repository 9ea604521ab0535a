// Placement files: see distributed_runs.hpp. Line by line, words separated by spaces, comments from `#` on.
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/base/ascii.hpp"
#include "compiler/base/read_file.hpp"
#include "compiler/driver/distributed_runs.hpp"
#include "compiler/driver/interaction_counts.hpp"
#include "runtime/distributed/place_free_atoms.hpp"

namespace bip::driver {

namespace {

// Of components whose home is found when all lines are read.
constexpr std::uint32_t kAnywhere = rt::kNone - 1;

struct Word {
  std::string_view text;
  SourceRange range;
};

// Does the pattern name the atom, or a compound that it is in? `[1..3]` is 1 and 2, as in models, `[*]` any index, `*`
// alone everything. `ROOT.` may be left out of the pattern.
bool names(std::string_view pattern, std::string_view path) {
  if (pattern == "*") return true;
  constexpr std::string_view kRoot = "ROOT.";
  if (!pattern.starts_with(kRoot) && path.starts_with(kRoot)) path.remove_prefix(kRoot.size());
  const auto number = [](std::string_view& text, std::uint64_t& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return true;
  };
  while (!pattern.empty()) {
    if (path.empty() || pattern.front() != path.front()) return false;
    const bool is_index = pattern.front() == '[';
    pattern.remove_prefix(1);
    path.remove_prefix(1);
    if (!is_index) continue;
    std::uint64_t index = 0, from = 0, until = 0;
    if (!number(path, index)) return false;
    if (pattern.starts_with('*')) {
      pattern.remove_prefix(1);
      continue;
    }
    if (!number(pattern, from)) return false;
    until = from + 1;
    if (pattern.starts_with("..")) {
      pattern.remove_prefix(2);
      if (!number(pattern, until)) return false;
    }
    if (index < from || index >= until) return false;
  }
  return path.empty() || path.front() == '.' || path.front() == '[';
}

// HOST:PORT; whether there is such a host is found out when the node listens there.
bool is_address(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == 0 || colon == std::string_view::npos) return false;
  const std::string_view port = text.substr(colon + 1);
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size() || number == 0) return false;
  std::string_view host = text.substr(0, colon);
  // Hosts come into scripts: no sign of a shell, and nothing that a program would take for an option.
  std::string_view signs = "._-";
  if (host.front() == '[') {
    if (host.size() < 3 || host.back() != ']') return false;
    host = host.substr(1, host.size() - 2);
    signs = ":.%";
  }
  return host.front() != '-' && std::all_of(host.begin(), host.end(), [&](char c) {
           return is_letter(c) || is_digit(c) || signs.find(c) != std::string_view::npos;
         });
}

class PlacementReader {
 public:
  PlacementReader(Compilation& c, FileId file, rt::Placement& placement)
      : compilation_(c), file_(file), placement_(placement) {
    const rt::Image& image = c.lowered->image;
    for (std::uint32_t atom = 0; atom < image.atoms.size; ++atom) paths_.push_back(image.atoms[atom].path());
    placement.home.assign(paths_.size(), rt::kNone);
  }

  bool read() {
    const std::string_view text = compilation_.sources.text(file_);
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      split(text, begin, end);
      if (!words_.empty() && words_[0].text == "node") node();
      else if (words_.size() == 2 && words_[0].text == "counts" && words_[1].text != "anywhere") counts();
      else if (words_.size() > 1 && words_[0].text == "split" && words_[1].text != "on") split_above();
      else if (!words_.empty()) home();
      begin = end + 1;
    }
    if (compilation_.diags.has_errors()) return false;
    BIP_ASSERT(placement_.addresses.size() == placement_.nodes.size() && placement_.home.size() == paths_.size(),
               "{} addresses of {} nodes", placement_.addresses.size(), placement_.nodes.size());
    if (placement_.nodes.empty()) {
      compilation_.diags.report(Diag::kB5073, {},
                                fmt::format("`{}` declares no node", compilation_.sources.name(file_)));
      return false;
    }
    const auto without = std::find(placement_.home.begin(), placement_.home.end(), rt::kNone);
    if (without == placement_.home.end()) return place_free();
    compilation_.diags.report(Diag::kB5076, {}, paths_[static_cast<std::size_t>(without - placement_.home.begin())])
        .help(fmt::format("`* on {}` as the last line places whatever is left", placement_.nodes.front()));
    return false;
  }

 private:
  void split(std::string_view text, std::size_t begin, std::size_t end) {
    words_.clear();
    end = std::min(end, text.find('#', begin));
    const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (begin < end) {
      if (is_space(text[begin])) {
        ++begin;
        continue;
      }
      std::size_t stop = begin;
      while (stop < end && !is_space(text[stop])) ++stop;
      words_.push_back({text.substr(begin, stop - begin),
                        {file_, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(stop)}});
      begin = stop;
    }
  }
  [[nodiscard]] SourceRange line() const { return {file_, words_.front().range.begin, words_.back().range.end}; }

  void node() {
    if (words_.size() != 2 && !(words_.size() == 4 && words_[2].text == "host")) {
      compilation_.diags.report(Diag::kB5073, line(), "expected `node NAME` or `node NAME host ADDRESS:PORT`");
      return;
    }
    const std::string name(words_[1].text);
    if (words_.size() == 4 && !is_address(words_[3].text)) {
      compilation_.diags.report(Diag::kB5073, words_[3].range, fmt::format("`{}` is no `ADDRESS:PORT`", words_[3].text))
          .help("for example `10.0.0.7:7701`, `lab.example:7701` or `[fd00::7]:7701`");
    }
    if (name.find_first_of("-,*[]") != std::string::npos) {
      compilation_.diags.report(Diag::kB5073, words_[1].range, fmt::format("`{}` is no name of a node", name));
    } else if (std::find(placement_.nodes.begin(), placement_.nodes.end(), name) != placement_.nodes.end()) {
      compilation_.diags.report(Diag::kB5073, words_[1].range, fmt::format("node `{}` is declared twice", name));
    } else if (placement_.nodes.size() == rt::kMostNodes) {
      compilation_.diags.report(Diag::kB5073, words_[1].range, fmt::format("more than {} nodes", rt::kMostNodes));
    } else {
      placement_.nodes.push_back(name);
      placement_.addresses.emplace_back(words_.size() == 4 ? words_[3].text : std::string_view());
    }
  }

  void split_above() {
    if (words_.size() == 2 && words_[1].text == "never") {
      placement_.split_above = rt::kSplitNone;
      return;
    }
    if (words_.size() == 3 && words_[1].text == "above") {
      const std::string_view text = words_[2].text;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), placement_.split_above);
      if (error == std::errc() && end == text.data() + text.size()) return;
    }
    compilation_.diags.report(Diag::kB5073, line(), "expected `split above NUMBER` or `split never`")
        .help("for example `split above 100`: conflict sets of more than 100 interactions get several coordinators");
  }

  void counts() {
    const std::filesystem::path folder = std::filesystem::path(compilation_.sources.name(file_)).parent_path();
    counts_at_ = words_[1].range;
    counts_path_ = (folder / words_[1].text).string();
  }

  // What may be anywhere, by counts.
  bool place_free() {
    const bool is_any = std::find(placement_.home.begin(), placement_.home.end(), kAnywhere) != placement_.home.end();
    if (!is_any && counts_path_.empty()) return true;
    std::replace(placement_.home.begin(), placement_.home.end(), kAnywhere, rt::kNone);
    const rt::Tables tables = rt::link(compilation_.lowered->image, rt::MaximalProgress::On);
    if (!counts_path_.empty()) {
      const std::optional<std::string> bytes = read_file(counts_path_);
      Result<std::vector<std::uint64_t>> counts = Failure{"it cannot be read"};
      if (bytes) counts = read_counts(tables, *bytes);
      if (!counts) {
        compilation_.diags.report(Diag::kB5073, counts_at_,
                                  fmt::format("`{}` holds no counts: {}", counts_path_, counts.error()));
        return false;
      }
      placement_.counts = std::move(*counts);
    }
    if (is_any) rt::place_free_atoms(tables, rt::link_priorities(tables), placement_.counts, placement_);
    BIP_ASSERT(std::all_of(placement_.home.begin(), placement_.home.end(),
                           [&](std::uint32_t home) { return home < placement_.nodes.size(); }),
               "an atom has none of the {} nodes for its home", placement_.nodes.size());
    return true;
  }

  void home() {
    const bool is_anywhere = words_.size() == 2 && words_[1].text == "anywhere";
    if (is_anywhere) return give_home(kAnywhere);
    if (words_.size() != 3 || words_[1].text != "on") {
      compilation_.diags.report(Diag::kB5073, line(), "expected `COMPONENT on NODE` or `node NAME`")
          .help("for example `table.phil[0..2] on field`, `* on lab` or `* anywhere`");
      return;
    }
    const auto node = std::find(placement_.nodes.begin(), placement_.nodes.end(), words_[2].text);
    if (node == placement_.nodes.end()) {
      compilation_.diags.report(Diag::kB5074, words_[2].range, words_[2].text)
          .help(fmt::format("`node {}` in a line above", words_[2].text));
      return;
    }
    give_home(static_cast<std::uint32_t>(node - placement_.nodes.begin()));
  }

  void give_home(std::uint32_t node) {
    bool is_known = words_[0].text == "*";
    for (std::size_t atom = 0; atom < paths_.size(); ++atom) {
      if (!names(words_[0].text, paths_[atom])) continue;
      is_known = true;
      std::uint32_t& home = placement_.home[atom];
      if (home == rt::kNone) home = node;
    }
    if (!is_known) compilation_.diags.report(Diag::kB5075, words_[0].range, words_[0].text);
  }

  Compilation& compilation_;
  FileId file_;
  rt::Placement& placement_;
  std::vector<std::string> paths_;
  std::vector<Word> words_;
  SourceRange counts_at_;
  std::string counts_path_;
};

}  // namespace

std::string print_placement(const rt::Image& image, const rt::Placement& placement) {
  BIP_ASSERT(placement.addresses.size() == placement.nodes.size() && placement.home.size() == image.atoms.size,
             "{} homes of {} components", placement.home.size(), image.atoms.size);
  std::string text;
  for (std::size_t node = 0; node < placement.nodes.size(); ++node) {
    const std::string& address = placement.addresses[node];
    text += fmt::format("node {}{}\n", placement.nodes[node], address.empty() ? address : " host " + address);
  }
  for (std::uint32_t atom = 0; atom < image.atoms.size; ++atom)
    text += fmt::format("{} on {}\n", image.atoms[atom].path(), placement.nodes[placement.home[atom]]);
  if (placement.split_above == rt::kSplitNone) return text + "split never\n";
  return text + fmt::format("split above {}\n", placement.split_above);
}

bool read_placement(Compilation& c, const std::string& path, rt::Placement& placement) {
  const Result<FileId> file = pipeline::load_text(c, path);
  if (!file) {
    c.diags.report(Diag::kB0090, {}, path, file.error());
    return false;
  }
  return PlacementReader(c, *file, placement).read();
}

}  // namespace bip::driver
