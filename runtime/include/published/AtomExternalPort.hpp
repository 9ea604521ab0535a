// The base of classes behind `extern port … as "Class"` in the form of the published engine: a constructor with the
// port's name and a policy, getters `event_get_x()`. Sources in that form compile unchanged; new ones derive from
// bip::EventSource (bip/event_source.hpp).
#pragma once
#include <string>

#include "TimeValue.hpp"
#include "bip/event_source.hpp"

using EventConsumptionPolicy = bip::EventSourcePolicy;

class AtomExternalPort : public bip::EventSource {
 public:
  AtomExternalPort(const std::string& name, const EventConsumptionPolicy& policy) : name_(name), policy_(policy) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const EventConsumptionPolicy& eventConsumptionPolicy() const { return policy_; }

  // ---- what a class defines; these have no events
  virtual void initialize() {}
  [[nodiscard]] virtual TimeValue eventTime() const { return TimeValue(now(), NANOSECOND); }
  [[nodiscard]] virtual bool hasEvent() const { return false; }
  virtual void popEvent() {}
  virtual void purgeEvents() {}

 private:
  std::string name_;
  EventConsumptionPolicy policy_;
};
