// The table of files that options name: it has all of them, and the conflicts that it finds.
#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "compiler/driver/cli_options.hpp"
#include "compiler/driver/file_options.hpp"
#include "tests/unit/base/scratch_folder.hpp"

using namespace bip;
using namespace bip::driver;

namespace {

std::string conflict_of(std::vector<std::string> words) {
  CLI::App app;
  Arguments arguments;
  add_commands(app, arguments, words.front());
  std::reverse(words.begin(), words.end());
  app.parse(std::move(words));
  return file_conflict(*app.get_subcommands().front());
}

}  // namespace

TEST_CASE("each option whose value is a file or a folder has a row, and each row an option") {
  CLI::App app;
  Arguments arguments;
  add_commands(app, arguments, "");
  std::size_t found = 0;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    for (const CLI::Option* option : command->get_options()) {
      if (!names_file(*option)) continue;
      INFO("file_options.cpp needs a row for " << command->get_name() << " " << option->get_name(true, true));
      const auto is_row = [&](const FileOption& row) {
        return row.command == command->get_name() && option->check_name(row.option);
      };
      CHECK(std::count_if(file_options().begin(), file_options().end(), is_row) == 1);
      ++found;
    }
  }
  CHECK(found == file_options().size());
}

TEST_CASE("an output that is an input or another output is named, by whatever links") {
  const testing::ScratchFolder folder;
  const std::string in = folder.path() + "/in", link = folder.path() + "/link", none = folder.path() + "/none";
  std::ofstream(in) << "text";
  std::filesystem::create_symlink("in", link);
  CHECK(conflict_of({"trace", "filter", "m.bip", in, "-o", link}) ==
        "-o would overwrite the file of TRACE, `" + in + "`");
  CHECK(conflict_of({"view", "m.bip", "--certificate", in, "-o", in}).find("the file of --certificate") !=
        std::string::npos);
  CHECK(conflict_of({"genom", "a.gen", "--codels", "b.c", "--codels", in, "-o", in}).find("--codels") !=
        std::string::npos);
  // Neither exists yet.
  CHECK(conflict_of({"run", "m.bip", "--trace", none, "--profile-json", folder.path() + "/./none"}) ==
        "--trace and --profile-json name the same file");
  CHECK(conflict_of({"run", "m.bip", "--trace", none, "--profile-json", in}).empty());
}

TEST_CASE("devices may be several outputs, and a checkpoint may replace the one that the run goes on from") {
  const testing::ScratchFolder folder;
  const std::string in = folder.path() + "/in";
  std::ofstream(in) << "text";
  CHECK(conflict_of({"run", "m.bip", "--trace", "/dev/null", "--profile-json", "/dev/null"}).empty());
  CHECK(conflict_of({"run", "m.bip", "--resume", in, "--checkpoint-file", in}).empty());
  CHECK_FALSE(conflict_of({"run", "m.bip", "--resume", in, "--trace", in}).empty());
  CHECK_FALSE(conflict_of({"run", "m.bip", "--checkpoint-file", in, "--trace", in}).empty());
}
