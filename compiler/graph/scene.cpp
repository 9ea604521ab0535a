// See scene.hpp. Boxes are made by one pass over compounds and atoms, nets by one pass over connectors.
#include "compiler/graph/scene.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "compiler/graph/code_text.hpp"
#include "compiler/graph/dot.hpp"
#include "compiler/system/system.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

constexpr std::size_t kMostNotes = 6;
constexpr u32 kColours = 8, kWireColours = 6;

/// "phil" of "phil[3]"; the indices of folded arrays and of connectors in loops are dropped.
std::string array_name(const std::string& name) { return name.substr(0, name.find('[')); }

class SceneBuilder {
 public:
  SceneBuilder(const System& system, const PictureOptions& options) : system_(system), options_(options) {}

  Scene run() {
    count_arrays();
    make_boxes();
    net_of_connector_.resize(system_.connectors.size());
    for (std::size_t k = 0; k < system_.connectors.size(); ++k) make_connector(ConnectorId(k));
    for (const Priority& row : system_.priorities) add_note(row);
    BIP_ASSERT(scene_.box_of_atom.size() == system_.atoms.size(), "{} of {} atoms have a box",
               scene_.box_of_atom.size(), system_.atoms.size());
    return std::move(scene_);
  }

 private:
  struct NetPlace {
    u32 box = kNoRow, net = kNoRow;
  };

  [[nodiscard]] std::string own_name(const std::string& path, CompoundId parent) const {
    const std::string outer = parent.is_valid() ? system_.compounds[parent].path + "." : "";
    return path.starts_with(outer) ? path.substr(outer.size()) : path;
  }
  /// (compound, array, type): the elements of an array that may be folded.
  using ArrayKey = std::tuple<u32, std::string, std::string>;
  [[nodiscard]] ArrayKey array_key(const std::string& path, CompoundId parent, const std::string& type) const {
    return {parent.value, array_name(own_name(path, parent)), type};
  }
  void count_arrays() {
    for (const Compound& row : system_.compounds)
      if (row.parent.is_valid() && row.path.ends_with(']')) ++arrays_[array_key(row.path, row.parent, row.type)];
    for (const Atom& row : system_.atoms)
      if (row.path.ends_with(']')) ++arrays_[array_key(row.path, row.parent, system_.atom_types[row.type].name)];
  }
  [[nodiscard]] bool is_opened(const std::string& path) const {
    const auto is_named = [&](const std::string& name) {
      return path == name || path == "ROOT." + name || array_name(path) == name || array_name(path) == "ROOT." + name;
    };
    return std::any_of(options_.open.begin(), options_.open.end(), is_named);
  }

  /// The folded array that the row belongs to: its box if there is one already, else kNoRow; `count` 1: none.
  u32 folded(const ArrayKey& key, const std::string& path, std::uint64_t& count) {
    count = 1;
    if (!path.ends_with(']')) return kNoRow;
    const auto found = arrays_.find(key);
    BIP_ASSERT(found != arrays_.end(), "`{}` belongs to no array", path);
    if (found->second <= options_.fold || is_opened(path)) return kNoRow;
    count = found->second;
    const auto box = array_box_.find(key);
    return box == array_box_.end() ? kNoRow : box->second;
  }

  u32 add_box(u32 parent, SceneBox box) {
    const u32 row = static_cast<u32>(scene_.boxes.size());
    BIP_ASSERT(parent == kNoRow ? row == 0 : parent < row, "box {} is in box {}", row, parent);
    box.parent = parent;
    scene_.boxes.push_back(std::move(box));
    if (parent != kNoRow) scene_.boxes[parent].children.push_back(row);
    return row;
  }

  void make_boxes() {
    box_of_compound_.resize(system_.compounds.size(), kNoRow);
    std::vector<std::uint64_t> depth(system_.compounds.size(), 0);
    for (std::size_t k = 0; k < system_.compounds.size(); ++k) {
      const Compound& row = system_.compounds[CompoundId(k)];
      SceneBox box;
      box.compound = static_cast<u32>(k);
      box.path = row.path;
      box.type = row.type;
      if (!row.parent.is_valid()) {
        box.name = row.path;
        box_of_compound_[k] = add_box(kNoRow, std::move(box));
        continue;
      }
      depth[k] = depth[row.parent.value] + 1;
      const u32 parent = box_of_compound_[row.parent.value];
      if (scene_.boxes[parent].kind == BoxKind::Closed) {
        box_of_compound_[k] = parent;
        continue;
      }
      const ArrayKey key = array_key(row.path, row.parent, row.type);
      const u32 array = folded(key, row.path, box.count);
      if (array != kNoRow) {
        box_of_compound_[k] = array;
        continue;
      }
      box.name = own_name(row.path, row.parent);
      const bool is_deep = depth[k] >= options_.depth && !is_opened(row.path);
      if (box.count > 1 || is_deep) box.kind = BoxKind::Closed;
      box.colour = kColours - 1;
      box_of_compound_[k] = finish_box(parent, std::move(box), key);
    }
    for (std::size_t k = 0; k < system_.atoms.size(); ++k) make_atom(AtomId(k));
  }

