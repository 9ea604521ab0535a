// A call of the system that found no memory ends a command as `new` does: main() answers both with its code.
#pragma once
#include <new>

namespace bip {

[[noreturn]] inline void throw_out_of_memory() { throw std::bad_alloc(); }

}  // namespace bip
