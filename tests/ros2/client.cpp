// A client of ROS 2 actions and topics over Fast DDS, for tests of `bipc ros2`: written from the specifications, with
// CDR by hand, and without anything of the bridge, so that both sides of the wire are independent.
//
//   ros2_client DOMAIN      commands on standard input, a JSON line on standard output for each event
//
//   action NAME TYPE RESULT     RESULT: the members of the result, as letters (below)
//   goal NAME HEX [VALUE…]      HEX: 32 digits, the goal's id; a VALUE is a letter, `:` and its text
//   result NAME HEX | cancel NAME HEX | cancel NAME all
//   topic NAME TYPE FORMAT
//   wait NAME N                 until all ends of an action, or the reader of a topic, have found N others, dead ones,
//   too hashes                      type hashes that were announced: topic, type, user data quit
// Letters: b bool, B uint8, h int16, i int32, q int64, f float, d double, s string, * a sequence of the next.
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <chrono>
#include <cstring>
#include <iostream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fd = eprosima::fastdds::dds;
namespace fr = eprosima::fastrtps::rtps;
using Bytes = std::vector<unsigned char>;

std::mutex& output_lock() {
  static std::mutex lock;
  return lock;
}
void print(const std::string& line) {
  const std::lock_guard<std::mutex> hold(output_lock());
  std::cout << line << std::endl;
}
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}
double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// ---- CDR: bytes after four of a head, numbers aligned to their size

struct Out {
  Bytes bytes{0, 1, 0, 0};
  template <class T>
  void put(T value) {
    while ((bytes.size() - 4) % sizeof value != 0) bytes.push_back(0);
    unsigned char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.insert(bytes.end(), raw, raw + sizeof value);
  }
  void text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size() + 1));
    bytes.insert(bytes.end(), value.begin(), value.end());
    bytes.push_back(0);
  }
  void id(const Bytes& uuid) { bytes.insert(bytes.end(), uuid.begin(), uuid.end()); }
  // "d:2.5"
  void value(const std::string& word) {
    const std::string content = word.size() > 2 ? word.substr(2) : "";
    switch (word[0]) {
      case 'b': return put(static_cast<unsigned char>(content == "true"));
      case 'B': return put(static_cast<unsigned char>(std::stoi(content)));
      case 'h': return put(static_cast<std::int16_t>(std::stoi(content)));
      case 'i': return put(static_cast<std::int32_t>(std::stol(content)));
      case 'q': return put(static_cast<std::int64_t>(std::stoll(content)));
      case 'f': return put(std::stof(content));
      case 'd': return put(std::stod(content));
      case 's': return text(content);
      default: print("{\"error\":" + quoted("no value: " + word) + "}");
    }
  }
};
struct In {
  const Bytes& bytes;
  std::size_t at = 4;
  template <class T>
  T get() {
    T value{};
    while ((at - 4) % sizeof value != 0) ++at;
    if (at + sizeof value > bytes.size()) {
      print("{\"error\":\"a sample is too short\"}");
      return value;
    }
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  }
  std::string text() {
    const auto length = get<std::uint32_t>();
    if (length == 0 || at + length > bytes.size()) return "";
    std::string value(reinterpret_cast<const char*>(bytes.data()) + at, length - 1);
    at += length;
    return value;
  }
  std::string id() {
    std::string digits;
    for (int k = 0; k < 16; ++k) {
      const auto byte = get<unsigned char>();
      digits += "0123456789abcdef"[byte >> 4];
      digits += "0123456789abcdef"[byte & 15];
    }
    return digits;
  }
  std::string one(char letter) {
    std::ostringstream out;
    out.precision(17);
    switch (letter) {
      case 'b': return get<unsigned char>() != 0 ? "true" : "false";
      case 'B': out << static_cast<int>(get<unsigned char>()); break;
      case 'h': out << get<std::int16_t>(); break;
      case 'i': out << get<std::int32_t>(); break;
      case 'q': out << get<std::int64_t>(); break;
      case 'f': out << get<float>(); break;
      case 'd': out << get<double>(); break;
      default: return quoted(text());
    }
    return out.str();
  }
  std::string members(const std::string& format) {
    std::string out;
    for (std::size_t k = 0; k < format.size(); ++k) {
      out += out.empty() ? "" : ",";
      if (format[k] != '*') {
        out += one(format[k]);
        continue;
      }
      ++k;
      std::string list;
      for (auto count = get<std::uint32_t>(); count > 0 && at <= bytes.size(); --count)
        list += (list.empty() ? "" : ",") + one(format[k]);
      out += "[" + list + "]";
    }
    return "[" + out + "]";
  }
};

