// The states with zones of a certificate with time (compiler/docs/certificate.md, *With time*) as the page reads them.
//
// A location: {"places": [text by atom, or null], "values": [[atom, variable, value]], "waits": [atom],
//              "zones": [[[atom, clock, low or null, high or null] or the same with a second atom and clock]]}
// The second ones are subtracted. Places as the page's states have them ("A, B"), values as numbers; bounds in ns.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "compiler/system/system_ids.hpp"

namespace bip::view {

class ZoneRecorder {
 public:
  explicit ZoneRecorder(const System& system);

  /// The words behind `state`: what differs from the state before.
  void add_state(const std::vector<std::string_view>& words);
  /// The words behind `zone`, of the last state.
  void add_zone(const std::vector<std::string_view>& words);
  /// Empty, or what in the last row is not of this model.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// All locations; zones beyond kMostZones are counted in left_out().
  [[nodiscard]] nlohmann::ordered_json take() { return std::move(locations_); }
  [[nodiscard]] std::size_t left_out() const { return left_out_; }

  static constexpr std::size_t kMostZones = 20000;

 private:
  using Json = nlohmann::ordered_json;
  struct Name {
    std::size_t atom = 0, row = 0;
  };
  void take_word(std::string_view word);
  void take_place(std::string_view path, std::string_view place, bool is_marked);
  void take_value(std::string_view name, std::string_view value);
  [[nodiscard]] bool find_clock(std::string_view name, Name& out);
  [[nodiscard]] Json bound_of(std::string_view word);

  const System& system_;
  std::map<std::string, std::size_t, std::less<>> atoms_;
  std::map<std::string, Name, std::less<>> clocks_, variables_;
  std::vector<std::vector<bool>> marks_;  // by atom and place, of the last state
  std::vector<bool> is_placed_, waits_;   // by atom
  std::map<std::pair<std::size_t, std::size_t>, long long> values_;
  Json locations_ = Json::array();
  std::map<std::string, std::size_t> rows_;  // by what a location says
  std::size_t now_ = 0;                      // row of the last state's
  std::size_t zones_ = 0, left_out_ = 0;
  std::string problem_;
};

}  // namespace bip::view
