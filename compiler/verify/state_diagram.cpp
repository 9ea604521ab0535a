// See state_diagram.hpp.
#include "compiler/verify/state_diagram.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace bip::verify {

namespace {

using u32 = std::uint32_t;
using About = StateDiagram::Question::About;
// 400 MB of states; and a diagram that the checker would not be done with.
constexpr std::size_t kMaxValues = 100000000, kMaxCases = 200000;

bool is_automaton(const AtomType& type) {
  return type.initial.size() == 1 && std::all_of(type.transitions.begin(), type.transitions.end(), [](const Transition& t) { return t.from.size() == 1 && t.to.size() == 1; });
}

// The minimal automaton of rows that come sorted: what later rows can't change any more is numbered, equal parts once.
class Builder {
 public:
  struct Branch {
    std::int32_t value = 0;
    u32 next = StateDiagram::kEnd;
    friend auto operator<=>(const Branch&, const Branch&) = default;
  };
  struct Node {
    std::size_t level = 0;
    std::vector<Branch> branches;
    friend auto operator<=>(const Node&, const Node&) = default;
  };

  explicit Builder(std::size_t width) : open_(width) {}

  /// `common`: how many values at the beginning are those of the row before.
  void add(const std::vector<std::int32_t>& row, std::size_t common) {
    close(common + 1);
    for (std::size_t level = common; level < open_.size(); ++level) open_[level].push_back({row[level]});
  }
  /// The node of the whole is the last one.
  std::vector<Node> finish() {
    close(0);
    return std::move(nodes_);
  }
  [[nodiscard]] std::size_t cases() const { return cases_; }

 private:
  void close(std::size_t first) {
    for (std::size_t level = open_.size(); level-- > first;) {
      if (open_[level].empty()) continue;
      Node node{level, std::move(open_[level])};
      open_[level].clear();
      cases_ += node.branches.size();
      const auto [found, is_new] = numbers_.try_emplace(std::move(node), static_cast<u32>(nodes_.size()));
      if (is_new) nodes_.push_back(found->first);
      else cases_ -= found->first.branches.size();
      if (level > 0) open_[level - 1].back().next = found->second;
    }
  }

  std::vector<std::vector<Branch>> open_;  // by level
  std::map<Node, u32> numbers_;
  std::vector<Node> nodes_;
  std::size_t cases_ = 0;
};

// A node with one case that one node alone leads to is no node of its own.
StateDiagram short_form(const std::vector<Builder::Node>& rows, const std::vector<u32>& question_of_level) {
  std::vector<u32> users(rows.size(), 0), number(rows.size(), 0);
  for (const Builder::Node& row : rows) {
    for (const Builder::Branch& branch : row.branches) {
      if (branch.next != StateDiagram::kEnd) ++users[branch.next];
    }
  }
  StateDiagram result;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const bool is_last = k + 1 == rows.size();
    if (!is_last && rows[k].branches.size() == 1 && users[k] == 1) continue;
    number[k] = static_cast<u32>(result.nodes.size());
    result.nodes.emplace_back();
    for (Builder::Branch branch : rows[k].branches) {
      std::size_t level = rows[k].level;
      StateDiagram::Case one;
      while (true) {
        one.answers.push_back({question_of_level[level], branch.value});
        if (branch.next == StateDiagram::kEnd) break;
        const Builder::Node& next = rows[branch.next];
        if (next.branches.size() > 1 || users[branch.next] > 1) {
          one.next = number[branch.next];
          break;
        }
        level = next.level;
        branch = next.branches[0];
      }
      result.nodes.back().push_back(std::move(one));
    }
  }
  return result;
}

}  // namespace

