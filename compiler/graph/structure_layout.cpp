// See structure_layout.hpp.
#include "compiler/graph/structure_layout.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "compiler/graph/child_order.hpp"
#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

constexpr double kGrid = 8, kGap = 24, kPad = 16, kHead = 24, kNoteLine = 14;
constexpr double kClear = 18;                   // from a box to the first track
constexpr double kNamed = 18, kUnnamed = 9;     // from a track to the next one
constexpr double kWideRow = 860, kShape = 1.7;  // a box with several rows is so much wider than high
constexpr double kChannelGuess = 70, kMostSpread = 160;

double on_grid(double x) { return std::ceil(x / kGrid - 1e-9) * kGrid; }

/// Lays out one open box whose children have their sizes.
class ChannelLayout {
 public:
  ChannelLayout(const Scene& scene, std::vector<PlacedBox>& placed, u32 box)
      : boxes_(scene.boxes), placed_(placed), box_(scene.boxes[box]), self_(placed[box]) {
    self_.nets.resize(box_.nets.size());
    self_.tabs.resize(box_.ports.size());
    members_ = members_of_nets(box_);
  }

  void run() {
    collect_stems();
    make_rows();
    order_ports();
    place_stems();
    find_channels();
    place_exits();
    place_tracks();
    place_vertically();
    make_lines();
    place_names();
  }

 private:
  struct Stem {
    u32 net = 0, end = 0, child = 0, port = 0;
    double x = 0;
  };
  /// The part of a net in a channel.
  struct Part {
    u32 channel = 0;
    double low = 1e9, high = -1e9;
    u32 stems = 0;
    bool has_lower = false, is_upper = false;
    u32 track = 0;
    double y = 0;
  };
  struct Channel {
    std::vector<u32> nets;
    std::vector<bool> named_low, named_high;  // by track, from below and from above
    double top = 0, bottom = 0;
  };
  struct Joint {
    u32 net = 0, end = 0, child = 0, channel = 0;
    double x = 0;
  };
  struct Vertical {
    double x, top, bottom;
    u32 net;
  };

  [[nodiscard]] bool has_name(u32 net) const {
    return box_.nets[net].kind == NetKind::Connector || box_.nets[net].kind == NetKind::Merged;
  }
  [[nodiscard]] double name_width(u32 net) const { return text_width(box_.nets[net].name, kNameSize); }

  void collect_stems() {
    for (u32 net = 0; net < box_.nets.size(); ++net)
      for (u32 end = 0; end < box_.nets[net].ends.size(); ++end)
        if (const SceneEnd& row = box_.nets[net].ends[end]; row.net == kNoRow) {
          BIP_ASSERT(&boxes_[boxes_[row.box].parent] == &box_ && row.port < boxes_[row.box].ports.size(),
                     "net {} ends at port {} of box {}, which is not beside it", net, row.port, row.box);
          stems_.push_back({net, end, row.box, row.port, 0});
        }
  }

  // -- Rows --

  void make_rows() {
    std::vector<u32> order = order_of_children(box_.children, members_);
    double total = 0, area = 0;
    for (const u32 child : order) {
      total += placed_[child].width + kGap;
      area += (placed_[child].width + kGap) * (placed_[child].height + kChannelGuess);
    }
    const double wide = std::max(kWideRow, std::sqrt(area * kShape));
    const std::size_t count = static_cast<std::size_t>(std::ceil(std::max(total / wide - 0.1, 1.0)));
    if (!split_in_two(order, total, count))
      fill_rows(order, total, std::min(count, std::max<std::size_t>(order.size(), 1)));
    std::erase_if(rows_, [](const std::vector<u32>& list) { return list.empty(); });
    if (rows_.empty()) rows_.emplace_back();
    content_width_ = 0;
    for (const std::vector<u32>& list : rows_) {
      double x = 0;
      for (const u32 child : list) x += placed_[child].width + kGap;
      content_width_ = std::max(content_width_, x - (list.empty() ? 0 : kGap));
    }
    for (u32 r = 0; r < rows_.size(); ++r) place_row(r);
    BIP_ASSERT(row_of_.size() == box_.children.size(), "{} of {} children are in rows", row_of_.size(),
               box_.children.size());
  }

