// A fabric of ZeroMQ sockets: frames over TCP or Unix sockets, encrypted by CURVE.
//
// Each process but the last listens (ROUTER), and connects to each with a smaller number (DEALER). Only keys of the
// plan may connect, and a frame is from the peer whose key its connection has shown, whatever it says itself. ZeroMQ
// connects again by itself; what is lost then is the link's to repeat, so its own heartbeats are off: they would break
// connections that only stall. Queues have no limit: the link's window is one. To other hosts (tcp) nothing is queued
// without a connection, and one on which bytes stay unconfirmed for 5 s is made anew.
#pragma once
#include <memory>
#include <string>

#include "runtime/distributed/fabric.hpp"

namespace bip::zmq_fabric {

[[nodiscard]] rt::FabricKeys make_keys();
[[nodiscard]] Result<std::unique_ptr<rt::Fabric>> open(const rt::FabricPlan& plan);
[[nodiscard]] std::string version();

}  // namespace bip::zmq_fabric
