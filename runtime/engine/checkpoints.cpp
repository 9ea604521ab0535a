// See checkpoints.hpp. The flag that the signal handler sets is global: a handler can reach nothing else.
#include "runtime/engine/checkpoints.hpp"
#include "runtime/core/text.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>

namespace bip::rt {

namespace {

volatile std::sig_atomic_t checkpoint_asked = 0;
extern "C" void bip_on_checkpoint(int) { checkpoint_asked = 1; }

bool write_whole_file(const std::string& path, const std::string& bytes) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return false;
  const bool is_written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  return (std::fclose(file) == 0) && is_written;
}

}  // namespace

CheckpointSignal::CheckpointSignal() {
  checkpoint_asked = 0;
  struct sigaction action {};
  action.sa_handler = bip_on_checkpoint;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  ::sigaction(SIGUSR1, &action, &before_);
}

CheckpointSignal::~CheckpointSignal() { ::sigaction(SIGUSR1, &before_, nullptr); }

i64 Checkpoints::due() const {
  return is_on() && options_.checkpoint_every > 0 ? due_ : std::numeric_limits<i64>::max();
}

bool Checkpoints::take_due(i64 now) {
  if (!is_on() || (now < due() && checkpoint_asked == 0)) return false;
  checkpoint_asked = 0;
  due_ = now + options_.checkpoint_every;
  return true;
}

// A crash while it is written leaves the one before.
void Checkpoints::write(const Core& core, Checkpoint checkpoint) {
  checkpoint.steps += resumed_;
  const std::string& path = options_.checkpoint_path;
  const std::string unfinished = path + ".new";
  if (!write_whole_file(unfinished, print_checkpoint(core, checkpoint)) ||
      std::rename(unfinished.c_str(), path.c_str()) != 0) {
    std::fprintf(stderr, "warning: no checkpoint: %s: %s\n", printable(path).c_str(), std::strerror(errno));
    return;
  }
  steps_ = checkpoint.steps;
  ++count_;
}

std::string resume(Core& core, const std::string& path, Checkpoint& checkpoint) {
  std::FILE* const file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return std::strerror(errno);
  std::string bytes;
  char buffer[4096];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;) bytes.append(buffer, n);
  std::fclose(file);
  checkpoint.state = core.snapshot();
  if (std::string problem = read_checkpoint(core, bytes, checkpoint); !problem.empty()) return problem;
  return core.restore(checkpoint.state) ? "" : "a run-time error: " + core.fault().what;
}

}  // namespace bip::rt
