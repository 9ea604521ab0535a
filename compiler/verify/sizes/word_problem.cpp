// See word_problem.hpp. Priorities and maximal progress are left out: they hide a step only where another one is
// possible, so they make no deadlock, and without them there are only more steps.
#include "compiler/verify/sizes/word_problem.hpp"

#include <algorithm>
#include <optional>
#include <unordered_map>

#include <fmt/format.h>

#include "compiler/system/system.hpp"
#include "compiler/system/uses_time.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr double kMostInteractions = 256;
constexpr std::size_t kMostTriggers = 6;

std::unordered_map<std::string, AtomId> atoms_by_path(const System& system) {
  std::unordered_map<std::string, AtomId> atoms;
  for (std::size_t a = 0; a < system.atoms.size(); ++a) atoms.emplace(system.atoms[AtomId(a)].path, AtomId(a));
  return atoms;
}

using BoundPorts = std::vector<std::pair<std::string, std::uint32_t>>;

// The ports of the connector in one round (of any connector: its only one).
BoundPorts bound_ports(const SizedCompound& sized, const SizedConnector& connector, std::int64_t size, std::int64_t i) {
  BoundPorts ports;
  for (const SizedPort& port : connector.ports) {
    const SizedFamily& family = sized.families[port.family];
    switch (port.place) {
      case ElementPlace::Single:
      case ElementPlace::FromStart: ports.emplace_back(element_path(family, port.offset), port.port); break;
      case ElementPlace::FromEnd: ports.emplace_back(element_path(family, size - 1 - port.offset), port.port); break;
      case ElementPlace::AtLoop:
        BIP_ASSERT(size > 0 && i + port.offset + size >= 0, "element {} at offset {} of {}", i, port.offset, size);
        ports.emplace_back(element_path(family, (i + port.offset + size) % size), port.port);
        break;
      case ElementPlace::Every:
        for (std::int64_t k = 0; k < size; ++k) ports.emplace_back(element_path(family, k), port.port);
        break;
    }
  }
  std::sort(ports.begin(), ports.end());
  return ports;
}

}  // namespace

bool is_described_instance(const SizedCompound& sized, const System& system, std::int64_t size) {
  std::vector<std::string> atoms, paths;
  for (const SizedFamily& family : sized.families) {
    const std::int64_t count = family.kind == ArrayKind::Sized ? size : family.count;
    for (std::int64_t k = 0; k < count; ++k) atoms.push_back(element_path(family, k));
  }
  for (const Atom& atom : system.atoms) paths.push_back(atom.path);
  std::sort(atoms.begin(), atoms.end());
  std::sort(paths.begin(), paths.end());
  if (atoms != paths) return false;
  std::vector<BoundPorts> wanted, found;
  for (const SizedConnector& connector : sized.connectors) {
    if (!connector.is_loop) wanted.push_back(bound_ports(sized, connector, size, 0));
    for (std::int64_t i = connector.low; connector.is_loop && i < size - connector.high; ++i)
      wanted.push_back(bound_ports(sized, connector, size, i));
  }
  for (const Connector& connector : system.connectors) {
    BoundPorts& ports = found.emplace_back();
    for (const PortRef& ref : connector.ports) {
      if (ref.kind != PortRef::Kind::Atom) return false;
      ports.emplace_back(system.atoms[ref.atom].path, ref.port);
    }
    std::sort(ports.begin(), ports.end());
  }
  std::sort(wanted.begin(), wanted.end());
  std::sort(found.begin(), found.end());
  return wanted == found;
}

namespace {

class WordProblemMaker {
 public:
  WordProblemMaker(const SizedCompound& sized, const Model& model, const CompoundType& type, const Net& net)
      : sized_(sized), model_(model), type_(type), net_(net), system_(*net.system), atoms_(atoms_by_path(system_)) {}

  Result<WordProblem> make() {
    if (const std::string timed = system::first_timed(system_); !timed.empty()) fail(timed);
    if (system_.code.has_cpp()) fail("the model calls C++");
    if (system_.code.has_draws()) fail("the model draws random numbers");
    if (net_.too_large_atom != kNoRow)
      fail(fmt::format("`{}` has too many local states", system_.atoms[AtomId(net_.too_large_atom)].path));
    if (reason_.empty()) components();
    for (const SizedConnector& connector : sized_.connectors) {
      if (reason_.empty()) interactions(connector);
    }
    if (!reason_.empty()) return Failure{reason_};
    return std::move(out_);
  }

 private:
  void fail(std::string reason) {
    if (reason_.empty()) reason_ = std::move(reason);
  }

  WordAtom word_atom(const SizedFamily& family, std::int64_t element) {
    const AtomId atom = atoms_.at(element_path(family, element));
    const AtomType& type = system_.atom_types[system_.atoms[atom].type];
    if (!type.merged.empty()) fail(fmt::format("`{}` exports merged ports", type.name));
    WordAtom row{&net_.class_at(atom.value), {}};
    for (const Mode& mode : row.modes->modes) {
      const bool is_final =
          std::includes(type.final_places.begin(), type.final_places.end(), mode.places.begin(), mode.places.end());
      row.is_final.push_back(is_final ? 1 : 0);
    }
    return row;
  }

