// A text with one system, or with those of several sizes: of each below the least one of which rows say how it grows,
// with a certificate of its own; of that one, with the certificate for all from it on; and greater ones, which must be
// what the rows say.
#include <list>

#include "tools/certcheck/checked_model.hpp"

namespace certcheck {
namespace {

std::string systems_checked(const std::list<Model>& models, std::istream& text, z3::context& z) {
  std::map<int, const Model*> by_size;
  const Tree* grows = nullptr;
  int least = 0;
  for (const Model& model : models) {
    const Tree &for_all = model.tree["for-all"], &size = model.tree["size"];
    if (for_all.items.empty() == size.items.empty()) throw Rejected("a system among several does not say its size");
    const Tree& row = for_all.items.empty() ? size : for_all;
    if (!by_size.emplace(row.at(2).number(), &model).second) throw Rejected("a size twice");
    if (for_all.items.empty()) continue;
    if (grows != nullptr) throw Rejected("two systems say how they grow");
    grows = &for_all;
    least = row.at(2).number();
  }
  if (grows == nullptr) throw Rejected("no system says how it grows");
  const int first = by_size.begin()->first;
  std::vector<const Model*> described;
  std::string small, compared;
  for (const auto& [size, model] : by_size) {
    if (size >= least) {
      described.push_back(model);
      if (size > least) compared += (compared.empty() ? "" : ", ") + std::to_string(size);
      continue;
    }
    if (!by_size.contains(size + 1)) throw Rejected("no system of size " + std::to_string(size + 1));
    const Certificate certificate = read_certificate(*model, text, Last::No);
    if (certificate.claim != "deadlock-free") throw Rejected("the claim " + quoted(certificate.claim));
    (void)check(*model, certificate, z);
    small += (small.empty() ? "" : ", ") + std::to_string(size);
  }
  const Certificate certificate = read_certificate(*described[0], text);
  check_words(described, certificate, z);
  const std::string name(grows->at(1).text);
  return "every " + name + " >= " + std::to_string(first) +
         (small.empty() ? "" : "; " + name + " = " + small + " alone") + "; from " + std::to_string(least) + " on " +
         std::to_string(certificate.set_rows.size()) + " rows of sets" +
         (compared.empty() ? "" : "; it grows as said at " + compared);
}

}  // namespace

std::string check_all(const std::string& systems, std::istream& certificates, z3::context& z) {
  const std::string head = "(bsys 1)\n";
  std::list<Model> models;
  for (std::size_t at = 0, end = 0; end != systems.size(); at = end) {
    const std::size_t next = systems.find("\n" + head, std::max(at, systems.find(head)));
    end = next == std::string::npos ? systems.size() : next + 1;
    read_model(systems.substr(at, end - at), models.emplace_back());
  }
  if (models.empty()) throw Rejected("not `(bsys 1)`");
  const Model& only = models.front();
  if (models.size() == 1 && only.tree["for-all"].items.empty()) return check(only, certificates, z);
  return systems_checked(models, certificates, z);
}

}  // namespace certcheck