  u32 finish_box(u32 parent, SceneBox box, const ArrayKey& key) {
    const bool is_array = box.count > 1;
    if (is_array) box.name = fmt::format("{}[{}]", array_name(box.name), box.count);
    const u32 row = add_box(parent, std::move(box));
    if (is_array) array_box_[key] = row;
    return row;
  }

  void make_atom(AtomId id) {
    const Atom& row = system_.atoms[id];
    const AtomType& type = system_.atom_types[row.type];
    const u32 parent = box_of_compound_[row.parent.value];
    if (scene_.boxes[parent].kind == BoxKind::Closed) {
      scene_.box_of_atom.push_back(parent);
      return;
    }
    SceneBox box;
    const ArrayKey key = array_key(row.path, row.parent, type.name);
    const u32 array = folded(key, row.path, box.count);
    if (array != kNoRow) {
      scene_.box_of_atom.push_back(array);
      return;
    }
    box.kind = BoxKind::Atom;
    box.atom = id.value;
    box.path = row.path;
    box.name = own_name(row.path, row.parent);
    std::string args;
    for (const Value& value : row.args) args += (args.empty() ? "" : ", ") + text_of(system_.code, value);
    box.type = type.name + (args.empty() || box.count > 1 ? "" : "(" + args + ")");
    box.colour = row.type.value % (kColours - 1);
    for (std::size_t p = 0; p < type.ports.size(); ++p)
      if (type.ports[p].exported || type.ports[p].external)
        box.ports.push_back({type.ports[p].name, type.ports[p].name, static_cast<u32>(p)});
    scene_.box_of_atom.push_back(finish_box(parent, std::move(box), key));
  }

  // -- Nets --

  [[nodiscard]] bool contains(u32 outer, u32 inner) const {
    while (inner != kNoRow && inner != outer) inner = scene_.boxes[inner].parent;
    return inner == outer;
  }
  u32 port_of(u32 box, const std::string& key, const std::string& name) {
    std::vector<ScenePort>& ports = scene_.boxes[box].ports;
    const auto found = std::find_if(ports.begin(), ports.end(), [&](const ScenePort& p) { return p.key == key; });
    if (found != ports.end()) return static_cast<u32>(found - ports.begin());
    ports.push_back({name, key, kNoRow});
    return static_cast<u32>(ports.size() - 1);
  }
  /// What tells a thing inside of a box apart from others there: its path without the box's.
  [[nodiscard]] std::string key_in(u32 box, const std::string& path) const {
    const SceneBox& row = scene_.boxes[box];
    const std::string outer = row.count > 1 ? array_name(row.path) : row.path;
    if (!path.starts_with(outer)) return path;
    const std::size_t dot = path.find('.', outer.size());
    return dot == std::string::npos ? path : path.substr(dot + 1);
  }

  /// Leads an end in `box` up to where it is beside the nets of `home`, through a port on each border.
  SceneEnd lead_out(SceneEnd end, const std::string& path, const std::string& name, u32 home) {
    while (scene_.boxes[end.box].parent != home) {
      const u32 outer = scene_.boxes[end.box].parent;
      BIP_ASSERT(outer != kNoRow, "`{}` is not in box {}", path, home);
      const std::string key = key_in(outer, path);
      const std::size_t before = scene_.boxes[outer].ports.size();
      const u32 port = port_of(outer, key, name);
      if (scene_.boxes[outer].ports.size() != before) {
        SceneNet net;
        net.kind = NetKind::Exit;
        net.path = path;
        net.ends = {end};
        net.exit = port;
        scene_.boxes[outer].nets.push_back(std::move(net));
      }
      end = SceneEnd{.box = outer, .port = port};
    }
    return end;
  }

