// See svg_to_png.hpp.
#include "compiler/driver/svg_to_png.hpp"

#include "compiler/base/read_file.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/pipeline/host_compiler.hpp"

namespace bip::driver {

Result<std::string> svg_to_png(const std::string& svg) {
  Result<pipeline::TemporaryDirectory> directory = pipeline::TemporaryDirectory::make();
  if (!directory) return Failure{directory.error()};
  const std::string from = directory->path() + "/picture.svg", to = directory->path() + "/picture.png";
  if (const auto written = write_file(from, svg, Durability::Unsynced); !written) return Failure{written.error()};
  const Result<int> code = pipeline::run_program({"rsvg-convert", "--unlimited", "--zoom", "2", "--output", to, from});
  if (!code)
    return Failure{
        "PNG needs the program `rsvg-convert`, which could not be started\n"
        "  = help: Debian's package librsvg2-bin has it; browsers and office programs read SVG as well"};
  if (*code != 0)
    return Failure{"`rsvg-convert` made no PNG of the picture; `-o` with the suffix .svg writes it as SVG"};
  std::optional<std::string> image = read_file(to);
  if (!image) return Failure{"`rsvg-convert` wrote no file"};
  return std::move(*image);
}

}  // namespace bip::driver
