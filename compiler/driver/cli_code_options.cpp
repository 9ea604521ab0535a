// Options of `bipc run` about machine code and about watching it: see cli_options.hpp.
#include "compiler/driver/cli_options.hpp"

namespace bip::driver {

void add_code_options(CLI::App& command, RunArguments& a) {
  CLI::Option* explores = command.get_option("--explore");
  command.add_flag("--profile", a.profile, "where the time went, at the end: by interaction, type, guard and action")->excludes(explores);
  command.add_option("--profile-json", a.profile_path, "the same as JSON to PATH")->type_name("PATH")->excludes(explores);
}

}  // namespace bip::driver