  /// Two kinds of children that only meet each other, clients and servers, face each other if both rows are long.
  bool split_in_two(const std::vector<u32>& order, double total, std::size_t count) {
    if (count > 2 || total < kWideRow / 2) return false;
    const std::vector<u32> side = sides_of_children(order, members_);
    if (side.empty()) return false;
    double first = 0;
    for (std::size_t k = 0; k < order.size(); ++k)
      if (side[k] == 0) first += placed_[order[k]].width + kGap;
    if (std::min(first, total - first) < total / 4) return false;
    rows_.resize(2);
    for (std::size_t k = 0; k < order.size(); ++k) rows_[side[k]].push_back(order[k]);
    return true;
  }

  void fill_rows(const std::vector<u32>& order, double total, std::size_t count) {
    rows_.resize(count);
    const std::size_t first_pair = count % 2;  // an odd number: the first row stands alone
    double used = 0;
    std::vector<double> widths(count, 0);
    for (const u32 child : order) {
      const double width = placed_[child].width + kGap;
      // The pair of rows (or the single one) at this part of the whole; in it the shorter row.
      const std::size_t at =
          std::min(count - 1, static_cast<std::size_t>((used + width / 2) / total * static_cast<double>(count)));
      std::size_t row = at < first_pair ? 0 : first_pair + (at - first_pair) / 2 * 2;
      if (row >= first_pair && widths[row + 1] < widths[row]) ++row;
      rows_[row].push_back(child);
      widths[row] += width;
      used += width;
    }
  }

  void place_row(u32 r) {
    double width = -kGap;
    for (const u32 child : rows_[r]) width += placed_[child].width + kGap;
    // A short row is spread, for straighter lines, and stands in the middle.
    const double rest = content_width_ - std::max(width, 0.0), size = static_cast<double>(rows_[r].size());
    const double more = std::floor(std::min(rest / (size + 1), kMostSpread) / kGrid) * kGrid;
    double x = kPad + std::floor((rest - more * (size - 1)) / 2 / kGrid) * kGrid;
    for (const u32 child : rows_[r]) {
      row_of_[child] = r;
      placed_[child].x = x;
      placed_[child].is_flipped = is_upper(r);
      x += placed_[child].width + kGap + more;
    }
    BIP_ASSERT(rows_[r].empty() || x - kGap - more <= kPad + content_width_, "row {} ends at {}, of {}", r,
               x - kGap - more, content_width_);
  }
  [[nodiscard]] bool is_odd() const { return rows_.size() % 2 == 1; }
  [[nodiscard]] u32 channel_of(u32 row) const { return is_odd() ? (row + 1) / 2 : row / 2 + 1; }
  [[nodiscard]] bool is_upper(u32 row) const { return is_odd() ? row % 2 == 1 : row % 2 == 0; }
  [[nodiscard]] u32 channel_count() const { return channel_of(static_cast<u32>(rows_.size()) - 1) + 1; }

  [[nodiscard]] double centre(u32 child) const { return placed_[child].x + placed_[child].width / 2; }
  /// Where the other children of the net are, on average; its own place if there are none.
  [[nodiscard]] double pull(u32 net, u32 child) const {
    double sum = 0;
    u32 count = 0;
    for (const u32 other : members_[net]) {
      if (other == child) continue;
      sum += centre(other);
      ++count;
    }
    return count == 0 ? centre(child) : sum / count;
  }

  // -- Ports and stems --

  void order_ports() {
    std::map<std::pair<u32, u32>, std::pair<double, u32>> pulls;
    for (const Stem& stem : stems_) {
      auto& [sum, count] = pulls[{stem.child, stem.port}];
      sum += pull(stem.net, stem.child);
      ++count;
    }
    for (const u32 child : box_.children) {
      if (boxes_[child].kind == BoxKind::Compound) continue;
      std::vector<PortTab>& tabs = placed_[child].tabs;
      std::vector<u32> order(tabs.size());
      std::iota(order.begin(), order.end(), 0u);
      const auto wish = [&](u32 port) {
        const auto found = pulls.find({child, port});
        return found == pulls.end() ? 1e9 : found->second.first / found->second.second;
      };
      std::stable_sort(order.begin(), order.end(), [&](u32 a, u32 b) { return wish(a) < wish(b); });
      double width = 0;
      for (const PortTab& tab : tabs) width += tab.width;
      double x = std::floor((placed_[child].width - width) / 2 / kGrid) * kGrid;
      for (const u32 port : order) {
        tabs[port].x = x;
        x += tabs[port].width;
      }
    }
  }

