// See sertype.hpp. Cyclone calls these functions from its own threads. A value is immutable once it is made, and
// counted by Cyclone; a type's only state is its name.
#include "compiler/dds/sertype.hpp"

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "bip/assert.hpp"

namespace bip::dds {
namespace {

// Cyclone reads in whole words.
constexpr std::size_t kWord = 4;

struct Value {
  ddsi_serdata base;  // first: Cyclone knows a value by it
  std::size_t size;   // what is in `bytes` without filling
  Payload bytes;
};
Value* value_of(ddsi_serdata* data) { return reinterpret_cast<Value*>(data); }
const Value* value_of(const ddsi_serdata* data) { return reinterpret_cast<const Value*>(data); }

Value* make_value(const ddsi_sertype* type, ddsi_serdata_kind kind, Payload bytes) {
  auto* const value = new Value{};
  ddsi_serdata_init(&value->base, type, kind);
  // All values of a type without a key are one instance.
  value->base.hash = type->serdata_basehash;
  value->size = bytes.size();
  value->bytes = std::move(bytes);
  value->bytes.resize((value->size + kWord - 1) / kWord * kWord);
  return value;
}

// ---- values

bool equal_keys(const ddsi_serdata*, const ddsi_serdata*) { return true; }
uint32_t size_of(const ddsi_serdata* data) { return static_cast<uint32_t>(value_of(data)->size); }
void free_value(ddsi_serdata* data) { delete value_of(data); }

// Fragments may overlap, and come in the order of their first bytes.
ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment, size_t size) {
  Payload bytes;
  bytes.reserve(size);
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    if (fragment->maxp1 <= bytes.size()) continue;
    if (fragment->min > bytes.size()) return nullptr;
    const unsigned char* const payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    bytes.insert(bytes.end(), payload + (bytes.size() - fragment->min), payload + (fragment->maxp1 - fragment->min));
  }
  if (bytes.size() < size) return nullptr;
  bytes.resize(size);
  return &make_value(type, kind, std::move(bytes))->base;
}
ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* pieces, size_t size) {
  Payload bytes;
  bytes.reserve(size);
  for (ddsrt_msg_iovlen_t k = 0; k < count; ++k) {
    const auto* const begin = static_cast<const std::uint8_t*>(pieces[k].iov_base);
    bytes.insert(bytes.end(), begin, begin + pieces[k].iov_len);
  }
  BIP_ASSERT(bytes.size() >= size, "pieces of {} bytes for a value of {}", bytes.size(), size);
  bytes.resize(size);
  return &make_value(type, kind, std::move(bytes))->base;
}
ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash*) {
  return &make_value(type, SDK_KEY, {})->base;
}
ddsi_serdata* from_sample(const ddsi_sertype* type, ddsi_serdata_kind kind, const void* sample) {
  return &make_value(type, kind, kind == SDK_DATA ? *static_cast<const Payload*>(sample) : Payload())->base;
}

void to_bytes(const ddsi_serdata* data, size_t at, size_t size, void* into) {
  BIP_ASSERT(at + size <= value_of(data)->bytes.size(), "bytes {} to {} of {}", at, at + size,
             value_of(data)->bytes.size());
  std::memcpy(into, value_of(data)->bytes.data() + at, size);
}
ddsi_serdata* to_bytes_shared(const ddsi_serdata* data, size_t at, size_t size, ddsrt_iovec_t* piece) {
  BIP_ASSERT(at + size <= value_of(data)->bytes.size(), "bytes {} to {} of {}", at, at + size,
             value_of(data)->bytes.size());
  piece->iov_base = const_cast<std::uint8_t*>(value_of(data)->bytes.data()) + at;
  piece->iov_len = size;
  return ddsi_serdata_ref(data);
}
void end_sharing(ddsi_serdata* data, const ddsrt_iovec_t*) { ddsi_serdata_unref(data); }

