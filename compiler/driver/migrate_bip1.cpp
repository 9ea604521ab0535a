// See migrate_bip1.hpp. What compiler/migrate wrote is parsed and printed, as `bipc fmt` does.
#include "compiler/driver/migrate_bip1.hpp"

#include <filesystem>
#include <fstream>

#include "compiler/base/stage_scope.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/genom_files.hpp"
#include "compiler/migrate/write_bip2.hpp"
#include "compiler/parse/bip1/parse_bip1.hpp"

namespace bip::driver {
namespace {

constexpr std::string_view kWrittenByMigrate = "// C code of the BIP1 model `";

bool is_of_somebody_else(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return false;
  std::string begin(kWrittenByMigrate.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return in.gcount() != static_cast<std::streamsize>(begin.size()) || begin != kWrittenByMigrate;
}

}  // namespace

std::optional<Bip1Migration> migrate_bip1(pipeline::Compilation& c, const std::string& output) {
  const StageScope doing("migrating", c.path);
  const std::optional<syntax::bip1::Model> model = parse::parse_bip1(c.sources, c.file, c.diags);
  if (!model) return std::nullopt;
  const std::filesystem::path at(output);
  const std::string stem = at.stem().string() + "_code";
  migrate::Bip2Text made = migrate::write_bip2(*model, c.sources, stem, c.diags);
  return Bip1Migration{formatted(made.bip), std::move(made.header), std::move(made.source),
                       (at.parent_path() / (stem + ".hpp")).string(), (at.parent_path() / (stem + ".cpp")).string()};
}

bool write_cpp_files(pipeline::Compilation& c, const Bip1Migration& migration) {
  if (migration.source.empty()) return true;
  for (const std::string& path : {migration.header_path, migration.source_path}) {
    if (is_of_somebody_else(path)) {
      c.diags.report(Diag::kB5004, {}, path, "it is there, and `bipc migrate` did not write it");
      return false;
    }
  }
  for (const auto& [path, text] :
       {std::pair(migration.header_path, migration.header), std::pair(migration.source_path, migration.source)}) {
    const Result<bool> written = write_file(path, text);
    if (written) continue;
    c.diags.report(Diag::kB5004, {}, path, written.error());
    return false;
  }
  return true;
}

}  // namespace bip::driver
