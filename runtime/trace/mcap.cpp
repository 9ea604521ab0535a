// See mcap.hpp. A record is an opcode, its length in 8 bytes, and fields in little endian; a text has its length before
// it.
#include "runtime/trace/mcap.hpp"

#include <algorithm>
#include <array>

#include "bip/assert.hpp"
#include "runtime/core/text.hpp"
#include "runtime/trace/trace.hpp"

namespace bip::rt {

namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunk = std::size_t{1} << 20;
constexpr u32 kMostChannels = 65535;

enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchemaRecord,
  kChannelRecord,
  kMessage,
  kChunkRecord,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd = 15
};

template <class Integer>
void add(std::string& out, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i) out += static_cast<char>(static_cast<u64>(value) >> (8 * i) & 0xff);
}
void add_text(std::string& out, std::string_view text) {
  add(out, static_cast<u32>(text.size()));
  out += text;
}
// Fields of a record, after its opcode and length.
template <class Fields>
void record(std::string& out, Opcode opcode, const Fields& fields) {
  out += static_cast<char>(opcode);
  const std::size_t at = out.size();
  add(out, u64{0});
  fields();
  std::string length;
  add(length, static_cast<u64>(out.size() - at - 8));
  BIP_ASSERT(length.size() == 8, "a length of {} bytes", length.size());
  out.replace(at, 8, length);
}
// A map or an array has its size in bytes before it.
template <class Items>
void counted_bytes(std::string& out, const Items& items) {
  const std::size_t at = out.size();
  add(out, u32{0});
  items();
  std::string length;
  add(length, static_cast<u32>(out.size() - at - 4));
  out.replace(at, 4, length);
}

// CRC-32 of ISO 3309, reflected polynomial 0xedb88320.
constexpr std::array<u32, 256> crc_table() {
  std::array<u32, 256> table{};
  for (u32 i = 0; i < 256; ++i) {
    u32 value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xedb88320u : 0);
    table[i] = value;
  }
  return table;
}
u32 crc_on(u32 crc, std::string_view bytes) {
  static constexpr std::array<u32, 256> kTable = crc_table();
  crc = ~crc;
  for (const char c : bytes) crc = kTable[(crc ^ static_cast<unsigned char>(c)) & 0xff] ^ (crc >> 8);
  return ~crc;
}

struct SchemaText {
  const char* name;
  const char* json;
};
constexpr SchemaText kSchemas[] = {
    {"bip.Step",
     R"({"type":"object","properties":{"step":{"type":"integer"},"interaction":{"type":"string"},"ports":{"type":"array","items":)"
     R"({"type":"object","properties":{"port":{"type":"string"},"values":{"type":"object"}}}}}})"},
    {"bip.Part",
     R"({"type":"object","properties":{"step":{"type":"integer"},"interaction":{"type":"string"},"port":{"type":"string"},)"
     R"("place":{"type":"string"},"values":{"type":"object"}}})"},
    {"bip.End",
     R"({"type":"object","properties":{"end":{"type":"string"},"steps":{"type":"integer"},"code":{"type":"string"},"message":{"type":"string"}}})"}};

}  // namespace

void McapWriter::put(std::string& out, std::string_view bytes) {
  crc_ = crc_on(crc_, bytes);
  written_ += bytes.size();
  out += bytes;
}

void McapWriter::append_schema(std::string& out, Schema schema) {
  const SchemaText& text = kSchemas[static_cast<std::size_t>(schema) - 1];
  BIP_ASSERT(static_cast<std::size_t>(schema) <= std::size(kSchemas), "schema {}", schema);
  record(out, kSchemaRecord, [&] {
    add(out, static_cast<std::uint16_t>(schema));
    add_text(out, text.name);
    add_text(out, "jsonschema");
    add_text(out, text.json);
  });
}

void McapWriter::append_channel(std::string& out, u32 row, const Channel& channel) {
  record(out, kChannelRecord, [&] {
    add(out, static_cast<std::uint16_t>(row + 1));
    add(out, static_cast<std::uint16_t>(channel.schema));
    add_text(out, channel.topic);
    add_text(out, "json");
    counted_bytes(out, [&] { out += channel.metadata; });
  });
}

u32 McapWriter::open_channel(std::string topic, Schema schema, std::string metadata) {
  channels_.push_back({std::move(topic), std::move(metadata), schema, 0, {}});
  const auto row = static_cast<u32>(channels_.size() - 1);
  BIP_ASSERT(row < kMostChannels, "channel {}", row);
  append_channel(open_, row, channels_.back());
  return row;
}

