// Registers machine code of this process with other tools: gdb's list of in-memory objects, perf's map. Internal to
// jit/.
#pragma once
#include <llvm/ExecutionEngine/Orc/LLJIT.h>

#include <map>
#include <string>

namespace bip::jit {

/// Registers every object that the engine links with gdb, and writes a line for each function to /tmp/perf-PID.map.
/// `labels`: the name under which perf shows a symbol, by symbol.
[[nodiscard]] llvm::Error let_watch(llvm::orc::LLJIT& engine, std::map<std::string, std::string> labels);

}  // namespace bip::jit
