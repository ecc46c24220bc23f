// Numbers with 288 binary places in seven words: sums are exact, and a product is cut off, so that it
// errs by less than one unit, `kPlace`, in the last place.
//
// What is too large, or was no number, is lost: so is all that is computed from it, and it becomes NaN.
// No number that is not lost reaches `kMost`, far enough from the end of the words that sums of
// a thousand of them do not either.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "pair.hpp"

namespace gsp {
namespace {

constexpr int kWords = 7, kPlaces = 288;
constexpr double kPlace = 0x1p-288, kMost = 0x1p140;
constexpr int kUsual = 5;  // words of most moduli, those below 2^32
constexpr int kTopBits = 44;  // of the last word, below `kMost`

struct Fixed {
  std::uint64_t word[kWords] = {};  // two's complement, the lowest word first
  bool lost = false;

  bool negative() const { return word[kWords - 1] >> 63; }
  bool is_zero() const {
    std::uint64_t any = lost;
    for (const std::uint64_t part : word) any |= part;
    return !any;
  }
};

inline Fixed operator+(const Fixed& a, const Fixed& b) {
  Fixed c;
  unsigned __int128 carry = 0;
  for (int k = 0; k < kWords; ++k) {
    carry += static_cast<unsigned __int128>(a.word[k]) + b.word[k];
    c.word[k] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  c.lost = a.lost || b.lost;
  return c;
}

// The number, negated where asked: without a branch, since signs are hard to predict.
inline Fixed with_sign(const Fixed& a, bool negate) {
  const std::uint64_t mask = 0 - static_cast<std::uint64_t>(negate);
  Fixed c;
  unsigned __int128 carry = negate;
  for (int k = 0; k < kWords; ++k) {
    carry += a.word[k] ^ mask;
    c.word[k] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  c.lost = a.lost;
  return c;
}
inline Fixed operator-(const Fixed& a) { return with_sign(a, true); }
inline Fixed operator-(const Fixed& a, const Fixed& b) { return a + -b; }
inline Fixed modulus(const Fixed& a) { return with_sign(a, a.negative()); }

// The words of the product of two moduli of so many words each.
template <int words>
void multiply(const Fixed& p, const Fixed& q, std::uint64_t* full) {
  for (int i = 0; i < words; ++i) {
    unsigned __int128 carry = 0;
    for (int j = 0; j < words; ++j) {
      carry += static_cast<unsigned __int128>(p.word[i]) * q.word[j] + full[i + j];
      full[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    full[i + words] = static_cast<std::uint64_t>(carry);
  }
}

// The number, lost if it is too large.
inline Fixed checked(Fixed a) {
  a.lost = a.lost || modulus(a).word[kWords - 1] >> kTopBits;
  return a;
}

inline Fixed operator*(const Fixed& a, const Fixed& b) {
  const Fixed p = modulus(a), q = modulus(b);
  std::uint64_t full[2 * kWords] = {};
  std::uint64_t high = 0;
  for (int k = kUsual; k < kWords; ++k) high |= p.word[k] | q.word[k];
  high ? multiply<kWords>(p, q, full) : multiply<kUsual>(p, q, full);
  constexpr int skipped = kPlaces / 64, rest = kPlaces % 64;
  static_assert(rest > 0);
  Fixed c;
  for (int k = 0; k < kWords; ++k)
    c.word[k] = full[k + skipped] >> rest | full[k + skipped + 1] << (64 - rest);
  std::uint64_t above = full[kWords + skipped] >> rest;
  for (int k = kWords + skipped + 1; k < 2 * kWords; ++k) above |= full[k];
  c.lost = p.lost || q.lost || above || c.word[kWords - 1] >> kTopBits;
  return with_sign(c, a.negative() != b.negative());
}

// A small multiple; exact.
inline Fixed operator*(int factor, const Fixed& a) {
  Fixed c;
  for (int k = 0; k < (factor < 0 ? -factor : factor); ++k) c = c + a;
  return factor < 0 ? -c : c;
}

// Half of a number, rounded down.
inline Fixed half(const Fixed& a) {
  Fixed c = a;
  for (int k = 0; k < kWords; ++k)
    c.word[k] = a.word[k] >> 1 | (k + 1 < kWords ? a.word[k + 1] << 63 : a.word[k] & 1ull << 63);
  return c;
}

// A double, cut off.
inline Fixed fixed(double x) {
  Fixed c;
  if (!(std::fabs(x) < kMost)) {
    c.lost = true;
    return c;
  }
  int exponent;
  const double part = std::frexp(std::fabs(x), &exponent);
  auto digits = static_cast<std::uint64_t>(std::ldexp(part, 53));
  int shift = exponent - 53 + kPlaces;
  if (shift < 0) {
    digits = shift > -64 ? digits >> -shift : 0;
    shift = 0;
  }
  c.word[shift / 64] = digits << shift % 64;
  if (shift % 64 && shift / 64 + 1 < kWords) c.word[shift / 64 + 1] = digits >> (64 - shift % 64);
  return x < 0.0 ? -c : c;
}
inline Fixed fixed(const Pair& x) { return fixed(x.hi) + fixed(x.lo); }

// A double that differs from the modulus by less than 2^-49 of it; NaN if it is lost.
inline double magnitude(const Fixed& a) {
  const Fixed p = modulus(a);
  double s = 0.0, place = kPlace;
  for (int k = 0; k < kWords; ++k, place *= 0x1p64) s += place * static_cast<double>(p.word[k]);
  return a.lost ? std::numeric_limits<double>::quiet_NaN() : s;
}

// A number of 32 digits that differs by less than 2^-96 of it; NaN if it is lost.
inline Pair rounded(const Fixed& a) {
  if (a.lost) return {std::numeric_limits<double>::quiet_NaN(), 0.0};
  const Fixed p = modulus(a);
  Pair s{0.0, 0.0};
  double place = kPlace;
  Pair halves[2 * kWords];
  for (int k = 0; k < 2 * kWords; ++k, place *= 0x1p32)
    halves[k] = {place * static_cast<std::uint32_t>(p.word[k / 2] >> 32 * (k % 2)), 0.0};
  for (int k = 2 * kWords; k-- > 0;)
    if (halves[k].hi > 0.0) s = sum(s, halves[k]);
  return a.negative() ? Pair{-s.hi, -s.lo} : s;
}

}  // namespace
}  // namespace gsp
