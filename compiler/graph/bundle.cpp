// See bundle.hpp.
#include "compiler/graph/bundle.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "runtime/include/bip/assert.hpp"

namespace bip::graph {
namespace {

constexpr std::size_t kLeastBundle = 3;

class Bundler {
 public:
  Bundler(Scene& scene, u32 box) : scene_(scene), box_(scene.boxes[box]) {}

  void run() {
    find_groups();
    if (groups_.empty()) return;
    std::set<std::pair<u32, u32>> before = joined_ports();
    replace();
    const std::set<std::pair<u32, u32>> after = joined_ports();
    remove_ports(before, after);
  }

 private:
  using Members = std::vector<u32>;

  /// Groups the connectors that no other connector binds by the boxes that they join. A net that they bind belongs to
  /// the group if no other net binds it.
  void find_groups() {
    const std::size_t count = box_.nets.size();
    const std::vector<Members> members = members_of_nets(box_);
    std::vector<bool> is_bound(count, false);
    for (const SceneNet& net : box_.nets)
      for (const SceneEnd& end : net.ends)
        if (end.net != kNoRow) is_bound[end.net] = true;
    std::map<Members, std::vector<u32>> found;
    for (u32 net = 0; net < count; ++net) {
      const auto is_open = [&](u32 child) { return scene_.boxes[child].kind == BoxKind::Compound; };
      if (box_.nets[net].kind != NetKind::Connector || is_bound[net] || box_.nets[net].exit != kNoRow) continue;
      if (std::none_of(members[net].begin(), members[net].end(), is_open)) found[members[net]].push_back(net);
    }
    // A net is bound by later ones: from the last one down, the nets that bind it have their groups.
    owner_.assign(count, kNoRow);
    for (auto& [boxes, nets] : found) {
      if (nets.size() < kLeastBundle) continue;
      for (const u32 net : nets) owner_[net] = static_cast<u32>(groups_.size());
      groups_.push_back({boxes, std::move(nets)});
    }
    std::vector<std::set<u32>> users(count);
    for (u32 net = static_cast<u32>(count); net-- > 0;) {
      const bool is_shared = users[net].size() > 1 || box_.nets[net].exit != kNoRow;
      if (is_bound[net] && !is_shared && !users[net].empty()) owner_[net] = *users[net].begin();
      for (const SceneEnd& end : box_.nets[net].ends)
        if (end.net != kNoRow) users[end.net].insert(owner_[net]);
    }
  }

  [[nodiscard]] std::set<std::pair<u32, u32>> joined_ports() const {
    std::set<std::pair<u32, u32>> ports;
    for (const SceneNet& net : box_.nets)
      for (const SceneEnd& end : net.ends)
        if (end.net == kNoRow) ports.insert({end.box, end.port});
    return ports;
  }

  void replace() {
    std::vector<SceneNet> kept;
    std::vector<u32> row(box_.nets.size(), kNoRow);
    for (u32 net = 0; net < box_.nets.size(); ++net) {
      if (owner_[net] != kNoRow) continue;
      row[net] = static_cast<u32>(kept.size());
      kept.push_back(box_.nets[net]);
      for (SceneEnd& end : kept.back().ends)
        if (end.net != kNoRow) {
          BIP_ASSERT(row[end.net] != kNoRow, "net {} stays and binds net {}, which does not", net, end.net);
          end.net = row[end.net];
        }
    }
    for (const auto& [boxes, nets] : groups_) {
      SceneNet bundle;
      bundle.name = fmt::format("{} connectors", nets.size());
      bundle.colour = box_.nets[nets.front()].colour;
      for (const u32 net : nets) {
        const SceneNet& part = box_.nets[net];
        bundle.details += (bundle.details.empty() ? "" : "\n") + part.name;
        bundle.bundled.emplace_back(part.first, part.last);
      }
      for (const u32 child : boxes) {
        std::vector<ScenePort>& ports = scene_.boxes[child].ports;
        bundle.ends.push_back({.box = child, .port = static_cast<u32>(ports.size())});
        ports.push_back({fmt::format("{} ports", ports_of(nets, child)), fmt::format("+{}", ports.size()), kNoRow});
      }
      kept.push_back(std::move(bundle));
    }
    box_.nets = std::move(kept);
  }
  /// How many ports of the child the nets reach, directly or through others.
  [[nodiscard]] std::size_t ports_of(const std::vector<u32>& nets, u32 child) const {
    std::set<u32> ports;
    std::vector<u32> todo = nets;
    while (!todo.empty()) {
      const SceneNet& net = box_.nets[todo.back()];
      todo.pop_back();
      for (const SceneEnd& end : net.ends) {
        if (end.net != kNoRow) todo.push_back(end.net);
        else if (end.box == child) ports.insert(end.port);
      }
    }
    return ports.size();
  }

  void remove_ports(const std::set<std::pair<u32, u32>>& before, const std::set<std::pair<u32, u32>>& after) {
    std::map<u32, std::vector<u32>> row;  // of a child's ports
    for (const u32 child : box_.children) {
      std::vector<ScenePort>& ports = scene_.boxes[child].ports;
      std::vector<ScenePort> kept;
      for (u32 port = 0; port < ports.size(); ++port) {
        const bool is_gone = before.contains({child, port}) && !after.contains({child, port});
        row[child].push_back(is_gone ? kNoRow : static_cast<u32>(kept.size()));
        if (!is_gone) kept.push_back(std::move(ports[port]));
      }
      BIP_ASSERT(scene_.boxes[child].kind != BoxKind::Compound || kept.size() == ports.size(),
                 "the open box {} loses a port", child);
      ports = std::move(kept);
    }
    for (SceneNet& net : box_.nets)
      for (SceneEnd& end : net.ends)
        if (end.net == kNoRow) {
          end.port = row[end.box][end.port];
          BIP_ASSERT(end.port != kNoRow, "a port of box {} is joined and removed", end.box);
        }
  }

  Scene& scene_;
  SceneBox& box_;
  std::vector<std::pair<Members, std::vector<u32>>> groups_;
  std::vector<u32> owner_;  // by net: its group
};

}  // namespace

void bundle_nets(Scene& scene, std::uint64_t most) {
  for (u32 box = 0; box < scene.boxes.size(); ++box)
    if (scene.boxes[box].kind == BoxKind::Compound && scene.boxes[box].nets.size() > most) Bundler(scene, box).run();
}

}  // namespace bip::graph
