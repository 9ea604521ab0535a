// Frames as bytes, and back. Numbers are LEB128. Whatever bytes come, reading ends with a frame whose numbers are rows
// of this image and whose messages this peer may send, or is refused.
//
// Linear in the bytes. A frame has at most kMostBytes; counts are checked against the bytes that are left before
// anything is allocated for them.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "runtime/distributed/distribution.hpp"
#include "runtime/distributed/link.hpp"

namespace bip::rt {

/// Writes numbers and texts.
class ByteWriter {
 public:
  explicit ByteWriter(std::string& out) : out_(out) {}
  void number(u64 value) {
    for (; value >= 0x80; value >>= 7) out_ += static_cast<char>(value | 0x80);
    out_ += static_cast<char>(value);
  }
  void text(std::string_view value) {
    number(value.size());
    out_ += value;
  }

 private:
  std::string& out_;
};

/// Reads them; once something was not there, everything is 0 and empty.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  [[nodiscard]] u64 number();
  [[nodiscard]] u32 row(u64 below);
  [[nodiscard]] std::string_view text();
  /// Of things of at least one byte each.
  [[nodiscard]] u64 count();
  void refuse() {
    is_sound_ = false;
    bytes_ = {};
  }
  [[nodiscard]] bool is_sound() const { return is_sound_; }
  [[nodiscard]] bool is_at_end() const { return bytes_.empty(); }

 private:
  std::string_view bytes_;
  bool is_sound_ = true;
};

class Codec {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 26;

  /// `run` tells the frames of a run from those of others. All must outlive the codec.
  Codec(const Tables& tables, const Distribution& distribution, u64 run);

  void write(const Frame& frame, std::string& bytes) const;
  /// Does a frame of the run begin so?
  [[nodiscard]] static bool is_of_run(std::string_view bytes, u64 run);
  /// False: this is no frame of the run from that peer to `self`. A peer beyond the nodes is the launcher.
  [[nodiscard]] bool read(std::string_view bytes, u32 from, u32 self, Frame& frame) const;

  /// The value of a cell; text if it is a string of an image whose C++ makes strings, so that their rows differ between
  /// processes.
  void write_cell(ByteWriter& writer, VariableId cell, u64 bits) const;
  [[nodiscard]] u64 read_cell(ByteReader& reader, VariableId cell) const;

 private:
  void write(ByteWriter& writer, const Offer& offer) const;
  void write(ByteWriter& writer, const Begin& begin) const;
  static void write(ByteWriter& writer, const Stop& stop);
  static void write(ByteWriter& writer, const Control& control);
  void write(ByteWriter& writer, const Lock& lock) const;
  static void write(ByteWriter& writer, const Release& release);
  static void write(ByteWriter& writer, const Wake& wake);
  void read(ByteReader& reader, u32 from, Offer& offer) const;
  void write(ByteWriter& writer, const Moment& moment) const;
  void read(ByteReader& reader, Moment& moment) const;
  void read_times(ByteReader& reader, Offer& offer) const;
  void read_offer(ByteReader& reader, Offer& offer) const;
  void read(ByteReader& reader, u32 from, u32 self, Lock& lock) const;
  void read(ByteReader& reader, u32 self, Release& release) const;
  void read(ByteReader& reader, u32 self, Wake& wake) const;
  [[nodiscard]] InteractionId read_split(ByteReader& reader) const;
  void read(ByteReader& reader, u32 self, Begin& begin) const;
  static void read(ByteReader& reader, Control& control);
  [[nodiscard]] bool has_port(const LinkedType& type, u32 row) const;
  void read_cells(ByteReader& reader, u32 atom, std::vector<u64>& cells) const;

  const Tables& tables_;
  const Distribution& distribution_;
  u64 run_;
  bool is_timed_;
  IndexVector<VariableId, std::uint8_t> is_text_;  // of the atoms. Empty: none is
};

}  // namespace bip::rt
