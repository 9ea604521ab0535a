// The control task: the message box (Bensalem, de Silva, Ingrand, Yan 2011, Figure 8) and its timer.
//
// A control cycle, place by place:
//   idle   -chck->    coll   the timer says so, and there is something to do (Plan::is_on_demand); the module's lock
//                            is taken
//   idle   -woken->   coll   a request has arrived in the mailbox (Executive::Served); the timer runs on
//   coll   -collect-> read   all final replies that are due
//   read   -read_X->  asked  at most one request (with the semaphore), or -none-> laun
//   asked  -accept->  allowed, or -refuse-> laun by the state of the module; control requests begin at `allowed`
//   allowed -admit_X-> ctrl or okay, or -full_X-> laun
//   ctrl   -valid->   okay, or -invalid-> laun: what the control codel answers
//   okay   -allow_X-> alld   if rules say so (only where there are some), or -rej_X-> laun
//   okay, alld -abtInc_X-> abtI  what is incompatible is told to stop
//   abtI   -trig_X->  laun (execution) or exec (control) -final-> laun
//   turn   -run_X->   exec   where codels run in threads, a control service has the data of its codels
//   laun   -launch->  laun   activities begin that need wait for nobody; -done-> give
//   give   -give/rest-> idle the lock and the semaphore go back
// Where codels run in threads the box keeps no semaphore (Plan::takes_semaphore_to_decide): `rest` ends each cycle.
#include <fmt/format.h>

#include <algorithm>

#include "compiler/genom/plan.hpp"
#include "compiler/genom/wires.hpp"

namespace bip::genom {
namespace {

struct Box {
  std::vector<std::pair<std::string, std::string>> ports;  // type, name
  std::string transitions;
  std::string places = "off, idle, coll, read";

