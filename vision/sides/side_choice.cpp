#include "vision/sides/side_choice.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace kawara::vision {
namespace {

constexpr std::size_t kBestOnes = 6, kBesideThem = 4;
constexpr double kLeastGain = 0.02;  // of what the best ones show together
constexpr float kGoodShare = 0.5F;   // as well as the best
constexpr std::size_t kLeastCells = 6;
constexpr float kDark = 8.0F, kBright = 247.0F;  // levels that say nothing about exposure

struct Chooser {
  const SideGrid& grid;
  std::span<const SideCandidate> candidates;
  SideChoice choice{};
  std::vector<float> best{};  // of each node

  float Score(std::size_t candidate, std::size_t node) const {
    return candidates[candidate].look.quality[node] * candidates[candidate].sharpness;
  }
  bool Good(std::size_t candidate, std::size_t node) const {
    const float score = Score(candidate, node);
    return score > 0.0F && score >= kGoodShare * best[node];
  }

  /// Colour of a cell as painted so far; false: not painted whole by one.
  bool Painted(int i, int j, std::array<float, 3>& colour) const {
    const int who = choice.of_node[grid.node(i, j)];
    if (who == SideChoice::kNone) return false;
    const auto& patch = candidates[static_cast<std::size_t>(who)].patch;
    if (patch.whole[grid.cell(i, j)] == 0) return false;
    colour = MeanOfCell(grid, patch, i, j);
    for (std::size_t c = 0; c < 3; ++c) colour[c] *= choice.gains[static_cast<std::size_t>(who)][c];
    return true;
  }

  /// Brings a candidate to the exposure of what is painted, where both show the same.
  void MatchGain(std::size_t candidate) {
    const SidePatch& patch = candidates[candidate].patch;
    std::array<std::vector<float>, 3> ratios;
    for (int j = 0; j < grid.cell_rows; ++j)
      for (int i = 0; i < grid.cell_columns; ++i) {
        std::array<float, 3> there{};
        if (patch.whole[grid.cell(i, j)] == 0 || !Painted(i, j, there)) continue;
        const auto here = MeanOfCell(grid, patch, i, j);
        const auto telling = [](float level) { return level > kDark && level < kBright; };
        if (!std::all_of(here.begin(), here.end(), telling) ||
            !std::all_of(there.begin(), there.end(), telling))
          continue;
        for (std::size_t c = 0; c < 3; ++c) ratios[c].push_back(there[c] / here[c]);
      }
    if (ratios[0].size() < kLeastCells) return;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto middle = ratios[c].begin() + static_cast<std::ptrdiff_t>(ratios[c].size() / 2);
      std::nth_element(ratios[c].begin(), middle, ratios[c].end());
      choice.gains[candidate][c] = std::clamp(*middle, 0.5F, 2.0F);
    }
  }

  void Run() {
    choice.of_node.assign(grid.nodes(), SideChoice::kNone);
    choice.gains.assign(candidates.size(), {1.0F, 1.0F, 1.0F});
    best.assign(grid.nodes(), 0.0F);
    for (std::size_t k = 0; k < candidates.size(); ++k)
      for (std::size_t n = 0; n < grid.nodes(); ++n) best[n] = std::max(best[n], Score(k, n));
    std::vector<bool> used(candidates.size(), false);
    std::vector<std::size_t> nodes(candidates.size(), 0);
    for (std::size_t round = 0; round < candidates.size(); ++round) {
      double most = 0.0;
      std::size_t which = candidates.size();
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        if (used[k]) continue;
        double sum = 0.0;
        for (std::size_t n = 0; n < grid.nodes(); ++n)
          if (choice.of_node[n] == SideChoice::kNone && Good(k, n))
            sum += static_cast<double>(Score(k, n));
        if (sum > most) {
          most = sum;
          which = k;
        }
      }
      if (which == candidates.size()) break;
      used[which] = true;
      if (round > 0) MatchGain(which);
      for (std::size_t n = 0; n < grid.nodes(); ++n) {
        if (choice.of_node[n] != SideChoice::kNone || !Good(which, n)) continue;
        choice.of_node[n] = static_cast<int>(which);
        ++nodes[which];
      }
      if (choice.main == SideChoice::kNone ||
          nodes[which] > nodes[static_cast<std::size_t>(choice.main)])
        choice.main = static_cast<int>(which);
    }
  }
};

}  // namespace

std::vector<std::size_t> WorthRectifying(const SideGrid& grid, std::span<const SideLook> looks) {
  std::vector<std::size_t> order(looks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t k) { return !(looks[k].total > 0.0); });
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return looks[a].total > looks[b].total; });
  std::vector<std::size_t> chosen;
  std::vector<float> best(grid.nodes(), 0.0F);
  double together = 0.0;
  const auto gain = [&](std::size_t k) {
    double sum = 0.0;
    for (std::size_t n = 0; n < grid.nodes(); ++n)
      sum += static_cast<double>(std::max(0.0F, looks[k].quality[n] - best[n]));
    return sum;
  };
  const auto take = [&](std::size_t place) {
    const std::size_t k = order[place];
    together += gain(k);
    for (std::size_t n = 0; n < grid.nodes(); ++n) best[n] = std::max(best[n], looks[k].quality[n]);
    chosen.push_back(k);
    order.erase(order.begin() + static_cast<std::ptrdiff_t>(place));
  };
  while (!order.empty() && chosen.size() < kBestOnes) take(0);
  while (!order.empty() && chosen.size() < kBestOnes + kBesideThem) {
    double most = kLeastGain * together;
    std::size_t which = order.size();
    for (std::size_t place = 0; place < order.size(); ++place) {
      const double more = gain(order[place]);
      if (!(more > most)) continue;
      most = more;
      which = place;
    }
    if (which == order.size()) break;
    take(which);
  }
  return chosen;
}

std::vector<float> Sharpness(const SideGrid& grid, std::span<const SidePatch> patches) {
  std::vector<float> most(grid.cells(), 0.0F);
  for (const SidePatch& patch : patches)
    for (std::size_t i = 0; i < grid.cells(); ++i) most[i] = std::max(most[i], patch.detail[i]);
  std::vector<float> sharpness;
  for (const SidePatch& patch : patches) {
    double shown = 0.0, there = 0.0;
    for (std::size_t i = 0; i < grid.cells(); ++i) {
      if (patch.whole[i] == 0) continue;
      shown += static_cast<double>(patch.detail[i]);
      there += static_cast<double>(most[i]);
    }
    sharpness.push_back(there > 0.0 ? static_cast<float>(std::sqrt(shown / there)) : 1.0F);
  }
  return sharpness;
}

SideChoice ChooseForNodes(const SideGrid& grid, std::span<const SideCandidate> candidates) {
  Chooser chooser{grid, candidates};
  chooser.Run();
  return std::move(chooser.choice);
}

}  // namespace kawara::vision
