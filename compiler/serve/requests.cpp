// See requests.hpp. What the model does with a request is seen in its steps: `ask` of the mailbox (its module reads
// it), `accepted` with the activity's `controller.trig`, `told` with the report, `controller.reply` with the final one.
#include "compiler/serve/requests.hpp"

#include <algorithm>
#include <cctype>
#include <mutex>

#include "bip/assert.hpp"
#include "bip/image_time.hpp"
#include "compiler/serve/request_values.hpp"
#include "runtime/core/text.hpp"

namespace bip::serve {

namespace {

// Codels of the model are no client of the server. Clients that have left are one client.
constexpr std::uint64_t kCaller = ~std::uint64_t{0}, kGone = kCaller - 1;

constexpr std::string_view kReply = ".controller.reply", kTrig = ".controller.trig";

// Insertions, deletions and replacements, upper and lower case alike.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t k = 0; k <= b.size(); ++k) row[k] = k;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t corner = std::exchange(row[0], i);
    for (std::size_t k = 1; k <= b.size(); ++k) {
      const bool same =
          std::tolower(static_cast<unsigned char>(a[i - 1])) == std::tolower(static_cast<unsigned char>(b[k - 1]));
      corner = std::exchange(row[k], std::min({row[k] + 1, row[k - 1] + 1, corner + (same ? 0 : 1)}));
    }
  }
  return row.back();
}

std::string_view module_of(std::string_view service) {
  return service.substr(0, std::min(service.find('.'), service.size()));
}
std::string_view name_of_service(std::string_view service) {
  return service.substr(std::min(service.find('.') + 1, service.size()));
}

const EventValue* value_at(const Step& step, std::uint32_t port, std::string_view name) {
  for (const StepValue& v : step.values) {
    if (v.port == port && name == v.name) return &v.value;
  }
  return nullptr;
}
std::uint64_t number_at(const Step& step, std::uint32_t port, std::string_view name) {
  const EventValue* const value = value_at(step, port, name);
  const auto* const number = value == nullptr ? nullptr : std::get_if<std::int32_t>(value);
  return number == nullptr || *number < 0 ? 0 : static_cast<std::uint64_t>(*number);
}

// The report that any port of the step carries.
std::string report_of(const Step& step) {
  for (const StepValue& v : step.values) {
    if (std::string_view(v.name) != "rep") continue;
    if (const auto* const text = std::get_if<std::string>(&v.value)) return *text;
  }
  return {};
}

template <class Queue>
auto find_number(Queue& queue, std::uint64_t number) {
  return std::find_if(queue.begin(), queue.end(), [&](const auto& r) { return r.number == number; });
}

template <class Queue>
std::size_t count_of_client(const Queue& queue, std::uint64_t client) {
  return static_cast<std::size_t>(
      std::count_if(queue.begin(), queue.end(), [&](const auto& r) { return r.client == client; }));
}

// What stops or interrupts with the same words does the same.
template <class Request>
bool is_alike(const Request& a, const Request& b) {
  return a.client == b.client && a.text == b.text && a.input == b.input;
}

}  // namespace

const ServiceText* Requests::Mailbox::find(std::string_view service) const {
  for (const ServiceText& s : services) {
    if (s.name == service) return &s;
  }
  return nullptr;
}

Requests::Requests(const rt::Image& image, Execution& system) : system_(system) {
  for (const rt::Atom& atom : image.atoms) {
    if (image.atom_types[atom.type].time == nullptr) continue;
    Mailbox box;
    box.path = atom.path();
    box.request = system.event_port(box.path + ".request");
    box.urgent = system.event_port(box.path + ".urgent");
    box.withdraw = system.event_port(box.path + ".withdraw");
    if (box.request == rt::kNone || box.urgent == rt::kNone || box.withdraw == rt::kNone ||
        !system.read(box.path + ".services", box.directory))
      continue;
    mailboxes_.push_back(std::move(box));
    for (const rt::Port& port : image.atom_types[atom.type].ports) {
      const std::string_view name = port.name;
      const auto add = [&](MailboxSignal heard) {
        ports_[atom.path() + "." + port.name] = {mailboxes_.size() - 1, heard};
      };
      if (name == "ask") add(MailboxSignal::Ask);
      else if (name == "lost") add(MailboxSignal::Lost);
      else if (name == "dropped") add(MailboxSignal::Dropped);
      else if (name == "told") add(MailboxSignal::Told);
      else if (name.starts_with("accepted")) add(MailboxSignal::Accepted);
    }
  }
  // The rows move no more: their texts can be pointed to.
  for (Mailbox& box : mailboxes_) box.services = read_services(box.directory);
}

