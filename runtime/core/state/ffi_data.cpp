// See ffi_data.hpp.
#include "runtime/core/state/ffi_data.hpp"

#include "bip/assert.hpp"
#include "bip/ffi.hpp"

namespace bip::rt {

FfiData::FfiData(const Image& image) {
  if (image.ffi != nullptr) image.ffi->attach(image.strings);
  if (image.ffi != nullptr) image.ffi->name_sites(image.sites, image.files);
  if (image.ffi_types.size == 0) return;
  row_of_.assign(image.cell_count, kNone);
  for (const Atom& atom : image.atoms) add(image, image.atom_types[atom.type].variables, atom.first_cell);
  atom_objects_ = objects_.size();
  for (const Connector& connector : image.connectors)
    add(image, image.connector_types[connector.type].variables, connector.first_cell);
}

FfiData::~FfiData() {
  for (const Object& object : objects_) object.type->destroy(object.address);
}

void FfiData::add(const Image& image, const Span<Var>& vars, std::uint32_t base) {
  for (std::uint32_t i = 0; i < vars.size; ++i) {
    if (!is_ffi(vars[i].type)) continue;
    const FfiType& type = ffi_type(image, vars[i].type);
    BIP_ASSERT(base + i < row_of_.size() && row_of_[base + i] == kNone, "cell {} has two objects", base + i);
    row_of_[base + i] = static_cast<std::uint32_t>(objects_.size());
    objects_.push_back({base + i, &type, type.make()});
  }
}

void FfiData::reset(const Span<Var>& vars, Cell* all, std::uint32_t base) {
  for (std::uint32_t i = 0; i < vars.size; ++i) {
    if (!is_ffi(vars[i].type)) continue;
    const Object& object = objects_[row_of_[base + i]];
    BIP_ASSERT(object.cell == base + i, "the object of cell {} at cell {}", object.cell, base + i);
    object.type->reset(object.address);
    all[base + i] = object_cell(object.address);
  }
}

void FfiData::save(std::vector<std::uint64_t>& data, std::vector<FfiValue>& out) const {
  for (std::size_t k = 0; k < atom_objects_; ++k) {
    BIP_ASSERT(objects_[k].cell < data.size(), "cell {} of {}", objects_[k].cell, data.size());
    data[objects_[k].cell] = 0;
    out.emplace_back(*objects_[k].type, objects_[k].address);
  }
}

void FfiData::load(Cell* all, const std::vector<FfiValue>& from) {
  BIP_ASSERT(from.size() == atom_objects_, "{} objects of {}", from.size(), atom_objects_);
  for (std::size_t k = 0; k < atom_objects_; ++k) {
    objects_[k].type->copy(objects_[k].address, from[k].object());
    all[objects_[k].cell] = object_cell(objects_[k].address);
  }
}

}  // namespace bip::rt
