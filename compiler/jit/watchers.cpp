// See watchers.hpp. gdb reads objects with DWARF that are registered by its "JIT Compilation Interface" (GDB manual);
// perf reads a text file of addresses, sizes and names.
#include "compiler/jit/watchers.hpp"

#include <llvm/ExecutionEngine/JITLink/JITLink.h>
#include <llvm/ExecutionEngine/Orc/DebugObjectManagerPlugin.h>
#include <llvm/ExecutionEngine/Orc/EPCDebugObjectRegistrar.h>
#include <llvm/ExecutionEngine/Orc/ObjectLinkingLayer.h>
#include <llvm/ExecutionEngine/Orc/TargetProcess/JITLoaderGDB.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>

namespace bip::jit {

namespace {

using llvm::orc::ObjectLinkingLayer;

class PerfMap : public ObjectLinkingLayer::Plugin {
 public:
  explicit PerfMap(std::map<std::string, std::string> labels) : labels_(std::move(labels)) {}

  void modifyPassConfig(llvm::orc::MaterializationResponsibility&, llvm::jitlink::LinkGraph&,
                        llvm::jitlink::PassConfiguration& passes) override {
    // Addresses are final then.
    passes.PostFixupPasses.push_back([this](llvm::jitlink::LinkGraph& graph) {
      write(graph);
      return llvm::Error::success();
    });
  }
  llvm::Error notifyFailed(llvm::orc::MaterializationResponsibility&) override { return llvm::Error::success(); }
  llvm::Error notifyRemovingResources(llvm::orc::JITDylib&, llvm::orc::ResourceKey) override {
    return llvm::Error::success();
  }
  void notifyTransferringResources(llvm::orc::JITDylib&, llvm::orc::ResourceKey, llvm::orc::ResourceKey) override {}

 private:
  // Several compilations of one process add to one file.
  void write(llvm::jitlink::LinkGraph& graph) const {
    // perf prescribes the name, in a folder in which every user can create a link or a file.
    const std::string path = "/tmp/perf-" + std::to_string(::getpid()) + ".map";
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (descriptor < 0) return;
    struct stat status {};
    const bool is_ours = ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
                         status.st_nlink == 1;
    std::FILE* const file = is_ours ? ::fdopen(descriptor, "a") : nullptr;
    if (file == nullptr) {
      ::close(descriptor);
      return;
    }
    for (const llvm::jitlink::Symbol* symbol : graph.defined_symbols()) {
      if (!symbol->isCallable() || !symbol->hasName() || symbol->getSize() == 0) continue;
      const std::string name = symbol->getName().str();
      const auto label = labels_.find(name);
      std::fprintf(file, "%llx %llx %s\n", static_cast<unsigned long long>(symbol->getAddress().getValue()),
                   static_cast<unsigned long long>(symbol->getSize()),
                   label == labels_.end() ? name.c_str() : label->second.c_str());
    }
    std::fclose(file);
  }

  std::map<std::string, std::string> labels_;
};

}  // namespace

llvm::Error let_watch(llvm::orc::LLJIT& engine, std::map<std::string, std::string> labels) {
  auto* const linking = llvm::dyn_cast<ObjectLinkingLayer>(&engine.getObjLinkingLayer());
  if (linking == nullptr)
    return llvm::createStringError(llvm::inconvertibleErrorCode(), "this machine's linker does not announce its code");
  llvm::orc::ExecutionSession& session = engine.getExecutionSession();
  // The function is in libLLVM, whose names the process does not see: so it gets the address.
  auto registrar = std::make_unique<llvm::orc::EPCDebugObjectRegistrar>(
      session, llvm::orc::ExecutorAddr::fromPtr(&llvm_orc_registerJITLoaderGDBWrapper));
  linking->addPlugin(std::make_shared<llvm::orc::DebugObjectManagerPlugin>(session, std::move(registrar), true, true));
  linking->addPlugin(std::make_shared<PerfMap>(std::move(labels)));
  return llvm::Error::success();
}

}  // namespace bip::jit
