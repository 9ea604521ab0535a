// See codec.hpp. Offers of a row of transitions that their atom does not have are refused like any other odd bytes, so
// that what a core is given is always within its tables; whether it is true is the sender's.
#include "runtime/distributed/codec.hpp"

#include <algorithm>

#include "bip/assert.hpp"
#include "bip/ffi.hpp"
#include "runtime/core/time/clocks.hpp"

namespace bip::rt {

namespace {

enum class Tag : std::uint8_t { Offer, Begin, Stop, Control, Lock, Release, Wake };

}  // namespace

u64 ByteReader::number() {
  u64 value = 0;
  for (unsigned shift = 0; shift < 64 && !bytes_.empty(); shift += 7) {
    const auto byte = static_cast<unsigned char>(bytes_.front());
    bytes_.remove_prefix(1);
    // The tenth byte has one bit.
    if (shift == 63 && byte > 1) break;
    value |= u64{byte & 0x7fu} << shift;
    if (byte < 0x80) return value;
  }
  refuse();
  return 0;
}

u32 ByteReader::row(u64 below) {
  const u64 value = number();
  if (value < below) return static_cast<u32>(value);
  refuse();
  return 0;
}

std::string_view ByteReader::text() {
  const u64 size = number();
  if (size > bytes_.size()) {
    refuse();
    return {};
  }
  const std::string_view value = bytes_.substr(0, size);
  bytes_.remove_prefix(size);
  return value;
}

u64 ByteReader::count() {
  const u64 value = number();
  if (value <= bytes_.size()) return value;
  refuse();
  return 0;
}

Codec::Codec(const Tables& tables, const Distribution& distribution, u64 run)
    : tables_(tables), distribution_(distribution), run_(run), is_timed_(has_time(*tables.image)) {
  if (tables.image->ffi == nullptr) return;
  is_text_.assign(tables.atom_cells, 0);
  for (u32 atom = 0; atom < tables.image->atoms.size; ++atom) {
    const AtomType& type = tables.atom_type(atom);
    for (u32 i = 0; i < type.variables.size; ++i)
      is_text_[tables.atoms[atom].first_cell + i] = type.variables[i].type == CellType::String ? 1 : 0;
  }
}

void Codec::write_cell(ByteWriter& writer, VariableId cell, u64 bits) const {
  if (is_text_.empty() || is_text_[cell] == 0) writer.number(bits);
  else writer.text(string_of(*tables_.image, Cell{.bits = bits}));
}

u64 Codec::read_cell(ByteReader& reader, VariableId cell) const {
  if (is_text_.empty() || is_text_[cell] == 0) return reader.number();
  Cell value{.bits = 0};
  value.i = tables_.image->ffi->intern(reader.text());
  return value.bits;
}

void Codec::write(const Frame& frame, std::string& bytes) const {
  ByteWriter writer(bytes);
  writer.number(kProtocol);
  writer.number(run_);
  writer.number(frame.from);
  writer.number(frame.number);
  writer.number(frame.received);
  writer.number(frame.stamp);
  BIP_ASSERT(frame.messages.empty() || (frame.number != 0 && frame.messages.size() <= Link::kMostMessages),
             "frame {} has {} messages", frame.number, frame.messages.size());
  writer.number(frame.messages.size());
  for (const Message& message : frame.messages) {
    writer.number(message.index());
    std::visit([&](const auto& said) { write(writer, said); }, message);
  }
}

bool Codec::is_of_run(std::string_view bytes, u64 run) {
  ByteReader reader(bytes);
  return reader.number() == kProtocol && reader.number() == run && reader.is_sound();
}

bool Codec::read(std::string_view bytes, u32 from, u32 self, Frame& frame) const {
  if (bytes.size() > kMostBytes) return false;
  ByteReader reader(bytes);
  if (reader.number() != kProtocol || reader.number() != run_ || reader.number() != from) return false;
  frame = {from, self, 0, 0, 0, {}};
  frame.number = reader.number();
  frame.received = reader.number();
  frame.stamp = reader.number();
  const u64 count = reader.count();
  if (!reader.is_sound() || (count != 0 && frame.number == 0) || count > Link::kMostMessages) return false;
  // No sound peer sends clocks that are about to overflow.
  if (frame.stamp >> 56 != 0) return false;
  frame.messages.reserve(count);
  for (u64 i = 0; i < count && reader.is_sound(); ++i) {
    switch (static_cast<Tag>(reader.row(u64{static_cast<u64>(Tag::Wake)} + 1))) {
      case Tag::Offer: read(reader, from, std::get<Offer>(frame.messages.emplace_back(Offer{}))); break;
      case Tag::Begin: read(reader, self, std::get<Begin>(frame.messages.emplace_back(Begin{}))); break;
      case Tag::Stop: frame.messages.emplace_back(Stop{reader.number()}); break;
      case Tag::Control: read(reader, std::get<Control>(frame.messages.emplace_back(Control{}))); break;
      case Tag::Lock: read(reader, from, self, std::get<Lock>(frame.messages.emplace_back(Lock{}))); break;
      case Tag::Release: read(reader, self, std::get<Release>(frame.messages.emplace_back(Release{}))); break;
      case Tag::Wake: read(reader, self, std::get<Wake>(frame.messages.emplace_back(Wake{}))); break;
    }
  }
  return reader.is_sound() && reader.is_at_end();
}

void Codec::write(ByteWriter& writer, const Offer& offer) const {
  writer.number(offer.atom);
  writer.number(offer.n);
  writer.number(offer.offer.place == kNone ? 0 : u64{offer.offer.place} + 1);
  for (const u64 word : offer.offer.marks) writer.number(word);
  writer.number(offer.offer.transitions.size());
  for (const u32 row : offer.offer.transitions) writer.number(row);
  writer.number(offer.offer.step);
  writer.number(offer.offer.order);
  if (distribution_.sets.by_situation[offer.atom] != 0) writer.number(offer.set);
  write(writer, offer.moment);
  if (tables_.types[tables_.atoms[offer.atom].type].is_timed) {
    for (const PortTime& time : offer.offer.times) {
      writer.number(static_cast<u64>(time.interval.low));
      writer.number(static_cast<u64>(time.interval.high));
      writer.number(static_cast<u64>(time.urgency) << 2 | (time.interval.low_open ? 1u : 0u) |
                    (time.interval.high_open ? 2u : 0u));
    }
    writer.number(static_cast<u64>(offer.offer.change));
  }
  const Span<VariableId> cells = distribution_.cells[offer.atom];
  BIP_ASSERT(offer.cells.size() == cells.size, "an offer of {} of {} variables", offer.cells.size(), cells.size);
  for (u32 i = 0; i < cells.size; ++i) write_cell(writer, cells[i], offer.cells[i]);
}

void Codec::write(ByteWriter& writer, const Moment& moment) const {
  if (!is_timed_) return;
  writer.number(static_cast<u64>(moment.instant));
  writer.number(moment.step);
}

void Codec::read(ByteReader& reader, Moment& moment) const {
  if (!is_timed_) return;
  const u64 instant = reader.number();
  if (instant >= static_cast<u64>(kForever)) return reader.refuse();
  moment.instant = static_cast<i64>(instant);
  moment.step = reader.number();
}

// Of each transition when: around the moment of the offer, which holds until after it.
void Codec::read_times(ByteReader& reader, Offer& offer) const {
  for (std::size_t k = 0; k < offer.offer.transitions.size() && reader.is_sound(); ++k) {
    const u64 low = reader.number(), high = reader.number();
    const u32 how = reader.row((static_cast<u64>(Urgency::Eager) + 1) << 2);
    const u64 now = static_cast<u64>(offer.moment.instant);
    if (low > now || high < now || high > static_cast<u64>(kForever)) return reader.refuse();
    const Interval interval{static_cast<i64>(low), static_cast<i64>(high), (how & 1) != 0, (how & 2) != 0};
    offer.offer.times.push_back({interval, static_cast<Urgency>(how >> 2), kNone});
  }
  const u64 change = reader.number();
  if (change <= static_cast<u64>(offer.moment.instant) || change > static_cast<u64>(kForever)) return reader.refuse();
  offer.offer.change = static_cast<i64>(change);
}

void Codec::read_cells(ByteReader& reader, u32 atom, std::vector<u64>& cells) const {
  const Span<VariableId> rows = distribution_.cells[atom];
  cells.reserve(rows.size);
  for (u32 i = 0; i < rows.size && reader.is_sound(); ++i) cells.push_back(read_cell(reader, rows[i]));
}

// A transition of the type, with a port: code of another type would touch what is not the atom's.
bool Codec::has_port(const LinkedType& type, u32 row) const {
  return row - type.first_transition < type.transition_count && tables_.transitions[row].port != kNone;
}

void Codec::read(ByteReader& reader, u32 from, Offer& offer) const {
  read_offer(reader, offer);
  if (reader.is_sound() && distribution_.home(offer.atom) != from) reader.refuse();
}

void Codec::read_offer(ByteReader& reader, Offer& offer) const {
  offer.atom = reader.row(tables_.image->atoms.size);
  if (!reader.is_sound()) return;
  const LinkedType& type = tables_.types[tables_.atoms[offer.atom].type];
  const AtomType& atom_type = tables_.atom_type(offer.atom);
  offer.n = reader.number();
  const u32 place = reader.row(u64{atom_type.places.size} + 1);
  offer.offer.place = place == 0 ? kNone : place - 1;
  if (type.mark_words == 0 && place == 0) return reader.refuse();
  for (u32 i = 0; i < type.mark_words; ++i) offer.offer.marks.push_back(reader.number());
  const u64 count = reader.count();
  if (!reader.is_sound()) return;
  // All that leave the place of a simple type are enabled, and no others.
  if (type.simple && count != tables_.place_transitions[type.first_place + offer.offer.place].size)
    return reader.refuse();
  for (u64 i = 0; i < count && reader.is_sound(); ++i) {
    const u32 row = reader.row(tables_.transitions.size());
    if (!reader.is_sound() || !has_port(type, row)) return reader.refuse();
    // One of each port, in their order.
    if (i != 0 && tables_.transitions[row].port <= tables_.transitions[offer.offer.transitions.back()].port)
      return reader.refuse();
    // An automaton offers what leaves its place.
    if (type.mark_words == 0 && tables_.transitions[row].from != offer.offer.place) return reader.refuse();
    offer.offer.transitions.push_back(row);
  }
  offer.offer.step = reader.number();
  offer.offer.order = reader.row(kNone);
  if (distribution_.sets.by_situation[offer.atom] != 0) offer.set = reader.row(distribution_.sets.count);
  read(reader, offer.moment);
  if (type.is_timed) read_times(reader, offer);
  read_cells(reader, offer.atom, offer.cells);
}

void Codec::write(ByteWriter& writer, const Begin& begin) const {
  writer.number(begin.step);
  writer.number(begin.interaction.value);
  write(writer, begin.moment);
  writer.number(begin.parts.size());
  for (const Part& part : begin.parts) {
    writer.number(part.atom);
    writer.number(part.n);
    writer.number(part.transition);
    writer.number(part.order);
    const Span<VariableId> cells = distribution_.cells[part.atom];
    BIP_ASSERT(part.cells.size() == cells.size, "a part with {} of {} variables", part.cells.size(), cells.size);
    for (u32 i = 0; i < cells.size; ++i) write_cell(writer, cells[i], part.cells[i]);
  }
}

void Codec::read(ByteReader& reader, u32 self, Begin& begin) const {
  begin.step = reader.number();
  begin.interaction = InteractionId(reader.row(tables_.interactions.size()));
  read(reader, begin.moment);
  const u64 count = reader.count();
  for (u64 i = 0; i < count && reader.is_sound(); ++i) {
    Part part;
    part.atom = reader.row(tables_.image->atoms.size);
    if (!reader.is_sound()) return;
    if (distribution_.home(part.atom) != self) return reader.refuse();
    part.n = reader.number();
    part.transition = reader.row(tables_.transitions.size());
    part.order = reader.row(kNone);
    const LinkedType& type = tables_.types[tables_.atoms[part.atom].type];
    if (!reader.is_sound() || !has_port(type, part.transition)) return reader.refuse();
    // What becomes the atom's history is a connector of the port.
    const u32 port = tables_.instance(part.atom, tables_.transitions[part.transition].port);
    if (distribution_.sets.is_told_apart[port] != 0) {
      if (!tables_.is_of_connector(begin.interaction)) return reader.refuse();
      std::vector<u32> ports;
      ports_of_interaction(tables_, tables_.interactions[begin.interaction], ports);
      if (std::find(ports.begin(), ports.end(), port) == ports.end()) return reader.refuse();
    }
    read_cells(reader, part.atom, part.cells);
    begin.parts.push_back(std::move(part));
  }
}

void Codec::write(ByteWriter& writer, const Lock& lock) const {
  writer.number(lock.interaction.value);
  writer.number(lock.own);
  writer.number(lock.held.size());
  for (const Offer& offer : lock.held) write(writer, offer);
}

// An interaction with locks.
InteractionId Codec::read_split(ByteReader& reader) const {
  const InteractionId interaction(reader.row(tables_.interactions.size()));
  if (reader.is_sound() && distribution_.locks[interaction].size == 0) reader.refuse();
  return interaction;
}

// Each atom once, and only such as the interaction needs; what is not the coordinator's was locked before this node, in
// the order of nodes.
void Codec::read(ByteReader& reader, u32 from, u32 self, Lock& lock) const {
  lock.interaction = read_split(reader);
  const u64 own = reader.number(), count = reader.count();
  if (!reader.is_sound()) return;
  const Span<u32> locks = distribution_.locks[lock.interaction], needs = distribution_.needs[lock.interaction];
  if (own == 0 || own > count || count > needs.size) return reader.refuse();
  lock.own = static_cast<u32>(own);
  for (u64 i = 0; i < count && reader.is_sound(); ++i) {
    Offer& offer = lock.held.emplace_back();
    read_offer(reader, offer);
    if (!reader.is_sound()) return;
    const auto is_it = [&](const Offer& other) { return other.atom == offer.atom; };
    if (!std::binary_search(needs.begin(), needs.end(), offer.atom) ||
        std::any_of(lock.held.begin(), lock.held.end() - 1, is_it))
      return reader.refuse();
    const u32 home = distribution_.home(offer.atom);
    if (i >= own && (home > from || std::find(locks.begin(), locks.end(), offer.atom) == locks.end()))
      return reader.refuse();
  }
  const bool is_next =
      std::any_of(locks.begin(), locks.end(), [&](u32 atom) { return distribution_.home(atom) == self; });
  if (!is_next || from >= self || from < distribution_.coordinator_of[lock.interaction]) reader.refuse();
}

void Codec::write(ByteWriter& writer, const Release& release) {
  writer.number(release.interaction.value);
  writer.number((release.is_refused ? 1u : 0u) + (release.is_watched ? 2u : 0u));
  writer.number(release.atoms.size());
  for (const u32 atom : release.atoms) writer.number(atom);
}

void Codec::read(ByteReader& reader, u32 self, Release& release) const {
  release.interaction = read_split(reader);
  const u32 flags = reader.row(4);
  release.is_refused = (flags & 1) != 0;
  release.is_watched = (flags & 2) != 0;
  const u64 count = reader.count();
  if (!reader.is_sound()) return;
  const Span<u32> needs = distribution_.needs[release.interaction];
  const bool is_coordinator = distribution_.coordinator_of[release.interaction] == self;
  for (u64 i = 0; i < count && reader.is_sound(); ++i) {
    const u32 atom = reader.row(tables_.image->atoms.size);
    if (!reader.is_sound()) return;
    if (!std::binary_search(needs.begin(), needs.end(), atom) || (!is_coordinator && distribution_.home(atom) != self))
      return reader.refuse();
    release.atoms.push_back(atom);
  }
}

void Codec::write(ByteWriter& writer, const Wake& wake) { writer.number(wake.interaction.value); }

void Codec::read(ByteReader& reader, u32 self, Wake& wake) const {
  wake.interaction = read_split(reader);
  if (reader.is_sound() && distribution_.coordinator_of[wake.interaction] != self) reader.refuse();
}

void Codec::write(ByteWriter& writer, const Stop& stop) { writer.number(stop.step); }

void Codec::write(ByteWriter& writer, const Control& control) {
  writer.number(static_cast<u64>(control.kind));
  writer.number(control.numbers.size());
  for (const u64 number : control.numbers) writer.number(number);
  writer.number(control.texts.size());
  for (const std::string& text : control.texts) writer.text(text);
}

void Codec::read(ByteReader& reader, Control& control) {
  control.kind = static_cast<Control::Kind>(reader.row(static_cast<u64>(kLastControl) + 1));
  u64 count = reader.count();
  control.numbers.reserve(count);
  for (u64 i = 0; i < count && reader.is_sound(); ++i) control.numbers.push_back(reader.number());
  count = reader.count();
  for (u64 i = 0; i < count && reader.is_sound(); ++i) control.texts.emplace_back(reader.text());
}

}  // namespace bip::rt
