// See greeting.hpp. Frames begin with the number of their protocol, which is not 0.
#include "runtime/distributed/greeting.hpp"

#include "runtime/distributed/codec.hpp"
#include "runtime/distributed/deployment.hpp"

namespace bip::rt {

namespace {

constexpr char kMark = '\0';
constexpr u64 kMostPolicies = 16, kMostFormats = 64;

FabricPlan plan_of(const Deployment& deployment, u32 self, const FabricKeys& keys) {
  FabricPlan plan;
  plan.self = self;
  plan.open_keys = deployment.open_keys;
  plan.keys = keys;
  for (const std::string& address : deployment.addresses) plan.addresses.push_back("tcp://" + address);
  if (self < plan.addresses.size()) plan.addresses[self] = "tcp://" + deployment.listen;
  plan.addresses.emplace_back();  // the launcher listens nowhere
  return plan;
}

}  // namespace

FabricPlan node_plan(const Deployment& deployment) { return plan_of(deployment, deployment.self, deployment.keys); }
FabricPlan launcher_plan(const Deployment& deployment) {
  return plan_of(deployment, deployment.launcher(), deployment.launcher_keys);
}

bool is_greeting(std::string_view bytes) { return !bytes.empty() && bytes.front() == kMark; }

std::string text_of(const Greeting& greeting) {
  std::string text(1, kMark);
  ByteWriter writer(text);
  writer.number(greeting.protocol);
  writer.number(static_cast<u64>(greeting.kind));
  writer.number(greeting.number);
  writer.text(greeting.model);
  if (greeting.kind != Greeting::Kind::Welcome) return text;
  writer.number(greeting.seed);
  writer.number(greeting.policy);
  writer.number(greeting.format);
  for (const bool flag :
       {greeting.is_silent, greeting.is_traced, greeting.goes_on, greeting.has_maximal_progress, greeting.is_asap})
    writer.number(flag ? 1 : 0);
  return text;
}

bool read(std::string_view bytes, Greeting& greeting) {
  if (!is_greeting(bytes)) return false;
  ByteReader reader(bytes.substr(1));
  greeting = {};
  greeting.protocol = reader.number();
  greeting.kind = static_cast<Greeting::Kind>(reader.row(static_cast<u64>(Greeting::Kind::Leave) + 1));
  if (!reader.is_sound()) return false;
  if (greeting.protocol != kProtocol) return true;
  greeting.number = reader.number();
  greeting.model = reader.text();
  if (greeting.kind == Greeting::Kind::Welcome) {
    greeting.seed = reader.number();
    greeting.policy = reader.row(kMostPolicies);
    greeting.format = reader.row(kMostFormats);
    for (bool* const flag : {&greeting.is_silent, &greeting.is_traced, &greeting.goes_on,
                             &greeting.has_maximal_progress, &greeting.is_asap})
      *flag = reader.row(2) != 0;
  }
  return reader.is_sound() && reader.is_at_end();
}

}  // namespace bip::rt