// What there is instead.
std::string Requests::unknown(std::string_view service) const {
  std::string text = "there is no service `" + std::string(service) + "`";
  std::vector<std::pair<std::size_t, std::string_view>> near;
  std::string modules, names;
  for (const Mailbox& box : mailboxes_) {
    for (const ServiceText& s : box.services) {
      const bool is_whole = service.find('.') != std::string_view::npos;
      const std::size_t distance = edits(service, is_whole ? s.name : name_of_service(s.name));
      if (distance <= std::max<std::size_t>(1, service.size() / 4)) near.emplace_back(distance, s.name);
      if (module_of(s.name) == module_of(service))
        names.append(names.empty() ? "" : ", ").append(name_of_service(s.name));
    }
    if (!box.services.empty()) modules.append(modules.empty() ? "" : ", ").append(module_of(box.services[0].name));
  }
  if (!near.empty()) {
    std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    text += ": did you mean ";
    for (std::size_t k = 0; k < near.size() && k < 3 && near[k].first == near[0].first; ++k)
      text.append(k == 0 ? "`" : "` or `").append(near[k].second);
    return text + "`?";
  }
  if (!names.empty()) return text + ": `" + std::string(module_of(service)) + "` has " + names;
  return text + ": there are the modules " + modules;
}

std::string Requests::ask(const std::string& asked, const std::string& asked_input, std::uint64_t client,
                          std::uint64_t& number) {
  if (mailboxes_.empty()) return "the model has no services: it was not made by `bipc genom --served`";
  const std::string asked_service(read_request(asked).service);
  for (Mailbox& box : mailboxes_) {
    const ServiceText* const service = box.find(asked_service);
    if (service == nullptr) continue;
    std::string text = asked, input = asked_input;
    if (!read_request(text).is_sound) return service->problem_of(read_request(text));
    if (std::string problem = settle_values(*service, input_problem, text, input); !problem.empty()) return problem;
    const RequestText wanted = read_request(text);
    if (std::string problem = service->problem_of(wanted); !problem.empty()) return problem;
    if (input_problem != nullptr) {
      const std::string problem = input_problem(std::string(service->name).c_str(), input.c_str());
      if (!problem.empty()) return "input of `" + std::string(service->name) + "`: " + problem;
    }
    const std::lock_guard<std::mutex> hold(lock_);
    Request request{next_, client, std::string(service->name), written_request(wanted), std::move(input), false};
    if (std::string problem = full(box, *service, request); !problem.empty()) return problem;
    number = next_++;
    enter(box, *service, std::move(request));
    return {};
  }
  return unknown(asked_service);
}

// Each client may have as many requests wait as there is room left: one gets half of the room, two together two thirds
// (dynamic thresholds: Choudhury and Hahne, 1998, with factor 1); and a few if there is none. What overtakes waits in a
// queue of its own and is not kept out by others: only by what its own client has asked for already.
std::string Requests::full(const Mailbox& box, const ServiceText& service, const Request& request) {
  const std::string module = "`" + std::string(module_of(service.name)) + "`";
  if (!service.overtakes) {
    const std::size_t own = count_of_client(box.waiting, request.client), all = box.waiting.size();
    BIP_ASSERT(own <= all, "{} of {} requests wait", own, all);
    if (own < kLeastShare || own + all < kMostWaiting) return {};
    return "full: " + std::to_string(own) + " requests of this client wait for " + module + ", " + std::to_string(all) +
           " in all";
  }
  const auto alike = std::count_if(box.overtaking.begin(), box.overtaking.end(),
                                   [&](const Request& r) { return is_alike(r, request); });
  if (static_cast<std::size_t>(alike) >= kMostAlike)
    return "full: " + std::to_string(alike) + " requests `" + request.text + "` of this client wait for " + module;
  if (count_of_client(box.overtaking, request.client) < kMostWaiting) return {};
  return "full: " + std::to_string(kMostWaiting) + " requests of this client that overtake wait for " + module;
}

