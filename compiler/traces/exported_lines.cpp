// See exported_lines.hpp. Of an MCAP file the records are read in their order (specification, version 0): chunks, the
// metadata of the channel `/steps`, its messages; indexes and summary are passed over. Of a Perfetto file each line is
// an event: names of tracks, interactions on track 0, and after each its ports on the tracks of their components.
#include "compiler/traces/exported_lines.hpp"

#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bip/assert.hpp"
#include "compiler/base/json_text.hpp"
#include "compiler/traces/compress_chunk.hpp"

namespace bip::traces {

namespace {

using Json = nlohmann::ordered_json;
constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8), kPerfettoHead =
                                                               R"({"displayTimeUnit":"ns","otherData":{"model":)";
// Bounds the memory that a chunk can claim: bipc writes chunks of 1 MiB and one step.
constexpr std::uint64_t kMostOfChunk = std::uint64_t{1} << 30;

std::string dumped(const Json& json) { return json_line(json) + "\n"; }

const Json* found(const Json& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto at = object.find(name);
  return at == object.end() ? nullptr : &*at;
}
bool has_text(const Json& object, const char* name) {
  const Json* const value = found(object, name);
  return value != nullptr && value->is_string();
}

std::string head_line(const std::string& model, const std::string& policy, const std::string& seed,
                      const std::string& resumes) {
  std::uint64_t number = 0;
  for (const char c : seed)
    if (c >= '0' && c <= '9') number = number * 10 + static_cast<std::uint64_t>(c - '0');
  Json head = {{"format", "bipc-trace"}, {"version", 1}, {"model", model}, {"seed", number}, {"policy", policy}};
  if (!resumes.empty()) head["resumes"] = resumes;
  return dumped(head);
}

// Appends the line of a step; its number must be the next one. Empty, or what is wrong.
std::string append_step(std::string& out, std::uint64_t& next, const Json& number, std::int64_t instant,
                        Instants instants, const std::string& interaction, Json ports) {
  if (!number.is_number_unsigned() || number.get<std::uint64_t>() != next)
    return fmt::format("step {} is not in it: a part of a run cannot be repeated", next);
  ++next;
  Json line{{"step", number}};
  if (instants == Instants::OfTheModel) line["time"] = instant;
  line["interaction"] = interaction;
  line["ports"] = std::move(ports);
  out += dumped(line);
  return {};
}

// Fields in little endian; after the first that goes beyond the end nothing more is read.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : bytes_(bytes) {}
  std::uint64_t number(std::size_t size) {
    BIP_ASSERT(size <= sizeof(std::uint64_t), "a number of {} bytes", size);
    std::uint64_t value = 0;
    const std::string_view part = take(size);
    for (std::size_t k = part.size(); k-- > 0;) value = value << 8 | static_cast<unsigned char>(part[k]);
    return value;
  }
  std::string_view take(std::uint64_t size) {
    if (size > bytes_.size()) is_sound_ = false;
    const std::string_view part = is_sound_ ? bytes_.substr(0, static_cast<std::size_t>(size)) : std::string_view();
    bytes_.remove_prefix(part.size());
    return part;
  }
  std::string_view text() { return take(number(4)); }
  [[nodiscard]] std::string_view rest() const { return bytes_; }
  [[nodiscard]] bool is_sound() const { return is_sound_; }

 private:
  std::string_view bytes_;
  bool is_sound_ = true;
};

class McapReader {
 public:
  explicit McapReader(Instants instants) : instants_(instants) {}

  Result<std::string> read(std::string_view bytes) {
    BIP_ASSERT(is_mcap(bytes), "{} bytes without the mark of MCAP", bytes.size());
    bytes.remove_prefix(kMcapMagic.size());
    records(bytes);
    if (!problem_.empty()) return Failure{problem_};
    if (out_.empty()) return Failure{"it has no channel `/steps` of a run that bipc wrote"};
    if (!has_end_) return Failure{"it is cut off"};
    return std::move(out_);
  }

 private:
  void records(std::string_view bytes) {
    Fields all(bytes);
    while (problem_.empty() && !is_done_ && !all.rest().empty()) {
      const std::uint64_t opcode = all.number(1), size = all.number(8);
      const std::string_view content = all.take(size);
      if (!all.is_sound()) return;  // cut off: there is no end of the data
      if (opcode == 4) channel(content);
      else if (opcode == 5) message(content);
      else if (opcode == 6) chunk(content);
      else if (opcode == 15) is_done_ = has_end_ = true;
    }
  }

  void channel(std::string_view content) {
    Fields fields(content);
    const std::uint64_t id = fields.number(2);
    (void)fields.number(2);
    const std::string_view topic = fields.text();
    (void)fields.text();
    Fields entries(fields.text());
    if (topic != "/steps" || steps_ || !fields.is_sound()) return;
    std::map<std::string, std::string, std::less<>> metadata;
    while (entries.is_sound() && !entries.rest().empty()) {
      const std::string key(entries.text());
      metadata[key] = std::string(entries.text());
    }
    if (!metadata.contains("model") || !metadata.contains("policy") || !metadata.contains("seed")) return;
    steps_ = id;
    out_ = head_line(metadata["model"], metadata["policy"], metadata["seed"], metadata["resumes"]);
  }

