// All sizes at once. A state of size n is a word: at each position the modes of the arrays' elements there. From the
// least size on the first positions, the last ones, and those between, which are all alike, are those of the system of
// that size. The certificate has an automaton over words of sets of modes. Each word that it reads must keep its
// promise (a trap that is marked at first; a set of which no interaction makes more, or fewer): it is read together
// with a memory of the first and the latest positions, where every interaction is seen as a whole. And each word of
// modes in which no step is possible for sure must break one: it is read together with all words of sets at once (a
// subset construction). An interaction is hidden only by another one that is possible, so priorities do not matter.
#include "tools/certcheck/terms.hpp"

namespace certcheck {
namespace {

enum class Where { One, First, Last, At, All };
/// A port that takes part: of an atom, or of the elements of an array at a position, counted from one.
struct Part {
  Where where = Where::One;
  int offset = 0;
  Text path, port;
  bool is_trigger = false;

  friend auto operator<=>(const Part&, const Part&) = default;
};
/// Parts that move together; with triggers, one of these and any of the others. In a loop: at each position from
/// `low` on but the last `high` ones. Sure: it is possible whenever its parts are.
struct Event {
  std::vector<Part> parts;
  bool has_triggers = false, is_sure = true, is_loop = false;
  int low = 0, high = 0;

  friend auto operator<=>(const Event&, const Event&) = default;
};

std::string element(Text array, int position) { return std::string(array) + '[' + std::to_string(position) + ']'; }

/// A system of some size as the rows say it.
class Pattern {
 public:
  Pattern(const Model& m, const Tree& rows, int size) : model_(m), rows_(rows), size_(size) {
    for (std::size_t k = 0; k < m.atoms.size(); ++k) atoms_.emplace(m.atoms[k].path, k);
    for (const Tree* row : rows.all("array")) {
      for (int p = 0; p < size; ++p) positions_.emplace(atom(element(row->at(1).text, p)), p);
      if (atoms_.contains(element(row->at(1).text, size))) throw Rejected("an array has more elements than its size");
    }
  }
  [[nodiscard]] std::size_t atom(const std::string& path) const {
    const auto found = atoms_.find(path);
    return found != atoms_.end() ? found->second : throw Rejected(quoted(path) + " is not there");
  }
  /// -1: in none of the arrays.
  [[nodiscard]] int position(std::size_t atom) const {
    const auto found = positions_.find(atom);
    return found == positions_.end() ? -1 : found->second;
  }
  std::vector<Event> events() {
    std::vector<Event> all;
    for (const Tree* row : rows_.all("join")) {
      const Tree& each = (*row)["each"];
      const int low = each.items.empty() ? 0 : each.at(1).number(), high = each.items.empty() ? 0 : each.at(2).number();
      const int end = each.items.empty() ? 1 : size_ - high;
      if (low < 0 || high < 0 || low >= end) throw Rejected("a loop over positions that there are not");
      const std::vector<Event> first = joined(*row, low, low, high);
      for (int i = low + 1; i < end; ++i)
        if (joined(*row, i, low, high) != first) throw Rejected("connectors of one row differ");
      all.insert(all.end(), first.begin(), first.end());
    }
    for (std::size_t c = 0; c < taken_.size(); ++c)
      if (!taken_[c]) throw Rejected(quoted(model_.connectors[c].path) + " is in no row");
    std::set<std::pair<Text, Text>> alone;
    for (std::size_t a = 0; a < model_.atoms.size(); ++a) {
      const bool is_one = position(a) < 0;
      const Text path = model_.atoms[a].path, owner = is_one ? path : path.substr(0, path.rfind('['));
      for (const Port& port : model_.type_of(a).ports) {
        if (port.is_exported || !alone.emplace(owner, port.name).second) continue;
        all.push_back({{{is_one ? Where::One : Where::At, 0, owner, port.name}}, false, true, !is_one});
      }
    }
    return all;
  }

