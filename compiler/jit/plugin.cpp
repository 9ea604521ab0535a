// libbipc_jit.so: the JIT as a plug-in, so that only commands that run native code pay for loading libLLVM (13 ms).
#include "compiler/jit/plugin.hpp"

#include "compiler/jit/plugin_abi.hpp"

using namespace bip;

extern "C" {

std::uint64_t bipc_jit_abi();
jit::Jit* bipc_jit_compile(const lower::LoweredSystem* lowered, const jit::JitOptions* options, jit::MadeCode* made,
                           std::string* error);
void bipc_jit_destroy(jit::Jit* jit);
bool bipc_jit_emit(const lower::LoweredSystem* lowered, jit::OptLevel level, jit::Listing kind, std::string* out);

std::uint64_t bipc_jit_abi() { return jit::kPluginAbi; }

jit::Jit* bipc_jit_compile(const lower::LoweredSystem* lowered, const jit::JitOptions* options, jit::MadeCode* made,
                           std::string* error) {
  Result<std::unique_ptr<jit::Jit>> result = jit::Jit::compile(*lowered, *options, *made);
  if (result) return result->release();
  *error = result.error();
  return nullptr;
}

void bipc_jit_destroy(jit::Jit* jit) { delete jit; }

bool bipc_jit_emit(const lower::LoweredSystem* lowered, jit::OptLevel level, jit::Listing kind, std::string* out) {
  Result<std::string> text =
      kind == jit::Listing::Llvm ? jit::emit_llvm(*lowered, level) : jit::emit_asm(*lowered, level);
  *out = text ? std::move(*text) : text.error();
  return static_cast<bool>(text);
}

}  // extern "C"
