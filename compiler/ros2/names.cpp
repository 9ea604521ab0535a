// See names.hpp.
#include "compiler/ros2/names.hpp"

#include <fmt/format.h>

#include <random>

namespace bip::ros2 {

EndpointPlan topic_plan(const Messages& messages, const std::string& name, const std::string& type) {
  return {.name = name,
          .message = type,
          .topic = "rt/" + name,
          .type = dds_type(type),
          .user_data = fmt::format("typehash={};", messages.hash_of(type))};
}

EndpointPlan service_plan(const Messages& messages, const std::string& name, const std::string& type, Half half,
                          const std::string& id) {
  const bool is_request = half == Half::Request;
  const std::string message = type + (is_request ? "_Request" : "_Response");
  return {.name = name,
          .message = message,
          .topic = (is_request ? "rq/" : "rr/") + name + (is_request ? "Request" : "Reply"),
          .type = dds_type(message),
          .user_data = fmt::format("serviceid={};typehash={};", id, messages.hash_of(type))};
}

std::string make_service_id() {
  std::random_device random;
  std::string id;
  for (int k = 0; k < 16; ++k) id += fmt::format("{}{:x}", k == 0 ? "" : ".", random() & 0xff);
  return id;
}

}  // namespace bip::ros2
