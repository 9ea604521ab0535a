// Objects of FFI types: made with the core, put to their default, saved and loaded as deep copies.
#include <catch2/catch.hpp>

#include <limits>
#include <vector>

#include "bip/ffi_state.hpp"
#include "runtime/core/state/ffi_data.hpp"

using namespace bip::rt;

namespace {

struct Incomparable {
  int x = 7;
};

const FfiType kTypes[] = {ffi_type_of<std::vector<int>>("List"), ffi_type_of<Incomparable>("Odd")};
const Var kVars[] = {{"n", CellType::Int, false, false},
                     {"l", static_cast<CellType>(kFirstFfiType), false, false},
                     {"o", static_cast<CellType>(kFirstFfiType + 1), false, false}};
const char* const kTexts[] = {"", "one"};

Image image_of(AtomType& type, const Atom& atom, FfiContext& ffi) {
  type.variables = {kVars, 3};
  Image image;
  image.strings = {kTexts, 2};
  image.atom_types = {&type, 1};
  image.atoms = {&atom, 1};
  image.cell_count = 3;
  image.ffi_types = {kTypes, 2};
  image.ffi = &ffi;
  return image;
}

}  // namespace

TEST_CASE("objects are saved and loaded as copies") {
  FfiState ffi;
  AtomType type{};
  const Atom atom{};
  const Image image = image_of(type, atom, ffi);
  FfiData data(image);
  std::vector<Cell> all(3, Cell{0});
  data.reset(type.variables, all.data(), 0);
  REQUIRE(object_in<std::vector<int>>(all[1]).empty());
  CHECK(object_in<Incomparable>(all[2]).x == 7);
  object_in<std::vector<int>>(all[1]) = {1, 2};

  std::vector<std::uint64_t> bits{0, all[1].bits, all[2].bits};
  std::vector<FfiValue> saved;
  data.save(bits, saved);
  CHECK(bits == std::vector<std::uint64_t>{0, 0, 0});
  object_in<std::vector<int>>(all[1]).push_back(3);
  const std::uint64_t address = all[1].bits;
  data.load(all.data(), saved);
  CHECK(all[1].bits == address);
  CHECK(object_in<std::vector<int>>(all[1]) == std::vector<int>{1, 2});

  SECTION("copies compare by the type's ==, and differ without one") {
    const std::vector<FfiValue> copy = saved;
    CHECK(copy[0] == saved[0]);
    CHECK_FALSE(copy[1] == saved[1]);
  }
  SECTION("reset gives the default value again") {
    data.reset(type.variables, all.data(), 0);
    CHECK(object_in<std::vector<int>>(all[1]).empty());
  }
}

TEST_CASE("strings made at run time stand above those of the image, each once") {
  FfiState ffi;
  ffi.attach({kTexts, 2});
  ffi.attach({kTexts, 2});
  CHECK(ffi.intern("one") == 1);
  CHECK(ffi.intern(static_cast<const char*>(nullptr)) == 0);
  const std::int32_t row = ffi.intern(std::string("two"));
  CHECK(row == 2);
  CHECK(ffi.intern("two") == row);
  CHECK(std::string(ffi.text(row)) == "two");
}

TEST_CASE("after the last row the rows of freed strings come again, and no row of a kept one") {
  constexpr std::int32_t kLast = std::numeric_limits<std::int32_t>::max();
  FfiState ffi(kLast - 1);
  ffi.attach({kTexts, 2});
  CHECK(ffi.intern("one") == 1);
  CHECK(ffi.intern("a") == kLast - 1);
  CHECK(ffi.intern("b") == kLast);
  CHECK(ffi.intern("c") == 2);
  constexpr std::int32_t kPinned[] = {1, kLast - 1, kLast, 2, 77}, kLive[] = {4};
  ffi.pin({kPinned, 5});
  CHECK(ffi.intern("d") == 3);
  CHECK(ffi.intern("e") == 4);
  ffi.keep_only({kLive, 1});
  CHECK(std::string(ffi.text(kLast)) == "b");
  CHECK(std::string(ffi.text(2)) == "c");
  CHECK(std::string(ffi.text(3)).empty());
  CHECK(std::string(ffi.text(4)) == "e");
  CHECK(ffi.intern("e") == 4);
  CHECK(ffi.intern("a") == kLast - 1);
}