class BlobType final : public fd::TopicDataType {
 public:
  explicit BlobType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = 1 << 16;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, fr::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(fr::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, fr::InstanceHandle_t*, bool) override { return false; }
};

class Announced final : public fd::DomainParticipantListener {
 public:
  void on_publisher_discovery(fd::DomainParticipant* own, fr::WriterDiscoveryInfo&& end) override {
    if (end.info.guid().guidPrefix == own->guid().guidPrefix) return;
    note(end.info.topicName().to_string(), end.info.typeName().to_string(), end.info.m_qos.m_userData.data_vec());
  }
  void on_subscriber_discovery(fd::DomainParticipant* own, fr::ReaderDiscoveryInfo&& end) override {
    if (end.info.guid().guidPrefix == own->guid().guidPrefix) return;
    note(end.info.topicName().to_string(), end.info.typeName().to_string(), end.info.m_qos.m_userData.data_vec());
  }
  void print_all() {
    const std::lock_guard<std::mutex> hold(lock_);
    for (const std::string& row : rows_) print(row);
    print("{\"event\":\"hashes\"}");
  }

 private:
  void note(const std::string& topic, const std::string& type, const std::vector<fr::octet>& data) {
    const std::lock_guard<std::mutex> hold(lock_);
    rows_.insert("{\"event\":\"end\",\"topic\":" + quoted(topic) + ",\"type\":" + quoted(type) +
                 ",\"data\":" + quoted(std::string(data.begin(), data.end())) + "}");
  }
  std::mutex lock_;
  std::set<std::string> rows_;
};

class Hearing final : public fd::DataReaderListener {
 public:
  explicit Hearing(std::function<void(const Bytes&)> hear) : hear_(std::move(hear)) {}
  void on_data_available(fd::DataReader* reader) override {
    Bytes bytes;
    fd::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) hear_(bytes);
    }
  }
  void on_subscription_matched(fd::DataReader*, const fd::SubscriptionMatchedStatus& status) override {
    matched = status.total_count;
  }
  std::atomic<int> matched{0};

 private:
  std::function<void(const Bytes&)> hear_;
};
class Writing final : public fd::DataWriterListener {
 public:
  void on_publication_matched(fd::DataWriter*, const fd::PublicationMatchedStatus& status) override {
    matched = status.total_count;
  }
  std::atomic<int> matched{0};
};