  void place_stems() {
    std::map<std::pair<u32, u32>, std::vector<u32>> of_port;
    for (u32 k = 0; k < stems_.size(); ++k) of_port[{stems_[k].child, stems_[k].port}].push_back(k);
    for (auto& [where, list] : of_port) {
      const auto [child, port] = where;
      const PlacedBox& box = placed_[child];
      const bool is_open = boxes_[child].kind == BoxKind::Compound;
      std::stable_sort(list.begin(), list.end(),
                       [&, of = child](u32 a, u32 b) { return pull(stems_[a].net, of) < pull(stems_[b].net, of); });
      // An open box's tab begins at the line inside of it; others have their stems in the middle.
      const double first =
          is_open ? box.tabs[port].x
                  : std::round(
                        (box.tabs[port].x + (box.tabs[port].width - kGrid * static_cast<double>(list.size() - 1)) / 2) /
                        kGrid) *
                        kGrid;
      for (u32 k = 0; k < list.size(); ++k) stems_[list[k]].x = box.x + first + kGrid * k;
    }
    // The verticals of two rows that face each other must not meet.
    std::map<std::pair<u32, double>, u32> lower;
    for (const Stem& stem : stems_)
      if (!is_upper(row_of_[stem.child])) lower[{channel_of(row_of_[stem.child]), stem.x}] = stem.net;
    for (Stem& stem : stems_) {
      if (!is_upper(row_of_[stem.child])) continue;
      const auto met = lower.find({channel_of(row_of_[stem.child]), stem.x});
      if (met != lower.end() && met->second != stem.net) stem.x += kGrid / 2;
    }
  }

  // -- Channels --

  Part& part(u32 net, u32 channel) {
    for (Part& row : parts_[net])
      if (row.channel == channel) return row;
    parts_[net].push_back({.channel = channel});
    return parts_[net].back();
  }
  static void widen(Part& row, double x) {
    row.low = std::min(row.low, x);
    row.high = std::max(row.high, x);
  }

  void find_channels() {
    channels_.resize(channel_count());
    parts_.resize(box_.nets.size());
    for (const Stem& stem : stems_) {
      const u32 row = row_of_[stem.child];
      Part& p = part(stem.net, channel_of(row));
      widen(p, stem.x);
      ++p.stems;
      p.has_lower = p.has_lower || !is_upper(row);
    }
    std::map<u32, std::vector<double>> used;  // by channel: places of joints
    for (u32 net = 0; net < box_.nets.size(); ++net) {
      for (u32 end = 0; end < box_.nets[net].ends.size(); ++end) {
        const u32 child = box_.nets[net].ends[end].net;
        if (child == kNoRow) continue;
        const auto top = std::min_element(parts_[child].begin(), parts_[child].end(),
                                          [](const Part& a, const Part& b) { return a.channel < b.channel; });
        BIP_ASSERT(top != parts_[child].end(), "net {} binds net {}, which reaches nothing", net, child);
        std::vector<double>& taken = used[top->channel];
        double x = std::round((top->low + top->high) / 2 / kGrid) * kGrid + kGrid / 4;
        while (std::find(taken.begin(), taken.end(), x) != taken.end()) x += kGrid;
        taken.push_back(x);
        widen(*top, x);
        const u32 channel = top->channel;
        joints_.push_back({net, end, child, channel, x});
        Part& p = part(net, channel);
        widen(p, x);
        p.has_lower = true;
      }
      if (box_.nets[net].exit != kNoRow) part(net, 0).has_lower = true;
      std::sort(parts_[net].begin(), parts_[net].end(),
                [](const Part& a, const Part& b) { return a.channel < b.channel; });
    }
    make_trunks();
  }

