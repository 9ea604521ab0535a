// See sized_compound.hpp. The items are read twice: first the components, which say what the arrays are, then the
// connectors. A loop over fixed bounds is unrolled, one from a constant to n - c stands for itself.
#include "compiler/verify/sizes/sized_compound.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"

namespace bip::verify {

namespace {

constexpr std::int64_t kLargestMargin = 4, kMostRounds = 64;

class SizeReader {
 public:
  SizeReader(const Model& model, const CompoundType& type, std::int64_t margin) : model_(model), type_(type) {
    out_.margin = margin;
    for (const ComponentFamily& family : type.components) {
      if (family.is_compound) {
        fail(fmt::format("`{}` is a compound, and only components that are atoms are followed", family.name));
        return;
      }
      out_.families.push_back(
          {family.name, family.atom, family.is_array ? ArrayKind::Fixed : ArrayKind::None, family.is_array ? 0 : 1});
    }
    covered_.resize(type.components.size());
    for (auto& zones : covered_) zones.assign(static_cast<std::size_t>(out_.least_size()), 0);
  }

  Result<SizedCompound> read() {
    std::vector<SizeValue> self = {SizeValue::linear(0, 1, 0)};
    if (reason_.empty()) items(type_.items, self, {0, 0, out_.least_size()}, ItemKind::Component);
    for (std::size_t f = 0; f < covered_.size() && reason_.empty(); ++f) {
      if (out_.families[f].kind != ArrayKind::Sized) continue;
      for (const int times : covered_[f]) {
        if (times != 1)
          fail(fmt::format("array `{}` does not have exactly {} elements", out_.families[f].name, size_name()));
      }
    }
    if (reason_.empty()) items(type_.items, self, {0, 0, out_.least_size()}, ItemKind::Connector);
    if (!reason_.empty()) return Failure{reason_};
    return std::move(out_);
  }

 private:
  [[nodiscard]] const std::string& size_name() const { return type_.params.front().name; }
  void fail(std::string reason) {
    if (reason_.empty()) reason_ = std::move(reason);
  }
  [[nodiscard]] std::string at(const CompoundItem& item) const {
    return fmt::format("line {}", model_.loc(item.range).line);
  }
  [[nodiscard]] SizeValue value(ExprId expr, const std::vector<SizeValue>& self, const SizeRange& range) const {
    return evaluate_for_sizes(model_.code, expr, self, range);
  }

  // `what`: the kind of items that are read. A loop whose variable stays symbolic has self.back() = i.
  void items(const std::vector<CompoundItem>& list, std::vector<SizeValue>& self, const SizeRange& range,
             ItemKind what) {
    for (const CompoundItem& item : list) {
      if (!reason_.empty()) return;
      if (item.kind == ItemKind::For) {
        loop(item, self, range, what);
      } else if (item.kind == what) {
        what == ItemKind::Component ? component(item, self, range) : connector(item, self, range);
      }
    }
  }

  void loop(const CompoundItem& item, std::vector<SizeValue>& self, const SizeRange& range, ItemKind what) {
    const SizeValue low = value(item.low, self, range), high = value(item.high, self, range);
    const bool is_linear = low.kind == SizeValue::Kind::Linear && high.kind == SizeValue::Kind::Linear;
    if (is_linear && low.of_position == high.of_position && low.of_size == high.of_size) {
      if (high.constant - low.constant > kMostRounds)
        return fail(fmt::format("the loop at {} has more than {} rounds", at(item), kMostRounds));
      for (std::int64_t k = low.constant; k < high.constant && reason_.empty(); ++k) {
        self.push_back(SizeValue::linear(low.of_position, low.of_size, k));
        items(item.items, self, range, what);
        self.pop_back();
      }
      return;
    }
    const bool is_nested = std::any_of(self.begin(), self.end(), [](const SizeValue& v) { return v.of_position != 0; });
    if (is_nested) return fail(fmt::format("the loop at {} is inside another one over all positions", at(item)));
    // Beyond the last position a round is another round's once more, which the word prover would not see.
    if (!low.is_constant() || !high.is_from_end() || low.constant < 0 || low.constant > out_.margin ||
        high.constant > 0 || -high.constant > out_.margin)
      return fail(fmt::format("the bounds of the loop at {} are not a constant and `{}` less a constant", at(item),
                              size_name()));
    self.push_back(SizeValue::linear(1, 0, 0));
    items(item.items, self, {low.constant, -high.constant, out_.least_size()}, what);
    self.pop_back();
  }

