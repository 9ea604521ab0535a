// Messages before and after a run of nodes on several hosts: a node is present and has a certain model, the options of
// the run, a node leaves. A greeting is never a valid frame of a run, and a frame never a valid greeting.
//
// The launcher knocks at each node until that answers, and welcomes all when the last one is there, until each is in
// the run.
#pragma once
#include <string>
#include <string_view>

#include "runtime/distributed/message.hpp"

namespace bip::rt {

struct Greeting {
  enum class Kind : std::uint8_t {
    Knock,    // of the launcher: it asks for an answer
    Answer,   // of a node
    Welcome,  // of the launcher: the run begins
    Leave     // of a node: it ends
  };
  Kind kind = Kind::Knock;
  u64 protocol = kProtocol;
  u64 number = 0;  // drawn by the sender when it starts, so a sender that was restarted has another one; the launcher's
                   // names the run
  std::string model;  // Deployment::model; of a Leave: why
  // Welcome.
  u64 seed = 0;
  u32 policy = 0, format = 0;  // rt::Policy, rt::TraceFormat
  bool is_silent = false, is_traced = false, goes_on = false, has_maximal_progress = true, is_asap = false;
};

[[nodiscard]] bool is_greeting(std::string_view bytes);
[[nodiscard]] std::string text_of(const Greeting& greeting);
/// False: it is none that can be understood. Of another protocol's only that is read.
[[nodiscard]] bool read(std::string_view bytes, Greeting& greeting);

}  // namespace bip::rt
