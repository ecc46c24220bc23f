// Monomials as packed exponents, numbered as they come up, in degree reverse lexicographic order.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace gsp {
namespace {

// Five bits for each exponent, the last variable in the highest ones.
using Monomial = unsigned __int128;

constexpr int kExponentBits = 5;
constexpr int kMaxVariables = 25, kMaxDegree = (1 << kExponentBits) - 1;

inline Monomial variable(int i) { return Monomial{1} << (kExponentBits * i); }
inline int exponent(Monomial m, int i) {
  return static_cast<int>(m >> (kExponentBits * i)) & kMaxDegree;
}

class Monomials {
 public:
  explicit Monomials(int variables) : variables_(variables) { number(0, 0); }

  int variables() const { return variables_; }
  int size() const { return static_cast<int>(monomial_.size()); }
  Monomial operator[](int k) const { return monomial_[k]; }
  int degree(int k) const { return degree_[k]; }
  // The number of a monomial, or -1 if it has none yet.
  int find(Monomial m) const {
    const auto found = number_.find(m);
    return found == number_.end() ? -1 : found->second;
  }
  // The number of a monomial times a variable.
  int times(int k, int i) {
    const std::size_t at = static_cast<std::size_t>(k) * variables_ + i;
    if (product_[at] < 0) {
      const int result = number(monomial_[k] + variable(i), degree_[k] + 1);
      product_[at] = result;
    }
    return product_[at];
  }
  // Whether a comes before b in the order, the greatest first; both of one degree.
  bool greater(int a, int b) const { return monomial_[a] < monomial_[b]; }

 private:
  struct Hash {
    std::size_t operator()(Monomial m) const {
      const std::uint64_t mixed =
          (static_cast<std::uint64_t>(m) * 0x9e3779b97f4a7c15u) ^
          (static_cast<std::uint64_t>(m >> 64) * 0xc2b2ae3d27d4eb4fu);
      return mixed ^ (mixed >> 29);
    }
  };
  int number(Monomial m, int degree) {
    const auto [at, is_new] = number_.emplace(m, size());
    if (is_new) {
      monomial_.push_back(m);
      degree_.push_back(degree);
      product_.resize(product_.size() + variables_, -1);
    }
    return at->second;
  }

  int variables_;
  std::vector<Monomial> monomial_;
  std::vector<int> degree_, product_;
  std::unordered_map<Monomial, int, Hash> number_;
};

}  // namespace
}  // namespace gsp
