// The atoms through which C++ or clients ask for services: `Executive`, one a level; mailboxes, one a module. Internal
// to compiler/genom.
#pragma once
#include <string>
#include <vector>

#include "compiler/genom/generate_package.hpp"
#include "compiler/genom/plan.hpp"

namespace bip::genom {

/// A parameter of a request, as clients see it.
struct RequestParameter {
  std::string name;
  bool is_text = false;
  std::vector<std::string> words{};  // of a text: those that rules declare, as BIP writes them; none: any word
};
/// What a module may be asked for.
struct RequestSpec {
  std::string text;   // "NDD.GoTo"
  std::string event;  // the mailbox's port that hears of its acceptance
  bool is_control = false;
  bool overtakes = false;            // it waits for no other request of its module
  bool may_be_bare = false;          // also without its parameters
  std::vector<std::string> stops{};  // "NDD.GoTo": older requests for these are dropped when it is accepted
  std::vector<RequestParameter> parameters{};
};

/// The requests to a module, in file order, then `Abort`.
[[nodiscard]] std::vector<RequestSpec> request_specs_of(const Plan& plan, std::size_t index,
                                                        const Constraints& constraints);
/// Port types and C++ functions, and for Executive::Cpp the atom type.
[[nodiscard]] std::string executive_type(const GenerateOptions& options, const std::vector<RequestSpec>& all);
/// Executive::Served: the atom type of a module's mailbox.
[[nodiscard]] std::string mailbox_type(const Plan& plan, const std::vector<RequestSpec>& requests);

}  // namespace bip::genom