 private:
  // The interactions of the row's connector in round i.
  std::vector<Event> joined(const Tree& row, int i, int low, int high) {
    static const std::map<Text, Where> kPlaces{
        {"one", Where::One}, {"first", Where::First}, {"last", Where::Last}, {"at", Where::At}, {"all", Where::All}};
    std::vector<Part> parts;
    Rows ports, part_of;  // by parameter
    const auto bind = [&](const Part& part, const std::string& path) {
      const std::size_t at = atom(path);
      if ((part.where == Where::One) != (position(at) < 0)) throw Rejected(quoted(path) + " has another place");
      ports.push_back(model_.first_port[at] + row_of(model_.type_of(at).ports, part.port, &Port::name));
      part_of.push_back(parts.size());
    };
    for (std::size_t k = 2; k < row.items.size(); ++k) {
      const Tree& item = row.items[k];
      if (item.head() == "each") continue;
      const auto place = kPlaces.find(item.head());
      if (place == kPlaces.end()) throw Rejected("a place " + quoted(item.head()));
      Part part{place->second, 0, item.items.back().text, item.items.back().text};
      part.path = item.at(item.items.size() - 2).text;
      if (item.items.size() > 3) part.offset = item.at(1).number();
      const int at = part.where == Where::Last ? size_ - 1 - part.offset
                     : part.where == Where::At ? (i + part.offset + size_) % size_
                                               : part.offset;
      if (part.where == Where::One) bind(part, std::string(part.path));
      for (int p = 0; p < size_ && part.where != Where::One; ++p)
        if (part.where == Where::All || p == at) bind(part, element(part.path, p));
      parts.push_back(part);
    }
    const auto is_at = [](const std::vector<Part>& some, Where where) {
      return std::ranges::any_of(some, [&](const Part& part) { return part.where == where; });
    };
    const Connector& c = connector(row.at(1).text, ports);
    const auto param = [&](std::size_t port) {
      return static_cast<std::size_t>(std::ranges::find(ports, port) - ports.begin());
    };
    if (!is_at(parts, Where::All)) {
      std::vector<Event> events;
      for (const Rows& chosen : interactions(c.root)) {
        Event& event = events.emplace_back();
        std::set<std::size_t> params;
        for (std::size_t port : chosen) params.insert(param(port));
        for (std::size_t p : params) event.parts.push_back(parts[part_of.at(p)]);
        event.is_loop = is_at(event.parts, Where::At);
        if (event.is_loop) event.low = low, event.high = high;
        event.is_sure = std::ranges::none_of(c.clauses, [&](const Clause& clause) {
          return !clause.guard->items.empty() && std::set(clause.params.begin(), clause.params.end()) == params;
        });
      }
      std::ranges::sort(events);
      return events;
    }
    // With all elements of an array: one group, in which they are all alike.
    const Node& root = model_.nodes[c.root];
    std::map<std::size_t, bool> is_trigger;
    for (const Edge& edge : root.children) {
      if (model_.nodes[edge.node].kind != Kind::Port) throw NotCheckable(quoted(c.path) + " has inner groups");
      if (is_trigger.emplace(part_of.at(param(edge.node)), edge.is_trigger).first->second != edge.is_trigger)
        throw NotCheckable(quoted(c.path) + " does not treat all elements alike");
    }
    if (root.children.size() != ports.size()) throw NotCheckable(quoted(c.path) + " leaves a port out");
    for (std::size_t k = 0; k < parts.size(); ++k) parts[k].is_trigger = is_trigger.at(k);
    Event event;
    event.parts = parts;
    event.has_triggers = root.kind == Kind::Trigger;
    event.is_loop = is_at(parts, Where::At);
    event.is_sure = std::ranges::all_of(c.clauses, [](const Clause& clause) { return clause.guard->items.empty(); });
    return {event};
  }
  // The one of that name, or of an array of that name, that binds these ports, of atoms.
  const Connector& connector(Text name, const Rows& ports) {
    std::size_t found = kNone;
    for (std::size_t k = 0; k < model_.connectors.size(); ++k) {
      const Connector& c = model_.connectors[k];
      if (c.path != name && !c.path.starts_with(std::string(name) + '[')) continue;
      if (!std::ranges::equal(c.params, ports, {}, &Edge::node)) continue;
      if (found != kNone) throw NotCheckable("two connectors " + quoted(name) + " join the same ports");
      found = k;
    }
    if (found == kNone || taken_[found]) throw Rejected("no connector " + quoted(name) + " joins what its row says");
    if (std::set(ports.begin(), ports.end()).size() != ports.size()) throw NotCheckable("a port is bound twice");
    if (!model_.nodes[model_.connectors[found].root].is_step) throw NotCheckable("a connector exports a port");
    taken_[found] = true;
    return model_.connectors[found];
  }
  // Sets of ports; as `combine` in structure.cpp.
  [[nodiscard]] std::set<Rows> interactions(std::size_t row) const {
    constexpr std::size_t kMost = 4096;
    const Node& node = model_.nodes[row];
    if (node.kind == Kind::Port) return {{row}};
    if (node.kind == Kind::Any) throw NotCheckable("merged ports");
    const auto join = [](const std::set<Rows>& some, const std::set<Rows>& more, std::set<Rows> into) {
      for (const Rows& a : some) {
        for (const Rows& b : more) {
          Rows both = a;
          both.insert(both.end(), b.begin(), b.end());
          into.insert(std::move(both));
        }
      }
      return into.size() <= kMost ? into : throw NotCheckable("a connector has too many interactions");
    };
    std::set<Rows> good, open{{}};  // what has been chosen so far; of groups with triggers, without one
    if (node.kind == Kind::All) good.insert(Rows());
    for (const Edge& edge : node.children) {
      const std::set<Rows> inner = interactions(edge.node);
      good = join(good, inner, node.kind == Kind::All ? std::set<Rows>() : good);
      if (edge.is_trigger) good = join(open, inner, good);
      else if (node.kind == Kind::Trigger) open = join(open, inner, open);
    }
    return good;
  }

