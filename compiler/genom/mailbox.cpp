// See mailbox.hpp. A mailbox holds one request and one that overtakes it; who hands requests over (compiler/serve)
// keeps the others, in the order in which they are to come. Its data `services` tells which there are.
//
//   NONE   nothing waits               DUE    `wanted` waits for its module
//   STOP   `first`, which overtakes    BOTH   both; `first` goes first
//
// `waits` wakes the control task, so that a request does not wait for the end of its period: once for each request,
// so that one that cannot be read yet does not keep the control task busy.
#include "compiler/genom/mailbox.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/codels.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::genom {
namespace {

constexpr const char* kStartsWaiting = "      waited = 0;\n";

// It is due now, whichever of the two it is.
std::string takes(const std::string& text, const std::string& input, const std::string& number,
                  const char* clock = kStartsWaiting) {
  return fmt::format(
      "      due = {};\n      due_input = {};\n      due_number = {};\n      due_service = request_service(due);\n"
      "{}      known = request_agrees(due, due_input, services);\n",
      text, input, number, clock);
}

// As read_services() (bip/service_requests.hpp) reads it.
std::string words_of(const RequestParameter& p) {
  std::string out;
  for (const std::string& word : p.words) {
    BIP_ASSERT(word.size() >= 2 && word.front() == '"' && word.back() == '"', "{} is no string", word);
    out += (out.empty() ? "=" : "|") + word.substr(1, word.size() - 2);
  }
  std::replace(out.begin(), out.end(), ' ', '~');
  return out;
}

// "NDD.GoTo activity x:number;NDD.Stop control overtakes stops=NDD.GoTo;VIAM.Acquire activity camera:word=Left|Right"
std::string directory(const std::vector<RequestSpec>& requests) {
  std::string out;
  for (const RequestSpec& r : requests) {
    out += (out.empty() ? "" : ";") + r.text + (r.is_control ? " control" : " activity");
    if (r.overtakes) out += " overtakes";
    if (r.may_be_bare) out += " bare";
    for (const std::string& stopped : r.stops) out += " stops=" + stopped;
    for (const RequestParameter& p : r.parameters)
      out += fmt::format(" {}:{}{}", p.name, p.is_text ? "word" : "number", words_of(p));
  }
  return out;
}

std::string condition_of(const std::vector<std::string>& services) {
  BIP_ASSERT(!services.empty(), "a condition on no service");
  std::string out;
  for (const std::string& s : services) out += fmt::format("{}wanted_service == \"{}\"", out.empty() ? "" : " || ", s);
  return out;
}

}  // namespace

std::vector<RequestSpec> request_specs_of(const Plan& plan, std::size_t index, const Constraints& constraints) {
  const Module& m = *plan.module;
  std::vector<RequestSpec> all;
  for (std::size_t i = 0; i < m.services.size(); ++i) {
    const Service& s = m.services[i];
    RequestSpec r{.text = m.name.text + "." + s.name.text, .event = "accepted"};
    r.is_control = s.kind == ServiceKind::Control;
    for (const std::size_t other : s.interrupted) r.stops.push_back(m.name.text + "." + m.services[other].name.text);
    // Over at once, and something else with it. An activity that interrupts others may depend on what was asked before.
    r.overtakes = s.overtakes || (r.is_control && !r.stops.empty() && !s.is_init);
    if (!r.overtakes) r.stops.clear();
    if (!r.stops.empty()) r.event = "accepted_" + plan.services[i].id;
    for (const ParameterRow& p : constraints.parameters) {
      if (p.service != ServiceRef{index, i}) continue;
      const bool is_text = p.type == ValueType::Text;
      r.parameters.push_back({p.name, is_text, is_text ? p.values : std::vector<std::string>()});
    }
    all.push_back(std::move(r));
  }
  if (plan.execution_activities > 0)
    all.push_back({.text = m.name.text + ".Abort",
                   .event = "accepted",
                   .is_control = true,
                   .overtakes = true,
                   .may_be_bare = true,
                   .parameters = {{"activity", true}}});
  return all;
}