  // The components, and the ports that are steps of their own.
  void components() {
    const std::int64_t size = sized_.least_size();
    out_.margin = sized_.margin;
    out_.zones.resize(static_cast<std::size_t>(size));
    for (const SizedFamily& family : sized_.families) {
      const bool is_sized = family.kind == ArrayKind::Sized;
      first_.push_back(static_cast<std::uint32_t>(is_sized ? out_.zones.front().size() : out_.singles.size()));
      for (std::int64_t k = 0; k < (is_sized ? size : family.count); ++k) {
        const AtomType& type = model_.atom_types[family.type];
        if (is_sized) out_.zones[static_cast<std::size_t>(k)].push_back(word_atom(family, k));
        else out_.singles.push_back(word_atom(family, k));
        if (is_sized && k > 0) continue;
        const std::uint32_t row = first_.back() + (is_sized ? 0 : static_cast<std::uint32_t>(k));
        for (std::uint32_t p = 0; p < type.ports.size(); ++p) {
          if (type.ports[p].exported) continue;
          WordEvent event;
          event.ports.push_back({row, p, is_sized ? ElementPlace::AtLoop : ElementPlace::Single, 0, false});
          event.is_loop = is_sized;
          out_.events.push_back(std::move(event));
        }
      }
    }
  }

  [[nodiscard]] WordPort word_port(const SizedPort& port) const {
    const bool is_single = port.place == ElementPlace::Single;
    const std::uint32_t row = first_[port.family] + (is_single ? static_cast<std::uint32_t>(port.offset) : 0);
    return {row, port.port, port.place, is_single ? 0 : port.offset, false};
  }

  void add(const SizedConnector& connector, std::vector<WordPort> ports, bool is_sure) {
    const bool is_loop =
        std::any_of(ports.begin(), ports.end(), [](const WordPort& p) { return p.place == ElementPlace::AtLoop; });
    if (connector.is_loop && !is_loop) {
      // The same interaction of elements outside of the arrays in each round; there is a round at each size.
      out_.events.push_back({std::move(ports), false, 0, 0, is_sure});
      return;
    }
    out_.events.push_back({std::move(ports), is_loop, connector.low, connector.high, is_sure});
  }

  void interactions(const SizedConnector& connector) {
    const bool has_every = std::any_of(connector.ports.begin(), connector.ports.end(),
                                       [](const SizedPort& p) { return p.place == ElementPlace::Every; });
    if (has_every) return interactions_of_all(connector);
    const ConnectorType& type = model_.connector_types[connector.type];
    if (model::interaction_count(type) > kMostInteractions)
      return fail(fmt::format("connector `{}` has more than {} interactions", name_of(connector), kMostInteractions));
    BIP_ENSURE(type.params.size() == connector.ports.size(), "{} ports of {}", connector.ports.size(),
               type.params.size());
    for (const std::vector<std::uint32_t>& params : model::interactions_of(type)) {
      std::vector<WordPort> ports;
      for (const std::uint32_t p : params) ports.push_back(word_port(connector.ports[p]));
      const bool is_sure = std::none_of(type.clauses.begin(), type.clauses.end(), [&params](const Clause& clause) {
        return clause.params == params && clause.guard.is_valid();
      });
      add(connector, std::move(ports), is_sure);
    }
  }

  // A connector with all elements of an array: a rendezvous of all, or single triggers with what is available.
  // Its type is that of the instance, in which [*] is unfolded.
  void interactions_of_all(const SizedConnector& connector) {
    const std::string path = "ROOT." + name_of(connector);
    const auto row = std::find_if(system_.connectors.begin(), system_.connectors.end(),
                                  [&path](const Connector& c) { return c.path == path; });
    if (row == system_.connectors.end())
      return fail(fmt::format("connector `{}` joins all elements in each round of a loop", name_of(connector)));
    const ConnectorType& type = system_.connector_types[row->type];
    std::vector<int> is_trigger(type.params.size(), -1);
    for (const std::uint32_t child : type.define.front().children) {
      const DefineNode& node = type.define[child];
      if (!node.is_leaf) return fail(fmt::format("connector `{}` has inner groups", name_of(connector)));
      is_trigger[node.param] = node.trigger ? 1 : 0;
    }
    std::vector<WordPort> ports;
    std::vector<std::uint8_t> triggers;  // by port as written
    std::size_t param = 0;
    for (const SizedPort& port : connector.ports) {
      ports.push_back(word_port(port));
      const std::size_t count = port.place == ElementPlace::Every ? static_cast<std::size_t>(sized_.least_size()) : 1;
      BIP_ENSURE(param + count <= is_trigger.size(), "{} parameters", is_trigger.size());
      triggers.push_back(is_trigger[param] == 1 ? 1 : 0);
      for (std::size_t k = 0; k < count; ++k, ++param) {
        if (is_trigger[param] != (triggers.back() != 0 ? 1 : 0))
          return fail(fmt::format("connector `{}` treats elements differently", name_of(connector)));
      }
    }
    const bool is_sure = std::none_of(type.clauses.begin(), type.clauses.end(),
                                      [](const Clause& clause) { return clause.guard.is_valid(); });
    if (std::none_of(triggers.begin(), triggers.end(), [](std::uint8_t t) { return t != 0; })) {
      out_.events.push_back({std::move(ports), false, 0, 0, is_sure});
      return;
    }
    if (std::all_of(triggers.begin(), triggers.end(), [](std::uint8_t t) { return t != 0; })) {
      // Each part of an interaction is one by itself, so no other empties a trap that these leave.
      for (WordPort port : ports) {
        const bool is_every = port.place == ElementPlace::Every;
        if (is_every) port.place = ElementPlace::AtLoop;
        out_.events.push_back({{port}, is_every, 0, 0, is_sure});
      }
      return;
    }
    subsets(connector, ports, triggers, is_sure);
  }

