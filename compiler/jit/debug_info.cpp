// See debug_info.hpp. Variables are not described, because they are cells of the core; `bipc serve` and traces show
// them by name.
#include "compiler/jit/debug_info.hpp"

#include <llvm/BinaryFormat/Dwarf.h>
#include <llvm/IR/DebugInfoMetadata.h>
#include <llvm/Support/FileSystem.h>
#include <llvm/Support/Path.h>

namespace bip::jit {

namespace {

Loc to_model(rt::SourceLine loc) { return {.file = loc.file, .line = loc.line, .column = loc.column}; }

}  // namespace

Place unit_place(const lower::LoweredSystem& lowered, std::size_t unit) {
  return {lowered.units[unit].name, lowered.units[unit].loc};
}

// Interactions are numbered as the runtime does: the connectors that export nothing, then the atoms' internal ports.
std::vector<Place> shape_places(const lower::LoweredSystem& lowered) {
  const rt::Image& image = lowered.image;
  std::vector<Place> of_interaction;
  for (const rt::Connector& connector : image.connectors) {
    const rt::ConnectorType& type = image.connector_types[connector.type];
    if (!type.exports) of_interaction.push_back({std::string("step_") + type.name, to_model(connector.loc)});
  }
  for (const rt::Atom& atom : image.atoms) {
    const rt::AtomType& type = image.atom_types[atom.type];
    for (const rt::Port& port : type.ports) {
      if (!port.exported)
        of_interaction.push_back({std::string("step_") + type.name + "_" + port.name, to_model(port.loc)});
    }
  }
  std::vector<Place> places(lowered.steps.shapes.size());
  for (const rt::StepRun& run : lowered.steps.runs) {
    if (places[run.shape].name.empty() && run.first < of_interaction.size())
      places[run.shape] = of_interaction[run.first];
  }
  const lower::InnerStepRows& inner = lowered.steps.inner;
  for (std::size_t k = 0; k < inner.interactions.size(); ++k) {
    if (inner.run_of[k] == rt::kNone) continue;
    Place& place = places[inner.runs[inner.run_of[k]].shape];
    if (place.name.empty() && inner.interactions[k] < of_interaction.size())
      place = of_interaction[inner.interactions[k]];
  }
  return places;
}

DebugInfo::DebugInfo(llvm::Module& module, const rt::Image& image) : image_(image), builder_(module) {
  module.addModuleFlag(llvm::Module::Warning, "Debug Info Version", llvm::DEBUG_METADATA_VERSION);
  module.addModuleFlag(llvm::Module::Warning, "Dwarf Version", 4);
  unit_ = builder_.createCompileUnit(llvm::dwarf::DW_LANG_C, file(0), "bipc", true, "", 0);
}

// With the folder, so that a debugger finds it from anywhere.
llvm::DIFile* DebugInfo::file(std::uint32_t row) {
  llvm::DIFile*& known = files_[row];
  if (known != nullptr) return known;
  llvm::SmallString<256> path(row < image_.files.size ? image_.files[row] : "model.bip");
  (void)llvm::sys::fs::make_absolute(path);
  known = builder_.createFile(llvm::sys::path::filename(path), llvm::sys::path::parent_path(path));
  return known;
}

void DebugInfo::enter(llvm::Function& function, const std::string& name, Loc loc) {
  llvm::DISubroutineType* type = builder_.createSubroutineType(builder_.getOrCreateTypeArray({}));
  llvm::DIFile* in = file(loc.file);
  function.setSubprogram(
      builder_.createFunction(in, name, "", in, loc.line, type, loc.line, llvm::DINode::FlagZero,
                              llvm::DISubprogram::SPFlagDefinition | llvm::DISubprogram::SPFlagOptimized));
}

llvm::DebugLoc DebugInfo::at(const llvm::Function& function, Loc loc) const {
  return llvm::DILocation::get(function.getContext(), loc.line, loc.column, function.getSubprogram());
}

}  // namespace bip::jit