  const Model& model_;
  const Tree& rows_;
  int size_ = 0;
  std::vector<bool> taken_ = std::vector<bool>(model_.connectors.size());
  std::map<std::string, std::size_t, std::less<>> atoms_;
  std::map<std::size_t, int> positions_;
};

constexpr int kBlocked = -1000, kMostSum = 3, kMostBehind = -2;
constexpr std::size_t kMostLetters = 100'000, kMostNodes = 1'000'000;

/// What parts do at most: to a trap, take from it without putting into it (1), or nothing (0); to a number of modes, by
/// how much it grows, or shrinks; a port that can be taken for sure: 1. Blocked: they cannot, or the set does not mind.
/// Of events with triggers: what those do that do something, and the best trigger.
struct Value {
  int sum = 0, top = kBlocked;
  friend auto operator<=>(const Value&, const Value&) = default;
};
using Letter = std::vector<Value>;  // by event and place in its window
struct Seen {
  int position = 0;
  Letter letter;
  friend auto operator<=>(const Seen&, const Seen&) = default;
};
/// Of a word that has been read so far.
struct Memory {
  bool adds = false;          // values add up; else the greatest counts
  bool flag = false;          // a trap is marked at first; an atom is not at a final place
  std::vector<Value> values;  // by event: of what is in no window
  std::vector<Seen> first, latest;
  friend auto operator<=>(const Memory&, const Memory&) = default;
};

class Words {
 public:
  Words(const std::vector<const Model*>& models, const Certificate& certificate, z3::context& z)
      : model_(*models.at(0)), proof_(certificate), terms_(model_, z) {
    if (size_ < 3 || size_ % 2 == 0) throw Rejected("the least size is not odd");
    if (proof_.claim != "deadlock-free" || !proof_.sets.empty() || !proof_.facts.empty() || !proof_.states.empty())
      throw Rejected("of all sizes, this is claimed or told: " + quoted(proof_.claim));
    if (model_.is_timed || proof_.classes.empty())
      throw NotCheckable("all sizes of a model with time, or without modes");
    events_ = pattern_.events();
    for (std::size_t k = 1; k < models.size(); ++k) compare(*models[k]);
    lay_out();
    moves_ = moves_of(model_, proof_, z);
  }

