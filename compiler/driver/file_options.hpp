// Which options of which command name files, and what the command does with these. One table for all commands: a unit
// test compares it with the command line, so that an option of a new command cannot be forgotten.
#pragma once
#include <span>
#include <string>

#include <CLI/CLI.hpp>

namespace bip::driver {

/// Source: part of the model, compared with outputs by check_outputs(). Updated: written, and it may take the place of
/// an input. Folder: a folder, or a place in which several files are written. Other: no file at all.
enum class FileRole : std::uint8_t { Source, Input, Output, Updated, Folder, Other };

struct FileOption {
  const char* command;
  const char* option;
  FileRole role;
};

[[nodiscard]] std::span<const FileOption> file_options();

/// Returns whether the help calls the value of the option a file or a folder; it must then have a row.
[[nodiscard]] bool names_file(const CLI::Option& option);

/// Returns the first option of the parsed command line whose file has no name, as it is shown; empty: there is none.
[[nodiscard]] std::string nameless_file(const CLI::App& command);

/// Compares the files that the parsed command line names. Returns a sentence about an output that is also an input or
/// another output, by whatever links; empty: there is none. Devices and pipes may be both.
[[nodiscard]] std::string file_conflict(const CLI::App& command);

}  // namespace bip::driver
