// What every program does at its beginning and at its end: bipc, emitted programs, the language server.
//
// A closed standard descriptor does not become the file that is opened next, what could not be written to standard
// output is an error, and running out of memory or of threads is an error with its own exit code, not an abort.
#pragma once

namespace bip {

/// The system refused memory, a thread or another resource (EX_OSERR of sysexits.h).
inline constexpr int kNoResources = 71;
/// Standard output, a trace or a record could not be written completely (EX_IOERR).
inline constexpr int kOutputLost = 74;

/// Runs `body` as the whole of a program and returns its exit code: that of `body`; kNoResources if memory or a
/// thread was missing and `body` had no answer to that, which is reported; kOutputLost if standard output could not be
/// written, which is reported as well.
[[nodiscard]] int run_process(int (*body)(int argc, char** argv), int argc, char** argv);

/// Opens the null device in the place of those of the descriptors 0 to 2 that are closed. Reading from them then ends
/// at once; writing to standard output fails, as it did before.
void hold_standard_descriptors();

/// Reports on standard error that standard output was lost, for the reason that the error's number gives (0: an earlier
/// one). Returns kOutputLost.
int report_lost_output(int error);

/// Writes what is buffered for standard output. Returns `code`, or kOutputLost after a report on standard error.
[[nodiscard]] int finish_standard_output(int code);

}  // namespace bip
