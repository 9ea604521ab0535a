// See page.hpp.
#include "compiler/view/page.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/graph/picture.hpp"
#include "compiler/system/system.hpp"
#include "compiler/view/page_files.hpp"

namespace bip::view {
namespace {

using Json = nlohmann::ordered_json;

std::string svg_of(const graph::Picture& picture) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\">\n{2}</svg>",
      graph::coordinate(picture.width), graph::coordinate(picture.height), picture.elements);
}

/// Compounds below the root, at most: 0 if there is none.
std::uint64_t depth_of(const System& system) {
  std::vector<std::uint64_t> depth(system.compounds.size(), 0);
  std::uint64_t deepest = 0;
  for (std::size_t k = 1; k < system.compounds.size(); ++k) {
    BIP_ASSERT(system.compounds[CompoundId(k)].parent.value < k, "compound {} comes before the one around it", k);
    depth[k] = depth[system.compounds[CompoundId(k)].parent.value] + 1;
    deepest = std::max(deepest, depth[k]);
  }
  return deepest;
}

Json model_json(const System& system) {
  Json out{{"atoms", Json::array()}, {"types", Json::array()}, {"connectors", Json::array()}};
  for (const Atom& atom : system.atoms) out["atoms"].push_back({atom.path, atom.type.value});
  for (const AtomType& type : system.atom_types) {
    Json variables = Json::array(), ports = Json::array();
    for (std::size_t k = 0; k < type.visible_variables(); ++k) variables.push_back(type.variables[k].name);
    for (const Port& port : type.ports) ports.push_back(port.name);
    out["types"].push_back({{"name", type.name}, {"places", type.places}, {"variables", variables}, {"ports", ports}});
  }
  for (const Connector& connector : system.connectors) out["connectors"].push_back(connector.path);
  return out;
}

/// JSON in a script element: nothing in it can end the element.
std::string script_json(const Json& json) {
  std::string out;
  for (const char c : json_line(json)) {
    if (c == '<') out += "\\u003c";
    else out += c;
  }
  return out;
}

}  // namespace

std::string page(const System& system, const std::string& title, const graph::PictureOptions& options, const Json& run,
                 const PageOptions& more) {
  const bool is_live = !more.connects_to.empty();
  Json data = model_json(system);
  data["title"] = title;
  const bool is_attached = !more.attached_role.empty();
  if (is_attached) data["attached"] = more.attached_role;
  else if (is_live) data["live"] = true;
  if (!more.proof.is_null()) data["proof"] = more.proof;
  data["run"] = run;
  std::string templates;
  std::size_t count = 0, first = 0;
  const std::uint64_t last = std::max<std::uint64_t>(1, std::min(depth_of(system) + 1, options.depth));
  for (std::uint64_t depth = 1; depth <= last; ++depth) {
    graph::PictureOptions level = options;
    const bool is_whole = depth == last;
    if (!is_whole) level.depth = depth;
    const std::string picture = svg_of(graph::structure_picture(system, level));
    if (count > 0 && picture.size() > kMostPicture) break;
    // The first picture that a person sees is the deepest one that a browser shows at once.
    if (count == 0 || picture.size() <= kMostFirstPicture) first = count;
    templates +=
        fmt::format("<template data-level=\"{}\">{}</template>\n",
                    is_whole ? "everything" : fmt::format("{} level{}", depth, depth == 1 ? "" : "s"), picture);
    ++count;
  }
  BIP_ASSERT(first < count, "picture {} of {} is shown first", first, count);
  data["level"] = first;
  for (std::size_t row = 0; row < system.atom_types.size(); ++row)
    templates += fmt::format("<template data-type=\"{}\">{}</template>\n", row,
                             svg_of(graph::automaton_picture(system, AtomTypeId(row))));
  std::string out =
      fmt::format("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{}</title>\n",
                  graph::escaped_markup(title));
  out += "<meta name=\"viewport\" content=\"width=device-width\">\n";
  // No request leaves the page, whatever is in it; a live one has its session. Browsers ask for an icon if there is
  // none.
  out +=
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; "
      "script-src 'unsafe-inline'; img-src data:";
  if (is_live) out += "; connect-src " + graph::escaped_markup(more.connects_to);
  out += "\">\n";
  if (is_live) out += "<link rel=\"icon\" href=\"data:,\">\n";
  out += fmt::format("<style>\n{}{}</style>\n</head>\n<body>\n{}", graph::picture_styles(), k_page_css, k_page_html);
  out += templates;
  out += "<script id=\"data\" type=\"application/json\">" + script_json(data) + "</script>\n";
  std::vector<std::string_view> scripts{k_run_js, k_picture_js, k_charts_js, k_steps_js};
  if (!more.proof.is_null()) scripts.push_back(k_proof_js);
  if (is_live || is_attached) scripts.push_back(k_connection_js);
  if (is_attached) scripts.push_back(k_attached_js);
  else if (is_live) scripts.push_back(k_live_js);
  scripts.push_back(k_page_js);
  for (const std::string_view script : scripts) out += fmt::format("<script>\n{}</script>\n", script);
  return out + "</body>\n</html>\n";
}

}  // namespace bip::view