void McapWriter::begin(std::string& out, const TraceHead& trace) {
  const Image& image = *trace.image;
  std::string head(kMagic);
  record(head, kHeader, [&] {
    add_text(head, "");
    add_text(head, "bipc");
  });
  for (const Schema schema : {Schema::Step, Schema::Part, Schema::End}) append_schema(head, schema);
  put(out, head);
  std::string metadata, number;
  append_number(number, trace.seed);
  std::vector<std::pair<std::string_view, std::string_view>> entries = {
      {"model", image.name}, {"policy", trace.policy}, {"seed", number}};
  if (trace.draws_resumes) entries.emplace_back("resumes", "drawn");
  for (const auto& [key, value] : entries) {
    add_text(metadata, key);
    add_text(metadata, value);
  }
  open_channel("/steps", Schema::Step, std::move(metadata));
  channel_of_.assign(image.atoms.size, kNone);
}

void McapWriter::message(u32 channel, i64 instant, std::string_view json) {
  const auto time = static_cast<u64>(instant);
  // A model that was taken back to a snapshot is earlier again.
  first_ = messages_ == 0 ? time : std::min(first_, time);
  last_ = messages_ == 0 ? time : std::max(last_, time);
  ++messages_;
  BIP_ASSERT(channel < channels_.size() && channels_.size() <= kMostChannels, "channel {}", channel);
  Channel& row = channels_[channel];
  row.index.emplace_back(time, open_.size());
  record(open_, kMessage, [&] {
    add(open_, static_cast<std::uint16_t>(channel + 1));
    add(open_, static_cast<u32>(row.messages++));
    add(open_, time);
    add(open_, time);
    open_ += json;
  });
}

void McapWriter::step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
                      std::uint64_t) {
  const Candidate candidate = core.candidate(position);
  const Image& image = core.image();
  const i64 instant = instant_of_step(core, number);
  std::string head = R"({"step":)";
  append_number(head, number);
  head += R"(,"interaction":)";
  name_.clear();
  append_candidate(name_, core, candidate);
  append_quoted(head, name_.c_str());
  core.participants(candidate, participants_);
  ports_.clear();
  for (const Participant& participant : participants_) {
    const Atom& atom = image.atoms[participant.atom];
    const Port& port = image.atom_types[atom.type].ports[participant.port];
    name_ = atom.path();
    name_ += '.';
    name_ += port.name;
    ports_ += ports_.empty() ? R"({"port":)" : R"(,{"port":)";
    append_quoted(ports_, name_.c_str());
    ports_ += R"(,"values":)";
    append_json_values(ports_, core, participant.atom, participant.port);
    ports_ += '}';
  }
  json_ = head + R"(,"ports":[)" + ports_ + "]}";
  message(0, instant, json_);
  for (const Participant& participant : participants_) {
    u32& channel = channel_of_[participant.atom];
    if (channel == kNone) {
      // The last channel is kept free for the end.
      if (channels_.size() + 1 >= kMostChannels) continue;
      // ROOT.a.b is /a/b; a single atom /ROOT.
      name_ = relative(image.atoms[participant.atom].path().c_str());
      std::replace(name_.begin(), name_.end(), '.', '/');
      channel = open_channel('/' + name_, Schema::Part, {});
    }
    json_ = head + R"(,"port":)";
    append_quoted(json_, core.tables().atom_type(participant.atom).ports[participant.port].name);
    json_ += R"(,"place":)";
    append_quoted(json_, places_of(core, participant.atom).c_str());
    json_ += R"(,"values":)";
    append_json_values(json_, core, participant.atom, participant.port);
    json_ += '}';
    message(channel, instant, json_);
  }
  if (open_.size() >= kChunk) close_chunk(out);
}

void McapWriter::close_chunk(std::string& out) {
  if (open_.empty()) return;
  const std::string packed = compression_.compress ? compression_.compress(open_) : std::string();
  const std::string_view records = compression_.compress ? packed : open_;
  Chunk chunk{first_, last_, written_, 0, 0, open_.size(), records.size(), {}};
  std::string text;
  record(text, kChunkRecord, [&] {
    add(text, first_);
    add(text, last_);
    add(text, static_cast<u64>(open_.size()));
    add(text, crc_on(0, open_));
    add_text(text, compression_.name);
    add(text, static_cast<u64>(records.size()));
    text += records;
  });
  chunk.size = text.size();
  for (u32 row = 0; row < channels_.size(); ++row) {
    Channel& channel = channels_[row];
    if (channel.index.empty()) continue;
    chunk.index_at.emplace_back(row, written_ + text.size());
    record(text, kMessageIndex, [&] {
      add(text, static_cast<std::uint16_t>(row + 1));
      counted_bytes(text, [&] {
        for (const auto& [time, offset] : channel.index) {
          add(text, time);
          add(text, offset);
        }
      });
    });
    channel.index.clear();
  }
  chunk.index_size = text.size() - chunk.size;
  BIP_ASSERT(messages_ != 0 && first_ <= last_, "{} messages from {} to {}", messages_, first_, last_);
  put(out, text);
  chunks_.push_back(std::move(chunk));
  open_.clear();
  messages_ = 0;
}

