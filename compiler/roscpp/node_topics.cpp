// See node_topics.hpp. roscpp's threads only keep messages and write to an eventfd; all else happens on the thread that
// calls.
#include "compiler/roscpp/node_topics.hpp"

#include <ros/ros.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstring>
#include <deque>
#include <mutex>
#include <utility>

namespace bip::roscpp {

/// A message of any type, as it is on the wire. The topic's plan has the type.
struct SerializedValue {
  ros1::Bytes bytes;
};

}  // namespace bip::roscpp

// What roscpp asks of a type of messages. "*": the type is not this one's to say.
namespace ros {
namespace message_traits {
template <>
struct MD5Sum<bip::roscpp::SerializedValue> {
  static const char* value() { return "*"; }
  static const char* value(const bip::roscpp::SerializedValue&) { return "*"; }
};
template <>
struct DataType<bip::roscpp::SerializedValue> {
  static const char* value() { return "*"; }
  static const char* value(const bip::roscpp::SerializedValue&) { return "*"; }
};
template <>
struct Definition<bip::roscpp::SerializedValue> {
  static const char* value() { return ""; }
  static const char* value(const bip::roscpp::SerializedValue&) { return ""; }
};
}  // namespace message_traits
namespace serialization {
template <>
struct Serializer<bip::roscpp::SerializedValue> {
  template <typename Stream>
  static void write(Stream& stream, const bip::roscpp::SerializedValue& value) {
    const auto length = static_cast<std::uint32_t>(value.bytes.size());
    std::uint8_t* const place = stream.advance(length);
    if (length > 0) std::memcpy(place, value.bytes.data(), length);
  }
  template <typename Stream>
  static void read(Stream& stream, bip::roscpp::SerializedValue& value) {
    const std::uint32_t length = stream.getLength();
    const std::uint8_t* const begin = stream.advance(length);
    value.bytes.assign(begin, begin + length);
  }
  static std::uint32_t serializedLength(const bip::roscpp::SerializedValue& value) {
    return static_cast<std::uint32_t>(value.bytes.size());
  }
};
}  // namespace serialization
}  // namespace ros

namespace bip::roscpp {
namespace {

using ros1::TopicMessage;
using ros1::TopicPlan;

class NodeTopics final : public ros1::TopicBus {
 public:
  NodeTopics() : event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)), spinner_(1) { spinner_.start(); }
  ~NodeTopics() override {
    spinner_.stop();
    publishers_.clear();
    for (Subscriber& subscriber : subscribers_) subscriber.handle.shutdown();
    ros::shutdown();
    if (event_ >= 0) (void)::close(event_);
  }

  Result<std::size_t> subscribe(const TopicPlan& plan) override {
    const std::size_t row = subscribers_.size();
    {
      const std::lock_guard lock(mutex_);
      subscribers_.emplace_back();
    }
    ros::SubscribeOptions options;
    using Event = ros::MessageEvent<const SerializedValue>;
    options.initByFullCallbackType<const Event&>(plan.topic, plan.depth, [this, row](const Event& event) {
      keep(row, {event.getConstMessage()->bytes, event.getPublisherName()});
    });
    options.md5sum = plan.md5;
    options.datatype = plan.type;
    options.transport_hints = ros::TransportHints().tcpNoDelay();
    subscribers_[row].handle = node_.subscribe(options);
    if (!subscribers_[row].handle) return Failure{"no subscription to " + plan.topic};
    return row;
  }
  Result<std::size_t> advertise(const TopicPlan& plan) override {
    ros::AdvertiseOptions options(plan.topic, plan.depth, plan.md5, plan.type, plan.definition);
    options.latch = plan.is_latched;
    publishers_.push_back(node_.advertise(options));
    if (!publishers_.back()) return Failure{"no topic " + plan.topic};
    return publishers_.size() - 1;
  }
  [[nodiscard]] int descriptor() const override { return event_; }
  void reset() override {
    std::uint64_t ignored = 0;
    (void)!::read(event_, &ignored, sizeof ignored);
  }
  std::vector<TopicMessage> take(std::size_t subscriber) override {
    const std::lock_guard lock(mutex_);
    return std::exchange(subscribers_[subscriber].messages, {});
  }
  void publish(std::size_t publisher, const ros1::Bytes& bytes) override {
    publishers_[publisher].publish(SerializedValue{bytes});
  }
  std::size_t publishers_of(std::size_t subscriber) override {
    return subscribers_[subscriber].handle.getNumPublishers();
  }
  std::size_t subscribers_of(std::size_t publisher) override { return publishers_[publisher].getNumSubscribers(); }

 private:
  struct Subscriber {
    ros::Subscriber handle;
    std::vector<TopicMessage> messages;
  };
  void keep(std::size_t row, TopicMessage message) {
    {
      const std::lock_guard lock(mutex_);
      subscribers_[row].messages.push_back(std::move(message));
    }
    const std::uint64_t increment = 1;
    (void)!::write(event_, &increment, sizeof increment);
  }

  int event_;
  ros::NodeHandle node_;
  ros::AsyncSpinner spinner_;
  std::mutex mutex_;  // of the messages, and of the rows that they are in
  std::deque<Subscriber> subscribers_;
  std::vector<ros::Publisher> publishers_;
};

}  // namespace

Result<std::unique_ptr<ros1::TopicBus>> open_node(const std::string& name) {
  // Signals stay the program's, and /rosout is not published.
  ros::init(ros::M_string(), name, ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  if (!ros::master::check()) return Failure{"no master of ROS at " + ros::master::getURI()};
  return std::unique_ptr<ros1::TopicBus>(std::make_unique<NodeTopics>());
}

}  // namespace bip::roscpp
