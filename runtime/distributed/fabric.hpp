// What carries frames between the processes of a distributed run: bytes to a peer, which arrive whole or not at all,
// encrypted, from peers that have shown their keys. All else (order, repetition, what a frame is) is the link's.
//
// An implementation is a plug-in (compiler/zmq); this header needs the standard library only. One thread uses a fabric.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bip/result.hpp"

namespace bip::rt {

/// A pair of keys, as printable texts.
struct FabricKeys {
  std::string open, secret;
};

/// One process's view of all of them. Peers are numbered; the peer with the larger number connects.
struct FabricPlan {
  std::uint32_t self = 0;
  std::vector<std::string> addresses;  // by peer: where it listens; empty: nowhere
  std::vector<std::string> open_keys;  // by peer
  FabricKeys keys;                     // own
};

struct Arrival {
  std::uint32_t from = 0;  // the peer whose key the sender has shown
  std::string bytes;
};

struct FabricCounts {
  std::uint64_t refused = 0;  // connections whose key belongs to no peer
};

class Fabric {
 public:
  virtual ~Fabric() = default;
  /// May lose the bytes without a report.
  virtual void send(std::uint32_t peer, std::string_view bytes) = 0;
  /// Appends what came; of much a portion, and the rest with the next calls. Waits for it until `ms` have passed (-1:
  /// for ever), one of `files` can be read, or a signal. Returns whether a file can be read.
  virtual bool wait(int ms, const std::vector<int>& files, std::vector<Arrival>& arrivals) = 0;
  [[nodiscard]] virtual FabricCounts counts() = 0;
};

class FabricFactory {
 public:
  virtual ~FabricFactory() = default;
  [[nodiscard]] virtual FabricKeys make_keys() const = 0;
  /// Listens and connects as the plan says; the caller owns what is opened.
  [[nodiscard]] virtual Result<std::unique_ptr<Fabric>> open(const FabricPlan& plan) const = 0;
  [[nodiscard]] virtual std::string version() const = 0;
};

}  // namespace bip::rt
