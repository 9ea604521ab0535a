// See known_conflicts.hpp.
#include "compiler/driver/known_conflicts.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "compiler/system/uses_time.hpp"
#include "runtime/core/fire/partial.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::driver {

namespace {

using std::uint32_t;
using Pairs = std::set<std::pair<rt::InteractionId, rt::InteractionId>>;

constexpr std::size_t kMostListedConflicts = 20;
// Of a place with more interactions the conflicts are not counted.
constexpr std::size_t kMostCounted = 300;

void add_pairs(const std::set<rt::InteractionId>& interactions, Pairs& pairs) {
  for (auto a = interactions.begin(); a != interactions.end(); ++a) {
    for (auto b = std::next(a); b != interactions.end(); ++b) pairs.emplace(*a, *b);
  }
}

// By port instance: interactions that it may take part in.
std::vector<std::vector<rt::InteractionId>> interactions_of_ports(const rt::Tables& tables) {
  std::vector<std::vector<rt::InteractionId>> of_port(tables.port_atom.size());
  std::vector<uint32_t> ports;
  for (const rt::InteractionId interaction : tables.interactions.ids()) {
    rt::ports_of_interaction(tables, tables.interactions[interaction], ports);
    for (const uint32_t port : ports) of_port[port].push_back(interaction);
  }
  return of_port;
}

struct PlaceConflicts {
  uint32_t atom = 0, place = 0;
  std::size_t by_places = 0, left = 0;
  bool by_invariants = false;
};

std::vector<PlaceConflicts> conflicts_of_places(const rt::Tables& tables, const verify::NextMoves& known) {
  const std::vector<std::vector<rt::InteractionId>> of_port = interactions_of_ports(tables);
  // By atom and place, then by history and mode.
  std::map<std::pair<uint32_t, uint32_t>, std::map<std::pair<uint32_t, uint32_t>, std::set<rt::InteractionId>>>
      situations;
  for (const rt::NextMove& move : known.moves) {
    BIP_ASSERT(move.atom < tables.image->atoms.size && move.place < tables.atom_type(move.atom).places.size,
               "a move of atom {} at place {}", move.atom, move.place);
    std::set<rt::InteractionId>& there = situations[{move.atom, move.place}][{move.history, move.mode}];
    if (move.connector != rt::kNone) {
      there.insert(tables.interaction_of(move.connector));
      continue;
    }
    for (const rt::InteractionId interaction : of_port[tables.instance(move.atom, move.port)])
      there.insert(interaction);
  }
  std::vector<PlaceConflicts> rows;
  for (const auto& [at, modes] : situations) {
    const auto [atom, place] = at;
    const rt::LinkedType& type = tables.types[tables.atoms[atom].type];
    std::set<rt::InteractionId> all;
    for (uint32_t row = type.first_transition; row < type.first_transition + type.transition_count; ++row) {
      const rt::LinkedTransition& transition = tables.transitions[row];
      if (transition.port == rt::kNone || transition.from != place) continue;
      for (const rt::InteractionId interaction : of_port[tables.instance(atom, transition.port)])
        all.insert(interaction);
    }
    if (all.size() > kMostCounted) continue;
    Pairs left;
    for (const auto& [mode, interactions] : modes) add_pairs(interactions, left);
    PlaceConflicts row{atom, place, all.size() * (all.size() - 1) / 2, left.size(), false};
    BIP_ASSERT(row.left <= row.by_places, "{} conflicts by modes, {} by places", row.left, row.by_places);
    row.by_invariants = std::any_of(known.excluded.begin(), known.excluded.end(),
                                    [&](const auto& move) { return move.atom == row.atom && move.place == row.place; });
    if (row.left < row.by_places) rows.push_back(row);
  }
  return rows;
}

}  // namespace

verify::NextMoves prove_next_moves(const Compilation& c) {
  // What a component offers changes with the instant as well.
  if (system::is_timed(*c.system)) return {};
  return verify::find_next_moves(*c.system, verify::within_seconds(kSecondsOfConflicts));
}

RemovedConflicts removed_conflicts(const rt::Tables& tables, const verify::NextMoves& known) {
  RemovedConflicts removed;
  removed.question = known.question;
  if (known.question != verify::ConflictQuestion::Answered) return removed;
  for (const PlaceConflicts& row : conflicts_of_places(tables, known)) {
    (row.by_invariants ? removed.by_invariants : removed.by_modes) += row.by_places - row.left;
    removed.places.push_back({tables.image->atoms[row.atom].path(), tables.atom_type(row.atom).places[row.place],
                              row.by_places, row.left, row.by_invariants});
  }
  return removed;
}

std::string removed_conflicts_text(const RemovedConflicts& removed) {
  switch (removed.question) {
    case verify::ConflictQuestion::Answered: break;
    case verify::ConflictQuestion::TooLarge:
      return "conflicts go by places: the model is too large to ask which of them cannot be\n";
    case verify::ConflictQuestion::OutOfTime:
      return fmt::format("conflicts go by places: {} s of the processor did not prove which of them cannot be\n",
                         kSecondsOfConflicts);
  }
  if (removed.places.empty()) return {};
  std::string text = fmt::format("conflicts by places that cannot be: {} by modes, {} by invariants\n",
                                 removed.by_modes, removed.by_invariants);
  for (std::size_t k = 0; k < std::min(removed.places.size(), kMostListedConflicts); ++k) {
    const RemovedConflicts::At& row = removed.places[k];
    text += fmt::format("  `{}` at {}: {} of {}, by {}\n", row.component, row.place, row.by_places - row.left,
                        row.by_places, row.by_invariants ? "what brought it there" : "its modes");
  }
  if (removed.places.size() > kMostListedConflicts)
    text += fmt::format("  and at {} more places\n", removed.places.size() - kMostListedConflicts);
  return text;
}

std::string print_next_moves(const std::vector<rt::NextMove>& moves) {
  std::string text =
      "# Made by `bipc deploy`: what components may do next. Atom, place, history, mode, port, connector; -: none.\n";
  const auto number = [](uint32_t value) { return value == rt::kNone ? std::string("-") : std::to_string(value); };
  for (const rt::NextMove& move : moves)
    text += fmt::format("{} {} {} {} {} {}\n", move.atom, move.place, number(move.history), move.mode, move.port,
                        number(move.connector));
  return text;
}

Result<std::vector<rt::NextMove>> read_next_moves(const rt::Image& image, const std::string& text) {
  std::vector<rt::NextMove> moves;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    std::string history, connector;
    rt::NextMove move;
    words >> move.atom >> move.place >> history >> move.mode >> move.port >> connector;
    const auto read = [](const std::string& word, uint32_t& value) {
      std::istringstream number(word);
      return word == "-" || (number >> value && number.eof());
    };
    const bool is_row = !words.fail() && read(history, move.history) && read(connector, move.connector);
    const auto is_connector = [&](uint32_t row) { return row == rt::kNone || row < image.connectors.size; };
    const auto is_of_model = [&] {
      if (move.atom >= image.atoms.size || !is_connector(move.history) || !is_connector(move.connector)) return false;
      const rt::AtomType& type = image.atom_types[image.atoms[move.atom].type];
      return move.place < type.places.size && move.port < type.ports.size;
    };
    if (!is_row || !is_of_model()) return Failure{"odd line: " + line};
    moves.push_back(move);
  }
  std::sort(moves.begin(), moves.end());
  return moves;
}

}  // namespace bip::driver
