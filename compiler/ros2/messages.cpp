// See messages.hpp.
#include "compiler/ros2/messages.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <set>

#include "bip/assert.hpp"
#include "compiler/ros2/sha256.hpp"

namespace bip::ros2 {
namespace {

// CDR knows no struct without members: rosidl gives it this one.
const std::vector<Field> kNothing{{.name = "structure_needs_at_least_one_member", .kind = Kind::UInt8}};
const std::vector<Field>& fields_of(const Message& message) {
  return message.fields.empty() ? kNothing : message.fields;
}

Json description_row(const Message& message) {
  Json fields = Json::array();
  for (const Field& f : fields_of(message)) {
    fields.push_back({{"name", f.name},
                      {"type",
                       {{"type_id", static_cast<int>(f.kind) + static_cast<int>(f.shape)},
                        {"capacity", f.count},
                        {"string_capacity", f.text_bound},
                        {"nested_type_name", f.message}}}});
  }
  return {{"type_name", message.name}, {"fields", std::move(fields)}};
}

// As Python's json.dumps writes it with its default separators.
void write_spaced(const Json& json, std::string& out) {
  if (!json.is_structured()) {
    out += json.dump();
    return;
  }
  const bool is_object = json.is_object();
  out += is_object ? '{' : '[';
  bool is_first = true;
  for (const auto& item : json.items()) {
    if (!is_first) out += ", ";
    is_first = false;
    if (is_object) out += Json(item.key()).dump() + ": ";
    write_spaced(item.value(), out);
  }
  out += is_object ? '}' : ']';
}

std::size_t size_of(Kind kind) {
  switch (kind) {
    case Kind::Int8:
    case Kind::UInt8:
    case Kind::Bool: return 1;
    case Kind::Int16:
    case Kind::UInt16: return 2;
    case Kind::Int32:
    case Kind::UInt32:
    case Kind::Float32:
    case Kind::String:
    case Kind::BoundedString: return 4;
    case Kind::Int64:
    case Kind::UInt64:
    case Kind::Float64: return 8;
    case Kind::Message: break;
  }
  return 1;
}

enum class Encoding : std::uint8_t { Cdr, Packed };
const std::vector<Field>& fields_of(const Message& message, Encoding encoding) {
  return encoding == Encoding::Cdr ? fields_of(message) : message.fields;
}

constexpr std::size_t kHead = 4;
constexpr std::uint8_t kLittleEndian = 1;
// Types do not contain themselves, so this is deeper than any.
constexpr int kMostNested = 64;

// ---- writing

class MessageEncoder {
 public:
  MessageEncoder(const Messages& messages, Encoding encoding) : messages_(messages), encoding_(encoding) {
    if (encoding == Encoding::Cdr) out_ = {0, kLittleEndian, 0, 0};
  }

  void number(std::uint64_t value, std::size_t size) {
    BIP_ASSERT(std::has_single_bit(size) && size <= 8, "a number of {} bytes", size);
    while (encoding_ == Encoding::Cdr && (out_.size() - kHead) % size != 0) out_.push_back(0);
    BIP_ASSERT(size == 8 || value >> (8 * size) == 0 || ~value >> (8 * size - 1) == 0, "{} does not fit {} bytes",
               value, size);
    for (std::size_t k = 0; k < size; ++k) out_.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
  }
  void message(const std::string& name, const Json& value, const std::string& where) {
    if (!value.is_object()) return fail(where, "is an object");
    for (const Field& f : fields_of(messages_.at(name), encoding_)) {
      const auto found = value.find(f.json_name());
      field(f, found == value.end() ? absent(f) : *found, where.empty() ? f.name : where + "." + f.name);
    }
  }
  Result<Bytes> result() {
    if (!wrong_.empty()) return Failure{wrong_};
    return std::move(out_);
  }