  void run() {
    for (const auto& [position, reads] : reads_) {
      for (const Read& read : reads) {
        for (const auto& [from, to] : moves_[read.atom].by_port[read.port])
          if (!proof_.reachable[read.atom].contains(to))
            throw Rejected(quoted(model_.atoms[read.atom].path) + " can reach a mode that is not listed");
      }
    }
    check_rows();
    check_promises();
    check_words();
  }

 private:
  // Which value of a letter a part changes.
  struct Read {
    std::size_t event = 0, value = 0, atom = 0, port = 0;
    bool is_trigger = false;
  };

  // What the rows say of a greater size.
  void compare(const Model& other) {
    const int size = other.tree["size"].at(2).number();
    const Text name = other.tree["size"].at(1).text;
    Pattern pattern(other, rows_, size);
    const std::string where = "at " + std::string(name) + " = " + std::to_string(size) + ": ";
    if (name != rows_.at(1).text || pattern.events() != events_) throw Rejected(where + "other connectors");
    std::size_t expected = 0;
    for (std::size_t a = 0; a < model_.atoms.size(); ++a)
      expected += pattern_.position(a) == margin_ ? static_cast<std::size_t>(size - size_ + 1) : 1;
    if (other.atoms.size() != expected) throw Rejected(where + "other components");
    const std::vector<const Tree*> types = model_.tree.all("atom-type"), others = other.tree.all("atom-type");
    for (std::size_t a = 0; a < other.atoms.size(); ++a) {
      const Atom& atom = other.atoms[a];
      const int p = pattern.position(a), from_end = size - p;
      const Text array = atom.path.substr(0, atom.path.rfind('['));
      const std::size_t like = pattern_.atom(p < 0 ? std::string(atom.path)
                                                   : element(array, p < margin_           ? p
                                                                    : from_end <= margin_ ? size_ - from_end
                                                                                          : margin_));
      const Tree &type = *types.at(model_.atoms[like].type), &its = *others.at(atom.type);
      const bool is_same = *atom.args == *model_.atoms[like].args &&
                           std::equal(type.items.begin() + 2, type.items.end(), its.items.begin() + 2, its.items.end());
      // What connectors may write.
      if (!is_same ||
          !std::ranges::equal(other.type_of(a).ports, model_.type_of(like).ports, {}, &Port::written, &Port::written))
        throw Rejected(where + quoted(atom.path) + " is another component");
    }
  }

  // Windows of loops begin at the least offset. Bounds and offsets are small, so a zone says which rounds begin there.
  void lay_out() {
    for (std::size_t e = 0; e < events_.size(); ++e) {
      const Event& event = events_[e];
      int least = size_, most = -size_;
      for (const Part& part : event.parts) {
        const bool is_at = part.where == Where::At, is_end = part.where == Where::First || part.where == Where::Last;
        if (is_at) least = std::min(least, part.offset), most = std::max(most, part.offset);
        if (is_end && (part.offset < 0 || part.offset >= margin_)) throw Rejected("an element is too far from the end");
        if (event.is_loop && !is_at && part.where != Where::One) throw Rejected("a loop with elements elsewhere");
      }
      if (!event.is_loop) least = most = 0;
      if (std::max(event.low, event.high) + std::max(std::abs(least), std::abs(most)) > margin_ ||
          most - least > margin_)
        throw Rejected("elements of a loop are too far from each other");
      base_.push_back(least);
      first_value_.push_back(letter_size_);
      width_.push_back(static_cast<std::size_t>(most - least + 1));
      letter_size_ += width_.back();
      reach_ = std::max(reach_, width_.back() - 1);
      bool wraps = false;
      for (int back = 1; back < static_cast<int>(width_.back()); ++back) wraps = wraps || begins(e, size_ - back);
      wraps_.push_back(wraps);
      for (int p = -1; p < size_; ++p) {
        for (const Part& part : event.parts) add_read(e, part, p);
      }
    }
    for (std::size_t a = 0; a < model_.atoms.size(); ++a) atoms_at_[pattern_.position(a)].push_back(a);
    atoms_at_[-1];
  }
  void add_read(std::size_t e, const Part& part, int p) {
    const bool is_there = part.where == Where::One     ? p == -1
                          : part.where == Where::First ? p == part.offset
                          : part.where == Where::Last  ? p == size_ - 1 - part.offset
                                                       : p >= 0;
    auto& reads = reads_[p];
    if (!is_there) return;
    const std::size_t atom = pattern_.atom(p < 0 ? std::string(part.path) : element(part.path, p));
    const std::size_t place = part.where == Where::At ? static_cast<std::size_t>(part.offset - base_[e]) : 0;
    reads.push_back({e, first_value_[e] + place, atom, row_of(model_.type_of(atom).ports, part.port, &Port::name),
                     part.is_trigger});
  }
  // Does a round of the loop begin its window there?
  [[nodiscard]] bool begins(std::size_t e, int position) const {
    const int i = (position - base_[e] + size_) % size_;
    return i >= events_[e].low && i < size_ - events_[e].high;
  }

