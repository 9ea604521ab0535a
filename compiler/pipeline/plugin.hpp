// Plug-ins that make objects of an interface by a factory: network, DDS. The JIT has a loader of its own
// (jit_loader.hpp).
#pragma once
#include <cstdint>
#include <string>

#include "compiler/base/result.hpp"

namespace bip::pipeline {

/// A shared object beside bipc, with a C function `abi_name` that returns `abi` and a C function `factory_name`.
struct Plugin {
  const char* file;
  const char* what;           // "no network": of the error, if the file is not there
  const char* package;        // that has the file
  const char* needed_build;   // the package that a build needs to make it
  const char* subject;        // "the network": of the error, if the file does not load
  const char* needed_to_run;  // the package that it is linked with
  const char* abi_name;
  std::uint64_t abi;
  const char* factory_name;
};

/// Loads the plug-in and returns its factory function; it stays loaded. Failure: it is not there, does not load, or was
/// built with another bipc.
[[nodiscard]] Result<void*> load_plugin(const Plugin& plugin);

}  // namespace bip::pipeline