 private:
  void fail(const std::string& where, const std::string& what) {
    if (wrong_.empty()) wrong_ = "`" + where + "` " + what;
  }
  // What is not there is zero or empty; of a real number null would be NaN.
  static Json absent(const Field& f) {
    const bool is_real = f.kind == Kind::Float32 || f.kind == Kind::Float64;
    return is_real && f.shape == Shape::One ? Json(0.0) : Json();
  }
  void field(const Field& f, const Json& value, const std::string& where) {
    if (f.is_optional) {
      number(value.is_null() ? 0 : 1, 4);
      if (!value.is_null()) element(f, value, where);
      return;
    }
    if (f.shape == Shape::One) return element(f, value, where);
    if (!value.is_array() && !value.is_null()) return fail(where, "is an array");
    const std::size_t length = value.is_null() ? 0 : value.size();
    if (f.shape == Shape::Array) {
      if (length > f.count) return fail(where, "has " + std::to_string(f.count) + " elements");
      const bool is_real = f.kind == Kind::Float32 || f.kind == Kind::Float64;
      const Json zero = is_real ? Json(0.0) : Json();
      for (std::size_t k = 0; k < f.count; ++k) element(f, k < length ? value[k] : zero, where);
      return;
    }
    if (f.shape == Shape::Bounded && length > f.count)
      return fail(where, "has at most " + std::to_string(f.count) + " elements");
    number(length, 4);
    for (std::size_t k = 0; k < length; ++k) element(f, value[k], where);
  }
  void element(const Field& f, const Json& value, const std::string& where) {
    switch (f.kind) {
      case Kind::Message: return message(f.message, value.is_null() ? Json::object() : value, where);
      case Kind::String:
      case Kind::BoundedString: {
        if (!value.is_string() && !value.is_null()) return fail(where, "is a text");
        const std::string text = value.is_null() ? "" : value.get<std::string>();
        if (f.text_bound != 0 && text.size() > f.text_bound)
          return fail(where, "has at most " + std::to_string(f.text_bound) + " bytes");
        const bool has_end = encoding_ == Encoding::Cdr;
        number(text.size() + (has_end ? 1 : 0), 4);
        out_.insert(out_.end(), text.begin(), text.end());
        if (has_end) out_.push_back(0);
        return;
      }
      case Kind::Bool:
        if (!value.is_boolean() && !value.is_null()) return fail(where, "is true or false");
        return number(value.is_boolean() && value.get<bool>() ? 1 : 0, 1);
      case Kind::Float32:
      case Kind::Float64: {
        // JSON has no NaN: `bipc serve` writes null.
        if (!value.is_number() && !value.is_null()) return fail(where, "is a number");
        const double real = value.is_null() ? std::nan("") : value.get<double>();
        if (f.kind == Kind::Float64) return number(std::bit_cast<std::uint64_t>(real), 8);
        return number(std::bit_cast<std::uint32_t>(static_cast<float>(real)), 4);
      }
      case Kind::Int8:
      case Kind::UInt8:
      case Kind::Int16:
      case Kind::UInt16:
      case Kind::Int32:
      case Kind::UInt32:
      case Kind::Int64:
      case Kind::UInt64: return whole(f, value, where);
    }
  }
  void whole(const Field& f, const Json& value, const std::string& where) {
    const std::size_t size = size_of(f.kind);
    if (value.is_null()) return number(0, size);
    if (f.is_character && value.is_string()) {
      const std::string text = value.get<std::string>();
      return number(text.empty() ? 0 : static_cast<std::uint8_t>(text[0]), size);
    }
    if (value.is_string()) {
      for (std::size_t k = 0; k < f.words.size(); ++k) {
        if (value == f.words[k]) return number(k, size);
      }
    }
    if (!value.is_number_integer()) return fail(where, "is a whole number");
    const bool is_signed =
        f.kind == Kind::Int8 || f.kind == Kind::Int16 || f.kind == Kind::Int32 || f.kind == Kind::Int64;
    const int unused_bits = 64 - static_cast<int>(8 * size);
    const std::uint64_t most = is_signed ? std::uint64_t{std::numeric_limits<std::int64_t>::max()} >> unused_bits
                                         : std::numeric_limits<std::uint64_t>::max() >> unused_bits;
    const bool fits =
        value.is_number_unsigned()
            ? value.get<std::uint64_t>() <= most
            : value.get<std::int64_t>() >= (is_signed ? -static_cast<std::int64_t>(most) - 1 : 0) &&
                  (value.get<std::int64_t>() < 0 || static_cast<std::uint64_t>(value.get<std::int64_t>()) <= most);
    if (!fits) return fail(where, "does not fit its type");
    number(
        value.is_number_unsigned() ? value.get<std::uint64_t>() : static_cast<std::uint64_t>(value.get<std::int64_t>()),
        size);
  }

