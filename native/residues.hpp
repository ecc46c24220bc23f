// Integers modulo a prime, below 2^31 or below 2^61, and sums of products that are reduced late.
#pragma once

#include <cstdint>

namespace gsp {
namespace {

using Wide = unsigned __int128;

// What both share; `Self` gives `Residue`, `Sum` and `reduce`.
template <class Self, class Residue>
struct ResidueOperations {
  const Self& self() const { return static_cast<const Self&>(*this); }

  Residue add(Residue a, Residue b) const {
    const Residue p = self().prime;
    return a >= p - b ? a - (p - b) : a + b;
  }
  Residue negative(Residue a) const { return a == 0 ? 0 : self().prime - a; }
  Residue subtract(Residue a, Residue b) const { return add(a, negative(b)); }
  Residue power(Residue a, std::uint64_t exponent) const {
    Residue result = 1;
    for (; exponent != 0; exponent >>= 1) {
      if (exponent & 1) result = self().multiply(result, a);
      a = self().multiply(a, a);
    }
    return result;
  }
  Residue inverse(Residue a) const { return power(a, self().prime - 2); }
};

// Modulo an odd prime below 2^31. A sum stays below p^2, so the loop has no branch and is
// vectorised by the compiler.
struct Residues31 : ResidueOperations<Residues31, std::uint32_t> {
  using Residue = std::uint32_t;
  using Sum = std::int64_t;
  static constexpr bool kCounted = false;  // sums never overflow

  explicit Residues31(std::uint64_t p)
      : prime(static_cast<Residue>(p)),
        square_(static_cast<Sum>(p * p)),
        reciprocal_(~std::uint64_t{0} / p) {}

  Residue reduce(Sum sum) const {
    const auto x = static_cast<std::uint64_t>(sum);
    const auto quotient = static_cast<std::uint64_t>((static_cast<Wide>(x) * reciprocal_) >> 64);
    std::uint64_t rest = x - quotient * prime;
    if (rest >= prime) rest -= prime;
    return static_cast<Residue>(rest >= prime ? rest - prime : rest);
  }
  Residue multiply(Residue a, Residue b) const {
    return reduce(static_cast<Sum>(static_cast<std::uint64_t>(a) * b));
  }
  // sums -= factor * row
  void subtract_multiple(Sum* __restrict sums, const Residue* __restrict row, Residue factor,
                         int length) const {
    const Sum square = square_;
    for (int k = 0; k < length; ++k) {
      Sum t = sums[k] - static_cast<Sum>(static_cast<std::uint64_t>(factor) * row[k]);
      t += (t >> 63) & square;
      sums[k] = t;
    }
  }

  Residue prime;

 private:
  Sum square_;
  std::uint64_t reciprocal_;
};

// Modulo an odd prime between 2^60 and 2^61. Products are below 2^122: `kCapacity` of them and a
// residue fit into a sum.
struct Residues61 : ResidueOperations<Residues61, std::uint64_t> {
  using Residue = std::uint64_t;
  using Sum = Wide;
  static constexpr bool kCounted = true;
  static constexpr int kCapacity = 60;

  // The division by the normalized divisor 8 p is that of Moeller and Granlund, "Improved division
  // by invariant integers", IEEE Trans. Comput. 60 (2011), algorithm 4.
  explicit Residues61(std::uint64_t p)
      : prime(p),
        divisor_(p << kShift),
        reciprocal_(static_cast<std::uint64_t>(~Wide{0} / (p << kShift) - (Wide{1} << 64))) {}

  Residue reduce(Sum sum) const {
    std::uint64_t high = static_cast<std::uint64_t>(sum >> 64);
    const std::uint64_t low = static_cast<std::uint64_t>(sum);
    if (high >= divisor_) high -= divisor_;
    const Wide q = static_cast<Wide>(reciprocal_) * high +
                   ((static_cast<Wide>(high) << 64) | low);
    const std::uint64_t quotient = static_cast<std::uint64_t>(q >> 64) + 1;
    std::uint64_t rest = low - quotient * divisor_;
    if (rest > static_cast<std::uint64_t>(q)) rest += divisor_;
    if (rest >= divisor_) rest -= divisor_;
    if (rest >= 4 * prime) rest -= 4 * prime;
    if (rest >= 2 * prime) rest -= 2 * prime;
    return rest >= prime ? rest - prime : rest;
  }
  Residue multiply(Residue a, Residue b) const { return reduce(static_cast<Wide>(a) * b); }
  // sums -= factor * row; at most `kCapacity` times before all sums are reduced
  void subtract_multiple(Sum* __restrict sums, const Residue* __restrict row, Residue factor,
                         int length) const {
    const Residue minus = negative(factor);
    for (int k = 0; k < length; ++k) sums[k] += static_cast<Wide>(minus) * row[k];
  }

  Residue prime;

 private:
  static constexpr int kShift = 3;
  std::uint64_t divisor_, reciprocal_;
};

}  // namespace
}  // namespace gsp
