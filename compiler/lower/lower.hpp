// From the System to the runtime's image: layout of cells, bindings as offsets, one code unit per guard, action or
// transfer of a type. All executors start here.
#pragma once
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "compiler/lower/results.hpp"
#include "compiler/lower/step_shapes.hpp"
#include "compiler/system/system_ids.hpp"
#include "runtime/include/bip/image_time.hpp"
#include "runtime/include/bip/ffi_state.hpp"

namespace bip::lower {

enum class CodeKind : std::uint8_t { Guard, Action };
enum class CodeOwner : std::uint8_t { Atom, Connector, Priority };
/// Row k describes Image::codes[k].
struct CodeUnit {
  CodeKind kind = CodeKind::Guard;
  CodeOwner owner = CodeOwner::Atom;
  std::uint32_t owner_row = 0;  // AtomTypeId, ConnectorTypeId or PriorityId
  std::string name;             // unique C identifier, readable: "Fork_on_take_from_free_guard"
  ExprId expr;                  // Guard
  StmtId body;                  // Action
  Loc loc{};
};

/// Owns what an Image points to. `codes` starts empty (null functions); an executor fills it before running.
struct LoweredSystem {
  const System* system = nullptr;   // must outlive this
  const CodeTable* code = nullptr;  // of the system
  std::vector<CodeUnit> units;
  std::vector<rt::Code> codes;              // one a unit
  std::vector<std::uint32_t> site_of_expr;  // by ExprId: row of Image::sites, or rt::kNone if it cannot fault
  rt::Image image;                          // image.codes points to `codes`
  // The FFI. The code that compiles it fills `functions` (one a row of CodeTable::functions) and `ffi_types`.
  std::vector<rt::FfiFunction> functions;
  void* library = nullptr;  // of the C++ that the model calls, as dlopen() gave it
  std::vector<rt::FfiType> ffi_types;
  std::vector<rt::EventClass> event_classes;  // one an EventClassUse
  Results results;
  rt::FfiState ffi;
  // Compiled steps: shapes that derive_steps found, and a function each if an executor made them.
  Steps steps;
  std::vector<rt::StepFn> step_fns;
  // Step functions call their pieces by the rows of `codes`, if a profile counts each call (rt::Profile); else they are
  // inlined.
  bool calls_rows = false;
  struct Pools;
  std::unique_ptr<Pools, void (*)(Pools*)> pools{nullptr, nullptr};  // owner of all arrays behind `image`
};

[[nodiscard]] std::unique_ptr<LoweredSystem> lower(const System& system, const std::string& name);

}  // namespace bip::lower