  const Messages& messages_;
  Encoding encoding_;
  Bytes out_;
  std::string wrong_;
};

// ---- reading

class MessageDecoder {
 public:
  MessageDecoder(const Messages& messages, const Bytes& bytes, Encoding encoding)
      : messages_(messages), bytes_(bytes), encoding_(encoding) {
    if (encoding == Encoding::Packed) return;
    at_ = kHead;
    if (bytes.size() < kHead || bytes[0] != 0 || bytes[1] > kLittleEndian) fail("the encoding is not plain CDR");
    else is_big_ = bytes[1] == 0;
  }

  std::uint64_t number(std::size_t size) {
    BIP_ASSERT(std::has_single_bit(size) && size <= 8, "a number of {} bytes", size);
    while (encoding_ == Encoding::Cdr && (at_ - kHead) % size != 0) ++at_;
    if (at_ > bytes_.size() || bytes_.size() - at_ < size) fail("there are too few bytes");
    if (!wrong_.empty()) return 0;
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < size; ++k)
      value |= std::uint64_t{bytes_[at_ + (is_big_ ? size - 1 - k : k)]} << (8 * k);
    at_ += size;
    return value;
  }
  Json message(const std::string& name, int depth) {
    Json value = Json::object();
    if (depth > kMostNested) fail("it is too deep");
    for (const Field& f : fields_of(messages_.at(name), encoding_)) {
      if (!wrong_.empty()) break;
      Json member = field(f, depth);
      if (!messages_.at(name).fields.empty()) value[f.json_name()] = std::move(member);
    }
    return value;
  }
  [[nodiscard]] const std::string& wrong() const { return wrong_; }

 private:
  void fail(const char* what) {
    if (wrong_.empty()) wrong_ = what;
  }
  Json field(const Field& f, int depth) {
    if (f.shape == Shape::One) return element(f, depth);
    std::size_t length = f.count;
    if (f.shape != Shape::Array) length = number(4);
    if (f.shape == Shape::Bounded && length > f.count) fail("a sequence is longer than its bound");
    // An element has a byte at least.
    if (at_ > bytes_.size() || length > bytes_.size() - at_) fail("a sequence is longer than the message");
    Json list = Json::array();
    for (std::size_t k = 0; k < length && wrong_.empty(); ++k) list.push_back(element(f, depth));
    if (!f.is_optional) return list;
    return list.empty() ? Json() : list[0];
  }
  Json element(const Field& f, int depth) {
    switch (f.kind) {
      case Kind::Message: return message(f.message, depth + 1);
      case Kind::Bool: return number(1) != 0;
      case Kind::Float32: return real(std::bit_cast<float>(static_cast<std::uint32_t>(number(4))));
      case Kind::Float64: return real(std::bit_cast<double>(number(8)));
      case Kind::Int8: return static_cast<std::int8_t>(number(1));
      case Kind::Int16: return static_cast<std::int16_t>(number(2));
      case Kind::Int32: return word(f, static_cast<std::int32_t>(number(4)));
      case Kind::Int64: return static_cast<std::int64_t>(number(8));
      case Kind::UInt8: {
        const auto value = static_cast<std::uint8_t>(number(1));
        if (f.is_character) return value == 0 ? std::string() : std::string(1, static_cast<char>(value));
        return value;
      }
      case Kind::UInt16: return static_cast<std::uint16_t>(number(2));
      case Kind::UInt32: return static_cast<std::uint32_t>(number(4));
      case Kind::UInt64: return number(8);
      case Kind::String:
      case Kind::BoundedString: return text(f);
    }
    return {};
  }
  static Json real(double value) { return std::isfinite(value) ? Json(value) : Json(); }
  static Json word(const Field& f, std::int32_t value) {
    if (value >= 0 && static_cast<std::size_t>(value) < f.words.size()) return f.words[static_cast<std::size_t>(value)];
    return value;
  }
  Json text(const Field& f) {
    std::size_t length = number(4);
    if (at_ > bytes_.size() || length > bytes_.size() - at_) fail("a text is longer than the message");
    if (!wrong_.empty()) return "";
    BIP_ASSERT(at_ + length <= bytes_.size(), "a text of {} bytes at {} of {}", length, at_, bytes_.size());
    const char* const begin = reinterpret_cast<const char*>(bytes_.data()) + at_;
    at_ += length;
    if (length > 0 && begin[length - 1] == '\0') --length;
    if (f.text_bound != 0 && length > f.text_bound) fail("a text is longer than its bound");
    return std::string(begin, length);
  }

