// See check_outputs.hpp. Files are compared by device and number, so links are seen through.
#include "compiler/driver/check_outputs.hpp"

#include <algorithm>
#include <filesystem>

#include "compiler/base/write_file.hpp"
#include "compiler/pipeline/ffi_build.hpp"

namespace bip::driver {

namespace {

std::vector<std::string> inputs_of(Compilation& c) {
  std::vector<std::string> inputs{c.path};
  for (const auto& [file, path] : c.paths) inputs.push_back(path);
  for (std::uint32_t file = 0; file < c.sources.size(); ++file) inputs.push_back(c.sources.name(FileId(file)));
  if (c.system) {
    emit_cpp::CppBuild cpp;
    if (find_ffi_files(c, cpp)) {
      for (const auto* files : {&cpp.sources, &cpp.headers, &cpp.objects})
        inputs.insert(inputs.end(), files->begin(), files->end());
    }
  }
  return inputs;
}

namespace fs = std::filesystem;

// By the path as it is given or by what it leads to.
bool lies_in(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  for (fs::path path : {fs::absolute(file, error).lexically_normal(), fs::weakly_canonical(file, error)}) {
    for (; path.has_relative_path(); path = path.parent_path()) {
      if (is_same_file(path, folder)) return true;
    }
  }
  return false;
}

}  // namespace

bool check_outputs(Compilation& c, const std::vector<std::string>& outputs, const std::vector<std::string>& others) {
  std::error_code error;
  const auto is_file = [&](const std::string& path) { return !path.empty() && fs::is_regular_file(path, error); };
  if (std::none_of(outputs.begin(), outputs.end(), is_file)) return true;
  std::vector<std::string> inputs = inputs_of(c);
  inputs.insert(inputs.end(), others.begin(), others.end());
  bool is_sound = !c.diags.has_errors();
  for (const std::string& output : outputs) {
    if (!is_file(output)) continue;
    if (std::none_of(inputs.begin(), inputs.end(),
                     [&](const std::string& in) { return !in.empty() && is_same_file(in, output); }))
      continue;
    c.diags.report(Diag::kB5013, {}, output);
    is_sound = false;
  }
  return is_sound;
}

bool check_replaced_folder(Compilation& c, const std::string& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return true;
  const std::vector<std::string> inputs = inputs_of(c);
  if (std::none_of(inputs.begin(), inputs.end(),
                   [&](const std::string& in) { return !in.empty() && lies_in(in, folder); }))
    return !c.diags.has_errors();
  c.diags.report(Diag::kB5013, {}, folder);
  return false;
}

bool check_writable(Compilation& c, const std::vector<std::string>& outputs) {
  bool is_sound = true;
  for (const std::string& output : outputs) {
    if (output.empty() || output == "-") continue;
    if (const Result<bool> writable = can_be_written(output); !writable) {
      c.diags.report(Diag::kB5004, {}, output, writable.error());
      is_sound = false;
    }
  }
  return is_sound;
}

}  // namespace bip::driver
