// The C ABI over the embedding API. See bip/bip.h.
#include "bip/bip.h"

#include <cmath>
#include <optional>
#include <variant>

#include "bip/bip.hpp"
#include "runtime/engine/copy_text.hpp"
#include "runtime/engine/policies.hpp"

struct bip_execution {
  bip::Execution system;
};
struct bip_snapshot {
  bip::Execution::Snapshot snapshot;
};

namespace {

int code_of(bip::Outcome outcome) { return static_cast<int>(outcome); }
static_assert(static_cast<int>(bip::Outcome::Stepped) == BIP_STEPPED &&
              static_cast<int>(bip::Outcome::Deadlock) == BIP_DEADLOCK &&
              static_cast<int>(bip::Outcome::Fault) == BIP_FAULT &&
              static_cast<int>(bip::Outcome::Stopped) == BIP_STOPPED &&
              static_cast<int>(bip::Outcome::Final) == BIP_FINAL);
static_assert(static_cast<int>(bip::Posted::Taken) == BIP_TAKEN && static_cast<int>(bip::Posted::Full) == BIP_FULL &&
              static_cast<int>(bip::Posted::NoSuchPort) == BIP_NO_SUCH_PORT &&
              static_cast<int>(bip::Posted::BadValues) == BIP_BAD_VALUES);

// Of a type that is none: nothing.
std::optional<bip::EventValue> event_value(const bip_value& value) {
  switch (value.type) {
    case BIP_INT: return value.is.as_int;
    case BIP_BOOL: return value.is.as_bool != 0;
    case BIP_FLOAT: return value.is.as_float;
    case BIP_STRING: return std::string(value.is.as_string == nullptr ? "" : value.is.as_string);
    default: return std::nullopt;
  }
}
// Text is borrowed.
bip_value c_value(const bip::EventValue& value) {
  bip_value out{};
  if (const auto* whole = std::get_if<std::int32_t>(&value)) out.is.as_int = *whole;
  if (const auto* truth = std::get_if<bool>(&value)) out = {BIP_BOOL, {.as_bool = *truth ? 1 : 0}};
  if (const auto* real = std::get_if<double>(&value)) out = {BIP_FLOAT, {.as_float = *real}};
  if (const auto* text = std::get_if<std::string>(&value)) out = {BIP_STRING, {.as_string = text->c_str()}};
  return out;
}

}  // namespace