  // ---- reading letters
  static Value joined(bool adds, const Value& a, const Value& b) {
    const bool is_blocked = a.sum == kBlocked || b.sum == kBlocked;
    return {is_blocked ? kBlocked : adds ? a.sum + b.sum : std::max(a.sum, b.sum), std::max(a.top, b.top)};
  }
  [[nodiscard]] bool acts(std::size_t e, const Value& v) const {
    return !events_[e].has_triggers ? v.sum > 0 : v.top != kBlocked && v.sum + std::min(v.top, 0) > 0;
  }
  // `does`: what an atom's port does.
  template <class Does>
  [[nodiscard]] Letter letter(int position, bool adds, const Does& does) const {
    Letter result(letter_size_);
    for (const Read& read : reads_.at(position)) {
      const int value = does(read.atom, read.port);
      const bool is_choice = events_[read.event].has_triggers;
      const Value change{is_choice ? std::max(value, 0) : value, is_choice && read.is_trigger ? value : kBlocked};
      result[read.value] = joined(adds, result[read.value], change);
    }
    return result;
  }
  [[nodiscard]] Memory begin(bool adds, bool flag, const Letter& letter) const {
    Memory memory{adds, flag, {}, {}, {}};
    for (std::size_t e = 0; e < events_.size(); ++e) memory.values.push_back(letter[first_value_[e]]);
    return memory;
  }
  [[nodiscard]] bool acts_from(const Memory& memory, const std::vector<Seen>& word, std::size_t e,
                               std::size_t first) const {
    if (!begins(e, word[first].position)) return false;
    Value value = memory.values[e];
    for (std::size_t k = 0; k < width_[e]; ++k)
      value = joined(memory.adds, value, word[first + k].letter[first_value_[e] + k]);
    return acts(e, value);
  }
  // False: an event has been seen as a whole, and acts. Steps: only if that is sure.
  [[nodiscard]] bool read(Memory& memory, int position, const Letter& letter, bool is_step) const {
    memory.latest.push_back({position, letter});
    for (std::size_t e = 0; e < events_.size(); ++e) {
      if (is_step && !events_[e].is_sure) continue;
      Value& value = memory.values[e];
      if (events_[e].is_loop) {
        const std::size_t count = memory.latest.size();
        if (count >= width_[e] && acts_from(memory, memory.latest, e, count - width_[e])) return false;
        continue;
      }
      value = joined(memory.adds, value, letter[first_value_[e]]);
      // A sum that is too small is taken as a greater one. One that is too great may become small again, and counts.
      if (value.sum > kMostSum && !events_[e].has_triggers) return false;
      if (value.sum != kBlocked) value.sum = std::clamp(value.sum, -kMostSum, kMostSum);
    }
    // What is remembered are windows that go on.
    for (std::size_t e = 0; e < events_.size(); ++e) {
      const auto window = memory.latest.back().letter.begin() + static_cast<long>(first_value_[e]);
      if (width_[e] == 1 || (is_step && !events_[e].is_sure)) std::fill_n(window, width_[e], Value());
    }
    if (memory.first.size() < reach_) {
      memory.first.push_back(memory.latest.back());
      for (std::size_t e = 0; e < events_.size(); ++e) {
        const auto window = memory.first.back().letter.begin() + static_cast<long>(first_value_[e]);
        if (!wraps_[e]) std::fill_n(window, width_[e], Value());
      }
    }
    if (memory.latest.size() > reach_) memory.latest.erase(memory.latest.begin());
    return true;
  }
  // After the last letter.
  [[nodiscard]] bool is_quiet(const Memory& memory, bool is_step) const {
    std::vector<Seen> word = memory.latest;
    word.insert(word.end(), memory.first.begin(), memory.first.end());
    for (std::size_t e = 0; e < events_.size(); ++e) {
      if (is_step && !events_[e].is_sure) continue;
      if (!events_[e].is_loop && acts(e, memory.values[e])) return false;
      for (std::size_t back = 1; back < width_[e]; ++back)
        if (acts_from(memory, word, e, memory.latest.size() - back)) return false;
    }
    return true;
  }

