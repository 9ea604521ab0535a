// C++ codels: nothing of bipc but the headers that it writes for a component.
#include "acsurvey.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <unistd.h>

#include "survey_cxx_types.hpp"

namespace survey {
struct camera_s {
  unsigned frames = 0;
};
}  // namespace survey

// --- Task fly -----------------------------------------------------------

genom_event
surveyStart(survey_ids &ids, uint32_t &cycles, const survey_sight &sight, const genom_context self)
{
  ids.flight.pace = survey::FAST;
  ids.flight.limit.high = 2.;
  ids.camera = new survey::camera_s;
  cycles = 0;
  sight.data(self)->label = "nothing yet";
  sight.write(self);
  return survey_main;
}

genom_event
surveyMain(const space::point &, uint32_t &cycles, survey::camera_s *&camera, const genom_context)
{
  ++cycles;
  ++camera->frames;
  return survey_pause_main;
}

genom_event
surveyStop(survey::camera_s *&camera, const genom_context)
{
  delete camera;
  camera = nullptr;
  return survey_ether;
}

// --- Attributes and functions -------------------------------------------

genom_event
surveyPace(survey::speed pace, const survey::ids::flight_s &flight, const genom_context)
{
  if (pace == survey::SLOW && flight.gains[0] > 5.) throw survey::e_empty();
  return genom_ok;
}

genom_event
surveyMeasure(const survey::area &place, const std::optional<double> &scale, const std::vector<bool> &flags, double &sum,
              genom::bounded_string<16> &verdict, survey::area &last, const genom_context self)
{
  sum = 0.;
  for (const bool flag : flags) sum += flag ? 1. : 0.;
  switch (place._d()) {
    case survey::SLOW:
      sum += place.radius();
      break;
    case survey::FAST:
      if (place.corners().empty()) return genom::raise(survey::e_empty(), self);
      for (const space::point &p : place.corners()) sum += p.x * p.y;
      if (sum > survey::too_far) {
        survey::e_far_detail d;
        d.distance = sum;
        d.what = "corners";
        d.beyond = place.corners();
        const genom_event e = genom::raise(survey::e_far(d), self);
        const survey::e_far_detail *raised = genom::raised<survey::e_far>(self);
        return raised != nullptr && raised->what == "corners" ? e : genom_ok;
      }
      break;
    default: throw std::runtime_error("a place called " + place.name());
  }
  sum *= scale.value_or(1.);
  verdict = std::string(place._d() == survey::SLOW ? "slow" : "fast") + " of " + std::to_string(flags.size());
  last = place;
  return genom_ok;
}

genom_event
surveyTabulate(const genom::bounded_vector<genom::bounded_vector<double, 2>, 3> &rows, const std::string &pilot,
               genom::bounded_vector<genom::bounded_vector<double, 2>, 3> &table, std::optional<std::string> &who,
               std::string &note, const genom_context)
{
  table = rows;
  for (auto &row : table) row.push_back(-1.);  // throws if it is full
  who = pilot;
  note = survey::greeting + std::string(" ") + *who;
  return genom_ok;
}

genom_event
surveyMark(const genom::bounded_string<8> &name, const space::point &at, const survey_marks &marks, const genom_context self)
{
  if (name.empty()) throw survey::e_empty();
  if (!marks.data(name, self)) marks.open(name, self);
  space::pose &pose = *marks.data(name, self);
  pose.at = at;
  pose.source = name;
  pose.spread = {1., 2.};
  return marks.write(name, self);
}

genom_event
surveyLook(const genom::bounded_string<8> &name, const survey_marks_seen &seen, space::pose &pose, const genom_context self)
{
  if (const genom_event e = seen.read(name, self); e != genom_ok) return e;
  if (!seen.data(name, self)) throw survey::e_empty();
  pose = *seen.data(name, self);
  return genom_ok;
}

genom_event
surveyFrames(const survey::camera_s *camera, uint32_t &count, const genom_context)
{
  count = camera->frames;
  return genom_ok;
}

// --- Activities ---------------------------------------------------------

genom_event
flyCheck(const std::vector<space::point> &path, double tolerance, const genom_context)
{
  if (path.empty()) throw survey::e_empty();
  survey::e_far_detail far{0., "", {}};
  for (const space::point &p : path) {
    far.distance = std::max(far.distance, std::hypot(p.x, p.y));
    if (std::hypot(p.x, p.y) > survey::too_far) far.beyond.push_back(p);
  }
  far.what = "path";
  if (!far.beyond.empty()) throw survey::e_far(far);
  return tolerance > 0. ? genom_ok : throw survey::e_far({tolerance, "tolerance", {}});
}

genom_event
flyStart(const std::vector<space::point> &, uint32_t &at, double &length, std::vector<space::point> &visited,
         const genom_context)
{
  visited.clear();
  at = 0;
  length = 0.;
  return survey_step;
}

genom_event
flyStep(const std::vector<space::point> &path, double tolerance, uint32_t &at, double &length,
        const survey::ids::flight_s &flight, space::point &position, std::vector<space::point> &visited,
        const survey_sight &sight, const genom_context self)
{
  const double reach = flight.pace == survey::FAST ? .01 : .005;
  const double x = path[at].x - position.x, y = path[at].y - position.y, left = std::hypot(x, y);
  if (left > std::max(reach, tolerance)) {
    position.x += x / left * reach;
    position.y += y / left * reach;
    length += reach;
    return survey_pause_step;
  }
  length += left;
  position = path[at];
  visited.push_back(position);
  space::sighting &seen = *sight.data(self);
  seen.where.seen_in = space::BODY;
  seen.where.at = position;
  seen.where.heading = std::atan2(y, x);
  seen.where.spread = {position.x, position.y};
  seen.where.source = "survey";
  seen.outline = visited;
  seen.hits.push_back(at % 2 == 0);
  seen.label = std::to_string(visited.size()) + " places";
  seen.covariance[1][0] = 0.5;
  if (sight.write(self) != genom_ok) return survey_ether;
  return ++at < path.size() ? survey_step : survey_ether;
}

genom_event
flyStop(std::string &note, const genom_context)
{
  note = "stopped";
  return survey_ether;
}

genom_event
homeStart(const survey_beacon &beacon, space::point &position, const genom_context self)
{
  if (const genom_event e = beacon.read(self); e != genom_ok) return e;
  const space::pose *seen = beacon.data(self);
  if (!seen) return survey_pause_start;
  if (seen->spread.size() != 2 || seen->source.str() != "lamp" || !seen->heading)
    throw survey::e_far({seen->at.x, "an odd beacon", {seen->at}});
  position = seen->at;
  return survey_ether;
}

genom_event
faultStart(survey::speed how, bool late, const genom_context)
{
  if (late) return survey_next;
  if (how == survey::SLOW) throw std::runtime_error("cannot be so slow");
  throw genom::syserr(genom::syserr_detail{5, "input/output"});
}

genom_event
faultNext(survey::speed how, const genom_context self)
{
  if (how == survey::SLOW) throw 7;
  return genom::raise(survey::e_far({1., "late", {}}), self);
}

genom_event
ponderStart(double seconds, std::string &answer, const genom_context)
{
  std::fputs("survey: ponders\n", stderr);
  // Until there is a file `enough`; after so long without one it makes `impatient`.
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end && ::access("enough", F_OK) != 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  if (::access("enough", F_OK) != 0) std::fclose(std::fopen("impatient", "w"));
  answer = "forty-two";
  return survey_ether;
}