  void component(const CompoundItem& item, std::vector<SizeValue>& self, const SizeRange& range) {
    SizedFamily& family = out_.families[item.family];
    const bool is_in_loop = self.size() > 1;
    if (!item.index.is_valid()) {
      arguments(item, self, range);
      return;
    }
    const SizeValue index = value(item.index, self, range);
    if (!is_in_loop) {
      arguments(item, self, range);
      if (index.is_constant()) {
        family.count = index.constant;
      } else if (index.is_from_end() && index.constant == 0) {
        family.kind = ArrayKind::Sized;
        for (int& times : covered_[item.family]) ++times;
      } else {
        fail(fmt::format("array `{}` has neither a fixed size nor size `{}`", family.name, size_name()));
      }
      return;
    }
    if (index.is_constant()) {
      family.count = std::max(family.count, index.constant + 1);
      if (index.constant >= 0 && index.constant < out_.margin)
        ++covered_[item.family][static_cast<std::size_t>(index.constant)];
      else outside_.push_back(item.family);
      arguments(item, self, range);
      return;
    }
    family.kind = ArrayKind::Sized;
    if (index.is_from_end() && index.constant < 0 && -index.constant <= out_.margin) {
      ++covered_[item.family][covered_[item.family].size() - static_cast<std::size_t>(-index.constant)];
      arguments(item, self, range);
      return;
    }
    const std::int64_t reach = std::max(range.low, std::abs(range.high)) + std::abs(index.constant);
    if (index.kind != SizeValue::Kind::Linear || index.of_position != 1 || index.of_size != 0 || reach > out_.margin)
      return fail(fmt::format("the index of `{}` at {} is neither a position nor a constant", family.name, at(item)));
    // Each zone that the loop reaches, with arguments of its own.
    const std::int64_t size = out_.least_size();
    for (std::int64_t p = 0; p < size && reason_.empty(); ++p) {
      const std::int64_t i = p - index.constant;
      if (i < range.low || i >= size - range.high) continue;
      BIP_ASSERT(covered_[item.family].size() == static_cast<std::size_t>(size), "{} zones of {} positions",
                 covered_[item.family].size(), size);
      ++covered_[item.family][static_cast<std::size_t>(p)];
      std::vector<SizeValue> own = self;
      SizeRange zone{0, 0, size};
      if (p < out_.margin) {
        own.back() = SizeValue::linear(0, 0, i);
      } else if (p > out_.margin) {
        own.back() = SizeValue::linear(0, 1, i - size);
      } else {
        zone = {out_.margin - index.constant, out_.margin + index.constant, size};
      }
      arguments(item, own, zone);
    }
  }

  // Each has one value in the whole zone, at all sizes.
  void arguments(const CompoundItem& item, const std::vector<SizeValue>& self, const SizeRange& range) {
    for (const ExprId arg : item.args) {
      const Expr& e = model_.code.exprs[arg];
      if (e.op == Op::ConstFloat || e.op == Op::ConstString) continue;
      const SizeValue v = value(arg, self, range);
      if (v.kind != SizeValue::Kind::Truth && !v.is_constant())
        return fail(fmt::format("an argument of `{}` at {} depends on `{}` or on the position",
                                out_.families[item.family].name, at(item), size_name()));
    }
  }

  void connector(const CompoundItem& item, const std::vector<SizeValue>& self, const SizeRange& range) {
    const ConnectorFamily& family = type_.connectors[item.family];
    const ConnectorType& type = model_.connector_types[item.type];
    if (type.exports)
      return fail(
          fmt::format("connector `{}` exports a port, and connectors of connectors are not followed", family.name));
    // Its code is another one for each element.
    if (!item.values.empty())
      return fail(
          fmt::format("the code of connector `{}` at {} names `{}` or a position", family.name, at(item), size_name()));
    SizedConnector row{item.family, item.type, {}, false, range.low, range.high};
    for (const PortPath& path : item.ports) {
      std::optional<SizedPort> port = sized_port(item, path, self, range);
      if (!port) return;
      row.is_loop = row.is_loop || port->place == ElementPlace::AtLoop;
      row.ports.push_back(*port);
    }
    const bool is_round =
        !self.empty() && std::any_of(self.begin(), self.end(), [](const SizeValue& v) { return v.of_position != 0; });
    if (is_round && !row.is_loop)
      return fail(fmt::format("connector `{}` at {} joins the same elements in each round", family.name, at(item)));
    for (const SizedPort& port : row.ports) {
      if (row.is_loop && port.place != ElementPlace::AtLoop && port.place != ElementPlace::Single)
        return fail(fmt::format("connector `{}` at {} joins elements at the loop's position with others", family.name,
                                at(item)));
    }
    if (row.is_loop && !is_within_margin(row))
      return fail(fmt::format("connector `{}` at {} joins elements too far from each other", family.name, at(item)));
    out_.connectors.push_back(std::move(row));
  }

