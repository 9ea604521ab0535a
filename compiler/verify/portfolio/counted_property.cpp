// See counted_property.hpp.
#include "compiler/verify/portfolio/counted_property.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "compiler/system/system.hpp"
#include "runtime/explore/explore.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

// Numbers that the search for exchanges compares.
constexpr rt::u64 kWorkOfExchanges = 30'000'000;

using Rows = std::vector<std::uint32_t>;

class CountedConditions {
 public:
  explicit CountedConditions(const Property& property) : property_(property), rows_(property.counted->rows) {
    atoms_.resize(rows_.size());
    for (std::uint32_t k = 0; k < rows_.size(); ++k) {
      find_atoms(rows_[k], atoms_[k]);
      for (const std::uint32_t atom : atoms_[k]) conditions_of_[atom].push_back(k);
    }
    if (property.counted->beside != Property::kNoRow) find_atoms(property.counted->beside, beside_);
  }

  // Does the exchange map each condition to one of them, and the one beside them to itself?
  [[nodiscard]] bool is_preserved_by(const rt::AtomExchange& exchange) const {
    std::set<std::uint32_t> touched, images;
    for (const auto& [atom, other] : exchange) {
      if (beside_.contains(atom)) return false;
      const auto found = conditions_of_.find(atom);
      if (found != conditions_of_.end()) touched.insert(found->second.begin(), found->second.end());
    }
    for (const std::uint32_t k : touched) {
      const auto image = std::find_if(touched.begin(), touched.end(), [&](std::uint32_t other) {
        return !images.contains(other) && is_image(rows_[k], rows_[other], exchange);
      });
      if (image == touched.end()) return false;
      images.insert(*image);
    }
    return true;
  }

  // Is each of them about one member of a group of those that may change places, and each about another one?
  [[nodiscard]] bool are_interchangeable(const std::vector<std::vector<Rows>>& groups) const {
    std::map<std::uint32_t, std::pair<std::size_t, std::size_t>> place;  // by atom: group, member
    for (std::size_t group = 0; group < groups.size(); ++group) {
      for (std::size_t member = 0; member < groups[group].size(); ++member) {
        for (const std::uint32_t atom : groups[group][member]) place[atom] = {group, member};
      }
    }
    std::set<std::pair<std::size_t, std::size_t>> members;
    for (const std::set<std::uint32_t>& atoms : atoms_) {
      std::set<std::pair<std::size_t, std::size_t>> own;
      for (const std::uint32_t atom : atoms) {
        if (const auto found = place.find(atom); found != place.end()) own.insert(found->second);
      }
      if (own.size() != 1 || !members.insert(*own.begin()).second) return false;
    }
    return members.begin()->first == members.rbegin()->first;
  }

  // Is each of them about one component of one array, and does it say of it what the first one says of its own?
  [[nodiscard]] bool are_of_one_array(const System& system) const {
    BIP_ASSERT(!atoms_.empty(), "no conditions are counted");
    std::string array;
    std::uint32_t first = Property::kNoRow;
    for (std::size_t k = 0; k < atoms_.size(); ++k) {
      if (atoms_[k].size() != 1) return false;
      const std::uint32_t atom = *atoms_[k].begin();
      const std::string& path = system.atoms[AtomId(std::size_t{atom})].path;
      if (path.back() != ']' || conditions_of_.at(atom).size() != 1 || beside_.contains(atom)) return false;
      const std::string of = path.substr(0, path.rfind('['));
      if (k == 0) {
        array = of;
        first = atom;
      } else if (of != array || !is_image(rows_[0], rows_[k], {{first, atom}, {atom, first}})) {
        return false;
      }
    }
    return true;
  }

  // The first `count` of them together, as a property of its own.
  [[nodiscard]] Property first(std::uint32_t count) const {
    BIP_ASSERT(count >= 1 && count <= rows_.size(), "{} of {} conditions", count, rows_.size());
    Property made;
    made.text = property_.text;
    made.is_never = true;
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t condition = copy_part(property_, rows_[k], made);
      if (k != 0) made.nodes.push_back({.kind = PropertyKind::Operator, .op = Op::And, .a = made.root, .b = condition});
      made.root = static_cast<std::uint32_t>(made.nodes.size() - 1);
    }
    if (property_.counted->beside != Property::kNoRow) {
      const std::uint32_t together = made.root, beside = copy_part(property_, property_.counted->beside, made);
      made.nodes.push_back({.kind = PropertyKind::Operator, .op = Op::And, .a = beside, .b = together});
      made.root = static_cast<std::uint32_t>(made.nodes.size() - 1);
    }
    return made;
  }

 private:
  // Conditions are as deep as they are written.
  void find_atoms(std::uint32_t row, std::set<std::uint32_t>& atoms) const {
    const PropertyNode& node = property_.nodes[row];
    if (names_atom(node.kind)) atoms.insert(node.owner);
    if (node.kind != PropertyKind::Operator) return;
    find_atoms(node.a, atoms);
    if (node.b != node.a) find_atoms(node.b, atoms);
  }
  [[nodiscard]] bool is_image(std::uint32_t of, std::uint32_t row, const rt::AtomExchange& exchange) const {
    const PropertyNode &a = property_.nodes[of], &b = property_.nodes[row];
    if (a.kind != b.kind || a.type != b.type || a.op != b.op || a.int_value != b.int_value ||
        a.float_value != b.float_value || a.row != b.row)
      return false;
    if (a.kind == PropertyKind::Operator) return is_image(a.a, b.a, exchange) && is_image(a.b, b.b, exchange);
    const auto other = names_atom(a.kind) ? exchange.find(a.owner) : exchange.end();
    return b.owner == (other == exchange.end() ? a.owner : other->second);
  }
  const Property& property_;
  const Rows& rows_;
  std::vector<std::set<std::uint32_t>> atoms_;   // by condition
  std::set<std::uint32_t> beside_;               // atoms of the condition beside them
  std::map<std::uint32_t, Rows> conditions_of_;  // by atom
};

}  // namespace

std::optional<Property> with_first_conditions(const Property& property, const rt::Image& image) {
  if (!property.counted || property.counted->rows.size() <= property.counted->least) return std::nullopt;
  if (property.fault != Property::kNoRow || !connectors_of(property).empty()) return std::nullopt;
  const CountedConditions conditions(property);
  rt::SymmetryLimits limits;
  limits.work = kWorkOfExchanges;
  limits.named_atoms = atoms_of(property);
  limits.preserves_predicate = [&](const rt::AtomExchange& exchange) { return conditions.is_preserved_by(exchange); };
  if (!conditions.are_interchangeable(rt::interchangeable_members(image, limits))) return std::nullopt;
  return conditions.first(property.counted->least);
}

std::optional<Property> with_first_of_array(const Property& property, const System& system) {
  if (!property.counted || property.counted->rows.size() <= property.counted->least) return std::nullopt;
  if (property.fault != Property::kNoRow || asks_offers(property)) return std::nullopt;
  const CountedConditions conditions(property);
  if (!conditions.are_of_one_array(system)) return std::nullopt;
  return conditions.first(property.counted->least);
}

}  // namespace bip::verify
