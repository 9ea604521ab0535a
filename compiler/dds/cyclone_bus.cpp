// See cyclone_bus.hpp. Cyclone's threads only write to an eventfd; all else happens on the thread that calls.
#include "compiler/dds/cyclone_bus.hpp"

#include <dds/dds.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

#include "compiler/dds/sertype.hpp"

namespace bip::dds {
namespace {

using ros2::BusPlan;
using ros2::EndpointPlan;
using ros2::Keep;
using ros2::PeerId;
using ros2::Sample;

constexpr dds_duration_t kMostBlocked = DDS_MSECS(100);

// On the loopback there is no multicast: participants find each other by trying the ports of the first few.
std::string configuration(const BusPlan& plan) {
  if (plan.interface.empty()) return {};
  const std::string interface = "<Interfaces><NetworkInterface name=\"" + plan.interface + "\"/></Interfaces>";
  if (plan.interface != "lo") return "<CycloneDDS><Domain><General>" + interface + "</General></Domain></CycloneDDS>";
  return "<CycloneDDS><Domain><General>" + interface +
         "<AllowMulticast>false</AllowMulticast></General><Discovery>"
         "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>31</MaxAutoParticipantIndex>"
         "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>";
}

Failure failure(const std::string& what, dds_return_t code) { return Failure{what + ": " + dds_strretcode(code)}; }

PeerId peer_of(const dds_guid_t& guid) {
  PeerId peer{};
  std::copy(std::begin(guid.v), std::end(guid.v), peer.begin());
  return peer;
}

class CycloneBus final : public ros2::Bus {
 public:
  CycloneBus() : event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
  ~CycloneBus() override {
    // Deletes everything in the domain and notifies peers.
    if (domain_ > 0) (void)dds_delete(domain_);
    else if (participant_ > 0) (void)dds_delete(participant_);
    if (event_ >= 0) (void)::close(event_);
  }

  // Empty, or what is wrong.
  std::string open(const BusPlan& plan) {
    if (event_ < 0) return "no eventfd";
    const std::string xml = configuration(plan);
    if (!xml.empty()) {
      domain_ = dds_create_domain(plan.domain, xml.c_str());
      if (domain_ < 0) return failure("no domain", domain_).message;
    }
    dds_qos_t* const qos = dds_create_qos();
    // Where ROS 2 looks for security enclaves.
    const std::string user_data = "enclave=/;";
    dds_qset_userdata(qos, user_data.data(), user_data.size());
    participant_ = dds_create_participant(plan.domain, qos, nullptr);
    dds_delete_qos(qos);
    return participant_ < 0 ? failure("no participant", participant_).message : "";
  }

  Result<std::size_t> add_reader(const EndpointPlan& plan) override {
    return add(plan, readers_, EndpointKind::Reader);
  }
  Result<std::size_t> add_writer(const EndpointPlan& plan) override {
    return add(plan, writers_, EndpointKind::Writer);
  }

  [[nodiscard]] int descriptor() const override { return event_; }
  void reset() override {
    std::uint64_t ignored = 0;
    (void)!::read(event_, &ignored, sizeof ignored);
  }

  std::vector<Sample> take(std::size_t reader) override {
    std::vector<Sample> all;
    while (true) {
      ros2::Bytes bytes;
      void* place = &bytes;
      dds_sample_info_t info{};
      if (dds_take(readers_[reader], &place, &info, 1, 1) <= 0) return all;
      if (!info.valid_data) continue;
      Sample sample{std::move(bytes), {}};
      if (dds_builtintopic_endpoint_t* const end =
              dds_get_matched_publication_data(readers_[reader], info.publication_handle)) {
        sample.peer = peer_of(end->participant_key);
        dds_builtintopic_free_endpoint(end);
      }
      all.push_back(std::move(sample));
    }
  }
  std::string write(std::size_t writer, const ros2::Bytes& bytes) override {
    const dds_return_t code = dds_write(writers_[writer], &bytes);
    return code == DDS_RETCODE_OK ? "" : dds_strretcode(code);
  }

