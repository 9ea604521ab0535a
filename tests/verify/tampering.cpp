// See tampering.hpp.
#include "tests/verify/tampering.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>

#include "compiler/base/content_cache.hpp"

namespace bip::verify::test {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;

class Forger {
 public:
  explicit Forger(std::uint64_t seed) : random_(seed) {}

  std::string changed(const std::string& text) {
    std::vector<std::string> rows;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      rows.push_back(text.substr(at, end - at));
      at = end + 1;
    }
    for (std::uint64_t k = 0, count = 1 + below(4); k < count && rows.size() > 1; ++k) change(rows);
    std::string result;
    for (const std::string& row : rows) result += row + '\n';
    return result;
  }
  std::uint64_t below(std::uint64_t count) { return random_() % count; }

 private:
  void change(std::vector<std::string>& rows) {
    // The first line is the format: mostly it stays.
    const std::size_t row = below(20) == 0 ? 0 : 1 + below(rows.size() - 1);
    switch (below(12)) {
      case 8:
      case 9:
      case 10:
      case 11: shorten(rows[row]); return;
      case 0: rows.erase(rows.begin() + static_cast<std::ptrdiff_t>(row)); return;
      case 1: rows.push_back(rows[row]); return;
      case 2: std::swap(rows[row], rows[below(rows.size())]); return;
      case 3: {
        static const char* const kWords[] = {"trap",  "one",           "sum",       "never",    "equation",  "atom",
                                             "steps", "way induction", "way plain", "way told", "way steps", "0",
                                             "x"};
        rows[row] = kWords[below(13)] + rows[row].substr(std::min(rows[row].find(' '), rows[row].size()));
        return;
      }
      case 4: rows[row].resize(below(rows[row].size() + 1)); return;
      default: change_number(rows[row]);
    }
  }
  // Says more than it did: without some of its components.
  void shorten(std::string& row) {
    const bool is_lemma = row.starts_with("never "), is_equation = row.starts_with("equation ");
    if (!is_lemma && !is_equation && !row.starts_with("trap ") && !row.starts_with("one ") && !row.starts_with("sum "))
      return change_number(row);
    const std::size_t head = is_lemma || is_equation ? 1 : 3, each = is_lemma ? 5 : is_equation ? 4 : 3;
    std::vector<std::size_t> ends;
    for (std::size_t k = 0; k <= row.size(); ++k) {
      if (k == row.size() || row[k] == ' ') ends.push_back(k);
    }
    // A row that was cut before may lack even its head.
    if (ends.size() < head + 2 * each) return change_number(row);
    const std::size_t terms = (ends.size() - head) / each;
    const std::size_t drop = below(terms), first = ends[head + drop * each - 1],
                      last = ends[head + (drop + 1) * each - 1];
    row.erase(first, last - first);
  }
  void change_number(std::string& row) {
    std::vector<std::size_t> starts;
    for (std::size_t k = 1; k < row.size(); ++k) {
      if (row[k - 1] == ' ') starts.push_back(k);
    }
    if (starts.empty()) return;
    const std::size_t start = starts[below(starts.size())], end = std::min(row.find(' ', start), row.size());
    static const char* const kOdd[] = {
        "-1", "4294967295", "4294967294", "18446744073709551615", "-9223372036854775808", "281474976710656", "", "1x"};
    const std::string number = below(6) == 0 ? kOdd[below(8)] : std::to_string(below(below(2) == 0 ? 3 : 12));
    row.replace(start, end - start, number);
  }

  std::mt19937_64 random_;
};

}  // namespace

std::vector<std::string> kept_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == ".proof") names.push_back(entry->path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void damage(const fs::path& folder, std::uint64_t seed) {
  Forger forger(seed);
  for (const std::string& name : kept_names(folder)) {
    const fs::path path = folder / (name + ".proof");
    std::ifstream in(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(in), {}};
    in.close();
    if (bytes.empty()) continue;
    if (forger.below(3) == 0) bytes.resize(forger.below(bytes.size()));
    else bytes[forger.below(bytes.size())] ^= static_cast<char>(1 + forger.below(255));
    std::ofstream(path, std::ios::binary) << bytes;
  }
}

std::string forge(const fs::path& folder, const std::string& foreign, std::uint64_t seed) {
  Forger forger(seed);
  ContentCache cache(ContentKind::Proof, folder.string(), kMostBytes);
  std::string last;
  for (const std::string& name : kept_names(folder)) {
    const std::optional<std::string> text = cache.load(name);
    if (!text) continue;
    last = *text;
    // A name of 64 digits is where another file is.
    const bool is_foreign = !foreign.empty() && forger.below(5) == 0;
    cache.store(name, is_foreign ? foreign : forger.changed(*text));
  }
  return last;
}

}  // namespace bip::verify::test