bool to_sample(const ddsi_serdata* data, void* sample, void**, void*) {
  const Value& value = *value_of(data);
  static_cast<Payload*>(sample)->assign(value.bytes.begin(),
                                        value.bytes.begin() + static_cast<std::ptrdiff_t>(value.size));
  return true;
}
ddsi_serdata* to_untyped(const ddsi_serdata* data) {
  Value* const value = make_value(data->type, SDK_KEY, {});
  value->base.type = nullptr;
  return &value->base;
}
bool untyped_to_sample(const ddsi_sertype*, const ddsi_serdata*, void* sample, void**, void*) {
  static_cast<Payload*>(sample)->clear();
  return true;
}
size_t print(const ddsi_sertype*, const ddsi_serdata* data, char* text, size_t size) {
  const int length = std::snprintf(text, size, "%zu bytes", value_of(data)->size);
  return std::min(size - 1, static_cast<size_t>(std::max(length, 0)));
}
void key_hash(const ddsi_serdata*, ddsi_keyhash* hash, bool) { std::memset(hash->value, 0, sizeof hash->value); }

const ddsi_serdata_ops& value_operations() {
  static const ddsi_serdata_ops operations = [] {
    ddsi_serdata_ops ops{};
    ops.eqkey = equal_keys;
    ops.get_size = size_of;
    ops.from_ser = from_fragments;
    ops.from_ser_iov = from_pieces;
    ops.from_keyhash = from_keyhash;
    ops.from_sample = from_sample;
    ops.to_ser = to_bytes;
    ops.to_ser_ref = to_bytes_shared;
    ops.to_ser_unref = end_sharing;
    ops.to_sample = to_sample;
    ops.to_untyped = to_untyped;
    ops.untyped_to_sample = untyped_to_sample;
    ops.free = free_value;
    ops.print = print;
    ops.get_keyhash = key_hash;
    return ops;
  }();
  return operations;
}

// ---- types

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete type;
}
bool equal_types(const ddsi_sertype*, const ddsi_sertype*) { return true; }
uint32_t hash_of_type(const ddsi_sertype*) { return 0; }
void clear_samples(const ddsi_sertype*, void* samples, size_t count) {
  for (size_t k = 0; k < count; ++k) static_cast<Payload*>(samples)[k].clear();
}
void resize_samples(void** pointers, const ddsi_sertype*, void* old, size_t old_count, size_t count) {
  auto* const samples = count == 0 ? nullptr : new Payload[count];
  auto* const before = static_cast<Payload*>(old);
  for (size_t k = 0; k < std::min(count, old_count); ++k) samples[k] = std::move(before[k]);
  delete[] before;
  for (size_t k = 0; k < count; ++k) pointers[k] = samples + k;
}
void free_samples(const ddsi_sertype*, void** pointers, size_t count, dds_free_op_t operation) {
  if (count == 0) return;
  if ((operation & DDS_FREE_ALL_BIT) != 0) delete[] static_cast<Payload*>(pointers[0]);
  else if ((operation & DDS_FREE_CONTENTS_BIT) != 0) {
    for (size_t k = 0; k < count; ++k) static_cast<Payload*>(pointers[k])->clear();
  }
}
size_t serialized_size(const ddsi_sertype*, const void* sample) { return static_cast<const Payload*>(sample)->size(); }
bool serialize_into(const ddsi_sertype*, const void* sample, void* buffer, size_t size) {
  const auto& bytes = *static_cast<const Payload*>(sample);
  if (size < bytes.size()) return false;
  std::copy(bytes.begin(), bytes.end(), static_cast<std::uint8_t*>(buffer));
  return true;
}

const ddsi_sertype_ops& type_operations() {
  static const ddsi_sertype_ops operations = [] {
    ddsi_sertype_ops ops{};
    ops.version = ddsi_sertype_v0;
    ops.free = free_type;
    ops.zero_samples = clear_samples;
    ops.realloc_samples = resize_samples;
    ops.free_samples = free_samples;
    ops.equal = equal_types;
    ops.hash = hash_of_type;
    ops.get_serialized_size = serialized_size;
    ops.serialize_into = serialize_into;
    return ops;
  }();
  return operations;
}

}  // namespace

ddsi_sertype* make_sertype(const std::string& name) {
  auto* const type = new ddsi_sertype{};
  ddsi_sertype_init(type, name.c_str(), &type_operations(), &value_operations(), true);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

}  // namespace bip::dds