  const Messages& messages_;
  const Bytes& bytes_;
  Encoding encoding_;
  std::size_t at_ = 0;
  bool is_big_ = false;
  std::string wrong_;
};

}  // namespace

Messages::Messages() {
  add({"builtin_interfaces/msg/Time",
       {{.name = "sec", .kind = Kind::Int32}, {.name = "nanosec", .kind = Kind::UInt32}}});
  add({"unique_identifier_msgs/msg/UUID", {{.name = "uuid", .kind = Kind::UInt8, .shape = Shape::Array, .count = 16}}});
  add({"service_msgs/msg/ServiceEventInfo",
       {{.name = "event_type", .kind = Kind::UInt8},
        {.name = "stamp", .kind = Kind::Message, .message = "builtin_interfaces/msg/Time"},
        {.name = "client_gid", .kind = Kind::UInt8, .shape = Shape::Array, .count = 16},
        {.name = "sequence_number", .kind = Kind::Int64}}});
  add({"action_msgs/msg/GoalInfo",
       {{.name = "goal_id", .kind = Kind::Message, .message = "unique_identifier_msgs/msg/UUID"},
        {.name = "stamp", .kind = Kind::Message, .message = "builtin_interfaces/msg/Time"}}});
  add({"action_msgs/msg/GoalStatus",
       {{.name = "goal_info", .kind = Kind::Message, .message = "action_msgs/msg/GoalInfo"},
        {.name = "status", .kind = Kind::Int8}}});
  add({"action_msgs/msg/GoalStatusArray",
       {{.name = "status_list",
         .kind = Kind::Message,
         .message = "action_msgs/msg/GoalStatus",
         .shape = Shape::Sequence}}});
  const Field info{.name = "goal_info", .kind = Kind::Message, .message = "action_msgs/msg/GoalInfo"};
  add_service("action_msgs/srv/CancelGoal", {info},
              {{.name = "return_code", .kind = Kind::Int8},
               {.name = "goals_canceling",
                .kind = Kind::Message,
                .message = "action_msgs/msg/GoalInfo",
                .shape = Shape::Sequence}});
}

void Messages::add(Message message) {
  std::string name = message.name;
  rows_.insert_or_assign(std::move(name), std::move(message));
}

const Message& Messages::at(const std::string& name) const {
  const auto found = rows_.find(name);
  BIP_ENSURE(found != rows_.end());
  return found->second;
}

std::string Messages::description_of(const std::string& name) const {
  std::set<std::string> seen, waiting{name};
  while (!waiting.empty()) {
    const std::string next = *waiting.begin();
    waiting.erase(waiting.begin());
    if (!seen.insert(next).second) continue;
    for (const Field& f : at(next).fields) {
      if (f.kind == Kind::Message) waiting.insert(f.message);
    }
  }
  seen.erase(name);
  Json all{{"type_description", description_row(at(name))}, {"referenced_type_descriptions", Json::array()}};
  for (const std::string& other : seen) all["referenced_type_descriptions"].push_back(description_row(at(other)));
  std::string text;
  write_spaced(all, text);
  return text;
}

