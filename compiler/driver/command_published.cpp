// The published tools' calling convention, so that existing scripts keep working:
//   bipc -f FILE [-d 'Root()'] or bipc -p Package -I DIR -d 'Root()' [--gencpp-output DIR]
// Package a.b.C is a/b/C.bip below one of the -I folders. Without --gencpp-output it only checks.
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "compiler/driver/report.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/pipeline/load_packages.hpp"

namespace bip::driver {
namespace {

// The first that exists; else the first one tried, for the message.
std::string file_of(const PublishedArguments& arguments) {
  const std::string relative = file_of_package(arguments.package);
  std::string first;
  std::vector<std::string> folders = arguments.compile.folders;
  if (folders.empty()) folders.emplace_back(".");
  for (const std::string& folder : folders) {
    const std::string path = (std::filesystem::path(folder) / relative).lexically_normal().string();
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) return path;
    if (first.empty()) first = path;
  }
  return first;
}

}  // namespace

int command_published(const PublishedArguments& arguments) {
  for (const std::string& name : arguments.ignored)
    print_error_words(fmt::format("note: `{}` has no effect in bipc", name));
  CompileOptions compile = arguments.compile;
  compile.package = arguments.package;
  const std::string file = arguments.file.empty() ? file_of(arguments) : arguments.file;
  compile.folders.insert(compile.folders.end(), arguments.cpp_folders.begin(), arguments.cpp_folders.end());
  if (arguments.cpp_output.empty()) return command_check({.compile = compile, .files = {file}});
  EmitArguments emit;
  emit.compile = compile;
  emit.file = file;
  emit.directory = arguments.cpp_output;
  emit.has_no_main = arguments.has_no_main;
  emit.extra.sources = arguments.sources;
  emit.extra.objects = arguments.objects;
  for (const std::string& folder : arguments.link_folders)
    emit.link_folders.push_back(std::filesystem::absolute(folder).lexically_normal().string());
  emit.libraries = arguments.libraries;
  return command_emit(emit);
}

}  // namespace bip::driver