class Client {
 public:
  explicit Client(unsigned domain) {
    fd::DomainParticipantQos qos;
    qos.transport().use_builtin_transports = false;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList.push_back("127.0.0.1");
    udp->maxInitialPeersRange = 32;
    qos.transport().user_transports.push_back(udp);
    fr::Locator_t here;
    fr::IPLocator::setIPv4(here, 127, 0, 0, 1);
    qos.wire_protocol().builtin.initialPeersList.push_back(here);
    qos.wire_protocol().builtin.metatrafficUnicastLocatorList.push_back(here);
    qos.wire_protocol().builtin.discovery_config.leaseDuration = {3, 0};
    qos.wire_protocol().builtin.discovery_config.leaseDuration_announcementperiod = {1, 0};
    participant_ = fd::DomainParticipantFactory::get_instance()->create_participant(domain, qos, &announced_,
                                                                                    fd::StatusMask::none());
    if (participant_ == nullptr) std::exit(2);
    publisher_ = participant_->create_publisher(fd::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(fd::SUBSCRIBER_QOS_DEFAULT);
  }
  ~Client() {
    participant_->delete_contained_entities();
    fd::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  void add_action(const std::string& name, const std::string& type, const std::string& result) {
    const std::size_t slash = type.find('/');
    const std::string dds = type.substr(0, slash) + "::action::dds_::" + type.substr(slash + 1) + "_";
    const std::string base = name + "/_action/";
    Action& action = actions_[name];
    action.send_goal = writer("rq/" + base + "send_goalRequest", dds + "SendGoal_Request_");
    action.get_result = writer("rq/" + base + "get_resultRequest", dds + "GetResult_Request_");
    action.cancel = writer("rq/" + base + "cancel_goalRequest", "action_msgs::srv::dds_::CancelGoal_Request_");
    const auto number = [](In& in) {
      (void)in.get<std::uint64_t>();
      return std::to_string(in.get<std::int64_t>());
    };
    const std::string of = ",\"action\":" + quoted(name);
    reader("rr/" + base + "send_goalReply", dds + "SendGoal_Response_", false, [=](const Bytes& bytes) {
      In in{bytes};
      const std::string which = number(in);
      print("{\"event\":\"goal\"" + of + ",\"number\":" + which + ",\"accepted\":" + in.one('b') +
            ",\"ms\":" + std::to_string(now_ms()) + "}");
    });
    reader("rr/" + base + "get_resultReply", dds + "GetResult_Response_", false, [=](const Bytes& bytes) {
      In in{bytes};
      const std::string which = number(in);
      const int status = in.get<signed char>();
      print("{\"event\":\"result\"" + of + ",\"number\":" + which + ",\"status\":" + std::to_string(status) +
            ",\"result\":" + in.members(result) + "}");
    });
    reader("rr/" + base + "cancel_goalReply", "action_msgs::srv::dds_::CancelGoal_Response_", false,
           [=](const Bytes& bytes) {
             In in{bytes};
             const std::string which = number(in);
             const int code = in.get<signed char>();
             print("{\"event\":\"cancel\"" + of + ",\"number\":" + which + ",\"code\":" + std::to_string(code) +
                   ",\"goals\":[" + goals(in, false) + "]}");
           });
    reader("rt/" + base + "feedback", dds + "FeedbackMessage_", false, [=](const Bytes& bytes) {
      In in{bytes};
      const std::string id = in.id();
      print("{\"event\":\"feedback\"" + of + ",\"id\":" + quoted(id) + ",\"feedback\":" + in.members("ss") +
            ",\"ms\":" + std::to_string(now_ms()) + "}");
    });
    reader("rt/" + base + "status", "action_msgs::msg::dds_::GoalStatusArray_", true, [=](const Bytes& bytes) {
      In in{bytes};
      print("{\"event\":\"status\"" + of + ",\"goals\":[" + goals(in, true) + "]}");
    });
  }
  void send(const std::string& name, const std::string& what, const std::string& id,
            const std::vector<std::string>& values) {
    Action& action = actions_[name];
    Out out;
    out.put(client_);
    out.put(static_cast<std::int64_t>(++number_));
    Bytes uuid(16);
    for (std::size_t k = 0; k < 16 && id != "all"; ++k)
      uuid[k] = static_cast<unsigned char>(std::stoi(id.substr(2 * k, 2), nullptr, 16));
    out.id(uuid);
    if (what == "cancel") {
      out.put(std::int32_t{0});
      out.put(std::uint32_t{0});
    }
    for (const std::string& value : values) out.value(value);
    print("{\"event\":\"sent\",\"what\":" + quoted(what) + ",\"action\":" + quoted(name) +
          ",\"number\":" + std::to_string(number_) + ",\"ms\":" + std::to_string(now_ms()) + "}");
    fd::DataWriter* const to = what == "goal" ? action.send_goal : what == "cancel" ? action.cancel : action.get_result;
    if (!to->write(&out.bytes)) print("{\"error\":\"not written\"}");
  }
  void add_topic(const std::string& name, const std::string& type, const std::string& format) {
    const std::size_t slash = type.find('/');
    reader("rt/" + name, type.substr(0, slash) + "::msg::dds_::" + type.substr(slash + 1) + "_", false,
           [=](const Bytes& bytes) {
             In in{bytes};
             print("{\"event\":\"topic\",\"topic\":" + quoted(name) + ",\"value\":" + in.members(format) + "}");
           });
  }
  void wait(const std::string& name, int count) {
    const auto is_of = [&](const std::string& topic) { return topic.substr(3, name.size()) == name; };
    for (int k = 0; k < 3000; ++k) {
      bool is_whole = true;
      for (const auto& [topic, hearing] : hearings_)
        is_whole = is_whole && (!is_of(topic) || hearing->matched >= count);
      for (const auto& [topic, writing] : writings_)
        is_whole = is_whole && (!is_of(topic) || writing->matched >= count);
      if (is_whole) return print("{\"event\":\"matched\",\"name\":" + quoted(name) + "}");
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    print("{\"event\":\"alone\",\"name\":" + quoted(name) + "}");
  }
  void print_hashes() { announced_.print_all(); }

 private:
  struct Action {
    fd::DataWriter *send_goal = nullptr, *get_result = nullptr, *cancel = nullptr;
  };
  static std::string goals(In& in, bool has_status) {
    std::string list;
    for (auto count = in.get<std::uint32_t>(); count > 0 && in.at < in.bytes.size(); --count) {
      const std::string id = in.id();
      (void)in.get<std::int32_t>();
      (void)in.get<std::uint32_t>();
      list += (list.empty() ? "" : ",") + ("[" + quoted(id)) +
              (has_status ? "," + std::to_string(static_cast<int>(in.get<signed char>())) : "") + "]";
    }
    return list;
  }
  fd::Topic* topic(const std::string& name, const std::string& type) {
    fd::TypeSupport(new BlobType(type)).register_type(participant_);
    return participant_->create_topic(name, type, fd::TOPIC_QOS_DEFAULT);
  }
  fd::DataWriter* writer(const std::string& name, const std::string& type) {
    fd::DataWriterQos qos;
    qos.reliability().kind = fd::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fd::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fd::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    auto& listener = writings_[name];
    listener = std::make_unique<Writing>();
    return publisher_->create_datawriter(topic(name, type), qos, listener.get());
  }
  void reader(const std::string& name, const std::string& type, bool is_late, std::function<void(const Bytes&)> hear) {
    fd::DataReaderQos qos;
    qos.reliability().kind = fd::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = is_late ? fd::TRANSIENT_LOCAL_DURABILITY_QOS : fd::VOLATILE_DURABILITY_QOS;
    qos.history().kind = fd::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = 10;
    auto& listener = hearings_[name];
    listener = std::make_unique<Hearing>(std::move(hear));
    (void)subscriber_->create_datareader(topic(name, type), qos, listener.get());
  }

  Announced announced_;
  fd::DomainParticipant* participant_ = nullptr;
  fd::Publisher* publisher_ = nullptr;
  fd::Subscriber* subscriber_ = nullptr;
  std::map<std::string, Action> actions_;
  std::map<std::string, std::unique_ptr<Hearing>> hearings_;
  std::map<std::string, std::unique_ptr<Writing>> writings_;
  const std::uint64_t client_ = 0x0123456789abcdefull;
  long number_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  Client client(static_cast<unsigned>(std::stoul(argv[1])));
  std::string line;
  while (std::getline(std::cin, line)) {
    // Words are separated by tabs, so that texts may have blanks.
    std::vector<std::string> words;
    std::istringstream in(line);
    for (std::string word; std::getline(in, word, '\t');) words.push_back(word);
    if (words.empty() || words[0] == "quit") break;
    if (words[0] == "action" && words.size() == 4) client.add_action(words[1], words[2], words[3]);
    else if ((words[0] == "goal" || words[0] == "result" || words[0] == "cancel") && words.size() >= 3)
      client.send(words[1], words[0], words[2], {words.begin() + 3, words.end()});
    else if (words[0] == "topic" && words.size() == 4) client.add_topic(words[1], words[2], words[3]);
    else if (words[0] == "wait" && words.size() == 3) client.wait(words[1], std::stoi(words[2]));
    else if (words[0] == "hashes") client.print_hashes();
    else print("{\"error\":" + quoted("no command: " + line) + "}");
  }
  return 0;
}