  void on(const std::string& port, const std::string& from, const std::string& to, const std::string& rest = {}) {
    transitions += fmt::format("    on {} from {} to {}{}\n", port, from, to, rest);
  }
  void signal(const std::string& name) { ports.emplace_back("Signal", name + "()"); }
  void report(const std::string& name) { ports.emplace_back("Report", name + "(rep)"); }
};

std::string asked_for(const std::string& name) { return fmt::format(" provided (rqst == \"{}\")", name); }

// The semaphore is kept from here to the end of the cycle.
const char* keeps_token(const Plan& plan) { return plan.takes_semaphore_to_decide() ? "" : " token = true;"; }

bool is_checked(const Plan& plan, const Service& s) {
  return plan.has_checks() && s.kind == ServiceKind::Execution && !s.is_init;
}

void requests(Box& box, const Plan& plan) {
  const Module& m = *plan.module;
  box.transitions += "\n    // At most one request.\n";
  for (std::size_t i = 0; i < m.services.size(); ++i) {
    const std::string& id = plan.services[i].id;
    box.signal("read_" + id);
    box.on("read_" + id, "read", is_checked(plan, m.services[i]) ? "asked" : "allowed",
           fmt::format(" do {{ rqst = \"{}\"; rep = \"OK\";{} }}", m.services[i].name.text, keeps_token(plan)));
  }
  box.signal("none");
  box.on("none", "read", "laun");
}

bool refuses(const Plan& plan, std::size_t service) {
  const Service& s = plan.module->services[service];
  return s.kind == ServiceKind::Execution || !s.before.empty() || !s.after.empty();
}

}  // namespace

void write_control(std::string& out, const Plan& plan) {
  const Module& m = *plan.module;
  const bool is_served = plan.executive == Executive::Served;
  bool any_checked = false;
  bool any_validate = false;
  bool any_invalid = false;
  bool any_control = false;
  bool any_execution = false;
  bool any_waits = false;
  for (const Service& s : m.services) {
    any_checked = any_checked || is_checked(plan, s);
    any_validate = any_validate || s.validate.name.is_set();
    any_invalid = any_invalid || (s.validate.name.is_set() && s.validate_fails);
    any_control = any_control || s.kind == ServiceKind::Control;
    any_execution = any_execution || s.kind == ServiceKind::Execution;
    any_waits = any_waits || plan.gives_lock(s);
  }
  Box box;
  for (const char* name : {"err", "stop", "chck", "collect"}) box.signal(name);
  box.on("init", "off", "idle");
  box.on("err", "off", "fini");
  box.on("stop", "idle", "fini");
  box.on("chck", "idle", "coll");
  if (is_served) {
    box.signal("woken");
    box.on("woken", "idle", "coll");
  }
  box.on("collect", "coll", "read");
  requests(box, plan);
  if (any_checked) {
    box.signal("accept");
    box.report("refuse");
    box.places += ", asked";
    box.transitions += "\n    // An execution request is refused by the state of the module.\n";
    box.on("accept", "asked", "allowed");
    box.on("refuse", "asked", "laun");
  }
  if (!m.services.empty()) box.places += ", allowed";
  if (any_validate) {
    box.signal("valid");
    if (any_invalid) box.report("invalid");
    box.places += ", ctrl";
  }
  box.places += m.services.empty() ? ", laun" : ", okay, abtI, laun";
  if (std::any_of(plan.services.begin(), plan.services.end(), [](const ServicePlan& s) { return s.is_decided; }))
    box.places += ", alld";
  for (std::size_t i = 0; i < m.services.size(); ++i) {
    const Service& s = m.services[i];
    const std::string& id = plan.services[i].id;
    const std::string guard = asked_for(s.name.text);
    const bool waits = plan.gives_lock(s);
    box.signal("admit_" + id);
    if (refuses(plan, i)) box.report("full_" + id);
    box.signal("abtInc_" + id);
    box.signal("trig_" + id);
    box.report("rej_" + id);
    box.transitions += fmt::format("\n    // {}\n", s.name.text);
    box.on("admit_" + id, "allowed", s.validate.name.is_set() ? "ctrl" : "okay", guard);
    if (refuses(plan, i)) box.on("full_" + id, "allowed", "laun", guard);
    if (plan.services[i].is_decided) {
      box.signal("allow_" + id);
      box.on("allow_" + id, "okay", "alld", guard);
    }
    box.on("abtInc_" + id, plan.services[i].is_decided ? "alld" : "okay", "abtI", guard);
    box.on("rej_" + id, "okay", "laun", guard);
    const bool is_patient = s.kind == ServiceKind::Control && plan.accepts_before_data();
    box.on("trig_" + id, "abtI",
           is_patient                       ? "turn"
           : s.kind == ServiceKind::Control ? "exec"
           : waits                          ? "back"
                                            : "laun",
           guard);
    if (is_patient) {
      box.signal("run_" + id);
      box.on("run_" + id, "turn", "exec", guard);
    }
  }
  box.transitions += "\n";
  if (any_validate) {
    box.on("valid", "ctrl", "okay");
    if (any_invalid) box.on("invalid", "ctrl", "laun");
  }
  if (any_control) {
    box.report("final");
    box.places += plan.accepts_before_data() ? ", turn, exec" : ", exec";
    box.on("final", "exec", plan.waits_in_box() && any_waits ? "back" : "laun");
  }
  if (any_waits) {
    box.signal("retake");
    box.places += ", back";
    box.on("retake", "back", "laun");
  }
  if (any_execution) {
    for (const char* name : {"read_Abort", "abort"}) {
      if (is_served) box.ports.emplace_back("Target", std::string(name) + "(activity)");
      else box.signal(name);
    }
    for (const char* name : {"unknown", "launch"}) box.signal(name);
    box.places += ", abor";
    box.transitions += "\n    // Abort names an activity.\n";
    box.on("read_Abort", "read", "abor", fmt::format(" do {{ rqst = \"Abort\"; rep = \"OK\";{} }}", keeps_token(plan)));
    box.on("abort", "abor", "laun");
    box.on("unknown", "abor", "laun", is_served ? " do { rep = \"UNKNOWN_ACTIVITY\"; }" : "");
    box.transitions += "\n    // Start what is ready.\n";
    box.on("launch", "laun", "laun");
  }
  const bool has_token = !plan.takes_semaphore_to_decide();
  box.signal("done");
  if (has_token) box.signal("give");
  box.signal("rest");
  box.places += ", give_back, fini";
  const std::string answer =
      fmt::format(" do {{ if (rqst != \"\") then executive_answer(\"{}\", rqst, rep); rqst = \"\"; fi }}", m.name.text);
  box.on("done", "laun", "give_back", plan.executive == Executive::Cpp ? answer : "");
  if (is_served) box.ports.emplace_back("Told", "told(rqst, rep)");
  if (is_served) box.on("told", "give_back", "give_back", " provided (rqst != \"\") do { rqst = \"\"; }");
  const std::string is_told = is_served ? "rqst == \"\"" : "";
  if (has_token) {
    const std::string and_told = is_served ? " && " + is_told : "";
    box.on("give", "give_back", "idle", fmt::format(" provided (token{}) do {{ token = false; }}", and_told));
    box.on("rest", "give_back", "idle", fmt::format(" provided (!token{})", and_told));
  } else {
    box.on("rest", "give_back", "idle", is_served ? fmt::format(" provided ({})", is_told) : "");
  }

  out += fmt::format(
      "\n  // Receives the requests to {} and answers them, one control cycle after the other (Figure 8).\n",
      m.name.text);
  out += fmt::format("  atom type {}()\n    data string rqst = \"\", rep = \"OK\"\n{}    port Signal init()\n",
                     plan.box_type, has_token ? "    data bool token = false\n" : "");
  if (is_served) out += "    data string activity = \"\"\n";
  for (const auto& [type, name] : box.ports) out += fmt::format("    export port {} {}\n", type, name);
  out += fmt::format("\n    place {}\n\n    initial to off\n\n{}  end\n", box.places, box.transitions);

  out += fmt::format(
      "\n  // The control task.\n  compound type {}(int period)\n    component {} box()\n    component {} "
      "timer(period, 0)\n",
      plan.control_type, plan.box_type, plan.is_on_demand() ? "RestingTimer" : "Timer");
  write_wire(out, {.name = "wake_up", .ports = {"box.chck", "timer.trigger"}, .exported = true});
  out += "\n";
  write_export(out, "timer.tick", "tick");
  write_export(out, "wake_up.out", "chck");
  for (const auto& [type, name] : box.ports) {
    const std::string bare = name.substr(0, name.find('('));
    if (bare != "chck") write_export(out, "box." + bare, bare);
  }
  out += "  end\n";
}

void write_data_lock(std::string& out, std::size_t threads) {
  out += fmt::format(
      "\n  // One datum of {0} threads: each may read it while nobody writes; who writes it has all tokens.\n  atom "
      "type DataLock{0}()\n",
      threads);
  for (std::size_t k = 1; k <= threads; ++k) {
    for (const char* port : {"read_take", "read_give", "write_take", "write_give"})
      out += fmt::format("    export port Signal {}_{}()\n", port, k);
  }
  std::string free;
  std::string busy;
  for (std::size_t k = 1; k <= threads; ++k) {
    free += fmt::format("{}free_{}", k == 1 ? "" : ", ", k);
    busy += fmt::format(", read_{0}, written_{0}", k);
  }
  out += fmt::format("\n    place {}{}\n\n    initial to {}\n\n", free, busy, free);
  for (std::size_t k = 1; k <= threads; ++k) {
    out += fmt::format(
        "    on read_take_{0} from free_{0} to read_{0}\n    on read_give_{0} from read_{0} to free_{0}\n", k);
    out += fmt::format("    on write_take_{0} from {1} to written_{0}\n    on write_give_{0} from written_{0} to {1}\n",
                       k, free);
  }
  out += "  end\n";
}

}  // namespace bip::genom
