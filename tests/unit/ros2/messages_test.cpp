// Descriptions of messages, their hashes, and their values in CDR.
#include "compiler/ros2/messages.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "compiler/ros2/names.hpp"
#include "compiler/ros2/sha256.hpp"

namespace bip::ros2 {
namespace {

// As FIPS 180-4's examples have them.
TEST_CASE("SHA-256 of texts of one block and of two") {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1000, 'a')) == "41edece42d63e8d9bf515a9ba6932e1c20cbc9f5a5d134645adb5db1b9737ea3");
}

// Those that ROS 2 publishes beside its messages: ours are of the same text.
TEST_CASE("type hashes are those of ROS 2") {
  Messages messages;
  messages.add({"std_msgs/msg/String", {{.name = "data", .kind = Kind::String}}});
  messages.add({"std_msgs/msg/Empty", {}});
  const std::pair<const char*, const char*> known[] = {
      {"std_msgs/msg/String", "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"},
      {"std_msgs/msg/Empty", "RIHS01_20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312"},
      {"builtin_interfaces/msg/Time", "RIHS01_b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"},
      {"unique_identifier_msgs/msg/UUID", "RIHS01_1b8e8aca958cbea28fe6ef60bf6c19b683c97a9ef60bb34752067d0f2f7ab437"},
      {"service_msgs/msg/ServiceEventInfo", "RIHS01_41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45"},
      {"action_msgs/msg/GoalInfo", "RIHS01_6398fe763154554353930716b225947f93b672f0fb2e49fdd01bb7a7e37933e9"},
      {"action_msgs/msg/GoalStatus", "RIHS01_32f4cfd717735d17657e1178f24431c1ce996c878c515230f6c5b3476819dbb9"},
      {"action_msgs/msg/GoalStatusArray", "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"}};
  for (const auto& [name, hash] : known) CHECK(messages.hash_of(name) == hash);
}

TEST_CASE("names of types on DDS") {
  CHECK(dds_type("action_msgs/srv/CancelGoal_Request") == "action_msgs::srv::dds_::CancelGoal_Request_");
  Messages messages;
  const EndpointPlan plan =
      service_plan(messages, "NDD/GoTo/_action/cancel_goal", "action_msgs/srv/CancelGoal", Half::Reply, "1.2");
  CHECK(plan.topic == "rr/NDD/GoTo/_action/cancel_goalReply");
  CHECK(plan.type == "action_msgs::srv::dds_::CancelGoal_Response_");
  CHECK(plan.user_data.starts_with("serviceid=1.2;typehash=RIHS01_"));
}

// Worked out by hand: numbers are aligned to their size behind the four bytes of the head.
TEST_CASE("CDR of a message with gaps") {
  Messages messages;
  messages.add({"m/msg/Gaps",
                {{.name = "flag", .kind = Kind::Bool},
                 {.name = "real", .kind = Kind::Float64},
                 {.name = "text", .kind = Kind::String},
                 {.name = "small", .kind = Kind::Int16},
                 {.name = "list", .kind = Kind::UInt8, .shape = Shape::Sequence}}});
  const Json value{{"flag", true}, {"real", 1.0}, {"text", "ab"}, {"small", -2}, {"list", {7, 8}}};
  const Result<Bytes> bytes = to_cdr(messages, "m/msg/Gaps", value);
  REQUIRE(bytes);
  CHECK(*bytes == Bytes{0,    1, 0, 0, 1, 0,   0,   0, 0, 0,    0,    0, 0, 0, 0, 0, 0, 0, 0xf0,
                        0x3f, 3, 0, 0, 0, 'a', 'b', 0, 0, 0xfe, 0xff, 0, 0, 2, 0, 0, 0, 7, 8});
  CHECK(*from_cdr(messages, "m/msg/Gaps", *bytes) == value);
}

TEST_CASE("CDR of big endian machines is read") {
  Messages messages;
  messages.add({"m/msg/Two", {{.name = "a", .kind = Kind::Int32}, {.name = "b", .kind = Kind::UInt16}}});
  CHECK(*from_cdr(messages, "m/msg/Two", {0, 0, 0, 0, 0xff, 0xff, 0xff, 0xfe, 1, 2}) == Json{{"a", -2}, {"b", 258}});
}

TEST_CASE("a value that does not fit its type is refused, with its place") {
  Messages messages;
  messages.add({"m/msg/Part", {{.name = "x", .kind = Kind::Float64}}});
  messages.add(
      {"m/msg/All",
       {{.name = "byte", .kind = Kind::UInt8},
        {.name = "name", .kind = Kind::BoundedString, .text_bound = 3},
        {.name = "parts", .kind = Kind::Message, .message = "m/msg/Part", .shape = Shape::Bounded, .count = 2}}});
  const auto problem = [&](const Json& value) {
    const Result<Bytes> bytes = to_cdr(messages, "m/msg/All", value);
    return bytes ? std::string() : bytes.error();
  };
  CHECK(problem({{"byte", 255}, {"name", "abc"}}).empty());
  CHECK(problem({{"byte", 256}}) == "`byte` does not fit its type");
  CHECK(problem({{"byte", -1}}) == "`byte` does not fit its type");
  CHECK(problem({{"name", "abcd"}}) == "`name` has at most 3 bytes");
  CHECK(problem({{"parts", {1, 2, 3}}}) == "`parts` has at most 2 elements");
  CHECK(problem({{"parts", {{{"x", "far"}}}}}) == "`parts.x` is a number");
  // What is not there is zero, null is no number.
  CHECK((*from_cdr(messages, "m/msg/Part", *to_cdr(messages, "m/msg/Part", Json::object())))["x"] == 0);
  CHECK((*from_cdr(messages, "m/msg/Part", *to_cdr(messages, "m/msg/Part", {{"x", nullptr}})))["x"].is_null());
}

