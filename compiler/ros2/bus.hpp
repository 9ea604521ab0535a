// What the bridge needs of DDS: readers and writers of serialized values, and the peers at the other end. The one
// implementation is in compiler/dds, a plug-in; nothing here knows a vendor.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"
#include "compiler/ros2/messages.hpp"

namespace bip::ros2 {

/// Of a participant: another process, as a rule.
using PeerId = std::array<std::uint8_t, 16>;

/// The quality of service of ROS 2 for services, topics and the status of actions. All are reliable.
enum class Keep : std::uint8_t { Volatile, LastForLateJoiners };
struct EndpointPlan {
  std::string name;       // as clients see it: "NDD/Speed", "NDD/GoTo/_action/send_goal"
  std::string message;    // "dala_msgs/msg/NDDSpeed"
  std::string topic;      // "rt/NDD/Speed"
  std::string type;       // "dala_msgs::msg::dds_::NDDSpeed_"
  std::string user_data;  // "typehash=RIHS01_…;"
  std::uint32_t depth = 10;
  Keep keep = Keep::Volatile;
};
struct BusPlan {
  std::uint32_t domain = 0;
  std::string interface = "lo";  // empty: as Cyclone DDS is configured
};

struct Sample {
  Bytes bytes;
  std::optional<PeerId> peer;  // not known if it has gone by now
};

class Bus {
 public:
  Bus() = default;
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;
  virtual ~Bus() = default;

  /// Readers and writers are numbers from 0 on.
  [[nodiscard]] virtual Result<std::size_t> add_reader(const EndpointPlan& plan) = 0;
  [[nodiscard]] virtual Result<std::size_t> add_writer(const EndpointPlan& plan) = 0;
  /// A file descriptor that can be read when samples have come, or peers have come or gone; reset() before taking.
  [[nodiscard]] virtual int descriptor() const = 0;
  virtual void reset() = 0;
  [[nodiscard]] virtual std::vector<Sample> take(std::size_t reader) = 0;
  /// Returns an empty text, or what went wrong.
  [[nodiscard]] virtual std::string write(std::size_t writer, const Bytes& bytes) = 0;
  /// Has the peer a reader that this writer has found? A volatile writer's samples reach no other.
  [[nodiscard]] virtual bool has_reader(std::size_t writer, const PeerId& peer) = 0;
  [[nodiscard]] virtual std::size_t readers_of(std::size_t writer) = 0;
  /// Has the peer still a writer for this reader?
  [[nodiscard]] virtual bool has_writer(std::size_t reader, const PeerId& peer) = 0;
};

class BusFactory {
 public:
  BusFactory() = default;
  BusFactory(const BusFactory&) = delete;
  BusFactory& operator=(const BusFactory&) = delete;
  virtual ~BusFactory() = default;
  [[nodiscard]] virtual Result<std::unique_ptr<Bus>> open(const BusPlan& plan) const = 0;
};

}  // namespace bip::ros2
