// The writer of a module's compound; its two halves are write_module.cpp (parts, control cycle, requests) and
// write_module_tasks.cpp (tasks, time, exports). Inside compiler/genom only.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "compiler/genom/names.hpp"
#include "compiler/genom/plan.hpp"
#include "compiler/genom/wires.hpp"

namespace bip::genom {

class ModuleWriter {
 public:
  ModuleWriter(std::string& out, const Plan& plan);
  void run(const GenerateOptions& options);

 private:
  [[nodiscard]] std::string control(const std::string& port) const { return plan_.control + "." + port; }
  [[nodiscard]] std::string of_activity(std::size_t activity, const std::string& port) const {
    return plan_.activities[activity].component + "." + port;
  }
  [[nodiscard]] std::string of_task(std::size_t task, const std::string& port) const {
    return plan_.tasks[task].component + "." + port;
  }
  /// Writes it under a name that the module does not have yet.
  void wire(Wire w);
  /// The name that a connector got.
  [[nodiscard]] std::string out_of(const std::string& connector) const { return names_.at(connector) + ".out"; }
  /// Of what the codels use, for a thread (LockPlan); `what` is "take" or "give".
  void add_locks(std::vector<std::string>& ports, const std::vector<const Codel*>& codels, std::size_t thread,
                 const char* what) const;
  void add_ports(std::vector<std::string>& ports, const Codel& codel) const;
  [[nodiscard]] std::string called(const std::vector<Codel>& codels, std::size_t activity,
                                   const std::string& port) const;
  [[nodiscard]] std::string begins(const Service& s, std::size_t activity) const;
  [[nodiscard]] std::string runs(const Service& s, std::size_t activity) const;
  [[nodiscard]] std::string accepted(const Service& s, std::size_t activity) const;
  [[nodiscard]] std::string answered(const std::string& answer, std::size_t k, std::size_t reports) const;
  /// What begins the turns of a task waits for the answer of its permanent codel, where that runs in the step before.
  void add_permanent(std::vector<std::string>& ports, std::size_t task) const {
    if (plan_.tasks[task].permanent_to_begin) ports.push_back(of_task(task, "permanent_ok"));
  }
  void add_module_lock(std::vector<std::string>& ports, const char* what) const;
  [[nodiscard]] bool waits(const Service& s) const { return plan_.gives_lock(s); }

  void parts(const GenerateOptions& options);
  void control_cycle();
  void demands();
  void request(std::size_t i);
  void admissions(std::size_t i);
  void admitted_once(std::size_t i);
  void order_guards(const Service& s, std::vector<std::string>& ports, std::string& guard) const;
  void wait_for_interrupted(const Service& s, std::size_t activity, std::vector<std::string>& ports,
                            std::string& guard) const;
  void validated(const Service& s, std::size_t activity);
  void interruptions(const Service& s, const ServicePlan& p);
  void finals(const Service& s, const ServicePlan& p);
  void aborts();
  void launches();

  void task(std::size_t i);
  void pass_over(std::size_t task);
  [[nodiscard]] std::vector<std::string> gives(std::size_t task, const std::string& port) const;
  void permanent(std::size_t task);
  void turns_of_permanent(std::size_t task);
  void turns(std::size_t task, std::size_t activity);
  void beside(std::size_t task, std::size_t activity);
  void returns(const Activity& activity, const ActivityPlan& a, std::size_t task, const std::string& port,
               const std::string& name, std::size_t thread);
  void ends(std::size_t task, std::size_t activity);
  void time();
  void priorities();
  void exports();

  std::string& out_;
  const Plan& plan_;
  const Module& module_;
  bool is_3_;
  Scope scope_;
  std::map<std::string, std::string> names_;
  std::vector<std::pair<std::string, std::string>> refusals_;  // wanted names: what gives way, to which refusal
  std::map<std::string, std::string> bad_finals_;  // by component of a control service: its ends with other reports
  std::vector<std::string> aborts_;                // wanted names of the connectors by which Abort finds an activity
};

}  // namespace bip::genom