void McapWriter::append_statistics(std::string& out) const {
  record(out, kStatistics, [&] {
    BIP_ASSERT(!chunks_.empty() && open_.empty(), "{} bytes are in no chunk", open_.size());
    u64 total = 0, first = chunks_.front().first, last = 0;
    for (const Channel& channel : channels_) total += channel.messages;
    add(out, total);
    add(out, static_cast<std::uint16_t>(std::size(kSchemas)));
    add(out, static_cast<u32>(channels_.size()));
    add(out, u32{0});
    add(out, u32{0});
    add(out, static_cast<u32>(chunks_.size()));
    for (const Chunk& chunk : chunks_) {
      first = std::min(first, chunk.first);
      last = std::max(last, chunk.last);
    }
    add(out, first);
    add(out, last);
    counted_bytes(out, [&] {
      for (u32 row = 0; row < channels_.size(); ++row) {
        add(out, static_cast<std::uint16_t>(row + 1));
        add(out, channels_[row].messages);
      }
    });
  });
}

// The records by which a reader knows what is in the file, in groups, and the footer that says where they are.
void McapWriter::append_summary(std::string& out) {
  struct Group {
    Opcode opcode;
    u64 at, size;
  };
  const u64 start = written_;
  std::string text;
  std::vector<Group> groups;
  const auto group = [&](Opcode opcode, const auto& records) {
    const std::size_t before = text.size();
    records();
    groups.push_back({opcode, start + before, text.size() - before});
  };
  group(kSchemaRecord, [&] {
    for (const Schema schema : {Schema::Step, Schema::Part, Schema::End}) append_schema(text, schema);
  });
  group(kChannelRecord, [&] {
    for (u32 row = 0; row < channels_.size(); ++row) append_channel(text, row, channels_[row]);
  });
  group(kStatistics, [&] { append_statistics(text); });
  group(kChunkIndex, [&] {
    for (const Chunk& chunk : chunks_) {
      record(text, kChunkIndex, [&] {
        add(text, chunk.first);
        add(text, chunk.last);
        add(text, chunk.at);
        add(text, chunk.size);
        counted_bytes(text, [&] {
          for (const auto& [row, at] : chunk.index_at) {
            add(text, static_cast<std::uint16_t>(row + 1));
            add(text, at);
          }
        });
        add(text, chunk.index_size);
        add_text(text, compression_.name);
        add(text, chunk.packed);
        add(text, chunk.bytes);
      });
    }
  });
  BIP_ASSERT(
      std::all_of(groups.begin(), groups.end(),
                  [&](const Group& part) { return part.at >= start && part.at + part.size <= start + text.size(); }),
      "a group beyond {} bytes", text.size());
  const u64 offsets = start + text.size();
  for (const Group& part : groups) {
    record(text, kSummaryOffset, [&] {
      text += static_cast<char>(part.opcode);
      add(text, part.at);
      add(text, part.size);
    });
  }
  // Its CRC is of the summary and of the footer itself, up to there.
  text += static_cast<char>(kFooter);
  add(text, u64{8 + 8 + 4});
  add(text, start);
  add(text, offsets);
  add(text, crc_on(0, text));
  out += text;
  out += kMagic;
}

void McapWriter::end(std::string& out, const Core& core, End end, std::uint64_t steps) {
  json_ = R"({"end":")";
  json_ += name_of(end);
  json_ += R"(","steps":)";
  append_number(json_, steps);
  if (end == End::Fault) append_json_fault(json_, core);
  json_ += '}';
  message(open_channel("/end", Schema::End, {}), instant_of_step(core, steps), json_);
  close_chunk(out);
  std::string data_end;
  const u32 crc = crc_;
  record(data_end, kDataEnd, [&] { add(data_end, crc); });
  put(out, data_end);
  append_summary(out);
}

}  // namespace bip::rt