std::string Messages::hash_of(const std::string& name) const { return "RIHS01_" + sha256(description_of(name)); }

void Messages::add_service(const std::string& name, std::vector<Field> request, std::vector<Field> response) {
  const std::string asked = name + "_Request", answered = name + "_Response", event = name + "_Event";
  add({asked, std::move(request)});
  add({answered, std::move(response)});
  add({event,
       {{.name = "info", .kind = Kind::Message, .message = "service_msgs/msg/ServiceEventInfo"},
        {.name = "request", .kind = Kind::Message, .message = asked, .shape = Shape::Bounded, .count = 1},
        {.name = "response", .kind = Kind::Message, .message = answered, .shape = Shape::Bounded, .count = 1}}});
  add({name,
       {{.name = "request_message", .kind = Kind::Message, .message = asked},
        {.name = "response_message", .kind = Kind::Message, .message = answered},
        {.name = "event_message", .kind = Kind::Message, .message = event}}});
}

void Messages::add_action(const std::string& name, std::vector<Field> goal, std::vector<Field> result,
                          std::vector<Field> feedback) {
  const Field id{.name = "goal_id", .kind = Kind::Message, .message = "unique_identifier_msgs/msg/UUID"};
  add({name + "_Goal", std::move(goal)});
  add({name + "_Result", std::move(result)});
  add({name + "_Feedback", std::move(feedback)});
  add_service(name + "_SendGoal", {id, {.name = "goal", .kind = Kind::Message, .message = name + "_Goal"}},
              {{.name = "accepted", .kind = Kind::Bool},
               {.name = "stamp", .kind = Kind::Message, .message = "builtin_interfaces/msg/Time"}});
  add_service(
      name + "_GetResult", {id},
      {{.name = "status", .kind = Kind::Int8}, {.name = "result", .kind = Kind::Message, .message = name + "_Result"}});
  add({name + "_FeedbackMessage", {id, {.name = "feedback", .kind = Kind::Message, .message = name + "_Feedback"}}});
}

std::string dds_type(const std::string& name) {
  std::string out;
  std::size_t begin = 0;
  for (std::size_t slash = 0; (slash = name.find('/', begin)) != std::string::npos; begin = slash + 1)
    out += name.substr(begin, slash - begin) + "::";
  return out + "dds_::" + name.substr(begin) + "_";
}

Result<Bytes> to_cdr(const Messages& messages, const std::string& name, const Json& value,
                     const RequestHeader* header) {
  MessageEncoder writer(messages, Encoding::Cdr);
  if (header != nullptr) {
    writer.number(header->client, 8);
    writer.number(static_cast<std::uint64_t>(header->number), 8);
  }
  writer.message(name, value, "");
  return writer.result();
}

Result<Json> from_cdr(const Messages& messages, const std::string& name, const Bytes& bytes, RequestHeader* header) {
  MessageDecoder reader(messages, bytes, Encoding::Cdr);
  if (header != nullptr) {
    header->client = reader.number(8);
    header->number = static_cast<std::int64_t>(reader.number(8));
  }
  Json value = reader.message(name, 0);
  if (!reader.wrong().empty()) return Failure{reader.wrong()};
  return value;
}

Result<Bytes> to_packed(const Messages& messages, const std::string& name, const Json& value) {
  MessageEncoder writer(messages, Encoding::Packed);
  writer.message(name, value, "");
  return writer.result();
}

Result<Json> from_packed(const Messages& messages, const std::string& name, const Bytes& bytes) {
  MessageDecoder reader(messages, bytes, Encoding::Packed);
  Json value = reader.message(name, 0);
  if (!reader.wrong().empty()) return Failure{reader.wrong()};
  return value;
}

}  // namespace bip::ros2
