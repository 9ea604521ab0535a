// Finds names similar to an unknown one: optimal string alignment distance (Levenshtein with transpositions; Boytsov,
// "Indexing methods for approximate dictionary searching", 2011), with a lower cost for case. O(n·|wrong|·|known|).
#include <algorithm>
#include <cctype>
#include <numeric>
#include <tuple>

#include "compiler/diag/diagnostics.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip {
namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// In half edits: a change of case costs 1, any other edit 2.
std::size_t distance(std::string_view a, std::string_view b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> before(width), previous(width), current(width);
  for (std::size_t j = 0; j < width; ++j) previous[j] = 2 * j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = 2 * i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : lower(a[i - 1]) == lower(b[j - 1]) ? 1 : 2;
      current[j] = std::min({previous[j] + 2, current[j - 1] + 2, previous[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        current[j] = std::min(current[j], before[j - 2] + 2);
      }
    }
    std::swap(before, previous);
    std::swap(previous, current);
  }
  BIP_ASSERT(previous[b.size()] <= 2 * std::max(a.size(), b.size()),
             "a distance of {} half edits between {} and {} characters", previous[b.size()], a.size(), b.size());
  return previous[b.size()];
}

}  // namespace

std::vector<std::string> similar_names(std::string_view wrong, const std::vector<std::string>& known) {
  constexpr std::size_t kLongestCompared = 80;
  struct Candidate {
    std::size_t distance;
    std::size_t gap;  // of the lengths: among names at one distance, one of the same length is likelier
    const std::string* name;
  };
  std::vector<Candidate> candidates;
  if (wrong.empty() || wrong.size() > kLongestCompared) return {};
  for (const std::string& name : known) {
    if (name.empty() || name.size() > kLongestCompared || name == wrong) continue;
    const std::size_t longer = std::max(wrong.size(), name.size());
    const std::size_t allowed = longer <= 2 ? 1 : 2 * std::max<std::size_t>(1, longer / 3);
    // Lengths alone can rule a name out, which is what makes long lists cheap.
    const std::size_t gap = longer - std::min(wrong.size(), name.size());
    if (2 * gap > allowed) continue;
    const std::size_t d = distance(wrong, name);
    if (d <= allowed) candidates.push_back({d, gap, &name});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.distance, a.gap, *a.name) < std::tie(b.distance, b.gap, *b.name);
  });
  std::vector<std::string> best;
  for (const Candidate& c : candidates) {
    if (best.size() == 2 || (!best.empty() && c.distance > candidates.front().distance + 2)) break;
    if (best.empty() || best.back() != *c.name) best.push_back(*c.name);
  }
  return best;
}

}  // namespace bip