// ---- random messages: what is written is read again, and what is cut off or changed is refused or harmless

using Random = std::mt19937;
std::size_t below(Random& random, std::size_t count) { return random() % count; }

constexpr Kind kKinds[] = {Kind::Int8,   Kind::UInt8,  Kind::Int16,  Kind::UInt16,  Kind::Int32,
                           Kind::UInt32, Kind::Int64,  Kind::UInt64, Kind::Float32, Kind::Float64,
                           Kind::Bool,   Kind::String, Kind::Message};

std::string random_message(Random& random, Messages& messages, int depth) {
  static int count = 0;
  Message message{"r/msg/M" + std::to_string(++count), {}};
  const std::size_t fields = below(random, 6);
  for (std::size_t k = 0; k < fields; ++k) {
    Field field{.name = "f" + std::to_string(k)};
    field.kind = kKinds[below(random, std::size(kKinds) - (depth > 2 ? 1 : 0))];
    if (field.kind == Kind::Message) field.message = random_message(random, messages, depth + 1);
    constexpr Shape kShapes[] = {Shape::One, Shape::One, Shape::Array, Shape::Bounded, Shape::Sequence};
    field.shape = kShapes[below(random, std::size(kShapes))];
    if (field.shape == Shape::Array || field.shape == Shape::Bounded) field.count = 1 + below(random, 3);
    message.fields.push_back(std::move(field));
  }
  messages.add(message);
  return message.name;
}

Json random_value(Random& random, const Messages& messages, const std::string& name) {
  Json value = Json::object();
  for (const Field& f : messages.at(name).fields) {
    const auto one = [&]() -> Json {
      const std::uint64_t bits = std::uint64_t{random()} << 32 | random();
      switch (f.kind) {
        case Kind::Message: return random_value(random, messages, f.message);
        case Kind::Bool: return below(random, 2) == 1;
        case Kind::Int8: return static_cast<std::int8_t>(bits);
        case Kind::UInt8: return static_cast<std::uint8_t>(bits);
        case Kind::Int16: return static_cast<std::int16_t>(bits);
        case Kind::UInt16: return static_cast<std::uint16_t>(bits);
        case Kind::Int32: return static_cast<std::int32_t>(bits);
        case Kind::UInt32: return static_cast<std::uint32_t>(bits);
        case Kind::Int64: return static_cast<std::int64_t>(bits);
        case Kind::UInt64: return bits;
        case Kind::Float32: return static_cast<double>(static_cast<float>(below(random, 1000)) / 8);
        case Kind::Float64: return static_cast<double>(below(random, 100000)) / 7;
        case Kind::String:
        case Kind::BoundedString: return std::string(below(random, 9), static_cast<char>('a' + below(random, 26)));
      }
      return {};
    };
    if (f.shape == Shape::One) {
      value[f.name] = one();
      continue;
    }
    Json list = Json::array();
    for (std::size_t k = f.shape == Shape::Array ? f.count : below(random, f.shape == Shape::Bounded ? f.count + 1 : 5);
         k > 0; --k)
      list.push_back(one());
    value[f.name] = std::move(list);
  }
  return value;
}

TEST_CASE("random messages come back from CDR as they were") {
  Random random(7);
  for (int k = 0; k < 400; ++k) {
    Messages messages;
    const std::string name = random_message(random, messages, 0);
    const Json value = random_value(random, messages, name);
    const RequestHeader header{random(), static_cast<std::int64_t>(random())};
    Result<Bytes> written = to_cdr(messages, name, value, &header);
    REQUIRE(written);
    const Bytes& bytes = *written;
    RequestHeader read;
    const Result<Json> again = from_cdr(messages, name, bytes, &read);
    REQUIRE(again);
    CHECK(*again == value);
    CHECK((read.client == header.client && read.number == header.number));
    // Cut off or changed anywhere, it is read to the end of its bytes and no further (a sanitizer sees more).
    Bytes cut = bytes;
    cut.resize(below(random, bytes.size()));
    CHECK_FALSE(from_cdr(messages, name, cut, &read));
    Bytes changed = bytes;
    for (int times = 0; times < 20; ++times) {
      changed[below(random, changed.size())] = static_cast<std::uint8_t>(random());
      (void)from_cdr(messages, name, changed, &read);
    }
  }
}

}  // namespace
}  // namespace bip::ros2
