// Lists the locations of a zone graph with their zones as rows of a certificate (compiler/docs/certificate.md): the set
// of their points is closed under steps and under time. A row of a state has only what differs from the state before.
// Cost: the text; the differences of two clocks that follow from the bounds of each are left out.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/verify/evidence/reached_states.hpp"
#include "runtime/explore/zones.hpp"

namespace bip::verify {

/// Does the observer of a response run beside the zone graph?
enum class ZoneObserver : std::uint8_t { None, OfResponse };

class ZoneCollector {
 public:
  /// Refers to `system`, which must outlive it. `unread_cells`: data that may have any value (unread_data.hpp).
  /// `bytes`: of the text.
  ZoneCollector(const System& system, const rt::Image& image, const std::vector<rt::VariableId>& unread_cells,
                std::size_t bytes, ZoneObserver observer = ZoneObserver::None);
  /// Returns what of the model no row can say or the checker cannot follow, with its name; empty if there is nothing.
  [[nodiscard]] const std::string& problem() const { return problem_; }
  void add(const rt::ListedLocation& location);
  /// Returns the rows; an empty text if they would be too long.
  [[nodiscard]] std::string rows() && { return is_too_long_ ? std::string() : std::move(rows_); }

 private:
  /// `rank` is empty, or a word of the row.
  void append(const rt::Zone& zone, const std::string& rank);

  std::vector<StateColumn> columns_;
  std::vector<std::string> busy_atoms_;  // by atom: its path if its type has time, else empty
  std::vector<std::string> clocks_;      // by clock + 1: "ROOT.a.x"
  std::vector<std::int64_t> last_;       // of columns, busy atoms and the observer: what the row before says
  ZoneObserver observer_;
  std::size_t bytes_;
  std::string rows_, problem_;
  bool is_too_long_ = false;
};

}  // namespace bip::verify