  SceneEnd resolve(const PortRef& ref, u32 home) {
    switch (ref.kind) {
      case PortRef::Kind::Atom: {
        const Atom& atom = system_.atoms[ref.atom];
        const std::string& name = system_.atom_types[atom.type].ports[ref.port].name;
        const u32 box = scene_.box_of_atom[ref.atom.value];
        const bool is_closed = scene_.boxes[box].kind == BoxKind::Closed;
        const std::string path = atom.path + "." + name;
        return lead_out({.box = box, .port = port_of(box, is_closed ? key_in(box, path) : name, name)}, path, name,
                        home);
      }
      case PortRef::Kind::Connector: {
        const Connector& row = system_.connectors[ref.connector];
        const NetPlace inner = net_of_connector_[ref.connector.value];
        // What connectors export often has one name for all; they have names of their own.
        const std::string name = own_name(row.path, row.parent);
        if (inner.box == home) return {.net = inner.net};
        const u32 port = port_of(inner.box, key_in(inner.box, row.path), name);
        if (inner.net != kNoRow) scene_.boxes[inner.box].nets[inner.net].exit = port;
        return lead_out({.box = inner.box, .port = port}, row.path, name, home);
      }
      case PortRef::Kind::Choice: break;
    }
    const auto [found, is_new] = merged_.try_emplace({ref.choice, home}, kNoRow);
    if (is_new) {
      SceneNet net;
      net.kind = NetKind::Merged;
      net.name = key_in(home, system_.choices[ref.choice].name);
      for (const PortRef& port : system_.choices[ref.choice].ports) net.ends.push_back(resolve(port, home));
      found->second = add_net(home, std::move(net));
    }
    return {.net = found->second};
  }

  u32 add_net(u32 home, SceneNet net) {
    scene_.boxes[home].nets.push_back(std::move(net));
    return static_cast<u32>(scene_.boxes[home].nets.size() - 1);
  }

  void add_end(SceneNet& net, SceneEnd end) {
    for (SceneEnd& other : net.ends) {
      if (other.box != end.box || other.port != end.port || other.net != end.net) continue;
      if (other.is_trigger != end.is_trigger) continue;
      ++other.count;
      return;
    }
    net.ends.push_back(end);
  }

  /// The innermost open box around the connector that contains all its ends.
  [[nodiscard]] u32 home_of(const Connector& row) const {
    u32 home = box_of_compound_[row.parent.value];
    if (scene_.boxes[home].kind == BoxKind::Closed) home = scene_.boxes[home].parent;
    const auto climb = [&](const PortRef& ref, auto&& self) -> void {
      switch (ref.kind) {
        case PortRef::Kind::Atom: {
          const u32 box = scene_.box_of_atom[ref.atom.value];
          while (!contains(home, box) || home == box) home = scene_.boxes[home].parent;
          return;
        }
        case PortRef::Kind::Connector:
          while (!contains(home, net_of_connector_[ref.connector.value].box)) home = scene_.boxes[home].parent;
          return;
        case PortRef::Kind::Choice:
          for (const PortRef& port : system_.choices[ref.choice].ports) self(port, self);
          return;
      }
    };
    for (const PortRef& ref : row.ports) climb(ref, climb);
    BIP_ASSERT(home != kNoRow && scene_.boxes[home].kind == BoxKind::Compound, "connector `{}` is in no open box",
               row.path);
    return home;
  }

  /// True if all of the connector is inside of a closed box.
  [[nodiscard]] bool is_hidden(const Connector& row, u32 box) const {
    const auto is_inside = [&](const PortRef& ref, auto&& self) -> bool {
      switch (ref.kind) {
        case PortRef::Kind::Atom: return scene_.box_of_atom[ref.atom.value] == box;
        case PortRef::Kind::Connector: return net_of_connector_[ref.connector.value].box == box;
        case PortRef::Kind::Choice: {
          const std::vector<PortRef>& ports = system_.choices[ref.choice].ports;
          return std::all_of(ports.begin(), ports.end(), [&](const PortRef& p) { return self(p, self); });
        }
      }
      return false;
    };
    return std::all_of(row.ports.begin(), row.ports.end(), [&](const PortRef& p) { return is_inside(p, is_inside); });
  }

  /// Adds the groups of a `define` inside out, and the ends of its root to `net`.
  void add_group(const ConnectorType& type, const Connector& row, u32 node, u32 home, SceneNet& net, u32 colour) {
    for (const u32 child : type.define[node].children) {
      const DefineNode& part = type.define[child];
      SceneEnd end;
      if (part.is_leaf) {
        end = resolve(row.ports[part.param], home);
      } else {
        SceneNet group;
        group.kind = NetKind::Group;
        group.colour = colour;
        add_group(type, row, child, home, group, colour);
        end.net = add_net(home, std::move(group));
      }
      end.is_trigger = part.trigger;
      add_end(net, end);
    }
  }

  void make_connector(ConnectorId id) {
    const Connector& row = system_.connectors[id];
    const ConnectorType& type = system_.connector_types[row.type];
    const u32 declared = box_of_compound_[row.parent.value];
    if (scene_.boxes[declared].kind == BoxKind::Closed && is_hidden(row, declared)) {
      net_of_connector_[id.value] = {declared, kNoRow};
      return;
    }
    const u32 home = home_of(row);
    const std::string name = own_name(row.path, row.parent);
    const std::size_t before = scene_.boxes[home].nets.size();
    SceneNet net;
    net.path = row.path;
    net.name = name;
    net.first = net.last = id.value;
    net.colour = colour_of(type.name + " " + array_name(name));
    add_group(type, row, 0, home, net, net.colour);
    if (name.ends_with(']') && is_drawn_already(home, before, net)) {
      scene_.boxes[home].nets.resize(before);
      net_of_connector_[id.value] = {home, last_of_array_[{home, array_name(name)}]};
      return;
    }
    net.details = details_of(type);
    const u32 made = add_net(home, std::move(net));
    net_of_connector_[id.value] = {home, made};
    if (name.ends_with(']')) last_of_array_[{home, array_name(name)}] = made;
  }