  // ---- the automaton
  void check_rows() {
    for (const SetRow& row : proof_.set_rows) {
      const int position = row.from == kNone ? -1 : static_cast<int>(row.position);
      if (position >= size_) throw Rejected(row.line + ": no position");
      for (const auto& [atom, modes] : row.modes)
        if (pattern_.position(atom) != position) throw Rejected(row.line + ": a component of another position");
      if (row.from != kNone && position_of_.try_emplace(row.from, position).first->second != position)
        throw Rejected(row.line + ": its state is at two positions");
    }
    for (const SetRow& row : proof_.set_rows) {
      const int position = row.from == kNone ? -1 : static_cast<int>(row.position), next = position_at(row.to);
      if (next != position + 1 && (position != margin_ || next != margin_))
        throw Rejected(row.line + ": leads to another position");
      if (row.from != kNone) rows_from_[row.from].push_back(&row);
      else if (promise_of_.try_emplace(row.to, row.promise).first->second != row.promise)
        throw Rejected(row.line + ": another promise");
    }
    for (bool is_new = true; is_new;) {
      is_new = false;
      for (const SetRow& row : proof_.set_rows) {
        if (row.from == kNone || !promise_of_.contains(row.from)) continue;
        const auto [at, is_first] = promise_of_.try_emplace(row.to, promise_of_[row.from]);
        if (at->second != promise_of_[row.from]) throw Rejected(row.line + ": another promise");
        is_new = is_new || is_first;
      }
    }
  }
  // The next one that it reads.
  [[nodiscard]] int position_at(std::size_t state) const {
    const auto found = position_of_.find(state);
    return found == position_of_.end() ? size_ : found->second;
  }
  [[nodiscard]] static bool has(const SetRow& row, std::size_t atom, std::size_t mode) {
    const auto modes = row.modes.find(atom);
    return modes != row.modes.end() && modes->second.contains(mode);
  }
  [[nodiscard]] int effect(const SetRow& row, Text promise, std::size_t atom, std::size_t port) const {
    int most = kBlocked;
    for (const auto& [from, to] : moves_[atom].by_port[port]) {
      const int takes = has(row, atom, from), puts = has(row, atom, to);
      if (promise != "trap") most = std::max(most, promise == "at-most" ? puts - takes : takes - puts);
      else if (puts == 0) most = std::max(most, takes);
    }
    return most;
  }
  // In its first mode, for sure (all) or perhaps.
  [[nodiscard]] bool has_first(const SetRow& row, std::size_t atom, bool all) const {
    const Modes& first = moves_[atom].first;
    const auto is_in = [&](std::size_t mode) { return has(row, atom, mode); };
    return all ? !first.empty() && std::ranges::all_of(first, is_in)
               : first.empty() || std::ranges::any_of(first, is_in);
  }