void Requests::enter(Mailbox& box, const ServiceText& service, Request request) {
  BIP_ASSERT(request.number != 0 && request.number < next_ && box.find(request.service) == &service,
             "request {} for `{}`", request.number, request.service);
  if (service.overtakes) {
    // Clients take turns: the first one of each goes before the second one of any.
    const std::size_t own = count_of_client(box.overtaking, request.client);
    std::map<std::uint64_t, std::size_t> seen;
    const auto place = std::find_if(box.overtaking.begin(), box.overtaking.end(), [&](const Request& r) {
      return r.client != request.client && seen[r.client]++ > own;
    });
    box.overtaking.insert(place, std::move(request));
  } else {
    box.waiting.push_back(std::move(request));
  }
  hand_over(box);
}

void Requests::leave(std::uint64_t client) {
  std::vector<RequestReply> lost;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    const auto drop = [&](std::deque<Request>& queue, std::deque<Request>::iterator at) {
      lost.push_back({at->number, at->client, at->service, true, "LOST"});
      return queue.erase(at);
    };
    for (Mailbox& box : mailboxes_) {
      std::size_t gone = count_of_client(box.waiting, kGone);
      for (auto at = box.waiting.begin(); at != box.waiting.end();) {
        if (at->client != client) {
          ++at;
        } else if (gone++ < kMostOfGone) {
          at++->client = kGone;
        } else {
          at = drop(box.waiting, at);
        }
      }
      // A stop is done although its client has left, but once.
      for (auto at = box.overtaking.begin(); at != box.overtaking.end();) {
        if (at->client == client) at->client = kGone;
        const bool is_there = at->client == kGone && std::any_of(box.overtaking.begin(), at,
                                                                 [&](const Request& r) { return is_alike(r, *at); });
        at = is_there ? drop(box.overtaking, at) : at + 1;
      }
      while (count_of_client(box.overtaking, kGone) > kMostWaiting)
        drop(box.overtaking, std::find_if(box.overtaking.begin(), box.overtaking.end(),
                                          [](const Request& r) { return r.client == kGone; }));
    }
  }
  for (const RequestReply& r : lost) send(r);
}

// One of each kind at a time, and none behind one that overtakes it: what waits here can be taken back.
void Requests::hand_over(Mailbox& box) {
  const auto post = [&](std::uint32_t port, std::deque<Request>& from, std::deque<Request>& to) {
    BIP_ASSERT(to.empty() && !from.empty(), "a mailbox holds one request, {} wait", from.size());
    const Request& r = from.front();
    if (system_.post(port, {EventValue(r.text), EventValue(r.input),
                            EventValue(static_cast<std::int32_t>(r.number))}) != Posted::Taken)
      return;
    to.push_back(std::move(from.front()));
    from.pop_front();
  };
  if (!box.overtaking.empty() && box.held_urgent.empty()) post(box.urgent, box.overtaking, box.held_urgent);
  if (!box.waiting.empty() && box.held.empty() && box.held_urgent.empty()) post(box.request, box.waiting, box.held);
  BIP_ASSERT(box.held.size() <= 1 && box.held_urgent.size() <= 1 && box.asked.size() <= 1,
             "a mailbox holds {} and {} requests, and {} are decided", box.held.size(), box.held_urgent.size(),
             box.asked.size());
}

std::string Requests::cancel(std::uint64_t number, std::uint64_t client) {
  std::vector<RequestReply> ended;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    if (number == 0 || number >= next_) return "there was no request " + std::to_string(number);
    for (Mailbox& box : mailboxes_) {
      for (std::deque<Request>* queue : {&box.waiting, &box.overtaking}) {
        const auto found = find_number(*queue, number);
        if (found == queue->end()) continue;
        ended.push_back({number, found->client, found->service, true, "CANCELLED"});
        queue->erase(found);
      }
      for (std::deque<Request>* queue : {&box.held, &box.held_urgent}) {
        const auto found = find_number(*queue, number);
        if (found == queue->end()) continue;
        found->is_cancelled = true;
        (void)system_.post(box.withdraw, {EventValue(static_cast<std::int32_t>(number))});
        return {};
      }
      if (find_number(box.asked, number) != box.asked.end())
        return "the module is deciding about request " + std::to_string(number) + ": ask again";
      for (const auto& [path, request] : box.running) {
        if (request.number != number) continue;
        const std::string abort = std::string(module_of(request.service)) + ".Abort";
        const ServiceText* const service = box.find(abort);
        if (service == nullptr) return "`" + request.service + "` cannot be aborted";
        // "ROOT.NDD.GoTo": the activity of this name.
        const std::string activity = path.substr(path.rfind('.') + 1);
        Request stop{next_, client, abort, abort + "(" + activity + ")", "", false};
        if (std::string problem = full(box, *service, stop); !problem.empty()) return problem;
        ++next_;
        enter(box, *service, std::move(stop));
        return {};
      }
    }
  }
  if (ended.empty()) return "request " + std::to_string(number) + " has had its final reply";
  for (const RequestReply& r : ended) send(r);
  return {};
}

