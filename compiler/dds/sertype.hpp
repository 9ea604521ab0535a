// A type of Cyclone DDS whose samples are bytes: CDR that compiler/ros2 writes and reads. Cyclone's own types are
// tables that idlc generates; the descriptions of modules are read at run time.
#pragma once
#include <string>

#include "compiler/ros2/messages.hpp"

struct ddsi_sertype;

namespace bip::dds {

/// A sample, as dds_write and dds_take have it: the encoding's four bytes, then the value.
using Payload = ros2::Bytes;

/// A new type without a key, which dds_create_topic_sertype takes over.
[[nodiscard]] ddsi_sertype* make_sertype(const std::string& name);

}  // namespace bip::dds
