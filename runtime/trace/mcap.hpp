// Traces as MCAP files (mcap.dev, "MCAP format specification", version 0), which Foxglove and rosbag tools open:
// messages in JSON with their JSON Schemas, in chunks, with the indexes by which readers find an instant at once.
// Chunks are not compressed unless the writer is given a function that does it: the runtime needs no library for it.
//
// Channels: `/steps`, a message a step; `/a/b` for the component ROOT.a.b, a message for each step in which it takes
// part, with the place it leaves; `/end`. Instants are the model's (without time a millisecond a step), so the same run
// gives the same bytes. A file has at most 65,535 channels: components whose turn comes after that are in `/steps`
// alone. Memory: a chunk, and its row of the index.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bip/run.hpp"
#include "runtime/core/core.hpp"
#include "runtime/trace/trace_formats.hpp"

namespace bip::rt {

class McapWriter final : public TraceSink {
 public:
  /// How chunks are compressed: a name of the format's list ("zstd", "lz4") and the function.
  struct Compression {
    std::string name;
    std::function<std::string(std::string_view)> compress;
  };
  McapWriter() = default;
  explicit McapWriter(Compression compression) : compression_(std::move(compression)) {}
  /// What these append is the file, in this order; each may append nothing and keep it for later.
  void begin(std::string& out, const TraceHead& head) override;
  void step(std::string& out, Core& core, EnabledSet::Position position, std::uint64_t number,
            std::uint64_t k) override;
  void end(std::string& out, const Core& core, End end, std::uint64_t steps) override;

 private:
  enum class Schema : std::uint16_t { Step = 1, Part, End };
  struct Channel {
    std::string topic, metadata;  // metadata as it is written
    Schema schema;
    u64 messages = 0;
    std::vector<std::pair<u64, u64>> index;  // of the open chunk: instant, offset
  };
  struct Chunk {                                                                       // one that was written
    u64 first = 0, last = 0, at = 0, size = 0, index_size = 0, bytes = 0, packed = 0;  // packed: as they are written
    std::vector<std::pair<u32, u64>> index_at;  // by channel with messages in it: where its index is
  };
  u32 open_channel(std::string topic, Schema schema, std::string metadata);
  void message(u32 channel, i64 instant, std::string_view json);
  void close_chunk(std::string& out);
  void append_summary(std::string& out);
  void append_statistics(std::string& out) const;
  void put(std::string& out, std::string_view bytes);
  static void append_schema(std::string& out, Schema schema);
  static void append_channel(std::string& out, u32 row, const Channel& channel);

  Compression compression_;        // without a function: none
  u64 written_ = 0;                // bytes of the file so far
  u32 crc_ = 0;                    // of them
  std::vector<Channel> channels_;  // a channel's id is its row + 1
  std::vector<u32> channel_of_;    // by atom; kNone: none yet
  std::vector<Chunk> chunks_;
  std::string open_;                         // records of the chunk that is not written yet
  u64 first_ = 0, last_ = 0, messages_ = 0;  // of the open chunk
  std::string json_, name_, ports_;          // scratch
  std::vector<Participant> participants_;
};

}  // namespace bip::rt