extern "C" {

bip_execution* bip_create(const bip_image* image, uint64_t seed, int policy) {
  bip_options options{};
  options.size = sizeof options;
  options.seed = seed;
  options.policy = policy;
  return bip_create_with(image, &options);
}
bip_execution* bip_create_with(const bip_image* image, const bip_options* given) {
  if (image == nullptr || given == nullptr || given->size != sizeof(bip_options)) return nullptr;
  if (given->policy < 0 || static_cast<std::size_t>(given->policy) >= bip::rt::policies().size()) return nullptr;
  if (!(given->speed >= 0) || std::isinf(given->speed)) return nullptr;
  bip::ExecutionOptions options;
  options.seed = given->seed;
  options.policy = static_cast<bip::rt::Policy>(given->policy);
  options.maximal_progress = given->no_maximal_progress == 0;
  options.asap = given->asap != 0;
  options.strict = given->strict != 0;
  options.speed = given->speed;
  if (given->event_capacity != 0) options.event_capacity = given->event_capacity;
  return std::make_unique<bip_execution>(
             bip_execution{bip::Execution(*reinterpret_cast<const bip::rt::Image*>(image), options)})
      .release();
}
int bip_find_policy(const char* name) {
  const bip::rt::PolicyRow* const row = name == nullptr ? nullptr : bip::rt::find_policy(name);
  return row == nullptr ? -1 : static_cast<int>(row->policy);
}
void bip_destroy(bip_execution* system) { const std::unique_ptr<bip_execution> owner(system); }

int bip_status(const bip_execution* system) { return code_of(system->system.outcome()); }
int bip_step(bip_execution* system) { return code_of(system->system.step()); }
uint64_t bip_run(bip_execution* system, uint64_t steps) { return system->system.run(steps); }
uint64_t bip_steps(const bip_execution* system) { return system->system.steps(); }

uint64_t bip_candidate_count(const bip_execution* system) { return system->system.candidate_count(); }
size_t bip_candidate(const bip_execution* system, uint64_t k, char* buffer, size_t size) {
  return bip::rt::copy_text(k < system->system.candidate_count() ? system->system.candidate(k) : std::string(), buffer,
                            size);
}
int bip_fire(bip_execution* system, uint64_t k) { return code_of(system->system.fire(k)); }

size_t bip_candidate_ports(const bip_execution* system, uint64_t k, char* buffer, size_t size) {
  std::string text;
  if (k < system->system.candidate_count()) {
    for (const std::string& port : system->system.candidate_ports(k)) text += (text.empty() ? "" : "\n") + port;
  }
  return bip::rt::copy_text(text, buffer, size);
}
size_t bip_why(const bip_execution* system, const char* path, char* buffer, size_t size) {
  return bip::rt::copy_text(system->system.why(path), buffer, size);
}

int64_t bip_now(const bip_execution* system) { return system->system.now(); }
uint64_t bip_late_steps(const bip_execution* system) { return system->system.late_steps(); }
void bip_restart_clock(bip_execution* system) { system->system.restart_clock(); }
void bip_stop(bip_execution* system) { system->system.stop(); }
void bip_go_on(bip_execution* system) { system->system.go_on(); }

int bip_post(bip_execution* system, const char* port, const bip_value* values, size_t count) {
  std::vector<bip::EventValue> given;
  for (size_t k = 0; k < count; ++k) {
    std::optional<bip::EventValue> value = event_value(values[k]);
    if (!value) return BIP_BAD_VALUES;
    given.push_back(std::move(*value));
  }
  return static_cast<int>(system->system.post(port, std::move(given)));
}

void bip_on_step_view(bip_execution* system, bip_step_callback callback, void* user) {
  if (callback == nullptr) {
    system->system.on_step(nullptr);
    return;
  }
  system->system.on_step([callback, user, system](const bip::Step& step) {
    std::vector<const char*> ports;
    for (const std::string& port : step.ports) ports.push_back(port.c_str());
    std::vector<bip_port_value> values;
    for (const bip::StepValue& v : step.values) values.push_back({v.port, v.name, c_value(v.value)});
    const bip_step_view view{step.number,   system->system.now(), step.interaction.c_str(), ports.size(), ports.data(),
                             values.size(), values.data()};
    callback(user, &view);
  });
}

void bip_on_step(bip_execution* system, bip_callback callback, void* user) {
  if (callback == nullptr) {
    system->system.on_step(nullptr);
    return;
  }
  system->system.on_step(
      [callback, user](const bip::Step& step) { callback(user, step.number, step.interaction.c_str()); });
}

int bip_read_int(const bip_execution* system, const char* path, int32_t* value) {
  return system->system.read(path, *value) ? 1 : 0;
}
int bip_read_bool(const bip_execution* system, const char* path, int* value) {
  bool truth = false;
  if (!system->system.read(path, truth)) return 0;
  *value = truth ? 1 : 0;
  return 1;
}
int bip_read_float(const bip_execution* system, const char* path, double* value) {
  return system->system.read(path, *value) ? 1 : 0;
}
size_t bip_read_string(const bip_execution* system, const char* path, char* buffer, size_t size) {
  std::string value;
  (void)system->system.read(path, value);
  return bip::rt::copy_text(value, buffer, size);
}
size_t bip_place(const bip_execution* system, const char* atom_path, char* buffer, size_t size) {
  return bip::rt::copy_text(system->system.place(atom_path), buffer, size);
}

bip_snapshot* bip_save(const bip_execution* system) {
  return std::make_unique<bip_snapshot>(bip_snapshot{system->system.snapshot()}).release();
}
void bip_restore(bip_execution* system, const bip_snapshot* snapshot) { system->system.restore(snapshot->snapshot); }
void bip_free_snapshot(bip_snapshot* snapshot) { const std::unique_ptr<bip_snapshot> owner(snapshot); }

size_t bip_fault(const bip_execution* system, char* buffer, size_t size) {
  return bip::rt::copy_text(system->system.fault(), buffer, size);
}
size_t bip_story(const bip_execution* system, char* buffer, size_t size) {
  return bip::rt::copy_text(system->system.story(), buffer, size);
}

}  // extern "C"
