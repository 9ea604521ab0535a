// DWARF debug information for a module: functions and lines of the model. Internal to jit/.
#pragma once
#include <llvm/IR/DIBuilder.h>
#include <llvm/IR/Module.h>

#include <map>
#include <string>
#include <vector>

#include "compiler/lower/lower.hpp"

namespace bip::jit {

/// Where a unit, or the connector (else the internal port) of the first interaction of a shape of steps, is declared.
struct Place {
  std::string name;
  Loc loc;
};
[[nodiscard]] Place unit_place(const lower::LoweredSystem& lowered, std::size_t unit);
/// By shape.
[[nodiscard]] std::vector<Place> shape_places(const lower::LoweredSystem& lowered);

class DebugInfo {
 public:
  DebugInfo(llvm::Module& module, const rt::Image& image);
  /// The function is at this place of the model; `name` is what a person reads.
  void enter(llvm::Function& function, const std::string& name, Loc loc);
  /// A place within a function that was entered.
  [[nodiscard]] llvm::DebugLoc at(const llvm::Function& function, Loc loc) const;
  /// After all functions are built.
  void finish() { builder_.finalize(); }

 private:
  llvm::DIFile* file(std::uint32_t row);
  const rt::Image& image_;
  llvm::DIBuilder builder_;
  llvm::DICompileUnit* unit_ = nullptr;
  std::map<std::uint32_t, llvm::DIFile*> files_;
};

}  // namespace bip::jit
