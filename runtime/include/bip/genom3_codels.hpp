// The run time of unmodified GenoM 3 codels: ports, contexts with exceptions, inputs and outputs of requests. Header
// only; what `bipc genom --codels` writes calls it. Codels that share data never overlap: the model's locks see to
// that. What crosses modules, and requests, is locked here.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bip/genom3_values.hpp"
#include "bip/service_requests.hpp"

// For codels in C, too.
extern "C" __attribute__((used)) inline int genom_sequence_reserve_bytes(void* sequence, uint32_t length, size_t own,
                                                                         size_t element) {
  struct Any {
    uint32_t _maximum, _length;
    void* _buffer;
    void (*_release)(void*);
  };
  Any& any = *static_cast<Any*>(sequence);
  if (own != 0) {
    // Not set yet if the sequence is in a union whose discriminant was changed.
    any._maximum = static_cast<uint32_t>(own / element);
    return length <= any._maximum ? 0 : -1;
  }
  if (length <= any._maximum) return 0;
  void* const bigger = std::realloc(any._buffer, length * element);
  if (bigger == nullptr) return -1;
  std::memset(static_cast<char*>(bigger) + any._maximum * element, 0, (length - any._maximum) * element);
  any._buffer = bigger;
  any._maximum = length;
  any._release = std::free;
  return 0;
}

namespace bip::genom3 {

/// An exception that codels raise.
struct ExceptionRow {
  genom_event event;
  // Of the struct of C, and of that of C++; null: it has none.
  void (*detail)(std::string& json, const void* detail);
  void (*object_detail)(std::string& json, const void* detail) = nullptr;
  // Raises it with details from JSON (null: all zero), in C and in C++; null: it has none, or is not known there.
  genom_event (*again)(const Json* detail, genom_context self) = nullptr;
  genom_event (*object_again)(const Json* detail, genom_context self) = nullptr;
};

// ---- contexts

struct Raised {
  genom_event event = genom_ok;
  std::vector<std::max_align_t> detail;
  std::unique_ptr<::genom::exception> object;  // of the C++ mapping
  [[nodiscard]] const void* details() const {
    return object != nullptr ? object->details() : detail.empty() ? nullptr : detail.data();
  }
};
inline genom_event raise(genom_event event, const void* detail, size_t size, genom_context self) {
  Raised& raised = *static_cast<Raised*>(self->data);
  raised.event = event;
  raised.object = nullptr;
  raised.detail.assign((size + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t), {});
  if (detail != nullptr && size != 0) std::memcpy(raised.detail.data(), detail, size);
  return event;
}
inline genom_event raise_object(const void* exception, genom_context self) {
  Raised& raised = *static_cast<Raised*>(self->data);
  raised.object = static_cast<const ::genom::exception*>(exception)->copy();
  return raised.event = raised.object->event();
}
inline const void* raised(genom_event* event, genom_context self) {
  const Raised& raised = *static_cast<const Raised*>(self->data);
  if (event != nullptr) *event = raised.event;
  return raised.details();
}

// ---- ports. `N` tells ports of one type apart. C functions have no object, so each port is a class.

/// What a component has written under a name; a port that is not `multiple` has the one name "".
template <class T>
struct Written {
  std::mutex lock;
  std::map<std::string, T, std::less<>> values;
  std::atomic<std::uint64_t> version{0};  // grows with each write
};
template <class T, int N>
struct OutPort {
  static inline std::map<std::string, T, std::less<>> own;  // between codels
  static inline Written<T> written;
  static T* data_of(const char* id, genom_context) {
    const auto found = own.find(std::string_view(id));
    return found == own.end() ? nullptr : &found->second;
  }
  static genom_event open(const char* id, genom_context) {
    const auto [at, is_new] = own.try_emplace(id);
    if (is_new) clear(at->second);
    return genom_ok;
  }
  static genom_event close(const char* id, genom_context) {
    if (const auto found = own.find(std::string_view(id)); found != own.end()) {
      release(found->second);
      own.erase(found);
    }
    return genom_ok;
  }
  static genom_event write_of(const char* id, genom_context self);
  static T* data(genom_context self) {
    (void)open("", self);
    return data_of("", self);
  }
  static genom_event write(genom_context self) {
    (void)open("", self);
    return write_of("", self);
  }
};
extern "C" const genom_event genom_no_such_outport_id, genom_no_such_inport_id, genom_no_such_service_id;

template <class T, int N>
genom_event OutPort<T, N>::write_of(const char* id, genom_context self) {
  T* const value = data_of(id, self);
  if (value == nullptr) return self->raise(genom_no_such_outport_id, nullptr, 0, self);
  const std::lock_guard<std::mutex> hold(written.lock);
  const auto [at, is_new] = written.values.try_emplace(id);
  if (is_new) clear(at->second);
  assign(at->second, *value);
  ++written.version;
  return genom_ok;
}

/// Copies what an out port holds under `id`; false: nothing was written yet.
template <class T>
using Fetch = bool (*)(std::string_view id, T& into);
template <class T>
bool fetch(Written<T>& written, std::string_view id, T& into) {
  const std::lock_guard<std::mutex> hold(written.lock);
  const auto found = written.values.find(id);
  if (found == written.values.end()) return false;
  assign(into, found->second);
  return true;
}
/// An out port that an in port may read, "eye/target".
template <class T>
struct SourceRow {
  const char* name;
  bool is_multiple;
  Fetch<T> fetch;
};

template <class T, int N>
struct InPort {
  // What `connect_port` has connected, by the id here.
  struct Connection {
    Fetch<T> fetch = nullptr;
    std::string id;
  };
  static inline Fetch<T> source = nullptr;  // of what is not connected: the same id there; null: there is none
  static inline std::span<const SourceRow<T>> sources;
  static inline std::map<std::string, Connection, std::less<>> connections;
  static inline std::mutex lock;  // of connections
  static inline std::map<std::string, T, std::less<>> own;

