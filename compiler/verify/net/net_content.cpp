// See net_content.hpp. Compounds come before what they hold, so backwards is bottom up.
#include "compiler/verify/net/net_content.hpp"

#include "compiler/base/content_hash.hpp"
#include "compiler/system/system.hpp"

namespace bip::verify {

namespace {

class Bytes {
 public:
  void number(std::uint64_t value) {
    for (unsigned k = 0; k < 8; ++k) text_ += static_cast<char>(value >> (8 * k));
  }
  template <class Row>
  void numbers(const std::vector<Row>& rows) {
    number(rows.size());
    for (const Row row : rows) number(row);
  }
  void text(const std::string& text) {
    number(text.size());
    text_ += text;
  }
  [[nodiscard]] std::string hash() const { return blake2b(text_); }

 private:
  std::string text_;
};

std::string hash_of(const ModeClass& row) {
  Bytes bytes;
  bytes.numbers(row.followed);
  bytes.number(row.modes.size());
  for (const Mode& mode : row.modes) {
    bytes.numbers(mode.places);
    for (std::size_t k = 0; k < mode.values.size(); ++k) {
      if (row.followed[k] != 0)
        bytes.number(mode.values[k].is_known ? static_cast<std::uint64_t>(mode.values[k].value) : ~std::uint64_t{0});
    }
  }
  bytes.numbers(row.initial);
  bytes.number(row.moves.size());
  for (const std::vector<Move>& moves : row.moves) {
    bytes.number(moves.size());
    for (const Move& move : moves) {
      bytes.number(move.from);
      bytes.number(move.to);
    }
  }
  for (const std::vector<std::uint8_t>& sure : row.is_sure) bytes.numbers(sure);
  return bytes.hash();
}

class NetContentReader {
 public:
  explicit NetContentReader(const Net& net)
      : net_(net), system_(*net.system), texts_(system_.compounds.size()), first_(system_.compounds.size(), kNoRow) {}

  NetContent read() {
    NetContent content;
    for (const ModeClass& row : net_.classes) content.of_class.push_back(hash_of(row));
    for (std::size_t row = 0; row < system_.atoms.size(); ++row) {
      const Atom& atom = system_.atoms[AtomId(row)];
      // Rows below a compound stand together, so its first one is what the others are counted from.
      for (CompoundId at = atom.parent; at.is_valid() && first_[at.value] == kNoRow; at = system_.compounds[at].parent)
        first_[at.value] = static_cast<u32>(row);
      Bytes& bytes = texts_[atom.parent.value];
      bytes.text(path_below(system_.compounds[atom.parent].path, atom.path));
      bytes.text(content.of_class[net_.class_of[row]]);
    }
    for (const Connector& connector : system_.connectors) add(connector);
    content.of_compound.resize(system_.compounds.size());
    for (std::size_t row = system_.compounds.size(); row-- > 0;) {
      const Compound& compound = system_.compounds[CompoundId(row)];
      content.of_compound[row] = texts_[row].hash();
      if (!compound.parent.is_valid()) continue;
      Bytes& above = texts_[compound.parent.value];
      above.text(path_below(system_.compounds[compound.parent].path, compound.path));
      above.text(content.of_compound[row]);
    }
    return content;
  }

 private:
  void add(const Connector& connector) {
    const ConnectorType& type = system_.connector_types[connector.type];
    Bytes& bytes = texts_[connector.parent.value];
    const std::string& above = system_.compounds[connector.parent].path;
    bytes.text(path_below(above, connector.path));
    bytes.number((type.exports ? 1u : 0u) + (connector.bound ? 2u : 0u));
    for (const DefineNode& node : type.define) {
      bytes.number((node.is_leaf ? 1u : 0u) + (node.trigger ? 2u : 0u));
      if (node.is_leaf) add(connector.ports[node.param], connector.parent, above, bytes);
      else bytes.numbers(node.children);
    }
  }
  void add(const PortRef& ref, CompoundId parent, const std::string& above, Bytes& bytes) {
    bytes.number(static_cast<std::uint64_t>(ref.kind));
    switch (ref.kind) {
      case PortRef::Kind::Atom:
        bytes.number(std::uint64_t{ref.atom.value} - first_[parent.value]);
        bytes.number(ref.port);
        break;
      case PortRef::Kind::Connector: bytes.text(path_below(above, system_.connectors[ref.connector].path)); break;
      case PortRef::Kind::Choice:
        // No choice is among the ports of a choice.
        for (const PortRef& port : system_.choices[ref.choice].ports) add(port, parent, above, bytes);
        bytes.number(system_.choices[ref.choice].ports.size());
        break;
    }
  }

  const Net& net_;
  const System& system_;
  std::vector<Bytes> texts_;  // by compound
  std::vector<u32> first_;    // by compound: row of its first atom
};

}  // namespace

NetContent content_of(const Net& net) { return NetContentReader(net).read(); }

std::string path_below(const std::string& compound, const std::string& path) {
  return path.size() > compound.size() && path.starts_with(compound) && path[compound.size()] == '.'
             ? path.substr(compound.size() + 1)
             : path;
}

}  // namespace bip::verify