std::string Requests::abort_activity(const std::string& service, std::uint64_t number, std::uint64_t client,
                                     std::uint64_t& count, std::optional<RequestReply>& at_once) {
  const std::string abort = std::string(module_of(service)) + ".Abort";
  const auto box = std::find_if(mailboxes_.begin(), mailboxes_.end(),
                                [&](const Mailbox& mailbox) { return mailbox.find(abort) != nullptr; });
  if (box == mailboxes_.end()) return unknown(service);
  const std::lock_guard<std::mutex> hold(lock_);
  for (const auto& [path, request] : box->running) {
    if (request.number != number) continue;
    const std::string activity = path.substr(path.rfind('.') + 1);
    Request stop{next_, client, abort, abort + "(" + activity + ")", "", false, service};
    if (std::string problem = full(*box, *box->find(abort), stop); !problem.empty()) return problem;
    count = next_++;
    enter(*box, *box->find(abort), std::move(stop));
    return {};
  }
  count = next_++;
  at_once = {count, client, service, true, "no_such_activity"};
  return {};
}

// The number of the request is known when it may have had its reply already: so calls are counted before.
RequestReply Requests::call(const std::string& text, const std::string& input) {
  RequestReply lost{0, kCaller, text, true, "LOST"};
  std::uint64_t number = 0;
  std::unique_lock<std::mutex> hold(calls_lock_);
  if (calls_end_) return lost;
  if (std::string problem = ask(text, input, kCaller, number); !problem.empty())
    return {0, kCaller, text, true, "", std::move(problem)};
  calls_.emplace(number, std::nullopt);
  answered_.wait(hold, [&] { return calls_end_ || calls_.at(number).has_value(); });
  const auto found = calls_.find(number);
  if (found->second) lost = std::move(*found->second);
  calls_.erase(found);
  return lost;
}

void Requests::end_calls() {
  const std::lock_guard<std::mutex> hold(calls_lock_);
  calls_end_ = true;
  answered_.notify_all();
}

void Requests::send(const RequestReply& reply) {
  if (reply.client == kCaller && reply.is_final) {
    const std::lock_guard<std::mutex> hold(calls_lock_);
    if (const auto found = calls_.find(reply.request); found != calls_.end()) found->second = reply;
    answered_.notify_all();
  }
  if (on_reply) on_reply(reply);
}

bool Requests::is_mailbox_port(const std::string& path) const {
  const std::string whole = rt::whole_path(path);
  for (const Mailbox& box : mailboxes_) {
    for (const char* port : {".request", ".urgent", ".withdraw"}) {
      if (whole == box.path + port) return true;
    }
  }
  return false;
}

std::vector<Requests::Row> Requests::open() const {
  const std::lock_guard<std::mutex> hold(lock_);
  std::vector<Row> rows;
  for (const Mailbox& box : mailboxes_) {
    for (const std::deque<Request>* queue : {&box.waiting, &box.overtaking, &box.held, &box.held_urgent, &box.asked}) {
      for (const Request& r : *queue) rows.push_back({r.number, r.service, false});
    }
    for (const auto& [path, r] : box.running) rows.push_back({r.number, r.service, true});
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.request < b.request; });
  return rows;
}

std::vector<ServiceText> Requests::services() const {
  std::vector<ServiceText> all;
  for (const Mailbox& box : mailboxes_) all.insert(all.end(), box.services.begin(), box.services.end());
  return all;
}

void Requests::forget() {
  {
    const std::lock_guard<std::mutex> hold(calls_lock_);
    for (auto& [number, reply] : calls_) reply = RequestReply{number, kCaller, "", true, "LOST"};
    answered_.notify_all();
  }
  const std::lock_guard<std::mutex> hold(lock_);
  activities_.clear();
  for (Mailbox& box : mailboxes_) {
    box.held.clear();
    box.held_urgent.clear();
    box.asked.clear();
    box.running.clear();
    hand_over(box);
  }
}

bool Requests::hears(const std::string& port) const {
  return !mailboxes_.empty() && (ports_.contains(port) || port.ends_with(kReply));
}

