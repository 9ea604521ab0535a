// Opens a debugging session, as `bipc step` and `bipc view` do.
#pragma once
#include <memory>

#include "compiler/driver/options.hpp"
#include "compiler/pipeline/executor.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "runtime/debug/session.hpp"

namespace bip::driver {

struct OpenSession {
  std::unique_ptr<rt::DebugSession> session;  // null: it was said why
  int exit_code = kOk;                        // without a session
};

/// Opens a session on the model that was compiled to an image, at the end of the trace if there is one. `options`:
/// those of the arguments; they get what the trace says of its run. The executor and the compilation must outlive the
/// session.
[[nodiscard]] OpenSession open_session(Compilation& c, Executor& executor, const SessionArguments& arguments,
                                       rt::SessionOptions& options);

}  // namespace bip::driver