  static T* data_of(const char* id, genom_context) {
    const auto found = own.find(std::string_view(id));
    return found == own.end() ? nullptr : &found->second;
  }
  static genom_event read_of(const char* id, genom_context self) {
    Connection from{source, id};
    {
      const std::lock_guard<std::mutex> hold(lock);
      if (const auto found = connections.find(from.id); found != connections.end()) from = found->second;
    }
    if (from.fetch == nullptr) return self->raise(genom_no_such_outport_id, nullptr, 0, self);
    const auto [at, is_new] = own.try_emplace(id);
    if (is_new) clear(at->second);
    // Nothing was written there: `data` is null, also if another port was read before.
    return from.fetch(from.id, at->second) ? genom_ok : close(id, self);
  }
  static genom_event open(const char*, genom_context) { return genom_ok; }
  static genom_event close(const char* id, genom_context) {
    if (const auto found = own.find(std::string_view(id)); found != own.end()) {
      release(found->second);
      own.erase(found);
    }
    return genom_ok;
  }
  static T* data(genom_context self) { return data_of("", self); }
  static genom_event read(genom_context self) { return read_of("", self); }

  /// False: there is no such out port, or it holds values of another type.
  static bool connect(std::string_view id, std::string_view remote) {
    for (const SourceRow<T>& row : sources) {
      const std::string_view name = row.name;
      std::string_view there;
      if (row.is_multiple) {
        if (!remote.starts_with(name) || remote.size() < name.size() + 2 || remote[name.size()] != '/') continue;
        there = remote.substr(name.size() + 1);
      } else if (remote != name) {
        continue;
      }
      const std::lock_guard<std::mutex> hold(lock);
      connections.insert_or_assign(std::string(id), Connection{row.fetch, std::string(there)});
      return true;
    }
    return false;
  }
};
struct InPortRow {
  const char* name;
  bool is_multiple;
  bool (*connect)(std::string_view id, std::string_view remote);
};
/// The service `connect_port` of a component. `local`: "target", or "gauge/left" of a multiple port.
inline genom_event connect_port(std::span<const InPortRow> ports, std::string_view local, std::string_view remote,
                                genom_context self) {
  const std::size_t slash = local.find('/');
  const std::string_view id = slash == std::string_view::npos ? "" : local.substr(slash + 1);
  for (const InPortRow& row : ports) {
    if (local.substr(0, slash) != row.name || row.is_multiple == id.empty()) continue;
    return row.connect(id, remote) ? genom_ok : self->raise(genom_no_such_outport_id, nullptr, 0, self);
  }
  return self->raise(genom_no_such_inport_id, nullptr, 0, self);
}

/// What an out port holds, as JSON; empty: nothing was written yet.
template <class T>
void show(Written<T>& written, std::string& json) {
  const std::lock_guard<std::mutex> hold(written.lock);
  if (const auto found = written.values.find(std::string_view()); found != written.values.end())
    to_json(json, found->second);
}

// ---- codels

/// What a codel answers, as the model has it: 0 ether, 1 + k the k-th state, 101 + k after a pause, -1 none of them.
inline int next_of(genom_event event, std::span<const char* const> states) {
  std::string_view name = event == genom_ok ? "" : event;
  if (name == "ether") return 0;
  const bool pauses = name.starts_with("pause::");
  if (pauses) name.remove_prefix(7);
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (name == states[k]) return static_cast<int>(k) + (pauses ? 101 : 1);
  }
  return -1;
}

/// A service or a task, as codels of it end.
struct Behaviour {
  std::span<const char* const> states;
  std::span<const char* const> reports;  // last names of exceptions
};

