// See exclude_all.hpp.
#include "compiler/verify/counting/exclude_all.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace bip::verify {

namespace {

constexpr std::size_t kMostCases = 200;
constexpr double kFraction = 1e-3;  // of a token

class CaseDistinction {
 public:
  CaseDistinction(CountedNetBuilder& builder, const CancellationToken& cancellation)
      : builder_(builder), net_(builder.net()), cancellation_(cancellation) {}

  std::optional<std::vector<ExcludedPlaces>> run(std::vector<BadPlaces> open) {
    std::vector<ExcludedPlaces> excluded;
    while (!open.empty()) {
      if (excluded.size() + open.size() > kMostCases || cancellation_.is_over()) return std::nullopt;
      BadPlaces bad = std::move(open.back());
      open.pop_back();
      SubInvariantSearch found = find_sub_invariant(net_, bad, cancellation_);
      if (found.proof) {
        excluded.push_back({std::move(bad), std::move(*found.proof)});
      } else if (found.open.empty() || !split(bad, found.open, open)) {
        return std::nullopt;
      }
    }
    return excluded;
  }

 private:
  // Some places of a kind, and how much of its token the marking has there.
  struct PartOfToken {
    std::vector<u32> places;
    double tokens = 0;
  };
  using Parts = std::map<rt::u64, PartOfToken>;  // by value

  // What is said of a place: is each place of the atom's type marked, which value has each variable?
  const std::vector<rt::u64>& said_of(u32 place) {
    const auto [found, is_new] = said_.try_emplace(place);
    const u32 atom = net_.atom_of_kind[net_.places[place].kind];
    if (!is_new || !builder_.enter_atoms({atom}, {place})) return found->second;
    const rt::Core& core = builder_.core();
    const rt::Image& image = core.image();
    const rt::AtomType& type = image.atom_types[image.atoms[atom].type];
    for (u32 row = 0; row < type.places.size; ++row) found->second.push_back(core.is_marked(atom, row) ? 1 : 0);
    for (u32 row = 0; row < type.variables.size; ++row)
      found->second.push_back(core.cell(image.atoms[atom].variable(row)).bits);
    return found->second;
  }
  [[nodiscard]] static double fraction(const PartOfToken& part) { return std::min(part.tokens, 1 - part.tokens); }

  // The places of a component that is in several ones, by the question with the fewest answers.
  bool split(const BadPlaces& bad, const std::vector<double>& marking, std::vector<BadPlaces>& open) {
    Parts best;
    u32 kind_of_best = 0;
    for (u32 kind = 0; kind < net_.places_of_kind.size(); ++kind) {
      if (std::count(net_.kind_of_atom.begin(), net_.kind_of_atom.end(), kind) != 1) continue;
      const std::vector<u32> allowed = allowed_places(bad, kind);
      if (allowed.empty()) continue;
      const std::size_t questions = said_of(allowed.front()).size();
      for (std::size_t question = 0; question < questions; ++question) {
        Parts parts;
        for (const u32 place : allowed) {
          const std::vector<rt::u64>& said = said_of(place);
          if (said.size() != questions) return false;
          PartOfToken& part = parts[said[question]];
          part.places.push_back(place);
          part.tokens += marking[place];
        }
        const auto is_split = [](const auto& row) { return fraction(row.second) > kFraction; };
        if (!std::any_of(parts.begin(), parts.end(), is_split) || (!best.empty() && parts.size() >= best.size()))
          continue;
        best = std::move(parts);
        kind_of_best = kind;
      }
    }
    if (best.empty()) return false;
    const auto chosen = std::max_element(
        best.begin(), best.end(), [](const auto& a, const auto& b) { return fraction(a.second) < fraction(b.second); });
    std::vector<u32> others;
    for (auto part = best.begin(); part != best.end(); ++part) {
      if (part != chosen) others.insert(others.end(), part->second.places.begin(), part->second.places.end());
    }
    std::sort(others.begin(), others.end());
    open.push_back(restricted(bad, kind_of_best, std::move(others)));
    open.push_back(restricted(bad, kind_of_best, chosen->second.places));
    return true;
  }
  [[nodiscard]] bool is_about(const std::vector<u32>& set, u32 kind) const {
    return !set.empty() && net_.places[set.front()].kind == kind;
  }
  [[nodiscard]] std::vector<u32> allowed_places(const BadPlaces& bad, u32 kind) const {
    for (const std::vector<u32>& set : bad.sets) {
      if (is_about(set, kind)) return set;
    }
    return net_.places_of_kind[kind];
  }
  [[nodiscard]] BadPlaces restricted(const BadPlaces& bad, u32 kind, std::vector<u32> places) const {
    BadPlaces result = bad;
    std::erase_if(result.sets, [&](const std::vector<u32>& set) { return is_about(set, kind); });
    result.sets.push_back(std::move(places));
    return result;
  }

  CountedNetBuilder& builder_;
  const CountedNet& net_;
  const CancellationToken& cancellation_;
  std::map<u32, std::vector<rt::u64>> said_;  // by place
};

}  // namespace

std::optional<std::vector<ExcludedPlaces>> exclude_all(CountedNetBuilder& builder, const std::vector<BadPlaces>& bad,
                                                       const CancellationToken& cancellation) {
  return CaseDistinction(builder, cancellation).run(bad);
}

}  // namespace bip::verify