  /// Nets in several channels have a vertical line to the right of all rows.
  void make_trunks() {
    trunk_.assign(box_.nets.size(), 0);
    std::vector<std::vector<bool>> columns;
    for (u32 net = 0; net < box_.nets.size(); ++net) {
      if (parts_[net].size() < 2) continue;
      const u32 from = parts_[net].front().channel, to = parts_[net].back().channel;
      const auto is_free = [&](const std::vector<bool>& column) {
        return std::none_of(column.begin() + from, column.begin() + to + 1, [](bool b) { return b; });
      };
      auto column = std::find_if(columns.begin(), columns.end(), is_free);
      if (column == columns.end()) column = columns.insert(columns.end(), std::vector<bool>(channels_.size(), false));
      std::fill(column->begin() + from, column->begin() + to + 1, true);
      trunk_[net] = kPad + content_width_ + kGrid + kGrid * static_cast<double>(column - columns.begin());
      for (Part& p : parts_[net]) widen(p, trunk_[net]);
    }
    right_ = kPad + content_width_ + (columns.empty() ? 0 : kGrid + kGrid * static_cast<double>(columns.size()));
  }

  /// Ports on the border: above the lines that lead to them, to the right of the title.
  void place_exits() {
    const double title = text_width(box_.name, kTitleSize) * 1.1 + text_width(" : " + box_.type, kTypeSize) + 3 * kGrid;
    right_ = std::max(right_, on_grid(title + kGrid));
    std::vector<std::vector<u32>> nets(box_.ports.size());
    for (u32 net = 0; net < box_.nets.size(); ++net)
      if (box_.nets[net].exit != kNoRow) nets[box_.nets[net].exit].push_back(net);
    std::vector<double> wish(box_.ports.size(), 0);
    for (u32 port = 0; port < box_.ports.size(); ++port)
      for (const u32 net : nets[port]) {
        const Part& p = part(net, 0);
        if (p.low <= p.high) wish[port] = p.stems == 1 || p.low == p.high ? p.low : (p.low + p.high) / 2;
      }
    std::vector<u32> order(box_.ports.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](u32 a, u32 b) { return wish[a] < wish[b]; });
    exit_x_.assign(box_.nets.size(), 0);
    double x = on_grid(title);
    for (const u32 port : order) {
      PortTab& tab = self_.tabs[port];
      x = std::max(x, std::round(wish[port] / kGrid) * kGrid);
      double at = x;
      for (const Stem& stem : stems_) {
        const bool meets = stem.x == at && channel_of(row_of_[stem.child]) == 0;
        if (meets && std::find(nets[port].begin(), nets[port].end(), stem.net) == nets[port].end()) at += kGrid / 2;
      }
      tab.x = at;
      x = on_grid(x + tab.width);
      right_ = std::max(right_, x);
      for (const u32 net : nets[port]) {
        exit_x_[net] = at;
        widen(part(net, 0), at);
      }
    }
  }

  // -- Tracks --

  /// The channel of a net's name: the one with most of its ends.
  [[nodiscard]] u32 home_part(u32 net) const {
    u32 best = 0;
    for (u32 k = 1; k < parts_[net].size(); ++k)
      if (parts_[net][k].stems > parts_[net][best].stems) best = k;
    return best;
  }

  void place_tracks() {
    std::vector<u32> level(box_.nets.size(), 0);
    for (u32 net = 0; net < box_.nets.size(); ++net)
      for (const SceneEnd& end : box_.nets[net].ends)
        if (end.net != kNoRow) level[net] = std::max(level[net], level[end.net] + 1);
    for (u32 net = 0; net < box_.nets.size(); ++net) {
      if (has_name(net) && !parts_[net].empty()) {
        Part& p = parts_[net][home_part(net)];
        p.high = std::max(p.high, p.low + name_width(net) + 2 * kGrid);
        right_ = std::max(right_, on_grid(p.high));
      }
      for (const Part& p : parts_[net]) channels_[p.channel].nets.push_back(net);
    }
    for (u32 c = 0; c < channels_.size(); ++c) {
      std::vector<u32>& nets = channels_[c].nets;
      const auto length = [&](u32 net) { return part(net, c).high - part(net, c).low; };
      std::stable_sort(nets.begin(), nets.end(), [&](u32 a, u32 b) {
        return level[a] != level[b] ? level[a] < level[b] : length(a) < length(b);
      });
      std::vector<std::vector<std::pair<double, double>>> low, high;
      for (const u32 net : nets) {
        Part& p = part(net, c);
        BIP_ASSERT(p.low <= p.high, "net {} reaches from {} to {} in channel {}", net, p.low, p.high, c);
        p.is_upper = !p.has_lower && c > 0;
        u32 track = 0;
        for (const Joint& joint : joints_)
          if (joint.net == net && joint.channel == c && !part(joint.child, c).is_upper)
            track = std::max(track, part(joint.child, c).track + 1);
        auto& tracks = p.is_upper ? high : low;
        const auto is_free = [&](const std::vector<std::pair<double, double>>& taken) {
          return std::none_of(taken.begin(), taken.end(), [&](const std::pair<double, double>& other) {
            return p.low < other.second + kGrid && other.first < p.high + kGrid;
          });
        };
        while (track < tracks.size() && !is_free(tracks[track])) ++track;
        if (track >= tracks.size()) tracks.resize(track + 1);
        tracks[track].push_back({p.low, p.high});
        p.track = track;
        std::vector<bool>& named = p.is_upper ? channels_[c].named_high : channels_[c].named_low;
        named.resize(tracks.size(), false);
        if (has_name(net) && parts_[net][home_part(net)].channel == c) named[track] = true;
      }
    }
  }

  // Sides of a channel.
  enum class Side : std::uint8_t { Upper, Lower };

  void place_vertically() {
    double y = kHead;
    for (u32 c = 0; c < channels_.size(); ++c) {
      Channel& channel = channels_[c];
      const auto row_at = [&](Side side) -> u32 {
        for (u32 r = 0; r < rows_.size(); ++r)
          if (channel_of(r) == c && is_upper(r) == (side == Side::Upper)) return r;
        return kNoRow;
      };
      if (const u32 row = row_at(Side::Upper); row != kNoRow) y = place_row_at(row, y);
      channel.top = y;
      double from_top = y;
      for (std::size_t t = 0; t < channel.named_high.size(); ++t)
        from_top += (t == 0 ? kClear - kUnnamed : 0) + (channel.named_high[t] ? kNamed : kUnnamed);
      set_tracks(c, Side::Upper, y);
      double height = 0;
      for (std::size_t t = 0; t < channel.named_low.size(); ++t)
        height += (t == 0 ? kClear : 0) + (channel.named_low[t] ? kNamed : kUnnamed);
      // Stems with their signs, also where there is no track.
      const bool is_used = !channel.nets.empty();
      channel.bottom = from_top +
                       std::max(height, is_used  ? kClear
                                        : c == 0 ? 0.0
                                                 : kGap) +
                       (from_top > y ? kUnnamed : 0);
      set_tracks(c, Side::Lower, channel.bottom);
      y = channel.bottom;
      if (const u32 row = row_at(Side::Lower); row != kNoRow)
        y = place_row_at(row, y) + (c + 1 < channels_.size() ? kGap : 0);
    }
    self_.notes = y + kGrid;
    for (const std::string& note : box_.notes) right_ = std::max(right_, on_grid(kPad + text_width(note, kNoteSize)));
    self_.height = y + kPad + kNoteLine * static_cast<double>(box_.notes.size());
    self_.width = on_grid(right_ + kPad);
  }
  double place_row_at(u32 row, double y) {
    double height = 0;
    for (const u32 child : rows_[row]) height = std::max(height, placed_[child].height);
    for (const u32 child : rows_[row]) placed_[child].y = is_upper(row) ? y + height - placed_[child].height : y;
    return y + height;
  }
  /// Heights of the tracks from one side of the channel; a name stands above its track.
  void set_tracks(u32 c, Side side, double y) {
    const bool upper = side == Side::Upper;
    const std::vector<bool>& named = upper ? channels_[c].named_high : channels_[c].named_low;
    std::vector<double> ys(named.size());
    for (std::size_t t = 0; t < named.size(); ++t) {
      if (upper) y += (t == 0 ? kClear - kUnnamed : 0) + (named[t] ? kNamed : kUnnamed);
      else y -= t == 0 ? kClear : named[t - 1] ? kNamed : kUnnamed;
      ys[t] = y;
    }
    for (const u32 net : channels_[c].nets)
      if (Part& p = part(net, c); p.is_upper == upper) p.y = ys[p.track];
  }

  // -- Lines and names --

  void make_lines() {
    verticals_.resize(channels_.size());
    const auto vertical = [&](u32 c, u32 net, Point from, Point to) {
      self_.nets[net].lines.push_back({from, to});
      verticals_[c].push_back({from.x, std::min(from.y, to.y), std::max(from.y, to.y), net});
    };
    std::vector<std::vector<std::vector<double>>> meets(box_.nets.size());
    for (u32 net = 0; net < box_.nets.size(); ++net) meets[net].resize(channels_.size());
    for (const Stem& stem : stems_) {
      const u32 row = row_of_[stem.child], c = channel_of(row);
      const double edge = is_upper(row) ? channels_[c].top : channels_[c].bottom;
      const SceneNet& net = box_.nets[stem.net];
      vertical(c, stem.net, {stem.x, edge}, {stem.x, part(stem.net, c).y});
      if (net.kind == NetKind::Connector || net.kind == NetKind::Group)
        self_.nets[stem.net].ends.push_back({{stem.x, edge}, net.ends[stem.end].is_trigger, is_upper(row)});
      meets[stem.net][c].push_back(stem.x);
    }
    for (const Joint& joint : joints_) {
      const double child = part(joint.child, joint.channel).y, y = part(joint.net, joint.channel).y;
      vertical(joint.channel, joint.net, {joint.x, child}, {joint.x, y});
      if (box_.nets[joint.net].kind != NetKind::Merged)
        self_.nets[joint.net].ends.push_back(
            {{joint.x, child}, box_.nets[joint.net].ends[joint.end].is_trigger, child < y});
      meets[joint.net][joint.channel].push_back(joint.x);
    }
    for (u32 net = 0; net < box_.nets.size(); ++net) {
      if (box_.nets[net].exit != kNoRow) {
        vertical(0, net, {exit_x_[net], 0}, {exit_x_[net], part(net, 0).y});
        meets[net][0].push_back(exit_x_[net]);
      }
      if (parts_[net].size() > 1) {
        self_.nets[net].lines.push_back({{trunk_[net], parts_[net].front().y}, {trunk_[net], parts_[net].back().y}});
        for (const Part& p : parts_[net]) meets[net][p.channel].push_back(trunk_[net]);
      }
      for (const Part& p : parts_[net]) add_track(net, p, meets[net][p.channel]);
    }
  }
  void add_track(u32 net, const Part& p, std::vector<double>& xs) {
    if (xs.empty()) return;
    std::sort(xs.begin(), xs.end());
    if (xs.front() < xs.back()) self_.nets[net].lines.push_back({{xs.front(), p.y}, {xs.back(), p.y}});
    for (std::size_t k = 1; k + 1 < xs.size(); ++k) self_.nets[net].joints.push_back({xs[k], p.y});
  }

  void place_names() {
    for (u32 net = 0; net < box_.nets.size(); ++net) {
      if (!has_name(net) || parts_[net].empty()) continue;
      const Part& p = parts_[net][home_part(net)];
      const double width = name_width(net), middle = (p.low + p.high - width) / 2;
      const auto crossings = [&](double x) {
        return std::count_if(verticals_[p.channel].begin(), verticals_[p.channel].end(), [&](const Vertical& v) {
          return v.x > x - 2 && v.x < x + width + 2 && v.top < p.y - 2 && v.bottom > p.y - 13;
        });
      };
      double best = middle;
      auto fewest = crossings(middle);
      for (double away = 0; fewest > 0 && away <= (p.high - p.low - width) / 2; away += 4)
        for (const double x : {middle - away, middle + away})
          if (const auto count = crossings(x); count < fewest) {
            best = x;
            fewest = count;
          }
      self_.nets[net].name = {best, p.y - 4};
    }
  }

  const std::vector<SceneBox>& boxes_;
  std::vector<PlacedBox>& placed_;
  const SceneBox& box_;
  PlacedBox& self_;
  std::vector<std::vector<u32>> members_;  // by net
  std::vector<Stem> stems_;
  std::vector<std::vector<u32>> rows_;
  std::map<u32, u32> row_of_;
  double content_width_ = 0, right_ = 0;
  std::vector<Channel> channels_;
  std::vector<std::vector<Part>> parts_;  // by net
  std::vector<Joint> joints_;
  std::vector<double> trunk_, exit_x_;  // by net
  std::vector<std::vector<Vertical>> verticals_;
};

