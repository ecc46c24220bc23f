// Built with GSP_PARTS = 2: lanes of double-double numbers.
#include "far_poses.hpp"

#include "correct_rounding.hpp"

namespace gsp {
namespace {

// Of a form, as a part of the moduli of its terms: products of local coordinates err by 2^-99, coefficients
// by 2^-104. In a group of seven terms what doubles leave, 2^-51 of each and 2^-53 of each sum, is added up in
// doubles: they err by 7 7 / 2 2^-106 and 2^-102. The sums of the groups err by 2^-102.5 each.
constexpr double kForm = 0x1p-97;
constexpr int kGroup = kLocal;
// Of a derivative in doubles.
constexpr double kSlope = 0x1p-46;

INLINE D modulus(const C& z) { return (z.re.hi < 0.0 ? -z.re.hi : z.re.hi) + (z.im.hi < 0.0 ? -z.im.hi : z.im.hi); }

// A sum of products of complex numbers.
struct ComplexTotal {
  Total same, other, mixed, crossed;
  INLINE void add(const C& a, const C& b) {
    same.add(a.re.hi, a.re.lo, b.re);
    other.add(a.im.hi, a.im.lo, b.im);
    mixed.add(a.re.hi, a.re.lo, b.im);
    crossed.add(a.im.hi, a.im.lo, b.re);
  }
  INLINE C total() const { return {minus(same.total(), other.total()), plus(mixed.total(), crossed.total())}; }
};

struct Local {
  C s[kLocal], square[kSquares];
};

INLINE void multiply_out(Local& at) {
  for (int i = 0, k = 0; i < kLocal; ++i)
    for (int j = i; j < kLocal; ++j, ++k) at.square[k] = times(at.s[i], at.s[j]);
}

// A form at local coordinates, from its first coefficient on.
C form_at(const FineNumbers& number, int first, const Local& at) {
  C sum = load(number, first++);
  const auto add = [&](const C* x) {
    ComplexTotal group;
    for (int i = 0; i < kGroup; ++i) group.add(load(number, first++), x[i]);
    sum = plus(sum, group.total());
  };
  add(at.s);
  static_assert(kSquares % kGroup == 0);
  for (int k = 0; k < kSquares; k += kGroup) add(at.square + k);
  return sum;
}

void mix(const FineNumbers& number, const double* shift, const double* shift_low, const FineNumbers& out) {
  for (int i = 0, k = kMixed; i < kLocal; ++i) {
    C sum{V(D{}), V(D{})};
    for (int r = 0; r < kEquations; ++r, ++k) {
      const V by{load(shift, r), load(shift_low, r)};
      const C a = load(number, k);
      sum = plus(sum, C{times(by, a.re), times(by, a.im)});
    }
    store(out, i, sum);
  }
}

void values(const FineNumbers& number, const int* second, const FineNumbers& local, const FineNumbers& mixed,
            const LaneNumbers& out) {
  Local at;
  for (int i = 0; i < kLocal; ++i) at.s[i] = load(local, i);
  multiply_out(at);
  const C norm = form_at(number, kOfNorm * kLocalMonomials, at);
  for (int r = 0; r < kLocal; ++r) {
    C value = form_at(number, r * kLocalMonomials, at), constant = load(mixed, r);
    if (second[r]) {
      value = times(value, form_at(number, second[r], at));
      constant = times(plus(constant, load(number, second[r] + kConstant)), norm);
    }
    value = minus(value, times(constant, norm));
    store(out.re, r, value.re.hi + value.re.lo), store(out.im, r, value.im.hi + value.im.lo);
  }
}

// In doubles.
struct Rough {
  D re, im;
  void add(const C& a, const C& b) {
    re += a.re.hi * b.re.hi - a.im.hi * b.im.hi;
    im += a.re.hi * b.im.hi + a.im.hi * b.re.hi;
  }
};

// Bounds of how far a form errs at local coordinates that err by `error`: it changes by its derivative there
// times that, and by its second one times the square.
D error_of(const FineNumbers& number, int first, bool is_linear, const Local& at, const D* size, const D& error,
           const D& doubt) {
  D terms = modulus(load(number, first)), slope = D{}, rounding = D{}, curvature = D{}, total = D{} + 1.0;
  Rough derivative[kLocal];
  for (int i = 0; i < kLocal; ++i) {
    const C x = load(number, first + 1 + i);
    derivative[i] = {x.re.hi, x.im.hi};
    const D a = modulus(x);
    terms += a * size[i], rounding += a, total += size[i] + error;
  }
  if (!is_linear)
    for (int i = 0, k = first + 1 + kLocal; i < kLocal; ++i)
      for (int j = i; j < kLocal; ++j, ++k) {
        const C x = load(number, k);
        derivative[i].add(x, at.s[j]), derivative[j].add(x, at.s[i]);
        const D a = modulus(x);
        terms += a * size[i] * size[j], rounding += a * (size[i] + size[j]), curvature += a;
      }
  for (const Rough& x : derivative) slope += (x.re < 0.0 ? -x.re : x.re) + (x.im < 0.0 ? -x.im : x.im);
  slope += kSlope * rounding + curvature * error;
  return kOutward * (kForm * terms + slope * error + doubt * total * total);
}

void poses(const FineNumbers& number, const FineNumbers& local, const LaneNumbers& change, const double* error,
           const double* doubt, const double* real, const double* unit, const FinePoses& out) {
  Local at;
  D size[kLocal], errors[kEntries];
  C entry[kEntries];
  const D off = load(error, 0), in_numbers = load(doubt, 0);
  const Mask is_real = load(real, 0) != 0.0;
  for (int i = 0; i < kLocal; ++i) {
    const C x = load(local, i);
    at.s[i] = {exact_sum(x.re.hi, x.re.lo - load(change.re, i)), exact_sum(x.im.hi, x.im.lo - load(change.im, i))};
    size[i] = kOutward * modulus(at.s[i]);
  }
  multiply_out(at);
  constexpr int first = kOfNorm * kLocalMonomials, last = kFarForms * kLocalMonomials;
  const C sum = form_at(number, first, at);
  // Where N nearly vanishes, its low part may be as large as the high one.
  const C norm{exact_sum(sum.re.hi, sum.re.lo), exact_sum(sum.im.hi, sum.im.lo)};
  const C factor = inverse(norm), part = inverse(complex_root(norm));
  const D norm_off = error_of(number, first, false, at, size, off, in_numbers);
  const D norm_size = root(norm.re.hi * norm.re.hi + norm.im.hi * norm.im.hi);
  const D least_norm = (1.0 - 0x1p-40) * norm_size - kOutward * norm_off;
  const D least = least_norm > 0.0 ? kOutward / least_norm : D{} + __builtin_inf();
  for (int i = 0; i < kEntries; ++i) {
    D own;
    if (i < kOfPose) {
      const int begin = first + (1 + i) * kLocalMonomials;
      entry[i] = times(factor, form_at(number, begin, at));
      own = least * error_of(number, begin, false, at, size, off, in_numbers);
    } else {
      const int begin = last + (i - kOfPose) * (1 + kLocal);
      ComplexTotal linear;
      for (int k = 0; k < kLocal; ++k) linear.add(load(number, begin + 1 + k), at.s[k]);
      entry[i] = times(part, plus(load(number, begin), linear.total()));
      // |sqrt(N') - sqrt(N)| <= |N' - N| / |sqrt(N)|.
      own = kOutward * root(least) * error_of(number, begin, true, at, size, off, in_numbers);
    }
    errors[i] = kOutward * (own + least * bound(entry[i]) * (norm_off + kRounding * norm_size));
  }
  put_rounded(entry, errors, is_real, load(unit, 0), out);
}

}  // namespace

extern const FineFarPoses GSP_FINE_FAR;
const FineFarPoses GSP_FINE_FAR{mix, values, poses};

}  // namespace gsp
