// Binary traces: see recorded.hpp.
#include "runtime/trace/recorded.hpp"

#include <cmath>
#include <cstring>

#include "bip/ffi.hpp"

namespace bip::rt {

namespace {

constexpr std::string_view kRecordMagic = "BIPTRC1\n";

void append_leb(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out += static_cast<char>(value | 0x80);
  out += static_cast<char>(value);
}

// FNV-1a over 64-bit words, mixed at the end.
class Digest {
 public:
  void add(std::uint64_t word) {
    state_ = (state_ ^ word) * 0x100000001b3u;
    state_ ^= state_ >> 29;
  }
  void add(std::string_view text) {
    add(text.size());
    for (const char c : text) add(static_cast<unsigned char>(c));
  }
  [[nodiscard]] std::uint64_t value() const { return state_ == 0 ? 1 : state_; }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

}  // namespace

void append_recorded_begin(std::string& out, const RecordedBegin& begin) {
  out += kRecordMagic;
  append_leb(out, (begin.maximal_progress ? 1u : 0u) | static_cast<unsigned>(begin.policy) << 1 |
                      static_cast<unsigned>(begin.engine) << 3);
  append_leb(out, begin.seed);
  append_leb(out, begin.name.size());
  out += begin.name;
}

void append_recorded_step(std::string& out, EnabledSet::Position at) {
  append_leb(out, 1 + (u64{at.interaction} << 1 | (at.rank != 0 ? 1 : 0)));
  if (at.rank != 0) append_leb(out, at.rank);
}

void append_recorded_end(std::string& out, const Core& core, End how, std::uint64_t steps) {
  append_leb(out, 0);
  append_leb(out, static_cast<u64>(how));
  append_leb(out, steps);
  std::uint64_t digest = how == End::Fault ? 0 : digest_of(core);
  for (int i = 0; i < 8; ++i, digest >>= 8) out += static_cast<char>(digest & 0xff);
}

std::uint64_t digest_of(const Core& core) {
  const Image& image = core.image();
  const State state = core.snapshot();
  Digest digest;
  for (const u32 place : state.places) digest.add(place);
  for (const u64 word : state.marks) digest.add(word);
  for (const i64 word : state.time) digest.add(static_cast<u64>(word));
  for (const Atom& atom : image.atoms) {
    const AtomType& type = image.atom_types[atom.type];
    for (u32 i = 0; i < type.variables.size; ++i) {
      const Cell cell = core.cell(atom.first_cell + i);
      if (is_ffi(type.variables[i].type)) continue;
      if (type.variables[i].type == CellType::String) digest.add(string_of(image, cell));
      else if (type.variables[i].type == CellType::Float && std::isnan(cell.f)) digest.add("nan");
      else digest.add(cell.bits);
    }
  }
  return digest.value();
}

bool RecordedReader::number(std::uint64_t& value) {
  value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    if (at_ == bytes_.size()) return false;
    const auto byte = static_cast<unsigned char>(bytes_[at_++]);
    value |= u64{byte & 0x7fu} << shift;
    if (byte < 0x80) return true;
  }
  return false;
}

bool RecordedReader::open(std::string_view bytes, RecordedBegin& begin) {
  bytes_ = bytes;
  at_ = kRecordMagic.size();
  std::uint64_t flags = 0, size = 0;
  if (!bytes.starts_with(kRecordMagic) || !number(flags) || !number(begin.seed) || !number(size)) return false;
  if (flags >= 1u << 5 || (flags >> 1 & 3) > static_cast<unsigned>(Policy::Fair) ||
      flags >> 3 > static_cast<unsigned>(Engine::Batch))
    return false;
  begin.maximal_progress = (flags & 1) != 0;
  begin.policy = static_cast<Policy>(flags >> 1 & 3);
  begin.engine = static_cast<Engine>(flags >> 3);
  if (size > bytes_.size() - at_) return false;
  begin.name = std::string(bytes_.substr(at_, size));
  at_ += size;
  return true;
}

RecordedReader::Next RecordedReader::next(EnabledSet::Position& at, RecordedEnd& end) {
  std::uint64_t word = 0, rank = 0;
  if (!number(word)) return Next::Cut;
  if (word != 0) {
    --word;
    if ((word & 1) != 0 && !number(rank)) return Next::Cut;
    // What is no interaction of any core stays none.
    at.interaction = word >> 1 > kNone ? kNone : static_cast<u32>(word >> 1);
    at.rank = rank > kNone ? kNone : static_cast<u32>(rank);
    return Next::Step;
  }
  if (!number(word) || word > static_cast<u64>(End::Interrupted) || !number(end.steps) || bytes_.size() - at_ < 8)
    return Next::Cut;
  end.how = static_cast<End>(word);
  end.digest = 0;
  for (unsigned i = 0; i < 8; ++i) end.digest |= u64{static_cast<unsigned char>(bytes_[at_ + i])} << (8 * i);
  at_ += 8;
  return Next::End;
}

}  // namespace bip::rt