/// Width of a port's room on a closed box: its name, and its lines.
void size_tabs(const SceneBox& box, const std::vector<u32>& stems, PlacedBox& placed) {
  placed.tabs.resize(box.ports.size());
  for (std::size_t p = 0; p < box.ports.size(); ++p) {
    const double lines = kGrid * static_cast<double>(std::max(stems[p], 1u)) + kGrid;
    const double extra = box.kind == BoxKind::Compound ? 12 : 8;
    placed.tabs[p].width = on_grid(std::max(text_width(box.ports[p].name, kPortSize) + extra, lines));
  }
}

void size_closed(const SceneBox& box, PlacedBox& placed) {
  double tabs = 0;
  for (const PortTab& tab : placed.tabs) tabs += tab.width;
  const double text = std::max(text_width(box.name, kTitleSize, Weight::Bold), text_width(box.type, kTypeSize));
  placed.width = on_grid(std::max(text + 2 * kGrid, tabs + 2 * kGrid));
  // The ports are in the middle, on the grid.
  if (std::fmod(placed.width - tabs, 2 * kGrid) != 0) placed.width += kGrid;
  placed.height = (box.ports.empty() ? kGrid : kTabHeight + kGrid / 2) + 36;
}

/// Are the children in the box, and its ports on its edge?
[[maybe_unused]] bool holds_children(const Scene& scene, const std::vector<PlacedBox>& placed, std::size_t box) {
  const PlacedBox& outer = placed[box];
  const auto is_inside = [&](u32 child) {
    const PlacedBox& inner = placed[child];
    return inner.x >= 0 && inner.y >= 0 && inner.x + inner.width <= outer.width &&
           inner.y + inner.height <= outer.height;
  };
  const auto is_on_edge = [&](const PortTab& tab) { return tab.x >= 0 && tab.x + tab.width <= outer.width; };
  return std::all_of(scene.boxes[box].children.begin(), scene.boxes[box].children.end(), is_inside) &&
         std::all_of(outer.tabs.begin(), outer.tabs.end(), is_on_edge);
}

}  // namespace

std::vector<PlacedBox> lay_out(const Scene& scene) {
  std::vector<PlacedBox> placed(scene.boxes.size());
  std::vector<std::vector<u32>> stems(scene.boxes.size());
  for (std::size_t k = 0; k < scene.boxes.size(); ++k) stems[k].resize(scene.boxes[k].ports.size(), 0);
  for (const SceneBox& box : scene.boxes)
    for (const SceneNet& net : box.nets)
      for (const SceneEnd& end : net.ends)
        if (end.net == kNoRow) ++stems[end.box][end.port];
  for (std::size_t k = scene.boxes.size(); k-- > 0;) {
    size_tabs(scene.boxes[k], stems[k], placed[k]);
    if (scene.boxes[k].kind == BoxKind::Compound) ChannelLayout(scene, placed, static_cast<u32>(k)).run();
    else size_closed(scene.boxes[k], placed[k]);
    BIP_ASSERT(holds_children(scene, placed, k), "something of box {} is outside of it", k);
  }
  return placed;
}

}  // namespace bip::graph