  // Then the zone of the first element that it joins says whether there is such a connector.
  [[nodiscard]] bool is_within_margin(const SizedConnector& row) const {
    std::int64_t least = out_.margin + 1, greatest = -out_.margin - 1;
    for (const SizedPort& port : row.ports) {
      if (port.place != ElementPlace::AtLoop) continue;
      least = std::min(least, port.offset);
      greatest = std::max(greatest, port.offset);
    }
    const std::int64_t reach = std::max(row.low, std::abs(row.high)) + std::max(std::abs(least), std::abs(greatest));
    return reach <= out_.margin && greatest - least <= out_.margin;
  }

  std::optional<SizedPort> sized_port(const CompoundItem& item, const PortPath& path,
                                      const std::vector<SizeValue>& self, const SizeRange& range) {
    const std::string& name = type_.connectors[item.family].name;
    const auto refused = [&](std::string_view what) {
      fail(fmt::format("connector `{}` at {} {}", name, at(item), what));
      return std::nullopt;
    };
    if (path.is_connector) return refused("binds another connector");
    BIP_ASSERT(path.element.family < out_.families.size(), "component {} of {}", path.element.family,
               out_.families.size());
    const SizedFamily& family = out_.families[path.element.family];
    if (path.port >= model_.atom_types[family.type].ports.size())
      return refused("binds a port that others are merged to");
    SizedPort port{path.element.family, path.port, ElementPlace::Single, 0};
    if (path.element.star) {
      if (family.kind != ArrayKind::Sized) return refused("binds all elements of an array of fixed size");
      port.place = ElementPlace::Every;
      return port;
    }
    if (!path.element.index.is_valid()) return port;
    const SizeValue index = value(path.element.index, self, range);
    const bool is_sized = family.kind == ArrayKind::Sized;
    port.offset = index.constant;
    if (index.is_constant()) {
      if (is_sized && (index.constant < 0 || index.constant >= out_.margin))
        return refused("binds an element too far from the first one");
      port.place = is_sized ? ElementPlace::FromStart : ElementPlace::Single;
      return port;
    }
    if (!is_sized)
      return refused(
          fmt::format("binds `{}`, of fixed size, at an index that depends on `{}`", family.name, size_name()));
    if (index.is_from_end()) {
      port.place = ElementPlace::FromEnd;
      port.offset = -1 - index.constant;
      if (port.offset < 0 || port.offset >= out_.margin) return refused("binds an element too far from the last one");
      return port;
    }
    const bool is_circular = index.kind == SizeValue::Kind::Circular;
    const bool is_line = index.kind == SizeValue::Kind::Linear && index.of_position == 1 && index.of_size == 0 &&
                         index.constant + range.low >= 0 && index.constant <= range.high;
    if (!is_circular && !is_line)
      return refused("has an index that is not a position, a constant, or one of them modulo the size");
    if (std::abs(index.constant) > out_.margin) return refused("binds an element too far from the loop's position");
    port.place = ElementPlace::AtLoop;
    return port;
  }

  const Model& model_;
  const CompoundType& type_;
  SizedCompound out_;
  std::vector<std::vector<int>> covered_;  // by family, by position at the least size: how many items declare it
  std::vector<std::uint32_t> outside_;     // families with an element at a constant beyond the margin
  std::string reason_;

 public:
  /// An element of a sized array lies at a constant beyond the margin: a greater one is needed.
  [[nodiscard]] bool is_beyond_margin() const {
    return std::any_of(outside_.begin(), outside_.end(),
                       [this](std::uint32_t f) { return out_.families[f].kind == ArrayKind::Sized; });
  }
};

}  // namespace

std::string element_path(const SizedFamily& family, std::int64_t element) {
  std::string path = "ROOT." + family.name;
  if (family.kind != ArrayKind::None) path += fmt::format("[{}]", element);
  return path;
}

Result<SizedCompound> describe_sizes(const Model& model, const CompoundType& type) {
  BIP_ASSERT(type.params.size() == 1, "{} parameters", type.params.size());
  std::string reason;
  for (std::int64_t margin = 1; margin <= kLargestMargin; ++margin) {
    SizeReader reader(model, type, margin);
    Result<SizedCompound> read = reader.read();
    if (!read) {
      reason = read.error();
      continue;
    }
    if (reader.is_beyond_margin()) {
      reason = "an element is declared too far from the first one";
      continue;
    }
    return read;
  }
  return Failure{reason};
}

}  // namespace bip::verify
