// Registers machine code of this process with other tools: gdb's list of in-memory objects, perf's map. Internal to
// jit/.
#pragma once
#include <llvm/ExecutionEngine/Orc/LLJIT.h>

#include <map>
#include <string>

namespace bip::jit {

/// From now on gdb is told of every object, and /tmp/perf-PID.map gets a line for each function. `labels`: how perf
/// shows a symbol, by its name.
[[nodiscard]] llvm::Error let_watch(llvm::orc::LLJIT& engine, std::map<std::string, std::string> labels);

}  // namespace bip::jit