  bool has_reader(std::size_t writer, const PeerId& peer) override {
    return has(writers_[writer], peer, &dds_get_matched_subscriptions, &dds_get_matched_subscription_data);
  }
  bool has_writer(std::size_t reader, const PeerId& peer) override {
    return has(readers_[reader], peer, &dds_get_matched_publications, &dds_get_matched_publication_data);
  }
  std::size_t readers_of(std::size_t writer) override {
    const dds_return_t count = dds_get_matched_subscriptions(writers_[writer], nullptr, 0);
    return count < 0 ? 0 : static_cast<std::size_t>(count);
  }

 private:
  template <class List, class Look>
  static bool has(dds_entity_t entity, const PeerId& peer, List list, Look look) {
    const dds_return_t count = list(entity, nullptr, 0);
    if (count <= 0) return false;
    std::vector<dds_instance_handle_t> handles(static_cast<std::size_t>(count));
    const dds_return_t found = list(entity, handles.data(), handles.size());
    handles.resize(std::min(handles.size(), static_cast<std::size_t>(std::max(found, 0))));
    return std::any_of(handles.begin(), handles.end(), [&](dds_instance_handle_t handle) {
      dds_builtintopic_endpoint_t* const end = look(entity, handle);
      if (end == nullptr) return false;
      const bool is_peer = peer_of(end->participant_key) == peer;
      dds_builtintopic_free_endpoint(end);
      return is_peer;
    });
  }

  enum class EndpointKind : std::uint8_t { Reader, Writer };
  Result<std::size_t> add(const EndpointPlan& plan, std::vector<dds_entity_t>& entities, EndpointKind kind) {
    const bool is_reader = kind == EndpointKind::Reader;
    ddsi_sertype* type = make_sertype(plan.type);
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, kMostBlocked);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, static_cast<std::int32_t>(plan.depth));
    dds_qset_durability(qos, plan.keep == Keep::Volatile ? DDS_DURABILITY_VOLATILE : DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_writer_data_lifecycle(qos, false);
    dds_qset_userdata(qos, plan.user_data.data(), plan.user_data.size());
    dds_listener_t* const listener = dds_create_listener(this);
    if (is_reader) {
      dds_lset_data_available(listener, [](dds_entity_t, void* bus) { static_cast<CycloneBus*>(bus)->notify(); });
      dds_lset_subscription_matched(listener, [](dds_entity_t, const dds_subscription_matched_status_t, void* bus) {
        static_cast<CycloneBus*>(bus)->notify();
      });
    } else {
      dds_lset_publication_matched(listener, [](dds_entity_t, const dds_publication_matched_status_t, void* bus) {
        static_cast<CycloneBus*>(bus)->notify();
      });
    }
    const dds_entity_t topic =
        dds_create_topic_sertype(participant_, plan.topic.c_str(), &type, nullptr, nullptr, nullptr);
    dds_entity_t entity = topic;
    if (topic >= 0)
      entity = is_reader ? dds_create_reader(participant_, topic, qos, listener)
                         : dds_create_writer(participant_, topic, qos, listener);
    dds_delete_listener(listener);
    dds_delete_qos(qos);
    if (entity < 0) return failure("topic `" + plan.topic + "`", entity);
    entities.push_back(entity);
    return entities.size() - 1;
  }
  void notify() {
    const std::uint64_t increment = 1;
    (void)!::write(event_, &increment, sizeof increment);
  }

  int event_;
  dds_entity_t domain_ = 0, participant_ = 0;
  std::vector<dds_entity_t> readers_, writers_;
};

}  // namespace

Result<std::unique_ptr<ros2::Bus>> open_bus(const BusPlan& plan) {
  auto bus = std::make_unique<CycloneBus>();
  if (std::string wrong = bus->open(plan); !wrong.empty()) return Failure{std::move(wrong)};
  return std::unique_ptr<ros2::Bus>(std::move(bus));
}

}  // namespace bip::dds
