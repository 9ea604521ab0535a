// Message types of ROS 2 as data: their description, its hash (REP-2011, REP-2016), and values of them in CDR.
//
// Values are JSON in this program, as `bipc serve` has them, and CDR (XCDR1, little endian) on the network. Both ways
// go over the description, so no code is generated for a type. What comes from the network is checked: nothing is read
// past its end, no length is believed that the bytes cannot hold.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compiler/base/result.hpp"

namespace bip::ros2 {

using Json = nlohmann::ordered_json;

/// The numbers are those of type_description_interfaces/msg/FieldType.
enum class Kind : std::uint8_t {
  Message = 1,
  Int8 = 2,
  UInt8 = 3,
  Int16 = 4,
  UInt16 = 5,
  Int32 = 6,
  UInt32 = 7,
  Int64 = 8,
  UInt64 = 9,
  Float32 = 10,
  Float64 = 11,
  Bool = 15,
  String = 17,
  BoundedString = 21
};
/// Added to the kind's number.
enum class Shape : std::uint8_t { One = 0, Array = 48, Bounded = 96, Sequence = 144 };

struct Field {
  std::string name;
  Kind kind = Kind::Int32;
  std::string message{};  // of Kind::Message: "pkg/msg/Name"
  Shape shape = Shape::One;
  std::size_t count = 0;             // of arrays and bounded sequences
  std::size_t text_bound = 0;        // of bounded strings
  std::string member{};              // its name in JSON; empty: the same
  bool is_optional = false;          // a sequence of at most one, in JSON null or the value
  bool is_character = false;         // a number here, in JSON a text of one character
  std::vector<std::string> words{};  // of an enumeration: word k is the number k, in JSON the word
  std::string initial{};             // as a .msg file has it; empty: none

  [[nodiscard]] const std::string& json_name() const { return member.empty() ? name : member; }
};
struct Message {
  std::string name;  // "pkg/action/Name_Goal"
  std::vector<Field> fields;
  std::string comment{};  // of a struct: its name in C
};

class Messages {
 public:
  /// Those that every action needs: builtin_interfaces, unique_identifier_msgs, action_msgs, service_msgs.
  Messages();
  /// A message that a field names is added before.
  void add(Message message);
  [[nodiscard]] bool has(const std::string& name) const { return rows_.contains(name); }
  [[nodiscard]] const Message& at(const std::string& name) const;
  /// "RIHS01_" and 64 digits.
  [[nodiscard]] std::string hash_of(const std::string& name) const;
  /// What the digits are the SHA-256 of: JSON of the type and of all those that it is made of.
  [[nodiscard]] std::string description_of(const std::string& name) const;

  /// Adds the request, the response and the event, and the service itself, which has a hash as well.
  void add_service(const std::string& name, std::vector<Field> request, std::vector<Field> response);
  /// Adds NAME_Goal, NAME_Result, NAME_Feedback and what actions make of them.
  void add_action(const std::string& name, std::vector<Field> goal, std::vector<Field> result,
                  std::vector<Field> feedback);

 private:
  std::map<std::string, Message> rows_;
};

/// "pkg/msg/Name" as DDS has it: "pkg::msg::dds_::Name_".
[[nodiscard]] std::string dds_type(const std::string& name);

using Bytes = std::vector<std::uint8_t>;

/// In front of each request and reply of a service, in what rmw_cyclonedds writes: the client, and the number of its
/// request.
struct RequestHeader {
  std::uint64_t client = 0;
  std::int64_t number = 0;
};

/// A serialized value, with the four bytes that say how.
[[nodiscard]] Result<Bytes> to_cdr(const Messages& messages, const std::string& name, const Json& value,
                                   const RequestHeader* header = nullptr);
[[nodiscard]] Result<Json> from_cdr(const Messages& messages, const std::string& name, const Bytes& bytes,
                                    RequestHeader* header = nullptr);

/// As ROS 1 serializes: members one behind the other, without a head and without gaps; a text without a zero at its
/// end.
[[nodiscard]] Result<Bytes> to_packed(const Messages& messages, const std::string& name, const Json& value);
[[nodiscard]] Result<Json> from_packed(const Messages& messages, const std::string& name, const Bytes& bytes);

}  // namespace bip::ros2