class Call {
 public:
  explicit Call(std::span<const ExceptionRow> exceptions) : exceptions_(exceptions) {}
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  /// What the codel returns, or the exception of its description that it throws.
  template <class Codel>
  genom_event run(Codel codel) const {
    try {
      return codel(&context_);
    } catch (const ::genom::exception& thrown) {
      return raise_object(&thrown, &context_);
    }
  }

  /// The number of the report, from 1 on; 0: the event is no exception, -1: one that the service does not throw.
  int report(genom_event event, const Behaviour& behaviour, ReplyNotes& notes, const char* whose) const {
    for (const ExceptionRow& row : exceptions_) {
      if (event != row.event) continue;
      const std::string_view full = event;
      std::string text = "\"exception\":{\"name\":" + json_text(full);
      const auto detail = raised_.object == nullptr ? row.detail : row.object_detail;
      if (detail != nullptr && raised_.event == event && raised_.details() != nullptr) {
        text += ",\"detail\":";
        detail(text, raised_.details());
      }
      if (*whose != '\0') notes.note(whose, text + "}");
      for (std::size_t k = 0; k < behaviour.reports.size(); ++k) {
        if (full.substr(full.rfind(':') + 1) == behaviour.reports[k]) return static_cast<int>(k) + 1;
      }
      std::fprintf(stderr, "warning[R0048]: %s raised %s, which it does not throw\n", whose, event);
      return -1;
    }
    return 0;
  }

 private:
  std::span<const ExceptionRow> exceptions_;
  Raised raised_;
  genom_context_if context_{&raise, &genom3::raised, &raised_, &raise_object};
};

/// A codel of an activity or a task; `outputs` gives the members of its reply.
template <class Codel, class Outputs>
int run_step(const char* name, const CodelOwner& owner, std::span<const ExceptionRow> exceptions,
             const Behaviour& behaviour, int& report, Codel codel, Outputs outputs) {
  return guarded_step(name, owner, [&] {
    const Call call(exceptions);
    const genom_event event = call.run(codel);
    const int raised = call.report(event, behaviour, activity_notes(), owner.name);
    if (raised != 0) {
      report = raised > 0 ? raised : 0;
      return raised > 0 ? 0 : kCodelThrew;
    }
    const int next = next_of(event, behaviour.states);
    if (next == 0) activity_notes().note(owner.name, outputs());
    return next;
  });
}
/// One that judges or does a request at once.
template <class Codel>
int run_control(const char* name, const CodelOwner& owner, std::span<const ExceptionRow> exceptions,
                const Behaviour& behaviour, Codel codel) {
  return guarded_control(name, owner, [&] {
    const Call call(exceptions);
    const genom_event event = call.run(codel);
    if (event == genom_ok) return 0;
    const int raised = call.report(event, behaviour, service_notes(), owner.service);
    return raised == 0 ? kCodelRefuses : raised;
  });
}

// ---- requests

/// Inputs of services, as they were asked for last. The engine's thread.
inline std::map<std::string, std::string, std::less<>>& asked_inputs() {
  static std::map<std::string, std::string, std::less<>> inputs;
  return inputs;
}
inline void note_asked(const char* request, const char* input) {
  asked_inputs()[std::string(read_request(request).service)] = input;
}
inline Json read_input(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) text = "{}";
  Json json = JsonReader::read(text);
  if (json.kind != Json::Kind::Object) throw std::runtime_error("an input is an object of JSON");
  return json;
}
/// One parameter, from its initial value and then from the input.
template <class T>
void read_parameter(const Json& input, const char* name, const char* initial, T& v) {
  release(v);
  clear(v);
  if (*initial != '\0') from_json(JsonReader::read(initial), v, name);
  if (const Json* const given = input.find(name)) from_json(*given, v, name);
  else if (*initial == '\0') refuse(name, "is missing");
}
inline void check_names(const Json& input, std::initializer_list<const char*> known) {
  for (const auto& [name, value] : input.members) {
    bool is_known = false;
    for (const char* const k : known) is_known = is_known || name == k;
    if (!is_known) throw std::runtime_error(no_parameter(name));
  }
}
/// A request that cannot be read any more keeps the initial values: `bipc serve` has refused it before.
template <class Take>
void begin(const CodelOwner& owner, Take take) {
  try {
    take();
  } catch (const std::exception& wrong) {
    std::fprintf(stderr, "warning[R0048]: input of %s: %s\n", owner.service, wrong.what());
  }
}
template <class T>
void write_output(std::string& members, const char* name, const T& v) {
  members += (members.empty() ? "\"output\":{" : ",") + json_text(name) + ":";
  to_json(members, v);
}
inline std::string end_outputs(std::string members) { return members.empty() ? members : members + "}"; }

}  // namespace bip::genom3
