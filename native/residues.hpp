// Integers modulo a prime, below 2^30 or below 2^61, and sums of products that are reduced late.
#pragma once

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

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
  // By Euclid's algorithm: `left` is a times `coefficient`, modulo p.
  Residue inverse(Residue a) const {
    if (a <= 1) return a;
    std::uint64_t left = a, next = self().prime;
    std::int64_t coefficient = 1, following = 0;
    while (left != 1) {
      const std::uint64_t quotient = next / left;
      const std::uint64_t rest = next - quotient * left;
      const std::int64_t other = following - static_cast<std::int64_t>(quotient) * coefficient;
      next = left, left = rest;
      following = coefficient, coefficient = other;
    }
    return static_cast<Residue>(coefficient < 0 ? coefficient + static_cast<std::int64_t>(self().prime)
                                                : coefficient);
  }
};

// Modulo an odd prime p below 2^30. A sum stays below 8 p^2 < 2^63, so eight products may be
// subtracted before the next test: if the sum is negative then, 8 p^2 is added.
struct Residues30 : ResidueOperations<Residues30, std::uint32_t> {
  using Residue = std::uint32_t;
  using Sum = std::int64_t;
  static constexpr bool kCounted = false;  // sums never overflow

  explicit Residues30(std::uint64_t p)
      : prime(static_cast<Residue>(p)),
        lift_(static_cast<Sum>(8 * p * p)),
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
  // sums -= factors[0] * rows[0] + ...: up to eight rows
  template <int n>
  void subtract_multiples(Sum* __restrict sums, const Residue* const (&rows)[n],
                          const Residue (&factors)[n], int length) const {
    static_assert(n <= 8);
    int k = 0;
#if defined(__AVX512F__)
    const __m512i lift = _mm512_set1_epi64(lift_);
    __m512i multipliers[n];
    for (int r = 0; r < n; ++r) multipliers[r] = _mm512_set1_epi64(factors[r]);
    for (; k + 8 <= length; k += 8) {
      __m512i t = _mm512_loadu_si512(sums + k);
      for (int r = 0; r < n; ++r) {
        const auto* from = reinterpret_cast<const __m256i*>(rows[r] + k);
        const __m512i row = _mm512_cvtepu32_epi64(_mm256_loadu_si256(from));
        t = _mm512_sub_epi64(t, _mm512_mul_epu32(row, multipliers[r]));
      }
      // As an unsigned number a negative number is larger than all others.
      _mm512_storeu_si512(sums + k, _mm512_min_epu64(t, _mm512_add_epi64(t, lift)));
    }
#elif defined(__AVX2__)
    const __m256i lift = _mm256_set1_epi64x(lift_), zero = _mm256_setzero_si256();
    __m256i multipliers[n];
    for (int r = 0; r < n; ++r) multipliers[r] = _mm256_set1_epi64x(factors[r]);
    for (; k + 4 <= length; k += 4) {
      auto* at = reinterpret_cast<__m256i*>(sums + k);
      __m256i t = _mm256_loadu_si256(at);
      for (int r = 0; r < n; ++r) {
        const auto* from = reinterpret_cast<const __m128i*>(rows[r] + k);
        const __m256i row = _mm256_cvtepu32_epi64(_mm_loadu_si128(from));
        t = _mm256_sub_epi64(t, _mm256_mul_epu32(row, multipliers[r]));
      }
      const __m256i negative = _mm256_cmpgt_epi64(zero, t);
      _mm256_storeu_si256(at, _mm256_add_epi64(t, _mm256_and_si256(negative, lift)));
    }
#endif
    for (; k < length; ++k) {
      Sum t = sums[k];
      for (int r = 0; r < n; ++r)
        t -= static_cast<Sum>(static_cast<std::uint64_t>(factors[r]) * rows[r][k]);
      sums[k] = t + ((t >> 63) & lift_);
    }
  }
  // sums -= factor * row
  void subtract_multiple(Sum* sums, const Residue* row, Residue factor, int length) const {
    subtract_multiples<1>(sums, {row}, {factor}, length);
  }

  Residue prime;

 private:
  Sum lift_;
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
  // The same with several rows at once, which count as so many times.
  template <int n>
  void subtract_multiples(Sum* __restrict sums, const Residue* const (&rows)[n],
                          const Residue (&factors)[n], int length) const {
    Residue minus[n];
    for (int r = 0; r < n; ++r) minus[r] = negative(factors[r]);
    for (int k = 0; k < length; ++k) {
      Sum t = sums[k];
      for (int r = 0; r < n; ++r) t += static_cast<Wide>(minus[r]) * rows[r][k];
      sums[k] = t;
    }
  }

  Residue prime;

 private:
  static constexpr int kShift = 3;
  std::uint64_t divisor_, reciprocal_;
};

}  // namespace
}  // namespace gsp
