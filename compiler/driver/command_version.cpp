// `bipc version`: what this program is and where it found its parts, for bug reports and for programs that start it.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "compiler/base/json_text.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/pipeline/host_compiler.hpp"
#include "compiler/pipeline/parts.hpp"
#include "compiler/pipeline/jit_loader.hpp"
#include "compiler/pipeline/load_packages.hpp"

namespace bip::driver {
namespace {

// Absent parts are null.
nlohmann::ordered_json text_or_null(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(text);
}

std::string as_json(const VersionArguments& built) {
  const RuntimeLocation runtime = find_runtime();
  const std::string plugin = find_jit_plugin();
  const bool has_jit = static_cast<bool>(load_jit());
  nlohmann::ordered_json back_ends = nlohmann::ordered_json::array();
  if (has_jit) back_ends.push_back("jit");
  back_ends.push_back("interp");
  back_ends.push_back("c++");
  const nlohmann::ordered_json json{{"format", "bipc-version"},
                                    {"version", BIPC_VERSION},
                                    {"commit", text_or_null(built.commit)},
                                    {"llvm", text_or_null(has_jit ? built.llvm_version : "")},
                                    {"back_ends", std::move(back_ends)},
                                    {"paths",
                                     {{"program", text_or_null(program_file().string())},
                                      {"jit", text_or_null(plugin)},
                                      {"runtime", text_or_null(runtime.directory)},
                                      {"runtime_library", text_or_null(runtime.library)},
                                      {"stdlib", text_or_null(find_stdlib())}}}};
  return indented_json(json) + '\n';
}

}  // namespace

int command_version(const VersionArguments& arguments) {
  switch (arguments.format) {
    case VersionFormat::Json: std::fputs(as_json(arguments).c_str(), stdout); return kOk;
    case VersionFormat::Text: break;
  }
  std::printf("bipc %s\n", BIPC_VERSION);
  std::printf("back ends: %sinterp, c++\n", load_jit() ? "jit, " : "");
  return kOk;
}

}  // namespace bip::driver
