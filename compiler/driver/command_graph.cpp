// `bipc graph`: draws the System, or robot modules, or prints them as DOT or JSON.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "bip/assert.hpp"
#include "compiler/base/write_file.hpp"
#include "compiler/driver/check_outputs.hpp"
#include "compiler/driver/commands.hpp"
#include "compiler/driver/describe_modules.hpp"
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

// The text of the picture; nothing if there are errors.
std::string module_text(Compilation& c, const GraphArguments& arguments, GraphFormat format) {
  GenomArguments level;
  level.compile = arguments.compile;
  level.files = arguments.files;
  level.side_file = arguments.side_file;
  level.defines = arguments.defines;
  const std::optional<graph::ModuleGraph> modules = describe_modules(c, level);
  if (!modules) return {};
  if (format == GraphFormat::Json) return graph::json(*modules);
  return format == GraphFormat::Dot ? graph::dot(*modules) : graph::svg(*modules);
}

std::string system_text(Compilation& c, const GraphArguments& arguments, GraphFormat format) {
  const std::string& file = arguments.files.front();
  if (!compile(c, file, Stage::System)) return {};
  graph::PictureOptions picture = arguments.picture;
  picture.show = arguments.shown == Shown::Structure  ? graph::Show::Structure
                 : arguments.shown == Shown::Automata ? graph::Show::Automata
                                                      : graph::Show::All;
  switch (format) {
    case GraphFormat::BySuffix:
    case GraphFormat::Dot: return graph::dot(*c.system, picture.show);
    case GraphFormat::Json: return graph::json(*c.system, picture.show);
    case GraphFormat::Html: return view::page(*c.system, page_title(*c.system, file), picture);
    case GraphFormat::Svg:
    case GraphFormat::Png: return graph::svg(*c.system, picture);
  }
  BIP_UNREACHABLE("a format of pictures");
}

// Empty, or what of the command line does not go together, and the way out.
std::pair<std::string, std::string> usage_of(const GraphArguments& arguments, GraphFormat format) {
  const std::vector<std::string>& files = arguments.files;
  if (arguments.shown == Shown::Modules) {
    const auto model = std::find_if_not(files.begin(), files.end(), describes_modules);
    if (model != files.end())
      return {fmt::format("`--show modules` is of robot modules, and `{}` is no description of them", *model),
              "a .gen or .rules file"};
    const auto is_rules = [](const std::string& file) { return file.ends_with(".rules"); };
    if (files.size() > 1 && std::any_of(files.begin(), files.end(), is_rules))
      return {"a .rules file names its modules", "give it alone"};
    if (format == GraphFormat::Html) return {"robot modules have no page", "`--format` svg, png, dot or json"};
    return {};
  }
  if (files.size() > 1) return {"a picture is of one model", "`--show modules` takes several descriptions of modules"};
  if (describes_modules(files.front()))
    return {fmt::format("`{}` describes robot modules", files.front()), "`--show modules` draws them"};
  if (!arguments.side_file.empty() || !arguments.defines.empty())
    return {"`--yields` and `-D` are of robot modules", "`--show modules`"};
  return {};
}

}  // namespace

int command_graph(const GraphArguments& arguments) {
  const std::optional<GraphFormat> format = format_of(arguments);
  if (!format) return kUsage;
  if (const auto [problem, help] = usage_of(arguments, *format); !problem.empty()) return usage_error(problem, help);
  Compilation c(arguments.compile);
  if (c.options.emit != EmitKind::None) {
    emit_stage(c, arguments.files.front(), Optimisation::Auto);
    return report(c);
  }
  std::string text =
      arguments.shown == Shown::Modules ? module_text(c, arguments, *format) : system_text(c, arguments, *format);
  if (c.diags.has_errors() || !check_outputs(c, {arguments.output})) return report(c);
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
  return report(c);
}

}  // namespace bip::driver
