// `bipc graph`: draws the System, or prints it as DOT or JSON.
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/emit_stage.hpp"
#include "compiler/driver/report.hpp"
#include "compiler/driver/page_title.hpp"
#include "compiler/driver/svg_to_png.hpp"
#include "compiler/pipeline/exit_codes.hpp"
#include "compiler/view/page.hpp"

namespace bip::driver {

namespace {

// Nothing, after a message: the name of the file does not say it.
std::optional<GraphFormat> format_of(const GraphArguments& arguments) {
  if (arguments.format != GraphFormat::BySuffix) return arguments.format;
  if (arguments.output.empty()) return GraphFormat::Dot;
  const std::string suffix = std::filesystem::path(arguments.output).extension().string();
  constexpr std::array<std::pair<std::string_view, GraphFormat>, 6> kSuffixes{{{".svg", GraphFormat::Svg},
                                                                               {".png", GraphFormat::Png},
                                                                               {".html", GraphFormat::Html},
                                                                               {".dot", GraphFormat::Dot},
                                                                               {".gv", GraphFormat::Dot},
                                                                               {".json", GraphFormat::Json}}};
  for (const auto& [name, format] : kSuffixes)
    if (suffix == name) return format;
  usage_error(fmt::format("the suffix of `{}` says no format: .svg, .png, .html, .dot or .json", arguments.output),
              "`--format` says it for any name");
  return std::nullopt;
}

}  // namespace

int command_graph(const GraphArguments& arguments) {
  const std::optional<GraphFormat> format = format_of(arguments);
  if (!format) return kUsage;
  Compilation c(arguments.compile);
  if (c.options.emit != EmitKind::None) {
    emit_stage(c, arguments.file, Optimisation::Auto);
    return report(c);
  }
  std::string text;
  if (compile(c, arguments.file, Stage::System) && check_outputs(c, {arguments.output})) {
    switch (*format) {
      case GraphFormat::BySuffix:
      case GraphFormat::Dot: text = graph::dot(*c.system, arguments.picture.show); break;
      case GraphFormat::Json: text = graph::json(*c.system, arguments.picture.show); break;
      case GraphFormat::Html:
        text = view::page(*c.system, page_title(*c.system, arguments.file), arguments.picture);
        break;
      case GraphFormat::Svg:
      case GraphFormat::Png: text = graph::svg(*c.system, arguments.picture); break;
    }
    if (*format == GraphFormat::Png) {
      Result<std::string> image = svg_to_png(text);
      if (!image) {
        (void)report(c);
        return usage_error(image.error());
      }
      text = std::move(*image);
    }
    if (arguments.output.empty()) {
      std::fwrite(text.data(), 1, text.size(), stdout);
    } else if (const auto written = write_file(arguments.output, text); !written) {
      c.diags.report(Diag::kB5004, {}, arguments.output, written.error());
    }
  }
  return report(c);
}

}  // namespace bip::driver