  // Each word that the automaton reads keeps its promise.
  void check_promises() {
    std::set<std::pair<std::size_t, Memory>> seen;
    std::vector<const std::pair<std::size_t, Memory>*> open;
    const auto go = [&](std::size_t state, Memory memory) {
      const auto [at, is_new] = seen.emplace(state, std::move(memory));
      if (is_new) open.push_back(&*at);
      if (seen.size() > kMostNodes) throw NotCheckable("the automaton has too many words");
    };
    const auto letter_of = [&](const SetRow& row, int position, Text promise) {
      return letter(position, promise != "trap",
                    [&](std::size_t atom, std::size_t port) { return effect(row, promise, atom, port); });
    };
    const auto marks = [&](const SetRow& row) {
      return std::ranges::any_of(row.modes, [&](const auto& of) { return has_first(row, of.first, true); });
    };
    std::map<const SetRow*, Letter> letters;
    for (const SetRow& row : proof_.set_rows) {
      if (row.from == kNone) go(row.to, begin(row.promise != "trap", marks(row), letter_of(row, -1, row.promise)));
      else if (promise_of_.contains(row.from))
        letters.emplace(&row, letter_of(row, static_cast<int>(row.position), promise_of_[row.from]));
    }
    while (!open.empty()) {
      const auto [state, memory] = *open.back();
      open.pop_back();
      if (position_at(state) == size_) {
        if (!is_quiet(memory, false)) throw Rejected("an interaction breaks the promise of a word of sets at its end");
        if (promise_of_[state] == "trap" && !memory.flag) throw Rejected("a word of sets is not marked at first");
        continue;
      }
      for (const SetRow* row : rows_from_[state]) {
        Memory next = memory;
        next.flag = next.flag || marks(*row);
        if (!read(next, static_cast<int>(row->position), letters.at(row), false))
          throw Rejected(row->line + ": an interaction breaks the promise of a word of sets");
        go(row->to, std::move(next));
      }
    }
  }

  // ---- words of modes
  using Runs = std::set<std::pair<std::size_t, int>>;  // states of the automaton; how far the promise is broken
  struct Modal {
    Letter letter;
    bool is_final = true;
    std::vector<std::tuple<std::size_t, std::size_t, int>> rows;  // from where to where, and how much more is broken
    std::string text;
  };

  // All letters of a position.
  std::vector<Modal> letters_of(int position) {
    const Rows& atoms = atoms_at_.at(position);
    std::vector<Modal> all;
    std::vector<std::map<std::size_t, std::size_t>> choices(1);
    for (std::size_t atom : atoms) {
      std::vector<std::map<std::size_t, std::size_t>> longer;
      for (const auto& choice : choices) {
        for (std::size_t mode : proof_.reachable[atom]) longer.emplace_back(choice)[atom] = mode;
      }
      if (longer.size() > kMostLetters) throw NotCheckable("a position has too many modes");
      choices = std::move(longer);
    }
    for (const auto& choice : choices) {
      Modal& modal = all.emplace_back();
      modal.letter = letter(position, false, [&](std::size_t atom, std::size_t port) {
        return offers(atom, choice.at(atom))[port] ? 1 : kBlocked;
      });
      for (const auto& [atom, mode] : choice) {
        const Values& values = proof_.classes[proof_.class_of[atom]].modes[mode];
        for (std::size_t p = 0; p < model_.type_of(atom).places; ++p)
          modal.is_final = modal.is_final && (*values[p] == 0 || contains(model_.type_of(atom).finals, p));
        modal.text += ' ' + std::string(model_.atoms[atom].path) + ':' + std::to_string(mode);
      }
      for (const SetRow& row : proof_.set_rows) {
        if ((row.from == kNone ? -1 : static_cast<int>(row.position)) != position || !promise_of_.contains(row.to))
          continue;
        const Text promise = promise_of_[row.to];
        int more = 0;
        for (const auto& [atom, mode] : choice) {
          const int is_in = has(row, atom, mode);
          if (promise == "trap") more += is_in;
          else
            more += promise == "at-most" ? is_in - int(has_first(row, atom, false))
                                         : int(has_first(row, atom, true)) - is_in;
        }
        if (promise != "trap" || more == 0) modal.rows.emplace_back(row.from, row.to, more);
      }
    }
    return all;
  }
  // By port: is it enabled whatever is not told?
  const std::vector<bool>& offers(std::size_t atom, std::size_t mode) {
    const auto [at, is_new] = offers_.try_emplace({atom, mode});
    if (!is_new) return at->second;
    const AtomType& type = model_.type_of(atom);
    Local local = terms_.local(model_.atoms[atom], proof_.classes[proof_.class_of[atom]].modes[mode]);
    expr fault = terms_.truth(false);
    const Offer offer = terms_.offer(type, local, fault);
    const expr is_stable = no(terms_.goes_on(type, local));
    for (const expr& port : offer.ports) at->second.push_back(!terms_.may_be(both(is_stable, no(port))));
    return at->second;
  }

