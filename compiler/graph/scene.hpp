// What the picture of a structure shows: boxes within boxes, and nets between their ports. A large array is one box, a
// compound below the depth limit is a closed one.
//
// A net is a connector, a group of its `define`, a merged port, or the line from something inside of a compound to the
// compound's border. All ends of a net are in one box: a line from deep inside leaves each compound through a port on
// its border. Linear in the System times the depth of its hierarchy.
#pragma once
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "compiler/graph/graph.hpp"
#include "compiler/system/system_ids.hpp"

namespace bip::graph {

using u32 = std::uint32_t;
inline constexpr u32 kNoRow = std::numeric_limits<u32>::max();

/// An end of a net: a port of a box beside it, or another net.
struct SceneEnd {
  u32 box = kNoRow, port = kNoRow;
  u32 net = kNoRow;
  bool is_trigger = false;
  u32 count = 1;  // ports of a folded array that it stands for
  friend bool operator==(const SceneEnd&, const SceneEnd&) = default;
};

enum class NetKind : std::uint8_t { Connector, Group, Merged, Exit };

struct SceneNet {
  NetKind kind = NetKind::Connector;
  std::string name;     // Connector, Merged
  std::string details;  // define, guards and transfers
  std::string path;
  u32 colour = 0;
  u32 first = kNoRow, last = kNoRow;  // Connector: rows of the system's connectors
  std::vector<SceneEnd> ends;
  std::vector<std::pair<u32, u32>> bundled{};  // of a bundle: first and last of each
  u32 exit = kNoRow;                           // port of the box around it to which this leads
};

struct ScenePort {
  std::string name;
  std::string key;   // tells the ports of a box apart
  u32 row = kNoRow;  // of the atom type's ports
};

enum class BoxKind : std::uint8_t { Compound, Closed, Atom };

struct SceneBox {
  BoxKind kind = BoxKind::Compound;
  std::string name, type, path;
  std::uint64_t count = 1;  // > 1: a folded array
  u32 parent = kNoRow;
  u32 colour = 0;
  u32 atom = kNoRow, compound = kNoRow;  // its row; of an array the first
  std::vector<ScenePort> ports;
  std::vector<u32> children;
  std::vector<SceneNet> nets;
  std::vector<std::string> notes;  // priorities
};

struct Scene {
  std::vector<SceneBox> boxes;  // 0 is the root; children come after their parents
  std::vector<u32> box_of_atom;
};

/// By net of the box: the children that it reaches, directly or through other nets; sorted.
[[nodiscard]] std::vector<std::vector<u32>> members_of_nets(const SceneBox& box);

[[nodiscard]] Scene build_scene(const System& system, const PictureOptions& options);

}  // namespace bip::graph
