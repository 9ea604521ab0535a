// Codels of Dala's modules over a simulated world (world.hpp), which is written down in world.path every 25 ticks:
// time, place, temperature, charge, metres driven, pictures, pictures sent, how near an obstacle was, how far the rover
// tilted. What a mission has no use for ends at once and well: the second half.
//
// With DALA_ROVER the rover is a process of its own (rover.cpp), and codels only read its sensors and command it.
#include "dala_codels.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <vector>

#include "bip/shared_object.hpp"
#include "bus.hpp"
#include "camera.hpp"
#include "vision.hpp"
#include "world.hpp"

namespace {

using namespace dala;

// What is next in an activity; of other codels 0 is OK.
constexpr int kOk = 0, kEther = 0, kExec = 2, kEnd = 3, kInter = 4;

// What modules see also from processes of their own (`bipc rules --processes`); all else here is its module's.
struct Shared {
  bip::SharedMutex lock;  // of all but what is atomic: codels of several modules run at a time (--task-threads)
  World world;
  Image panorama;                        // what VIAM shows in its poster
  Pair pair;                             // of images, likewise
  Cloud cloud;                           // Stereo's
  HeightMap map;                         // DTM's
  ArcPlanner arcs;                       // P3D's
  std::atomic<bool> takes_pairs{false};  // VIAM.AcquireContinuous, else the panorama
  std::atomic<bool> is_stopped{false};   // without a bus
};
const bip::SharedObject<Shared> kShared;
World& world() { return kShared->world; }
// A codel that looks at the world, or changes it, has it for itself.
struct Turn {
  Turn() { kShared->lock.lock(); }
  ~Turn() { kShared->lock.unlock(); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;
};
Image& panorama() { return kShared->panorama; }

// What requests came with, as numbers, by service. With a turn: a request may come while a codel runs in a thread.
std::map<std::string, std::vector<double>>& arguments() {
  static std::map<std::string, std::vector<double>> numbers;
  return numbers;
}

// Requests for Stereo.SetSource so far: read by a codel that runs beside the engine.
std::atomic<int>& sources_set() {
  static std::atomic<int> count{0};
  return count;
}

// What a request came with, as numbers; `without` if there are too few.
double input(const char* service, std::size_t k, double without) {
  const std::vector<double>& numbers = arguments()[service];
  return k < numbers.size() ? numbers[k] : without;
}

// The rover stands until it is told to move again: set beside everything else (safe_stop).
std::atomic<bool>& is_stopped() { return bus() != nullptr ? bus()->is_stopped : kShared->is_stopped; }
// The speed that the wheels are to follow was found now, by whom.
enum class Finder { Laser, Vision, Odometry };
void note_reference(Finder finder) {
  Bus* const b = bus();
  if (b == nullptr) return;
  const double now = b->now;
  b->found_at = now;
  if (finder == Finder::Laser) b->laser_at = now;
  if (finder == Finder::Vision) b->vision_at = now;
}
// What the map holds of the ground ahead, and how old its youngest image is.
enum class Ground { Unknown, Flat, Rough };
Ground ground_ahead() {
  const double step = kShared->map.roughness(world());
  return step < 0 ? Ground::Unknown : step < kRoughStep ? Ground::Flat : Ground::Rough;
}
double map_age() { return kShared->map.at < 0 ? 1e6 : world().now - kShared->map.at; }

// The words of the last request for Hueblob.SetHue.
std::string& hue() {
  static std::string words;
  return words;
}
// Of the last request for VIAM.Acquire.
bool& is_sharp() {
  static bool sharp = false;
  return sharp;
}

// The wires of the rover's sensors, which each host has.
void read_sensors() {
  if (bus() == nullptr) return;
  const Bus& b = *bus();
  World& w = world();
  w.now = b.now;
  w.x = b.x;
  w.y = b.y;
  w.heading = b.heading;
  w.v = b.v;
  w.windows = {{{0, 1e9}, {0, 1e9}}};
}
// The wheels' wires: sensors, then commands.
void talk_to_rover(Bus& b) {
  read_sensors();
  const World& w = world();
  b.wanted_v = w.wanted_v;
  b.wanted_turn = w.wanted_turn;
  b.follows = w.is_tracking;
}

// Nothing before the first scan.
std::string scan_text(const std::array<double, dala::kRays>& scan) {
  if (scan[0] == 0) return {};
  std::ostringstream out;
  out.precision(4);
  for (const double range : scan) out << (out.tellp() == 0 ? "{\"data\": [" : ", ") << range;
  return out.str() + "]}";
}

}  // namespace

// The watchdog's thread: it waits for nothing.
extern "C" void safe_stop(const char* /*why*/) { is_stopped() = true; }
// `bipc node` calls it when a node goes on that stood still, of whose reference nothing is forgotten.
extern "C" void safe_go_on(const char* /*why*/) { is_stopped() = false; }

// What posters hold, as their descriptions say; null: this one does not show it.
extern "C" const char* bip_poster_value(const char* poster) {
  const Turn turn;
  static thread_local std::string json;
  const World& w = world();
  const std::string_view name = poster;
  const auto object = [](std::initializer_list<std::pair<const char*, double>> members) {
    std::ostringstream out;
    out.precision(17);
    for (const auto& [member, value] : members)
      out << (out.tellp() == 0 ? "{" : ", ") << '"' << member << "\": " << value;
    return out.str() + "}";
  };
  if (name == "POM.Pos") json = "{\"data\": " + object({{"x", w.x}, {"y", w.y}, {"theta", w.heading}}) + "}";
  else if (name == "LaserRF.Scan") json = scan_text(w.scan);
  else if (name == "NDD.Speed") json = "{\"data\": " + object({{"v", w.wanted_v}, {"w", w.wanted_turn}}) + "}";
  else if (name == "P3D.Speed")
    json = "{\"data\": " + object({{"v", kShared->arcs.v}, {"w", kShared->arcs.turn}}) + "}";
  else if (name == "DTM.Env")
    json = "{\"data\": " +
           object({{"ground", static_cast<double>(ground_ahead())},
                   {"roughness", kShared->map.roughness(w)},
                   {"age", map_age()}}) +
           "}";
  else if (name == "Heating.Temperature") json = object({{"data", w.temperature}});
  else if (name == "Battery.State") json = object({{"data", w.charge}});
  else return nullptr;
  return json.c_str();
}

// What terrain.rules ask of DTM's poster.
std::string DTM_Env_ground() {
  const Turn turn;
  const Ground ground = ground_ahead();
  return ground == Ground::Unknown ? "unknown" : ground == Ground::Flat ? "flat" : "rough";
}
std::string DTM_Env_image() {
  const Turn turn;
  return map_age() < kOldImage ? "recent" : "old";
}

// No codel here judges what a request came with.
void request_asked(const char*, const char*) {}

// Words are no number: NaN.
void request_input(const char* service, const char* text) {
  const Turn turn;
  const std::string bare = service;
  std::vector<double>& numbers = arguments()[bare.substr(0, bare.find('('))];
  numbers.clear();
  if (bare == "Stereo.SetSource") ++sources_set();
  if (bare == "Hueblob.SetHue") hue() = text;
  if (bare.starts_with("VIAM.Acquire(")) is_sharp() = bare == "VIAM.Acquire(Marlin)";
  if (bare.starts_with("VIAM.AcquireContinuous")) kShared->takes_pairs = bare == "VIAM.AcquireContinuous(Pairs)";
  // A value that rules judge stands in parentheses.
  const bool is_judged = bare.starts_with("P3D.SetSpeed(");
  std::istringstream words(is_judged ? bare.substr(13, bare.size() - 14) : text);
  for (std::string word; words >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    numbers.push_back(end != nullptr && *end == '\0' ? number : std::nan(""));
  }
}

// ---- POM, RFLEX: where the rover is, and its wheels
int pomPermanent() { return kOk; }
int rflexPermanent() {
  const Turn turn;
  World& w = world();
  if (bus() != nullptr) {
    talk_to_rover(*bus());
    return kOk;
  }
  static std::ofstream path("world.path");
  const bool tracks = w.is_tracking;
  w.is_tracking = tracks && !is_stopped();
  w.now += 5 * kTick;
  w.move(5 * kTick);
  w.is_tracking = tracks;
  w.steepest = std::max(w.steepest, tilt_at(w.x, w.y, w.heading));
  if (++w.cycles % 5 == 0) {
    path << w.now << ' ' << w.x << ' ' << w.y << ' ' << w.temperature << ' ' << w.charge << ' ' << w.driven << ' '
         << w.pictures << ' ' << w.sent << ' ' << w.nearest << ' ' << w.steepest << '\n'
         << std::flush;
  }
  return kOk;
}
int rflexTrackSpeedStartStart(int&) {
  const Turn turn;
  is_stopped() = false;
  world().is_tracking = true;
  return kExec;
}
int rflexTrackSpeedStartMain(int&) { return kExec; }
int rflexTrackSpeedStartInter(int&) {
  const Turn turn;
  world().is_tracking = false;
  return std::abs(world().v) > 0.01 ? kInter : kEther;
}
// By odometry alone, straight.
int rflexGotoPositionMain(int&) {
  const Turn turn;
  World& w = world();
  const double dx = input("RFLEX.GotoPosition", 0, w.x) - w.x, dy = input("RFLEX.GotoPosition", 1, w.y) - w.y,
               far = std::hypot(dx, dy);
  const double off = wrapped(std::atan2(dy, dx) - w.heading);
  w.is_tracking = far > 0.1;
  w.wanted_turn = std::clamp(2.0 * off, -1.2, 1.2);
  w.wanted_v = std::abs(off) < 0.3 ? std::min(0.5, far) : 0;
  note_reference(Finder::Odometry);
  return w.is_tracking ? kExec : kEnd;
}
int rflexGotoPositionInter(int&) {
  const Turn turn;
  world().is_tracking = false;
  return kEther;
}

// ---- LaserRF, Aspect: what is round the rover
int laserPermanent() {
  const Turn turn;
  if (world().is_scanning) world().look();
  return kOk;
}
int laserrfStartAcquisitionMain(int&) {
  const Turn turn;
  world().is_scanning = true;
  return kExec;
}
int laserrfStartAcquisitionInter(int&) {
  const Turn turn;
  world().is_scanning = false;
  return kEther;
}
int aspectPermanent() {
  const Turn turn;
  if (world().is_mapping) world().map = world().scan;
  return kOk;
}
int aspectBuildMapMain(int&) {
  const Turn turn;
  world().is_mapping = true;
  return kExec;
}
int aspectBuildMapInter(int&) {
  const Turn turn;
  world().is_mapping = false;
  return kEther;
}

// ---- NDD: speeds from obstacles and a goal
// Without a speed it cannot go on.
int nddPermanent() {
  const Turn turn;
  return std::isnan(world().fastest) ? -1 : kOk;
}
int nddGoToStart(int&) {
  const Turn turn;
  World& w = world();
  w.goal_x = input("NDD.GoTo", 0, w.x);
  w.goal_y = input("NDD.GoTo", 1, w.y);
  w.blocked_since = -1;
  return kExec;
}
int nddGoToMain(int& report) {
  const Turn turn;
  World& w = world();
  note_reference(Finder::Laser);
  if (std::hypot(w.goal_x - w.x, w.goal_y - w.y) < 0.15) return kEnd;
  if (w.avoid()) {
    w.blocked_since = -1;
    return kExec;
  }
  if (w.blocked_since < 0) w.blocked_since = w.now;
  if (w.now - w.blocked_since < 5) return kExec;
  report = 1;  // BLOCKED
  return kEther;
}
int nddGoToEnd(int&) {
  const Turn turn;
  world().wanted_v = world().wanted_turn = 0;
  note_reference(Finder::Laser);
  return kEther;
}
int nddGoToInter(int&) {
  const Turn turn;
  world().wanted_v = world().wanted_turn = 0;
  return kEther;
}

// ---- Heating, Battery
int heatingPermanent() {
  const Turn turn;
  World& w = world();
  w.temperature += (w.is_heating ? 12.0 : 0.0) * 0.1 - 0.002 * (w.temperature + 30);
  return kOk;
}
int heatingHeatToStart(int&) {
  const Turn turn;
  world().heat_to = input("Heating.HeatTo", 0, 0);
  world().is_heating = true;
  return kExec;
}
int heatingHeatToMain(int&) {
  const Turn turn;
  return world().temperature < world().heat_to ? kExec : kEnd;
}
int heatingHeatToEnd(int&) {
  const Turn turn;
  world().is_heating = false;
  return kEther;
}
int batteryPermanent() {
  const Turn turn;
  World& w = world();
  w.charge -= (w.is_heating ? 60.0 : 0.0) * 0.1 + 40 * std::abs(w.v) * 0.1 + 1.0;
  return kOk;
}
int batteryCameraStartUsingBatteryMain(int&) { return kExec; }
int batteryPTUStartUsingBatteryMain(int&) { return kExec; }
int batteryLaserStartUsingBatteryMain(int&) { return kExec; }
int batteryWheelsStartUsingBatteryMain(int&) { return kExec; }
int batteryAntennaStartUsingBatteryMain(int&) { return kExec; }

// ---- PTU, VIAM, Hueblob: cameras
int ptuMoveAbsoluteStart(int&) {
  const Turn turn;
  world().pan_to = input("PTU.MoveAbsolute", 0, 0);
  return kExec;
}
int ptuMoveAbsoluteMain(int&) {
  const Turn turn;
  World& w = world();
  w.pan += std::clamp(w.pan_to - w.pan, -0.02, 0.02);
  return std::abs(w.pan_to - w.pan) > 0.001 ? kExec : kEther;
}
int viamAcquireStart(int&) {
  const Turn turn;
  read_sensors();
  if (bus() != nullptr) bus()->exposes = is_sharp();
  world().busy_until = world().now + 3;
  return kExec;
}
int viamAcquireMain(int&) {
  const Turn turn;
  read_sensors();
  return world().now < world().busy_until ? kExec : kEnd;
}
// To the sides of the front wheels, where the PTU looks.
int viamAcquireEnd(int&) {
  const Turn turn;
  if (bus() != nullptr) bus()->exposes = false;
  static Image picture;
  take(picture, world(), 640, 480, world().pan - 0.4, world().pan + 0.4);
  ++world().pictures;
  return kEther;
}
int viamAcquireContinuousMain(int&) {
  const Turn turn;
  read_sensors();
  if (bus() != nullptr) bus()->exposes_pair = kShared->takes_pairs.load();
  if (kShared->takes_pairs) take_pair(kShared->pair, world());
  else take(panorama(), world(), 1280, 480, -kPi, kPi);
  return kExec;
}
// A red rock in front.
int hueblobMonitorMain(int&) {
  const Turn turn;
  double direction = 0;
  return find_red(panorama(), direction) && std::abs(direction) < 0.8 ? kEnd : kExec;
}

// ---- Stereo, DTM, P3D: points of pairs, a map of heights, arcs over it
int stereoCorrelateContinuousMain(int&) {
  const Turn turn;
  if (kShared->pair.at > kShared->cloud.at) correlate(kShared->cloud, kShared->pair);
  return kExec;
}
int dtmFuseContinuousMain(int&) {
  const Turn turn;
  kShared->map.fuse(kShared->cloud);
  if (bus() != nullptr) bus()->mapped_at = kShared->map.at;
  return kExec;
}
int p3dSetSpeed() {
  const Turn turn;
  kShared->arcs.fastest = input("P3D.SetSpeed", 0, kShared->arcs.fastest);
  return kOk;
}
int p3dGoToStart(int&) {
  const Turn turn;
  ArcPlanner& arcs = kShared->arcs;
  arcs.goal_x = input("P3D.GoTo", 0, world().x);
  arcs.goal_y = input("P3D.GoTo", 1, world().y);
  arcs.blocked_since = -1;
  return kExec;
}
int p3dGoToMain(int& report) {
  const Turn turn;
  World& w = world();
  ArcPlanner& arcs = kShared->arcs;
  if (std::hypot(arcs.goal_x - w.x, arcs.goal_y - w.y) < 0.25) return kEnd;
  const bool is_free = arcs.plan(kShared->map, w);
  w.wanted_v = arcs.v;
  w.wanted_turn = arcs.turn;
  note_reference(Finder::Vision);
  if (is_free) arcs.blocked_since = -1;
  else if (arcs.blocked_since < 0) arcs.blocked_since = w.now;
  if (is_free || w.now - arcs.blocked_since < 25) return kExec;
  report = 1;  // BLOCKED
  return kEther;
}
int p3dGoToEnd(int&) {
  const Turn turn;
  kShared->arcs.v = kShared->arcs.turn = world().wanted_v = world().wanted_turn = 0;
  note_reference(Finder::Vision);
  return kEther;
}
int p3dGoToInter(int& report) {
  p3dGoToEnd(report);
  return kEther;
}

// ---- Antenna: pictures to the orbiter, while it is there
int antennaCheckWindow() {
  const Turn turn;
  return world().orbiter_is_visible() ? kOk : 1;
}
int antennaCommunicateMain(int&) {
  const Turn turn;
  World& w = world();
  const bool sends = w.sent != w.pictures && w.orbiter_is_visible();
  if (bus() != nullptr) bus()->sends = sends;
  if (!sends) return kEther;
  if (w.now >= w.busy_until) {
    ++w.sent;
    w.busy_until = w.now + 1;
  }
  return kExec;
}

// ---- ends at once and well
int pomInitMain(int&) { return kEther; }
int pomCheckReference() { return kOk; }
int pomSetReferenceMain(int&) { return kEther; }
int pomSetFrame() { return kOk; }
int rflexInitMain(int&) { return kEther; }
int rflexCheckTrack() { return kOk; }
int rflexGotoPositionStart(int&) {
  is_stopped() = false;
  return kExec;
}
int rflexGotoPositionEnd(int&) { return kEther; }
int rflexGotoSpeedStart(int&) { return kExec; }
int rflexGotoSpeedMain(int&) { return kEther; }
int rflexGotoSpeedInter(int&) { return kEther; }
int rflexSetPositionMain(int&) { return kEther; }
int rflexBrakesOnMain(int&) { return kEther; }
int rflexBrakesOffMain(int&) { return kEther; }
int rflexCalibrateMain(int&) { return kEther; }
int rflexMonitorBatteryMain(int&) { return kEther; }
int rflexSonarOnMain(int&) { return kEther; }
int rflexLogStartMain(int&) { return kEther; }
int rflexSetMode() { return kOk; }
int rflexTrackPermanent() { return kOk; }
int laserrfInitStart(int&) { return kExec; }
int laserrfInitMain(int&) { return kEther; }
int laserCheckMode() { return kOk; }
int laserrfSetModeMain(int&) { return kEther; }
int laserrfSetResolutionMain(int&) { return kEther; }
int laserCheckStart() { return kOk; }
int laserrfStartAcquisitionStart(int&) { return kExec; }
int laserrfOneScanMain(int&) { return kEther; }
int laserrfSetSegmentationMain(int&) { return kEther; }
int laserrfLogStartMain(int&) { return kEther; }
int laserrfMonitorMain(int&) { return kEther; }
int laserrfResetMain(int&) { return kEther; }
int laserSetPeriod() { return kOk; }
int laserSetFrame() { return kOk; }
int laserSetPort() { return kOk; }
int aspectInitMain(int&) { return kEther; }
int aspectCheckView() { return kOk; }
int aspectSetViewParametersMain(int&) { return kEther; }
int aspectBuildMapStart(int&) { return kExec; }
int aspectAddSegmentMain(int&) { return kEther; }
int aspectSetSource() { return kOk; }
int aspectSetRange() { return kOk; }
int nddInitMain(int&) { return kEther; }
int nddCheckParams() { return kOk; }
int nddSetParamsMain(int&) { return kEther; }
int nddSetDataSourceMain(int&) { return kEther; }
int nddCheckSpeed() { return kOk; }
int nddSetSpeedMain(int&) {
  const Turn turn;
  world().fastest = input("NDD.SetSpeed", 0, world().fastest);
  return kEther;
}
int nddCheckGoal() { return kOk; }
int heatingInitMain(int&) { return kEther; }
int heatingCheckGoal() { return kOk; }
int heatingHeatToInter(int&) { return kEther; }
int heatingMonitorMain(int&) { return kEther; }
int heatingCoolDownMain(int&) { return kEther; }
int heatingSetLimits() { return kOk; }
int batteryInitMain(int&) { return kEther; }
int batteryCheckPower() { return kOk; }
int batteryCameraStartUsingBatteryEnd(int&) { return kEther; }
int batteryCameraStartUsingBatteryInter(int&) { return kEther; }
int batteryPTUStartUsingBatteryEnd(int&) { return kEther; }
int batteryPTUStartUsingBatteryInter(int&) { return kEther; }
int batteryLaserStartUsingBatteryEnd(int&) { return kEther; }
int batteryLaserStartUsingBatteryInter(int&) { return kEther; }
int batteryWheelsStartUsingBatteryEnd(int&) { return kEther; }
int batteryWheelsStartUsingBatteryInter(int&) { return kEther; }
int batteryAntennaStartUsingBatteryEnd(int&) { return kEther; }
int batteryAntennaStartUsingBatteryInter(int&) { return kEther; }
int antennaInitMain(int&) { return kEther; }
int antennaCommunicateStart(int&) { return kExec; }
int antennaCommunicateInter(int&) {
  if (bus() != nullptr) bus()->sends = false;
  return kEther;
}
int antennaAddWindow() { return kOk; }
int ptuInitStart(int&) { return kExec; }
int ptuInitMain(int&) { return kEther; }
int ptuCheckAngles() { return kOk; }
int ptuMoveAbsoluteInter(int&) { return kEther; }
int ptuMoveRelativeStart(int&) { return kExec; }
int ptuMoveRelativeMain(int&) { return kEther; }
int ptuMoveRelativeInter(int&) { return kEther; }
int ptuTrackStart(int&) { return kExec; }
int ptuTrackMain(int&) { return kEther; }
int ptuTrackInter(int&) { return kEther; }
int ptuCalibrateMain(int&) { return kEther; }
int ptuSetSpeed() { return kOk; }
int ptuPermanent() { return kOk; }
int viamInitMain(int&) { return kEther; }
int viamCheckFormat() { return kOk; }
int viamConfigureMain(int&) { return kEther; }
int viamCheckBank() { return kOk; }
int viamAcquireInter(int&) {
  if (bus() != nullptr) bus()->exposes = false;
  return kEther;
}
int viamAcquireContinuousStart(int&) { return kExec; }
int viamAcquireContinuousEnd(int&) { return kEther; }
int viamAcquireContinuousInter(int&) {
  if (bus() != nullptr) bus()->exposes_pair = false;
  return kEther;
}
int viamSaveMain(int&) { return kEther; }
int viamLoadMain(int&) { return kEther; }
int viamDisplayMain(int&) { return kEther; }
int viamDisplayInter(int&) { return kEther; }
int viamLogStartMain(int&) { return kEther; }
int viamSetExposure() { return kOk; }
int viamSetGain() { return kOk; }
int viamCreateBank() { return kOk; }
int hueblobInitMain(int&) { return kEther; }
int hueCheckMonitor() { return kOk; }
int hueblobMonitorStart(int&) { return kExec; }
int hueblobMonitorEnd(int&) { return kEther; }
int hueblobMonitorInter(int&) { return kEther; }
int hueblobDetectStart(int&) { return kExec; }
int hueblobDetectMain(int&) { return kEnd; }
int hueblobDetectEnd(int&) { return kEther; }
int hueCheckHue() { return kOk; }
// Faults: with the word `hang` it takes four seconds, with `crash` it writes where there is nothing, with `exit` it
// ends the process, with `throw` it throws.
int hueblobSetHueMain(int&) {
  std::string words;
  {
    const Turn turn;
    words = hue();
  }
  if (words == "throw") throw std::runtime_error("no such hue");
  if (words == "hang") std::this_thread::sleep_for(std::chrono::seconds(4));
  if (words == "exit") std::exit(0);
  static volatile std::uintptr_t nowhere = 0;
  if (words == "crash") *reinterpret_cast<volatile int*>(nowhere) = 1;
  return kEther;
}
int hueblobLearnStart(int&) { return kExec; }
int hueblobLearnMain(int&) { return kEnd; }
int hueblobLearnEnd(int&) { return kEther; }
int hueSetSource() { return kOk; }
int huePermanent() { return kOk; }
int dtmInitMain(int&) { return kEther; }
int dtmCheckFuse() { return kOk; }
int dtmFuseStart(int&) { return kExec; }
int dtmFuseMain(int&) { return kEnd; }
int dtmFuseEnd(int&) { return kEther; }
int dtmFuseInter(int&) { return kEther; }
int dtmFuseContinuousStart(int&) { return kExec; }
int dtmFuseContinuousEnd(int&) { return kEther; }
int dtmFuseContinuousInter(int&) { return kEther; }
int dtmResetMapMain(int&) { return kEther; }
int dtmSaveMain(int&) { return kEther; }
int dtmLoadMain(int&) { return kEther; }
int dtmExtractMain(int&) { return kEnd; }
int dtmExtractEnd(int&) { return kEther; }
int dtmSetResolution() { return kOk; }
int dtmSetSource() { return kOk; }
int dtmPermanent() { return kOk; }
int stereoInitMain(int&) { return kEther; }
int stereoCheckPair() { return kOk; }
namespace {
std::atomic<bool> is_stuck{false};
}
int stereoCorrelateStart(int&) {
  const Turn turn;
  is_stuck = std::isnan(input("Stereo.Correlate", 0, 0));
  return kExec;
}
// Beside everything else (async.yields). Asked for with a word it waits for an image that never comes, until it gets
// another source.
int stereoCorrelateMain(int&) {
  const int before = sources_set();
  for (int k = 0; k < 4000 && is_stuck && sources_set() == before; ++k)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return kEnd;
}
int stereoCorrelateEnd(int&) { return kEther; }
int stereoCorrelateInter(int&) { return kEther; }
int stereoCorrelateContinuousStart(int&) { return kExec; }
int stereoCorrelateContinuousEnd(int&) { return kEther; }
int stereoCorrelateContinuousInter(int&) { return kEther; }
int stereoRectifyMain(int&) { return kEnd; }
int stereoRectifyEnd(int&) { return kEther; }
int stereoCalibrateMain(int&) { return kEther; }
int stereoSaveMain(int&) { return kEther; }
int stereoSetParameters() { return kOk; }
int stereoSetSource() { return kOk; }
int stereoPermanent() { return kOk; }
int p3dInitMain(int&) { return kEther; }
int p3dCheckGoal() { return kOk; }
int p3dTrackPathStart(int&) { return kExec; }
int p3dTrackPathMain(int&) { return kEnd; }
int p3dTrackPathEnd(int&) { return kEther; }
int p3dTrackPathInter(int&) { return kEther; }
int p3dEvaluateMain(int&) { return kEther; }
int p3dCheckArcs() { return kOk; }
int p3dSetArcsMain(int&) { return kEther; }
int p3dSetCostsMain(int&) { return kEther; }
int p3dSetDemMain(int&) { return kEther; }
int p3dPlanStart(int&) { return kExec; }
int p3dPlanMain(int&) { return kEther; }
int p3dPlanInter(int&) { return kEther; }
int p3dLogStartMain(int&) { return kEther; }
int p3dRecoverMain(int&) { return kEther; }
int p3dSetSource() { return kOk; }
int p3dSetPoseSource() { return kOk; }
int p3dPermanent() { return kOk; }
