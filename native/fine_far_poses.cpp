// Built with GSP_PARTS = 2: lanes of double-double numbers.
#include "far_poses.hpp"

#include "correct_rounding.hpp"

namespace gsp {
namespace {

// Of sums of products with coefficients that err by 2^-104.
constexpr double kForm = 0x1p-92;

INLINE D modulus(const C& z) { return (z.re.hi < 0.0 ? -z.re.hi : z.re.hi) + (z.im.hi < 0.0 ? -z.im.hi : z.im.hi); }

// A sum of products of complex numbers.
struct ComplexTotal {
  Total same, other, mixed;
  INLINE void add(const C& a, const C& b) {
    same.add(a.re.hi, a.re.lo, b.re);
    other.add(a.im.hi, a.im.lo, b.im);
    mixed.add(a.re.hi, a.re.lo, b.im);
    mixed.add(a.im.hi, a.im.lo, b.re);
  }
  INLINE C total() const { return {minus(same.total(), other.total()), mixed.total()}; }
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
  ComplexTotal sum;
  for (int i = 0; i < kLocal; ++i) sum.add(load(number, first + 1 + i), at.s[i]);
  for (int k = 0; k < kSquares; ++k) sum.add(load(number, first + 1 + kLocal + k), at.square[k]);
  return plus(load(number, first), sum.total());
}

void values(const FineNumbers& number, const FineNumbers& local, const double* shift, const double* shift_low,
            const LaneNumbers& out) {
  Local at;
  for (int i = 0; i < kLocal; ++i) at.s[i] = load(local, i);
  multiply_out(at);
  const C norm = form_at(number, kOfNorm * kLocalMonomials, at);
  for (int r = 0; r < kLocal; ++r) {
    C value = form_at(number, r * kLocalMonomials, at);
    if (r > 0) {
      const V by{D{} + shift[r - 1], D{} + shift_low[r - 1]};
      value = minus(value, C{times(by, norm.re), times(by, norm.im)});
    }
    store(out.re, r, value.re.hi + value.re.lo), store(out.im, r, value.im.hi + value.im.lo);
  }
}

// Bounds of how far a form with so many monomials errs where local coordinates err by `error`.
D error_of(const FineNumbers& number, int first, bool is_linear, const D* size, const D& error, const D& doubt) {
  D terms = modulus(load(number, first)), slope = D{}, total = D{} + 1.0;
  for (int i = 0; i < kLocal; ++i) {
    const D a = modulus(load(number, first + 1 + i));
    terms += a * size[i], slope += a, total += size[i] + error;
  }
  if (!is_linear)
    for (int i = 0, k = first + 1 + kLocal; i < kLocal; ++i)
      for (int j = i; j < kLocal; ++j, ++k) {
        const D a = modulus(load(number, k));
        terms += a * size[i] * size[j], slope += a * (size[i] + size[j] + error);
      }
  return kOutward * (kForm * terms + slope * error + doubt * total * total);
}

void poses(const FineNumbers& number, const FineNumbers& local, const LaneNumbers& change, const double* error,
           const double* doubt, const double* real, double unit, const FinePoses& out) {
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
  const C norm = form_at(number, first, at), factor = inverse(norm), part = inverse(complex_root(norm));
  const D norm_off = error_of(number, first, false, size, off, in_numbers);
  const D norm_size = root(norm.re.hi * norm.re.hi + norm.im.hi * norm.im.hi);
  const D least_norm = (1.0 - 0x1p-40) * norm_size - kOutward * norm_off;
  const D least = least_norm > 0.0 ? kOutward / least_norm : D{} + __builtin_inf();
  for (int i = 0; i < kEntries; ++i) {
    D own;
    if (i < kOfPose) {
      const int begin = first + (1 + i) * kLocalMonomials;
      entry[i] = times(factor, form_at(number, begin, at));
      own = least * error_of(number, begin, false, size, off, in_numbers);
    } else {
      const int begin = last + (i - kOfPose) * (1 + kLocal);
      ComplexTotal sum;
      for (int k = 0; k < kLocal; ++k) sum.add(load(number, begin + 1 + k), at.s[k]);
      entry[i] = times(part, plus(load(number, begin), sum.total()));
      // |sqrt(N') - sqrt(N)| <= |N' - N| / |sqrt(N)|.
      own = kOutward * root(least) * error_of(number, begin, true, size, off, in_numbers);
    }
    errors[i] = kOutward * (own + least * bound(entry[i]) * (norm_off + kRounding * norm_size));
  }
  put_rounded(entry, errors, is_real, unit, out);
}

}  // namespace

extern const FineFarPoses GSP_FINE_FAR;
const FineFarPoses GSP_FINE_FAR{values, poses};

}  // namespace gsp
