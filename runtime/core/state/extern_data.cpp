// See extern_data.hpp.
#include "runtime/core/state/extern_data.hpp"

#include "bip/outside.hpp"

namespace bip::rt {

ExternData::ExternData(const Image& image) {
  if (image.outside != nullptr) image.outside->attach(image.strings);
  if (image.extern_types.size == 0) return;
  row_of_.assign(image.cell_count, kNone);
  for (const Atom& atom : image.atoms) add(image, image.atom_types[atom.type].variables, atom.first_cell);
  atom_objects_ = objects_.size();
  for (const Connector& connector : image.connectors)
    add(image, image.connector_types[connector.type].variables, connector.first_cell);
}

ExternData::~ExternData() {
  for (const Object& object : objects_) object.type->destroy(object.address);
}

void ExternData::add(const Image& image, const Span<Var>& vars, std::uint32_t base) {
  for (std::uint32_t i = 0; i < vars.size; ++i) {
    if (!is_extern(vars[i].type)) continue;
    const ExternType& type = extern_type(image, vars[i].type);
    row_of_[base + i] = static_cast<std::uint32_t>(objects_.size());
    objects_.push_back({base + i, &type, type.make()});
  }
}

void ExternData::reset(const Span<Var>& vars, Cell* all, std::uint32_t base) {
  for (std::uint32_t i = 0; i < vars.size; ++i) {
    if (!is_extern(vars[i].type)) continue;
    const Object& object = objects_[row_of_[base + i]];
    object.type->reset(object.address);
    all[base + i] = object_cell(object.address);
  }
}

void ExternData::save(std::vector<std::uint64_t>& data, std::vector<ExternValue>& out) const {
  for (std::size_t k = 0; k < atom_objects_; ++k) {
    data[objects_[k].cell] = 0;
    out.emplace_back(*objects_[k].type, objects_[k].address);
  }
}

void ExternData::load(Cell* all, const std::vector<ExternValue>& from) {
  for (std::size_t k = 0; k < atom_objects_; ++k) {
    objects_[k].type->copy(objects_[k].address, from[k].object());
    all[objects_[k].cell] = object_cell(objects_[k].address);
  }
}

}  // namespace bip::rt