void Requests::note_step(const Step& step) {
  if (mailboxes_.empty() || step.ports.empty()) return;
  {
    const std::lock_guard<std::mutex> hold(lock_);
    for (std::uint32_t k = 0; k < step.ports.size(); ++k) {
      if (const auto found = ports_.find(step.ports[k]); found != ports_.end())
        hear(mailboxes_[found->second.mailbox], found->second.heard, step, k);
      else if (!activities_.empty() && step.ports[k].ends_with(kReply)) hear_end(step, k);
    }
  }
  // A client that reads this may ask at once.
  for (const RequestReply& r : replies_) send(r);
  replies_.clear();
}

void Requests::hear(Mailbox& box, MailboxSignal what, const Step& step, std::uint32_t port) {
  switch (what) {
    case MailboxSignal::Ask:
    case MailboxSignal::Lost:
    case MailboxSignal::Dropped: {
      const std::uint64_t number = number_at(step, port, "due_number");
      for (std::deque<Request>* queue : {&box.held, &box.held_urgent}) {
        const auto found = find_number(*queue, number);
        if (found == queue->end()) continue;
        if (what == MailboxSignal::Ask) box.asked.assign(1, *found);
        else
          reply(*found, true,
                what == MailboxSignal::Lost ? "LOST"
                : found->is_cancelled       ? "CANCELLED"
                                            : "ACTIVITY_INTERRUPTED");
        queue->erase(found);
        break;
      }
      return hand_over(box);
    }
    case MailboxSignal::Accepted: {
      if (box.asked.empty() || box.asked[0].number != number_at(step, port, "asked_number")) return;
      const ServiceText* const service = box.find(box.asked[0].service);
      BIP_ASSERT(service != nullptr, "`{}` is no service", box.asked[0].service);
      for (const std::string& path : step.ports) {
        if (service->is_control || !path.ends_with(kTrig)) continue;
        const std::string activity = path.substr(0, path.size() - kTrig.size());
        box.running[activity] = box.asked[0];
        activities_[activity] = static_cast<std::size_t>(&box - mailboxes_.data());
      }
      // Older ones for what is told to stop are not begun afterwards.
      const auto is_stopped = [&](const Request& r) {
        return r.number < box.asked[0].number &&
               std::find(service->stops.begin(), service->stops.end(), r.service) != service->stops.end();
      };
      for (const Request& r : box.waiting) {
        if (is_stopped(r)) reply(r, true, "ACTIVITY_INTERRUPTED");
      }
      box.waiting.erase(std::remove_if(box.waiting.begin(), box.waiting.end(), is_stopped), box.waiting.end());
      return;
    }
    case MailboxSignal::Told: {
      if (box.asked.empty() || box.asked[0].number != number_at(step, port, "number")) return;
      const Request request = std::move(box.asked[0]);
      box.asked.clear();
      const std::string report = report_of(step);
      const ServiceText* const service = box.find(request.service);
      const bool is_final = report != "OK" || service == nullptr || service->is_control;
      return reply(request, is_final, report, is_final ? result(request.service, false) : "");
    }
  }
}

void Requests::hear_end(const Step& step, std::uint32_t port) {
  const std::string activity = step.ports[port].substr(0, step.ports[port].size() - kReply.size());
  const auto found = activities_.find(activity);
  if (found == activities_.end()) return;
  Mailbox& box = mailboxes_[found->second];
  BIP_ASSERT(box.running.contains(activity), "`{}` ends and does not run", activity);
  const EventValue* const value = value_at(step, port, "rep");
  const auto* const text = value == nullptr ? nullptr : std::get_if<std::string>(value);
  const std::size_t root = activity.starts_with("ROOT.") ? 5 : 0;
  reply(box.running.at(activity), true, text == nullptr ? "" : *text, result(activity.substr(root), true));
  box.running.erase(activity);
  activities_.erase(found);
}

void Requests::reply(const Request& request, bool is_final, const std::string& report, std::string result) {
  const bool is_renamed = !request.asked_as.empty();
  replies_.push_back({request.number, request.client, is_renamed ? request.asked_as : request.service, is_final,
                      is_renamed && report == "UNKNOWN_ACTIVITY" ? "no_such_activity" : report, std::move(result)});
}

std::string Requests::result(const std::string& whose, bool is_activity) const {
  const char* const text = result_of == nullptr ? nullptr : result_of(whose.c_str(), is_activity ? 1 : 0);
  return text == nullptr ? "" : text;
}

}  // namespace bip::serve