std::string executive_type(const GenerateOptions& options, const std::vector<RequestSpec>& all) {
  std::string out =
      "\n  // Of the text of a request: its service, values of its parameters (bip/service_requests.hpp).\n"
      "  extern function string request_service(string)\n"
      "  extern function float request_number(string, int)\n"
      "  extern function string request_word(string, int)\n"
      "  extern function bool request_known(string, string)\n";
  if (options.executive == Executive::Served) {
    return out +
           "\n  // Is it a request for one of the services, and does its input have the values that rules judge?\n"
           "  extern function bool request_agrees(string, string, string)\n"
           "\n  // What a request came with, as its client wrote it: when it is asked for, for codels that judge it; "
           "and "
           "once it is accepted.\n" +
           fmt::format("  extern function {}(string, string)\n  extern function {}(string, string)\n",
                       request_function(options, "asked"), request_function(options, "input")) +
           "\n  port type Asks(string due, string due_service, string due_input, int due_number)\n"
           "  port type Posts(string text, string input, int number)\n"
           "  port type Accepted(string asked, string asked_input, int asked_number)\n"
           "  port type Numbered(int number)\n  port type Target(string activity)\n"
           "  port type Told(string rqst, string rep)\n";
  }
  const bool wakes = options.design == Design::Ours;
  return out +
         "\n  // The next request, \"MODULE.SERVICE(VALUE, ...)\", or nothing; intermediate replies, or why there is "
         "none; final replies.\n"
         "  extern function string executive_request()\n"
         "  extern function executive_answer(string, string, string)\n"
         "  extern function executive_reply(string, string, string)\n"
         "\n  port type Asks(string due, string due_service)\n" +
         (wakes ? "  port type Pending(string due_module)\n"
                  "\n  // The module of a request.\n  extern function string request_module(string)\n"
                : "") +
         "\n  // The decisional level, as far as it is seen here: one request at a time, asked for anew in each tick.\n"
         "  atom type Executive()\n    data string services = \"" +
         directory(all) + "\"\n    data string due = \"\", due_service = \"\"" + (wakes ? ", due_module = \"\"" : "") +
         "\n    export port Signal tick()\n    export port Asks ask(due, due_service)\n" +
         (wakes ? "    export port Pending pending(due_module)\n" : "") +
         "\n    place HERE\n\n    initial to HERE\n\n"
         "    on tick from HERE to HERE do {\n      if (due == \"\") then\n        due = executive_request();\n"
         "        if (due != \"\") then\n          if (request_known(due, services)) then\n"
         "            due_service = request_service(due);\n" +
         (wakes ? "            due_module = request_module(due);\n" : "") +
         "          else\n            executive_answer(\"\", due, \"UNKNOWN_REQUEST\");\n            due = \"\";\n"
         "          fi\n        fi\n      fi\n    }\n"
         "    on ask from HERE to HERE do {\n      due = \"\";\n      due_service = \"\";\n    }\n" +
         (wakes ? "    on pending from HERE to HERE provided (due != \"\")\n" : "") + "  end\n";
}

