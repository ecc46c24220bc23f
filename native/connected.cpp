// Labels boxes of poses that are connected; see reach.hpp.
#include <algorithm>
#include <numeric>
#include <utility>

#include "reach.hpp"

namespace gsp {
namespace {

// Sets that are merged.
class Partition {
 public:
  explicit Partition(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::int64_t{0});
  }
  std::int64_t find(std::int64_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void merge(std::int64_t i, std::int64_t j) {
    i = find(i);
    j = find(j);
    if (i != j) parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::int64_t> parent_;
};

// Where boxes of one level are in the list: a table with open addressing.
class Level {
 public:
  void reserve(std::size_t count) {
    if (!count) return;
    std::size_t size = 4;
    while (size < 2 * count) size *= 2;
    boxes_.assign(size, {0, -1});
  }
  bool empty() const { return boxes_.empty(); }
  void insert(std::uint64_t key, std::int64_t index) {
    std::size_t i = hash(key);
    while (boxes_[i].second >= 0) i = (i + 1) & (boxes_.size() - 1);
    boxes_[i] = {key, index};
  }
  std::int64_t find(std::uint64_t key) const {
    if (boxes_.empty()) return -1;
    for (std::size_t i = hash(key);; i = (i + 1) & (boxes_.size() - 1))
      if (boxes_[i].second < 0 || boxes_[i].first == key) return boxes_[i].second;
  }

 private:
  std::size_t hash(std::uint64_t key) const {
    key = (key ^ (key >> 31)) * 0x9E3779B97F4A7C15u;
    return (key ^ (key >> 32)) & (boxes_.size() - 1);
  }
  std::vector<std::pair<std::uint64_t, std::int64_t>> boxes_;
};

}  // namespace

std::vector<std::int64_t> connected(const std::uint64_t* keys, const std::int32_t* levels,
                                    std::size_t count, int dimensions, bool touching,
                                    const bool* periodic, int poles) {
  const int bits = 64 / dimensions;
  const std::uint64_t mask = bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
  std::vector<Level> grid(64);
  std::vector<std::size_t> counts(64);
  for (std::size_t i = 0; i < count; ++i) ++counts[levels[i]];
  for (int l = 0; l < 64; ++l) grid[l].reserve(counts[l]);
  for (std::size_t i = 0; i < count; ++i)
    grid[levels[i]].insert(keys[i], static_cast<std::int64_t>(i));
  std::vector<int> used;
  for (int l = 63; l >= 0; --l)
    if (!grid[l].empty()) used.push_back(l);
  Partition parts(count);
  std::int64_t at_poles[2] = {-1, -1};
  int steps = 1;
  for (int d = 0; d < dimensions; ++d) steps *= 3;
  for (std::size_t i = 0; i < count; ++i) {
    const int level = levels[i];
    const std::int64_t side = std::int64_t{1} << level;
    std::int64_t place[8];
    for (int d = 0; d < dimensions; ++d)
      place[d] = static_cast<std::int64_t>(keys[i] >> (d * bits) & mask);
    if (touching && poles >= 0)
      for (int end = 0; end < 2; ++end)
        if (place[poles] == (end ? side - 1 : 0)) {
          if (at_poles[end] >= 0) parts.merge(at_poles[end], static_cast<std::int64_t>(i));
          at_poles[end] = static_cast<std::int64_t>(i);
        }
    for (int step = 0; step < steps; ++step) {
      std::int64_t next[8];
      int moved = 0;
      bool exists = true;
      for (int d = 0, rest = step; d < dimensions; ++d, rest /= 3) {
        const int by = rest % 3 - 1;
        moved += by != 0;
        next[d] = place[d] + by;
        if (next[d] < 0 || next[d] >= side) {
          if (touching && periodic[d]) next[d] = (next[d] + side) % side;
          else exists = false;
        }
      }
      if (!exists || moved == 0 || (!touching && moved > 1)) continue;
      // Boxes of the same parent are no larger.
      bool sibling = true;
      for (int d = 0; d < dimensions; ++d) sibling = sibling && next[d] >> 1 == place[d] >> 1;
      for (const int other : used) {
        if (other > level) continue;
        if (other < level && sibling) break;
        std::uint64_t key = 0;
        for (int d = 0; d < dimensions; ++d)
          key |= static_cast<std::uint64_t>(next[d] >> (level - other)) << (d * bits);
        const std::int64_t j = grid[other].find(key);
        if (j >= 0) {
          parts.merge(static_cast<std::int64_t>(i), j);
          break;
        }
      }
    }
  }
  std::vector<std::int64_t> labels(count);
  for (std::size_t i = 0; i < count; ++i) labels[i] = parts.find(static_cast<std::int64_t>(i));
  return labels;
}

}  // namespace gsp