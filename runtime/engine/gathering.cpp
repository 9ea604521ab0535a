// See gathering.hpp.
#include "runtime/engine/gathering.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace bip::rt {

Gathering::Gathering(const Deployment& deployment, Fabric& fabric, Greeting welcome)
    : deployment_(deployment), fabric_(fabric), welcome_(std::move(welcome)), guests_(deployment.names.size()) {
  guests_[0].is_there = guests_[0].is_in_run = true;
}

bool Gathering::is_complete() const {
  return std::all_of(guests_.begin(), guests_.end(), [](const Guest& guest) { return guest.is_there; });
}

void Gathering::tell(const std::string& text) const {
  std::fprintf(stderr, "bipc: %s\n", text.c_str());
  std::fflush(stderr);
}

void Gathering::tick(i64 now) {
  if (tell_at_ == 0) tell_at_ = now + kTellMissing;
  if (now >= tell_at_ && !is_welcoming_) {
    tell_missing();
    tell_at_ = kForever;
  }
  if (now < next_) return;
  next_ = kForever;
  const std::string knock =
      text_of({.kind = Greeting::Kind::Knock, .number = welcome_.number, .model = deployment_.model});
  for (u32 node = 0; node < guests_.size(); ++node) {
    Guest& guest = guests_[node];
    if (is_welcoming_ ? guest.is_in_run : guest.is_there) continue;
    fabric_.send(node, is_welcoming_ ? text_of(welcome_) : knock);
    next_ = now + pause_;
  }
  pause_ = std::min(2 * pause_, kKnock);
}

i64 Gathering::due() const { return is_welcoming_ ? next_ : std::min(next_, tell_at_); }

void Gathering::tell_missing() {
  std::string names;
  for (u32 node = 0; node < guests_.size(); ++node) {
    if (!guests_[node].is_there)
      names += (names.empty() ? "`" : ", `") + deployment_.names[node] + "` at " + deployment_.addresses[node];
  }
  tell("waiting for " + names);
}

std::string Gathering::take(const Arrival& arrival, i64 now) {
  Greeting greeting;
  if (arrival.from >= guests_.size() || !read(arrival.bytes, greeting)) return {};
  Guest& guest = guests_[arrival.from];
  const std::string node = "node `" + deployment_.names[arrival.from] + '`';
  if (greeting.protocol != kProtocol || (greeting.kind == Greeting::Kind::Answer && greeting.model != welcome_.model)) {
    if (!std::exchange(guest.is_refused, true))
      tell(node +
           (greeting.protocol != kProtocol ? " has a bipc of another version"
                                           : " has another model, placement or bipc") +
           ", and is refused: deploy again");
    return {};
  }
  switch (greeting.kind) {
    case Greeting::Kind::Answer:
      // Who says so again has heard of nothing yet.
      if (is_welcoming_ && guest.is_in_run && greeting.number != guest.number) return "was started anew";
      guest.is_there = true;
      guest.number = greeting.number;
      next_ = std::min(next_, now);
      return {};
    case Greeting::Kind::Leave: guest.is_there = false; return greeting.model.empty() ? "has left" : greeting.model;
    case Greeting::Kind::Knock:
    case Greeting::Kind::Welcome: return {};
  }
  return {};
}

void Gathering::welcome(i64 now) {
  is_welcoming_ = true;
  pause_ = kKnock;
  next_ = now;
  tick(now);
}

}  // namespace bip::rt