  void message(std::string_view content) {
    Fields fields(content);
    if (fields.number(2) != steps_) return;
    (void)fields.number(4);
    const auto instant = static_cast<std::int64_t>(fields.number(8));
    (void)fields.number(8);
    const Json step = parse_json(fields.rest());
    if (!fields.is_sound() || found(step, "step") == nullptr || !has_text(step, "interaction") ||
        found(step, "ports") == nullptr) {
      problem_ = fmt::format("message {} of `/steps` is no step", next_);
      return;
    }
    problem_ = append_step(out_, next_, step["step"], instant, instants_, step["interaction"].get<std::string>(),
                           step["ports"]);
  }

  void chunk(std::string_view content) {
    Fields fields(content);
    (void)fields.take(16);
    const std::uint64_t size = fields.number(8);
    (void)fields.number(4);
    const std::string_view compression = fields.text(), packed = fields.take(fields.number(8));
    if (!fields.is_sound() || size > kMostOfChunk) {
      problem_ = "a chunk goes beyond its record";
    } else if (compression.empty()) {
      records(packed);
    } else if (compression != "zstd") {
      problem_ = fmt::format("its chunks are compressed with `{}`: bipc writes zstd or nothing", compression);
    } else if (!has_zstd()) {
      problem_ = "its chunks are compressed with zstd, and this bipc was built without libzstd";
    } else if (const std::optional<std::string> text = unzstd(packed, static_cast<std::size_t>(size))) {
      records(*text);
    } else {
      problem_ = "a chunk is no zstd of its size";
    }
  }

  Instants instants_;
  std::string out_, problem_;
  std::optional<std::uint64_t> steps_;  // the channel's id
  std::uint64_t next_ = 0;
  bool is_done_ = false, has_end_ = false;
};

class PerfettoReader {
 public:
  explicit PerfettoReader(Instants instants) : instants_(instants) {}

  Result<std::string> read(std::string_view text) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return Failure{"it is cut off"};
    const Json head = parse_json(std::string(text.substr(0, end)) + "]}");
    const Json* const data = found(head, "otherData");
    if (data == nullptr || !has_text(*data, "model") || !has_text(*data, "seed") || !has_text(*data, "policy"))
      return Failure{"its first line does not say of which run it is"};
    out_ = head_line((*data)["model"], (*data)["policy"], (*data)["seed"],
                     has_text(*data, "resumes") ? (*data)["resumes"].get<std::string>() : "");
    text.remove_prefix(end + 1);
    while (!text.empty() && problem_.empty() && !is_done_) {
      std::string_view line = text.substr(0, std::min(text.find('\n'), text.size()));
      text.remove_prefix(std::min(line.size() + 1, text.size()));
      if (line.ends_with(',')) line.remove_suffix(1);
      event(parse_json(line));
    }
    if (problem_.empty() && !is_done_) problem_ = "it is cut off";
    if (!problem_.empty()) return Failure{problem_};
    return std::move(out_);
  }

 private:
  void event(const Json& event) {
    const Json *const track = found(event, "tid"), *const arguments = found(event, "args"),
                      *const instant = found(event, "ts");
    if (track == nullptr || !track->is_number_unsigned() || !has_text(event, "name")) return;
    const std::string name = event["name"];
    if (name == "thread_name" && arguments != nullptr && has_text(*arguments, "name"))
      paths_[track->get<std::uint64_t>()] = (*arguments)["name"];
    if (!has_text(event, "cat")) return;
    const std::string category = event["cat"];
    if (category == "end") {
      close();
      is_done_ = true;
      return;
    }
    const Json* const step = arguments == nullptr ? nullptr : found(*arguments, "step");
    if (step == nullptr || instant == nullptr || !instant->is_number()) return;
    if (category == "interaction") {
      close();
      is_open_ = true;
      number_ = *step;
      interaction_ = name;
      instant_ = std::llround(instant->get<double>() * 1000);
      ports_ = Json::array();
    } else if (category == "port" && is_open_ && *step == number_) {
      Json port{{"port", paths_[track->get<std::uint64_t>()] + "." + name}};
      if (const Json* const values = found(*arguments, "values")) port["values"] = *values;
      ports_.push_back(std::move(port));
    }
  }
  // The step whose ports have been read.
  void close() {
    if (is_open_) problem_ = append_step(out_, next_, number_, instant_, instants_, interaction_, std::move(ports_));
    is_open_ = false;
  }

  Instants instants_;
  std::string out_, problem_, interaction_;
  std::map<std::uint64_t, std::string> paths_;  // by track
  std::uint64_t next_ = 0;
  std::int64_t instant_ = 0;
  Json number_, ports_;
  bool is_open_ = false, is_done_ = false;
};

}  // namespace

bool is_mcap(std::string_view bytes) { return bytes.starts_with(kMcapMagic); }
bool is_perfetto(std::string_view text) { return text.starts_with(kPerfettoHead); }

Result<std::string> lines_of_mcap(std::string_view bytes, Instants instants) {
  return McapReader(instants).read(bytes);
}
Result<std::string> lines_of_perfetto(std::string_view text, Instants instants) {
  return PerfettoReader(instants).read(text);
}

}  // namespace bip::traces
