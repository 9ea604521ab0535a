// The pipeline of a translation, one line per stage.
#include "compiler/genom/translate.hpp"

#include <algorithm>

#include "compiler/genom/c_codels.hpp"
#include "compiler/genom/check_data.hpp"
#include "compiler/genom/codel_mapping.hpp"
#include "compiler/genom/names.hpp"
#include "compiler/genom/parse_genom.hpp"
#include "compiler/genom/standard_services.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

// Types of all modules stand in one package, and begin with the module's name.
void check_module_names(const std::vector<Module>& modules, Diagnostics& diags) {
  for (std::size_t i = 0; i < modules.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!modules[i].name.is_set() || type_name(modules[i].name.text) != type_name(modules[j].name.text)) continue;
      diags.report(Diag::kB6013, modules[i].name.range, "module", modules[i].name.text)
          .label(modules[j].name.range, "the first one");
    }
  }
}

// Posters that a side file names.
void check_reads(const std::vector<Module>& modules, Diagnostics& diags) {
  std::vector<std::string> known;
  for (const Module& m : modules) {
    for (const Poster& p : m.posters) known.push_back(m.name.text + "." + p.name.text);
  }
  for (const Module& m : modules) {
    for (const Task& t : m.tasks) {
      for (const Name& read : t.reads) {
        if (std::find(known.begin(), known.end(), read.text) != known.end()) continue;
        auto d = diags.report(Diag::kB6008, read.range, "poster", read.text);
        for (const std::string& similar : similar_names(read.text, known))
          d.help(fmt::format("there is `{}`", similar), read.range, similar);
      }
    }
  }
}

void find_port_types(Module& module, const idl::Component& component) {
  for (Port& port : module.ports) {
    const auto declared = std::find_if(component.ports.begin(), component.ports.end(),
                                       [&](const idl::Port& p) { return p.name == port.name; });
    if (declared == component.ports.end()) continue;
    port.type = component.types[declared->type].c_name;
    port.is_multiple = declared->is_multiple;
  }
}

}  // namespace

Module read_module(SourceMap& sources, const Description& description, const PreprocessOptions& options,
                   Diagnostics& diags, Types types) {
  const Preprocessed text = preprocess(sources, description.path, description.file, options, diags);
  const Headers headers = text.header_missing ? Headers::Missing : Headers::Found;
  if (!is_genom3(text.tokens)) return parse_genom2(text.tokens, headers, diags);
  Module module = parse_genom3(text.tokens, description.file, headers, diags);
  // A header that is not there may have declared whatever is not known.
  if (diags.has_errors() || (types == Types::Skipped && module.is_open)) return module;
  std::optional<idl::Component> component = idl::read_idl(
      text.tokens, description.file, types == Types::Read ? idl::Purpose::Codels : idl::Purpose::Check, diags);
  if (component) find_port_types(module, *component);
  if (component && check_data(*component, diags) && types == Types::Read) module.component = std::move(component);
  return module;
}

std::optional<std::vector<Module>> read_modules(SourceMap& sources, const std::vector<Description>& files,
                                                std::vector<SideLine> side, const TranslateOptions& options,
                                                Diagnostics& diags) {
  std::vector<Module> modules;
  for (const Description& d : files)
    modules.push_back(
        read_module(sources, d, options.preprocess, diags, options.generate.calls_c ? Types::Read : options.types));
  if (options.generate.calls_c) {
    find_mappings(modules, options.codel_files, diags);
    for (Module& m : modules) {
      if (m.component) add_standard_services(m);
    }
  }
  for (Module& m : modules) resolve(m, side, options.instances, options.generate.flavour, diags);
  report_unused(side, diags);
  check_module_names(modules, diags);
  check_reads(modules, diags);
  if (diags.has_errors() || (options.generate.calls_c && !check_c_codels(modules, diags))) return std::nullopt;
  for (const Module& m : modules) {
    if (m.services.empty()) diags.report(Diag::kB6026, m.name.range, m.name.text);
  }
  return modules;
}

std::string package_of(const std::vector<Module>& modules) {
  BIP_ASSERT(!modules.empty(), "a package of no modules");
  return bip_name(modules.front().name.text);
}

Translation write_package(const std::vector<Module>& modules, const GenerateOptions& options) {
  Translation result{generate(modules, options), {}, {}, {}};
  if (options.calls_c) result.c_files = c_codel_files(modules, options);
  else if (options.flavour == Flavour::Execution) {
    result.codel_header = codel_header(modules, options);
    result.codel_source = codel_source(modules, options);
  }
  return result;
}

}  // namespace bip::genom
