// The C++ objects behind variables of FFI types: one object a cell, made with the core and kept until it goes.
//
// A cell of an FFI type holds its object's address, always the same one; assignment copies between objects. A state
// that is kept (State) has copies of its own. A system without such variables pays one comparison a frame.
#pragma once
#include <vector>

#include "bip/image.hpp"

namespace bip::rt {

/// A copy of one object, with value semantics.
class FfiValue {
 public:
  FfiValue(const FfiType& type, const void* from) : type_(&type), object_(type.make()) { type.copy(object_, from); }
  FfiValue(const FfiValue& other) : FfiValue(*other.type_, other.object_) {}
  FfiValue(FfiValue&& other) noexcept : type_(other.type_), object_(other.object_) { other.object_ = nullptr; }
  FfiValue& operator=(FfiValue other) noexcept {
    void* const object = object_;
    object_ = other.object_;
    other.object_ = object;
    type_ = other.type_;
    return *this;
  }
  ~FfiValue() {
    if (object_ != nullptr) type_->destroy(object_);
  }
  [[nodiscard]] const void* object() const { return object_; }
  [[nodiscard]] void* object() { return object_; }
  /// Values that C++ cannot compare differ.
  friend bool operator==(const FfiValue& a, const FfiValue& b) {
    return a.type_ == b.type_ && a.type_->equal != nullptr && a.type_->equal(a.object_, b.object_);
  }

 private:
  const FfiType* type_;
  void* object_;
};

class FfiData {
 public:
  explicit FfiData(const Image& image);
  FfiData(const FfiData&) = delete;
  FfiData& operator=(const FfiData&) = delete;
  ~FfiData();

  [[nodiscard]] bool empty() const { return objects_.empty(); }
  /// Puts the objects of `vars` at their cells, from row `base` of `all` on, each with its default value.
  void reset(const Span<Var>& vars, Cell* all, std::uint32_t base);
  /// Copies of the atoms' objects, in the order of the cells; `data` (the cells' bits) forgets their addresses.
  void save(std::vector<std::uint64_t>& data, std::vector<FfiValue>& out) const;
  /// The atoms' objects from such copies, and their addresses into the cells.
  void load(Cell* all, const std::vector<FfiValue>& from);

 private:
  struct Object {
    std::uint32_t cell;
    const FfiType* type;
    void* address;
  };
  void add(const Image& image, const Span<Var>& vars, std::uint32_t base);

  std::vector<Object> objects_;        // by cell
  std::vector<std::uint32_t> row_of_;  // by cell; empty if there are no objects
  std::size_t atom_objects_ = 0;       // those of atoms come first
};

}  // namespace bip::rt