StateCollector::StateCollector(const System& system, const rt::Image& image) : image_(image) {
  u32 mark_word = 0;
  for (std::size_t a = 0; a < system.atoms.size(); ++a) {
    const AtomType& type = system.atom_types[system.atoms[AtomId(a)].type];
    const u32 atom = static_cast<u32>(a);
    const bool is_alone = is_automaton(type);
    for (std::size_t p = 0; p < (is_alone ? 1 : type.places.size()); ++p) {
      questions_.push_back({atom, static_cast<u32>(p), is_alone ? About::Automaton : About::Place});
      position_.push_back(is_alone ? atom : mark_word * 64 + static_cast<u32>(p));
    }
    if (!is_alone) mark_word += static_cast<u32>((type.places.size() + 63) / 64);
    for (std::size_t k = 0; k < type.slots.size(); ++k) {
      const Type of = type.slots[k].type;
      if (type.slots[k].is_param) continue;
      can_tell_ = can_tell_ && (of == Type::Int || of == Type::Bool || of == Type::String);
      questions_.push_back({atom, static_cast<u32>(k), About::Slot});
      position_.push_back(image.atoms[atom].slot_base + static_cast<u32>(k));
    }
  }
}

void StateCollector::add(const rt::State& state) {
  if (!can_tell_ || values_.size() > kMaxValues) return;
  for (std::size_t q = 0; q < questions_.size(); ++q) {
    const u32 at = position_[q];
    if (questions_[q].about == About::Automaton) values_.push_back(static_cast<std::int32_t>(state.places[at]));
    else if (questions_[q].about == About::Place) values_.push_back(static_cast<std::int32_t>(state.marks[at / 64] >> (at % 64) & 1));
    else values_.push_back(static_cast<std::int32_t>(static_cast<u32>(state.data[at])));
  }
}

StateDiagram StateCollector::diagram() {
  const std::size_t width = questions_.size(), count = width == 0 ? 0 : values_.size() / width;
  if (!can_tell_ || count == 0 || values_.size() > kMaxValues) return {};
  // What never changes is asked first.
  std::vector<u32> order(width);
  std::iota(order.begin(), order.end(), 0);
  std::stable_partition(order.begin(), order.end(), [&](u32 q) {
    for (std::size_t s = 1; s < count; ++s) {
      if (values_[s * width + q] != values_[q]) return false;
    }
    return true;
  });
  std::vector<u32> rows(count);
  std::iota(rows.begin(), rows.end(), 0);
  const auto difference = [&](u32 a, u32 b) {
    std::size_t level = 0;
    while (level < width && values_[a * width + order[level]] == values_[b * width + order[level]]) ++level;
    return level;
  };
  std::sort(rows.begin(), rows.end(), [&](u32 a, u32 b) {
    const std::size_t level = difference(a, b);
    return level < width && values_[a * width + order[level]] < values_[b * width + order[level]];
  });
  Builder builder(width);
  std::vector<std::int32_t> row(width);
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t common = s == 0 ? 0 : difference(rows[s - 1], rows[s]);
    if (common == width) continue;
    for (std::size_t level = 0; level < width; ++level) row[level] = values_[rows[s] * width + order[level]];
    builder.add(row, common);
    if (builder.cases() > kMaxCases) return {};
  }
  StateDiagram result = short_form(builder.finish(), order);
  result.questions = questions_;
  return result;
}

std::string diagram_text(const StateDiagram& diagram, const System& system) {
  std::string out;
  for (std::size_t k = 0; k < diagram.nodes.size(); ++k) {
    out += "node " + std::to_string(k);
    for (const StateDiagram::Case& one : diagram.nodes[k]) {
      char separator = ' ';
      for (const StateDiagram::Answer& answer : one.answers) {
        const StateDiagram::Question& q = diagram.questions[answer.question];
        const Atom& atom = system.atoms[AtomId(std::size_t{q.atom})];
        const AtomType& type = system.atom_types[atom.type];
        out += separator;
        separator = '&';
        out += (q.about == About::Place && answer.value == 0 ? "!" : "") + atom.path;
        if (q.about == About::Automaton) out += '@' + type.places[static_cast<std::size_t>(answer.value)];
        else if (q.about == About::Place) out += '@' + type.places[q.row];
        else out += '.' + type.slots[q.row].name + '=' + std::to_string(answer.value);
      }
      if (one.next != StateDiagram::kEnd) out += separator + ('#' + std::to_string(one.next));
    }
    out += '\n';
  }
  return out + "lemma #" + std::to_string(diagram.nodes.size() - 1) + '\n';
}

}  // namespace bip::verify