  /// Whether this connector of an array has the ends of the last one: then one line stands for both.
  bool is_drawn_already(u32 home, std::size_t before, const SceneNet& net) {
    if (scene_.boxes[home].nets.size() != before) return false;  // it has groups of its own
    const auto last = last_of_array_.find({home, array_name(net.name)});
    if (last == last_of_array_.end()) return false;
    SceneNet& other = scene_.boxes[home].nets[last->second];
    if (other.ends != net.ends) return false;
    const std::string first = own_name(system_.connectors[ConnectorId(other.first)].path,
                                       system_.connectors[ConnectorId(other.first)].parent);
    other.last = net.first;
    const auto index = [](const std::string& text) {
      return text.substr(text.find('[') + 1, text.size() - text.find('[') - 2);
    };
    other.name = fmt::format("{}[{}..{}]", array_name(first), index(first), index(net.name));
    return true;
  }

  u32 colour_of(const std::string& name) {
    return colours_.try_emplace(name, static_cast<u32>(colours_.size() % kWireColours)).first->second;
  }

  std::string details_of(const ConnectorType& type) const {
    std::vector<std::string> lines{type.name + ": " + define_of(type)};
    const CodeNames names = names_of(system_, type);
    for (const Clause& clause : type.clauses) {
      std::string line = "on";
      for (const u32 p : clause.params) line += " " + type.params[p].name;
      if (const std::string text = text_of(system_.code, clause.guard, names); !text.empty()) line += " [" + text + "]";
      if (const std::string text = text_of(system_.code, clause.up, names); !text.empty()) line += " up " + text;
      if (const std::string text = text_of(system_.code, clause.down, names); !text.empty()) line += " down " + text;
      lines.push_back(std::move(line));
    }
    return lines_of(lines);
  }

  void add_note(const Priority& row) {
    const u32 home = box_of_compound_[row.parent.value];
    if (scene_.boxes[home].kind == BoxKind::Closed) return;
    const auto side = [&](const Pattern& pattern) -> std::string {
      if (pattern.any_connector) return "*";
      const Connector& connector = system_.connectors[pattern.connector];
      std::string text = own_name(connector.path, row.parent);
      if (pattern.any_interaction) return text;
      const ConnectorType& type = system_.connector_types[connector.type];
      std::string params;
      for (const u32 p : pattern.params) params += (params.empty() ? "" : " ") + type.params[p].name;
      return text + ":" + params;
    };
    const std::string guard = text_of(system_.code, row.guard, names_of(system_, row));
    std::vector<std::string>& notes = scene_.boxes[home].notes;
    if (notes.size() < kMostNotes) {
      notes.push_back(
          shortened("priority " + side(row.low) + " < " + side(row.high) + (guard.empty() ? "" : " [" + guard + "]")));
    } else {
      ++more_notes_[home];
      if (notes.size() == kMostNotes) notes.emplace_back();
      notes.back() = fmt::format("… and {} more priorities", more_notes_[home]);
    }
  }

  const System& system_;
  const PictureOptions& options_;
  Scene scene_;
  std::map<ArrayKey, std::uint64_t> arrays_;
  std::map<ArrayKey, u32> array_box_;
  std::vector<u32> box_of_compound_;
  std::vector<NetPlace> net_of_connector_;
  std::map<std::pair<u32, u32>, u32> merged_;  // (row of the choices, box): its net
  std::map<std::pair<u32, std::string>, u32> last_of_array_;
  std::map<std::string, u32> colours_;
  std::map<u32, u32> more_notes_;
};

}  // namespace

std::vector<std::vector<u32>> members_of_nets(const SceneBox& box) {
  std::vector<std::vector<u32>> members(box.nets.size());
  for (u32 net = 0; net < box.nets.size(); ++net) {
    std::vector<u32>& list = members[net];
    for (const SceneEnd& end : box.nets[net].ends) {
      if (end.net == kNoRow) {
        list.push_back(end.box);
      } else {
        BIP_ASSERT(end.net < net, "net {} is bound by {}", end.net, net);
        list.insert(list.end(), members[end.net].begin(), members[end.net].end());
      }
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return members;
}

Scene build_scene(const System& system, const PictureOptions& options) { return SceneBuilder(system, options).run(); }

}  // namespace bip::graph
