// Names of a module become indices; what the description leaves open is taken from the side file.
//
// Side file, a line each, `#` begins a comment; `Module.Name` where two modules have the name:
//   codel NAME yields A B …      what a codel really returns: states, or OK and ERROR of control and permanent
//                                codels; OTHER is an answer that its state does not permit
//   codel NAME async [TIME]      it runs beside its task; when TIME is over it is given up
//   codel NAME takes TIME        who waits for it waits so long at most: a profile tells how often it took longer,
//                                rules may ask it of codels of activities
//   trigger SERVICE waits        a constraint may make the trigger of SERVICE wait
//   task TASK reads MODULE.POSTER … [within AGE]
//                                its cycle begins only with posters that are younger, in steps of PosterAge
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/genom/module.hpp"
#include "compiler/genom/tokens.hpp"

namespace bip::genom {

struct SideLine {
  std::string kind;  // "codel", "async", "takes", "trigger", "request", "task"
  Name subject;
  std::vector<Name> words;
  bool used = false;
  std::int64_t within = 0;  // of a task's posters: the age
};
/// Reads a side file; what is no line of it is reported.
[[nodiscard]] std::vector<SideLine> parse_side_file(const SourceMap& sources, FileId file, Diagnostics& diags);

/// Checks and connects the names of `module`, applies the lines that are about it (and marks them as used), and gives
/// every service its number of instances. In the execution flavour codels are not narrowed, and may answer nonsense. A
/// service that interrupts itself needs one more: the new one waits for the old.
void resolve(Module& module, std::vector<SideLine>& side, std::size_t instances, Flavour flavour, Diagnostics& diags);

/// Lines of the side file that were about nothing.
void report_unused(const std::vector<SideLine>& side, Diagnostics& diags);

}  // namespace bip::genom
