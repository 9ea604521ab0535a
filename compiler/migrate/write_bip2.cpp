// See write_bip2.hpp.
#include "compiler/migrate/write_bip2.hpp"

#include "compiler/migrate/bip2_writer.hpp"

namespace bip::migrate {

Bip2Text write_bip2(const syntax::bip1::Model& model, const SourceMap& sources, const std::string& stem,
                    Diagnostics& diags) {
  Bip2Writer writer(model, sources, diags);
  Bip2Text made;
  made.bip = writer.run(stem);
  if (writer.cpp().is_empty()) return made;
  const std::string name(model.name.text);
  made.header = writer.cpp().header(name);
  made.source = writer.cpp().source(name, stem + ".hpp");
  return made;
}

}  // namespace bip::migrate
