// See bip/process.hpp.
#include "bip/process.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <system_error>

namespace bip {

namespace {

constexpr int kInternalError = 70;  // as of a failed assertion

// After a failed allocation only what needs no memory can be trusted.
void write_error(const char* what, const char* why) {
  for (const char* text : {"error: ", what, why, "\n"}) {
    if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
  }
}

// Reports the exception that is being handled, and returns its exit code.
int report_exception() {
  try {
    std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    write_error("out of memory", "");
    return kNoResources;
  } catch (const std::system_error& error) {
    write_error("the system refused a resource: ", error.what());
    return kNoResources;
  } catch (const std::exception& error) {
    write_error("unexpected exception: ", error.what());
  } catch (...) {
    write_error("unexpected exception", "");
  }
  return kInternalError;
}

// For exceptions that no `catch` can see: of threads, of destructors, of initializers before main().
[[noreturn]] void end_after_exception() {
  if (std::current_exception() == nullptr) std::abort();
  std::_Exit(report_exception());
}

// Before the initializers of other files, which allocate.
__attribute__((constructor(101))) void set_terminate_handler() { std::set_terminate(end_after_exception); }

}  // namespace

void hold_standard_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest free number is taken, which is this one. Standard output is opened for reading: writing to it fails.
    const int opened = ::open("/dev/null", descriptor == STDERR_FILENO ? O_RDWR : O_RDONLY);
    if (opened >= 0 && opened != descriptor) ::close(opened);
  }
}

int report_lost_output(int error) {
  const char* const reason = error != 0 ? std::strerror(error) : "an earlier part was lost";
  std::fprintf(stderr, "error[B5004]: cannot write `standard output`: %s\n", reason);
  return kOutputLost;
}

int finish_standard_output(int code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return report_lost_output(errno);
}

namespace {

// What the deepest permitted nesting of a source needs, and what a thread has by default.
constexpr std::size_t kStackBytes = 8u << 20;

struct Body {
  int (*function)(int argc, char** argv);
  int argc;
  char** argv;
  int code = kInternalError;
};

extern "C" void* bip_run_body(void* context) {
  Body& body = *static_cast<Body*>(context);
  try {
    body.code = body.function(body.argc, body.argv);
  } catch (...) {
    body.code = report_exception();
  }
  return nullptr;
}

bool is_stack_small() {
  struct rlimit limit {};
  return ::getrlimit(RLIMIT_STACK, &limit) == 0 && limit.rlim_cur < kStackBytes;
}

// On a thread with a stack of kStackBytes, which all later threads have as well. False: there is no thread.
bool run_on_larger_stack(Body& body) {
  pthread_attr_t attributes;
  pthread_t thread{};
  ::pthread_attr_init(&attributes);
  ::pthread_attr_setstacksize(&attributes, kStackBytes);
  ::pthread_setattr_default_np(&attributes);
  const bool is_started = ::pthread_create(&thread, &attributes, bip_run_body, &body) == 0;
  ::pthread_attr_destroy(&attributes);
  if (is_started) ::pthread_join(thread, nullptr);
  return is_started;
}

}  // namespace

int run_process(int (*body)(int argc, char** argv), int argc, char** argv) {
  hold_standard_descriptors();
  // A file at its limit of size is a failed write, which is reported.
  std::signal(SIGXFSZ, SIG_IGN);
  Body called{body, argc, argv};
  if (!is_stack_small() || !run_on_larger_stack(called)) bip_run_body(&called);
  return finish_standard_output(called.code);
}

}  // namespace bip
