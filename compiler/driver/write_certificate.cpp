// See write_certificate.hpp.
#include "compiler/driver/write_certificate.hpp"

#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/pipeline/exit_codes.hpp"

namespace bip::driver {

void write_certificate(pipeline::Compilation& c, const std::string& path, const library::Verdict& verdict) {
  if (path.empty()) return;
  if (!verdict.certificate.empty()) {
    if (const Result<bool> written = write_file(path, verdict.certificate); !written)
      c.diags.report(Diag::kB5004, {}, path, written.error());
    return;
  }
  std::error_code error;
  if (verdict.exit_code != pipeline::kViolated || !std::filesystem::is_regular_file(path, error)) return;
  if (std::filesystem::remove(path, error)) {
    print_error_words(fmt::format("note: `{}` held an earlier certificate and was removed", path));
  } else {
    c.diags.report(Diag::kB5004, {}, path, error.message());
  }
}

}  // namespace bip::driver