  // Each word without a step breaks a promise.
  void check_words() {
    struct Node {
      int position = 0;
      Memory memory;
      Runs runs;
      auto operator<=>(const Node&) const = default;
    };
    std::map<Node, std::pair<const Node*, const Modal*>> seen;  // from where, by which letter
    std::vector<const Node*> open;
    const auto go = [&](Node node, const Node* from, const Modal* by) {
      const auto [at, is_new] = seen.try_emplace(std::move(node), from, by);
      if (is_new) open.push_back(&at->first);
      if (seen.size() > kMostNodes) throw NotCheckable("there are too many words without a step");
    };
    std::map<int, std::vector<Modal>> letters;
    for (int p = -1; p < size_; ++p) letters.emplace(p, letters_of(p));
    for (const Modal& modal : letters.at(-1)) {
      Runs runs;
      for (const auto& [from, to, more] : modal.rows) runs.emplace(to, std::min(more, 1));
      go({0, begin(false, !modal.is_final, modal.letter), std::move(runs)}, nullptr, &modal);
    }
    while (!open.empty()) {
      const Node& node = *open.back();
      open.pop_back();
      if (node.position == size_) {
        const bool breaks = std::ranges::any_of(
            node.runs, [&](const auto& run) { return promise_of_[run.first] == "trap" || run.second > 0; });
        if (breaks || !node.memory.flag || !is_quiet(node.memory, true)) continue;
        std::string word;
        for (const Node* at = &node; at != nullptr; at = seen.at(*at).first) word = seen.at(*at).second->text + word;
        throw Rejected("no set excludes" + word);
      }
      for (const Modal& modal : letters.at(node.position)) {
        Memory memory = node.memory;
        memory.flag = memory.flag || !modal.is_final;
        if (!read(memory, node.position, modal.letter, true)) continue;
        std::map<int, Runs> runs;  // by the position that comes next
        for (const auto& [from, to, more] : modal.rows) {
          for (auto run = node.runs.lower_bound({from, kBlocked}); run != node.runs.end() && run->first == from;
               ++run) {
            const int broken = std::min(run->second + more, 1);
            if (broken >= kMostBehind) runs[position_at(to)].emplace(to, broken);
          }
        }
        go({node.position + 1, memory, runs[node.position + 1]}, &node, &modal);
        if (node.position == margin_) go({margin_, std::move(memory), runs[margin_]}, &node, &modal);
      }
    }
  }

  const Model& model_;
  const Certificate& proof_;
  const Tree& rows_ = model_.tree["for-all"];
  const int size_ = rows_.at(2).number(), margin_ = (size_ - 1) / 2;
  Pattern pattern_{model_, rows_, size_};
  Terms terms_;
  std::vector<Event> events_;
  std::vector<int> base_;     // by event: where its windows begin
  Rows first_value_, width_;  // by event: its first value in a letter; how many it has
  std::vector<bool> wraps_;   // by event: do windows go on at the first position?
  std::size_t letter_size_ = 0, reach_ = 0;
  std::map<int, std::vector<Read>> reads_;  // by position; -1: of atoms alone
  std::map<int, Rows> atoms_at_;
  std::vector<AtomMoves> moves_;
  std::map<std::size_t, int> position_of_;  // by state of the automaton
  std::map<std::size_t, Text> promise_of_;
  std::map<std::size_t, std::vector<const SetRow*>> rows_from_;
  std::map<std::pair<std::size_t, std::size_t>, std::vector<bool>> offers_;
};

}  // namespace

void check_words(const std::vector<const Model*>& models, const Certificate& certificate, z3::context& z) {
  Words(models, certificate, z).run();
}

}  // namespace certcheck
