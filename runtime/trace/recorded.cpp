// Binary traces: see recorded.hpp.
#include "runtime/trace/recorded.hpp"

#include <cmath>
#include <cstring>

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

constexpr std::string_view kRecordMagic = "BIPTRC2\n", kRecordMagicOfVersion1 = "BIPTRC1\n";

void append_leb(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out += static_cast<char>(value | 0x80);
  out += static_cast<char>(value);
}

void append_text(std::string& out, std::string_view text) {
  append_leb(out, text.size());
  out += text;
}

void append_recorded_step(std::string& out, EnabledSet::Position position) {
  BIP_ASSERT(position.interaction.is_valid(), "a step of no interaction");
  append_leb(out, 1 + (u64{position.interaction.value} << 1 | (position.rank != 0 ? 1 : 0)));
  if (position.rank != 0) append_leb(out, position.rank);
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

void RecordedWriter::begin(std::string& out, const TraceHead& head) {
  out += kRecordMagic;
  BIP_ASSERT(head.image != nullptr, "a trace of no image");
  append_leb(out,
             (head.maximal_progress ? 1u : 0u) | (has_time(*head.image) ? 2u : 0u) | (head.draws_resumes ? 4u : 0u));
  append_text(out, head.policy);
  append_text(out, name_of(head.engine));
  append_leb(out, head.seed);
  append_text(out, head.image->name);
}

void RecordedWriter::step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t, std::uint64_t) {
  append_recorded_step(out, position);
  if (core.is_timed()) append_leb(out, static_cast<u64>(core.now()));
}

void RecordedWriter::steps(std::string& out, const std::vector<InteractionId>& interactions) {
  for (const InteractionId interaction : interactions) append_recorded_step(out, {interaction, 0});
}

void RecordedWriter::end(std::string& out, const Core& core, End end, std::uint64_t steps) {
  append_leb(out, 0);
  BIP_ASSERT(end <= End::Final, "the end {}", end);
  append_leb(out, static_cast<u64>(end));
  append_leb(out, steps);
  if (core.is_timed()) append_leb(out, static_cast<u64>(core.now()));
  // Of a partial state there is none.
  std::uint64_t digest = end == End::Fault || core.partial().is_on() ? 0 : digest_of(core);
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
      const Cell cell = core.cell(atom.variable(i));
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

bool RecordedReader::text(std::string& value) {
  std::uint64_t size = 0;
  if (!number(size) || size > bytes_.size() - at_) return false;
  BIP_ASSERT(at_ + size <= bytes_.size(), "a text of {} bytes at {} of {}", size, at_, bytes_.size());
  value = bytes_.substr(at_, size);
  at_ += size;
  return true;
}

bool RecordedReader::engine(Engine& value) {
  std::string name;
  if (!text(name)) return false;
  for (const Engine known :
       {Engine::Sequential, Engine::Threads, Engine::Batch, Engine::Simulated, Engine::Distributed}) {
    if (name != name_of(known)) continue;
    value = known;
    return true;
  }
  return false;
}

std::string RecordedReader::open(std::string_view bytes, RecordedBegin& begin) {
  if (bytes.starts_with(kRecordMagicOfVersion1))
    return "a binary trace of version 1, written by bipc 0.1; this bipc reads version 2: record the run again";
  bytes_ = bytes;
  at_ = kRecordMagic.size();
  std::uint64_t flags = 0;
  if (!bytes.starts_with(kRecordMagic) || !number(flags) || flags > 7 || !text(begin.policy) || !engine(begin.engine) ||
      !number(begin.seed) || !text(begin.name))
    return "it does not begin like a binary trace";
  begin.maximal_progress = (flags & 1) != 0;
  begin.has_time = has_time_ = (flags & 2) != 0;
  begin.draws_resumes = (flags & 4) != 0;
  return {};
}

bool RecordedReader::read_instant() {
  std::uint64_t value = 0;
  if (!has_time_) return true;
  if (!number(value) || value > static_cast<u64>(kForever)) return false;
  instant_ = static_cast<i64>(value);
  return true;
}

RecordedReader::Next RecordedReader::next(EnabledSet::Position& position, RecordedEnd& end) {
  BIP_ASSERT(at_ >= kRecordMagic.size() && at_ <= bytes_.size(), "byte {} of {}", at_, bytes_.size());
  std::uint64_t word = 0, rank = 0;
  if (!number(word)) return Next::Cut;
  if (word != 0) {
    --word;
    if (((word & 1) != 0 && !number(rank)) || !read_instant()) return Next::Cut;
    // What is no interaction of any core stays none.
    position.interaction = word >> 1 > kNone ? InteractionId() : InteractionId(word >> 1);
    position.rank = rank > kNone ? kNone : static_cast<u32>(rank);
    return Next::Step;
  }
  if (!number(word) || word > static_cast<u64>(End::Final) || !number(end.steps) || !read_instant() ||
      bytes_.size() - at_ < 8)
    return Next::Cut;
  end.how = static_cast<End>(word);
  end.digest = 0;
  for (unsigned i = 0; i < 8; ++i) end.digest |= u64{static_cast<unsigned char>(bytes_[at_ + i])} << (8 * i);
  at_ += 8;
  return Next::End;
}

}  // namespace bip::rt
