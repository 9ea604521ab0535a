// The output of commands for a compilation, and the resulting exit code.
#pragma once
#include <string>
#include <string_view>

#include "compiler/driver/options.hpp"
#include "compiler/driver/usage_error.hpp"
#include "compiler/pipeline/pipeline.hpp"

namespace bip::driver {

/// Decides colour from the choice, NO_COLOR and whether standard error is a terminal.
[[nodiscard]] bool wants_color(ColorChoice choice, int file_descriptor);

/// Writes to standard error, as it is.
void print_error_text(const std::string& text);
/// The same as print_error_words(), to standard output.
void print_words(std::string_view text);
/// Writes lines to standard error that hold words of the command line or of files: control characters, which could
/// drive the reader's terminal, are shown as U+FFFD. Ends the last line.
void print_error_words(std::string_view text);

/// Writes diagnostics and, if asked for, the time table to standard error. Call once, before a run starts.
/// 1 if there are errors (or warnings under --Werror), else 0; kOutputLost if JSON or SARIF could not be written whole.
[[nodiscard]] int report(const Compilation& c);

}  // namespace bip::driver