std::string mailbox_type(const Plan& plan, const std::vector<RequestSpec>& requests) {
  const bool is_patient = plan.has_patient_mailbox();
  const char* const clock = is_patient ? "" : kStartsWaiting;
  std::string out = fmt::format(
      "\n  // Requests of clients to {}: one that waits, and one that overtakes it. What there is not is lost at once"
      "{}.\n  atom type {}({})\n    data string services = \"{}\"\n"
      "    data string wanted = \"\", wanted_input = \"\", wanted_service = \"\", first = \"\", first_input = \"\"\n"
      "    data string due = \"\", due_service = \"\", due_input = \"\", asked = \"\", asked_input = \"\"\n"
      "    data int wanted_number = 0, first_number = 0, due_number = 0, asked_number = 0, gone = 0{}\n"
      "    data bool known = false, wanted_is_gone = false, first_is_gone = false, wakes = false\n"
      "    extern port Posts request(wanted, wanted_input, wanted_number) remember\n"
      "    extern port Posts urgent(first, first_input, first_number) remember\n"
      "    extern port Numbered withdraw(gone) remember\n"
      "    export port Signal tick()\n    export port Signal waits()\n    export port Signal pending()\n"
      "    export port Asks ask(due, due_service, due_input, due_number)\n"
      "    export port Signal recover()\n    export port Numbered told(asked_number)\n",
      plan.module->name.text, is_patient ? "" : ", what is not taken after `patience` ticks", plan.mailbox_type,
      is_patient ? "" : "int patience", directory(requests), is_patient ? "" : ", waited = 0");
  std::vector<const RequestSpec*> stops;
  for (const RequestSpec& r : requests) {
    if (!r.stops.empty()) stops.push_back(&r);
  }
  out += "    export port Accepted accepted(asked, asked_input, asked_number)\n";
  for (const RequestSpec* r : stops)
    out += fmt::format("    export port Accepted {}(asked, asked_input, asked_number)\n", r->event);
  out +=
      "    port Asks lost(due, due_service, due_input, due_number)\n"
      "    port Asks dropped(due, due_service, due_input, due_number)\n"
      "\n    place NONE, DUE, STOP, BOTH\n\n    initial to NONE\n";
  const std::string takes_wanted = takes("wanted", "wanted_input", "wanted_number", clock) + "      wakes = true;\n";
  const std::string takes_first = "      first_is_gone = first_number != 0 && first_number == gone;\n" +
                                  takes("first", "first_input", "first_number", clock) + "      wakes = true;\n";
  out += fmt::format(
      "\n    on request from NONE to DUE eager do {{\n      wanted_service = request_service(wanted);\n"
      "      wanted_is_gone = wanted_number != 0 && wanted_number == gone;\n{}    }}\n",
      takes_wanted);
  for (const char* places : {"NONE to STOP", "DUE to BOTH"})
    out += fmt::format("    on urgent from {} eager do {{\n{}    }}\n", places, takes_first);
  const std::string asks = "      asked = due;\n      asked_input = due_input;\n      asked_number = due_number;\n";
  struct Row {
    const char *from, *to, *is_gone;
  };
  constexpr Row kDue[] = {
      {"DUE", "NONE", "wanted_is_gone"}, {"STOP", "NONE", "first_is_gone"}, {"BOTH", "DUE", "first_is_gone"}};
  for (const Row& row : kDue) {
    const std::string next = row.to == std::string("DUE") ? takes_wanted : "";
    const std::string then = next.empty() ? "" : " do {\n" + next + "    }";
    out += fmt::format("\n    on ask from {} to {} provided (!{}) do {{\n{}{}    }}\n", row.from, row.to, row.is_gone,
                       asks, next);
    out += fmt::format("    on waits from {0} to {0} provided (wakes && known && !{1}) do {{ wakes = false; }}\n",
                       row.from, row.is_gone);
    out += fmt::format("    on pending from {0} to {0} provided (known && !{1})\n", row.from, row.is_gone);
    out += fmt::format("    on dropped from {} to {} provided ({}){}\n", row.from, row.to, row.is_gone, then);
    out += fmt::format("    on lost from {} to {} provided (!{} && {}){}\n", row.from, row.to, row.is_gone,
                       is_patient ? "!known" : "(!known || waited >= patience)", then);
    out += fmt::format("    on tick from {0} to {0} provided (!{1} && known{2}\n", row.from, row.is_gone,
                       is_patient ? ")" : " && waited < patience) do { waited = waited + 1; }");
  }
  out +=
      "    on tick from NONE to NONE\n"
      "\n    // The next request may arrive before this one is accepted. A recovery has no client, so it has no "
      "input.\n";
  for (const char* place : {"NONE", "DUE", "STOP", "BOTH"}) {
    out += fmt::format("    on accepted from {0} to {0}\n    on told from {0} to {0}\n", place);
    out += fmt::format("    on recover from {0} to {0} do {{\n      asked = \"\";\n      asked_number = 0;\n    }}\n",
                       place);
    out += fmt::format(
        "    on withdraw from {0} to {0} eager do {{\n"
        "      wanted_is_gone = wanted_is_gone || wanted_number == gone;\n"
        "      first_is_gone = first_is_gone || first_number == gone;\n    }}\n",
        place);
  }
  if (!stops.empty()) out += "\n    // What is told to stop is not begun afterwards by an older request.\n";
  for (const RequestSpec* r : stops) {
    for (const char* place : {"NONE", "DUE", "STOP", "BOTH"}) {
      const bool waits = place[0] == 'D' || place[0] == 'B';
      out += fmt::format("    on {1} from {0} to {0}{2}\n", place, r->event,
                         waits ? fmt::format(" do {{\n      if (wanted_number < asked_number && ({})) then\n        "
                                             "wanted_is_gone = true;\n      fi\n    }}",
                                             condition_of(r->stops))
                               : "");
    }
  }
  return out + "  end\n";
}

}  // namespace bip::genom