  // Each choice of the written ports that contains a trigger; all elements of an array take part as they can.
  void subsets(const SizedConnector& connector, const std::vector<WordPort>& ports,
               const std::vector<std::uint8_t>& triggers, bool is_sure) {
    std::vector<std::size_t> chosen;
    for (std::size_t p = 0; p < ports.size(); ++p) {
      if (ports[p].place != ElementPlace::Every) chosen.push_back(p);
      else if (triggers[p] != 0)
        return fail(
            fmt::format("connector `{}` has all elements of an array as triggers, and synchrons", name_of(connector)));
    }
    if (chosen.size() > kMostTriggers)
      return fail(
          fmt::format("connector `{}` has more than {} ports outside of arrays", name_of(connector), kMostTriggers));
    for (std::size_t set = 1; set < std::size_t(1) << chosen.size(); ++set) {
      std::vector<WordPort> own;
      bool has_trigger = false;
      for (std::size_t k = 0; k < chosen.size(); ++k) {
        if ((set >> k & 1) == 0) continue;
        own.push_back(ports[chosen[k]]);
        has_trigger = has_trigger || triggers[chosen[k]] != 0;
      }
      if (!has_trigger) continue;
      for (WordPort port : ports) {
        if (port.place != ElementPlace::Every) continue;
        port.is_optional = true;
        own.push_back(port);
      }
      out_.events.push_back({std::move(own), false, 0, 0, is_sure});
    }
  }

  [[nodiscard]] const std::string& name_of(const SizedConnector& connector) const {
    return type_.connectors[connector.family].name;
  }

  const SizedCompound& sized_;
  const Model& model_;
  const CompoundType& type_;
  const Net& net_;
  const System& system_;
  std::unordered_map<std::string, AtomId> atoms_;
  std::vector<std::uint32_t> first_;  // by family: row of its first atom
  WordProblem out_;
  std::string reason_;
};

}  // namespace

Result<WordProblem> make_word_problem(const SizedCompound& sized, const Model& model, const CompoundType& type,
                                      const Net& net) {
  return WordProblemMaker(sized, model, type, net).make();
}

std::string candidate_text(const SizedCompound& sized, const Net& net, const WordProblem& problem,
                           const WordAnswer& answer, const std::string& size_name) {
  constexpr std::size_t kPlacesShown = 12;
  std::vector<std::string> places;
  std::size_t single = 0, array = 0;
  const auto size = answer.letters.size();
  BIP_ASSERT(answer.singles.size() == problem.singles.size() && size >= problem.zones.size(),
             "a candidate of {} single components and {} letters", answer.singles.size(), size);
  for (const SizedFamily& family : sized.families) {
    if (family.kind != ArrayKind::Sized) {
      for (std::int64_t k = 0; k < family.count; ++k, ++single)
        places.push_back(element_path(family, k).substr(5) + "@" +
                         mode_text(*net.system, *problem.singles[single].modes, answer.singles[single]));
      continue;
    }
    for (std::size_t p = 0; p < size; ++p) {
      const auto margin = static_cast<std::size_t>(problem.margin);
      const std::size_t zone = p < margin ? p : p + margin >= size ? 2 * margin + 1 - (size - p) : margin;
      places.push_back(element_path(family, static_cast<std::int64_t>(p)).substr(5) + "@" +
                       mode_text(*net.system, *problem.zones[zone][array].modes, answer.letters[p][array]));
    }
    ++array;
  }
  std::string text = fmt::format("{} = {}:", size_name, size);
  for (std::size_t k = 0; k < std::min(places.size(), kPlacesShown); ++k) text += (k == 0 ? " " : ", ") + places[k];
  return text + (places.size() > kPlacesShown ? ", …" : "");
}

}  // namespace bip::verify
