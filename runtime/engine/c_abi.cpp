// The C ABI over the embedding API. See bip/bip.h.
#include "bip/bip.h"

#include <algorithm>
#include <cstring>

#include "bip/bip.hpp"
#include "runtime/engine/policies.hpp"

struct bip_execution {
  bip::Execution system;
};
struct bip_snapshot {
  bip::Execution::Snapshot snapshot;
};

namespace {

std::size_t copy_out(const std::string& text, char* buffer, std::size_t size) {
  if (buffer != nullptr && size != 0) {
    const std::size_t length = std::min(size - 1, text.size());
    std::memcpy(buffer, text.data(), length);
    buffer[length] = '\0';
  }
  return text.size();
}
int code_of(bip::Outcome outcome) { return static_cast<int>(outcome); }
static_assert(static_cast<int>(bip::Outcome::Stepped) == BIP_STEPPED &&
              static_cast<int>(bip::Outcome::Deadlock) == BIP_DEADLOCK &&
              static_cast<int>(bip::Outcome::Fault) == BIP_FAULT &&
              static_cast<int>(bip::Outcome::Stopped) == BIP_STOPPED);

}  // namespace

extern "C" {

bip_execution* bip_create(const bip_image* image, uint64_t seed, int policy) {
  if (image == nullptr || policy < 0 || static_cast<std::size_t>(policy) >= bip::rt::policies().size()) return nullptr;
  bip::ExecutionOptions options;
  options.seed = seed;
  options.policy = static_cast<bip::rt::Policy>(policy);
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
  return copy_out(k < system->system.candidate_count() ? system->system.candidate(k) : std::string(), buffer, size);
}
int bip_fire(bip_execution* system, uint64_t k) { return code_of(system->system.fire(k)); }

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
  return copy_out(value, buffer, size);
}
size_t bip_place(const bip_execution* system, const char* atom_path, char* buffer, size_t size) {
  return copy_out(system->system.place(atom_path), buffer, size);
}

bip_snapshot* bip_save(const bip_execution* system) {
  return std::make_unique<bip_snapshot>(bip_snapshot{system->system.snapshot()}).release();
}
void bip_restore(bip_execution* system, const bip_snapshot* snapshot) { system->system.restore(snapshot->snapshot); }
void bip_free_snapshot(bip_snapshot* snapshot) { const std::unique_ptr<bip_snapshot> owner(snapshot); }

size_t bip_fault(const bip_execution* system, char* buffer, size_t size) {
  return copy_out(system->system.fault(), buffer, size);
}
size_t bip_story(const bip_execution* system, char* buffer, size_t size) {
  return copy_out(system->system.story(), buffer, size);
}

}  // extern "C"
