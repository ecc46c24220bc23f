// Built with GSP_PARTS = 2: derivatives and inverses of double-double numbers.
#include "finer_ends.hpp"

#include "isolation.hpp"

namespace gsp {
namespace {

constexpr int kFinerParts = 4, kEntries = 12, kNumbers = 16, kMotion = 13;
// Errors of values with 64 digits (FinerPoints), and the most steps of Newton's method. It ends after a step
// below kArrived times the largest coordinate, or below kShort and hardly shorter than the one before.
constexpr double kFinerRounding = 0x1p-190;
constexpr int kFinerSteps = 16;
constexpr double kArrived = 0x1p-170, kShort = 0x1p-80, kStalled = 0.25;

// Numbers of all lanes as other builds of code can read them, with their low parts.
template <int count>
struct Room {
  double re[2][count * W], im[2][count * W];

  void store(const C* z) {
    for (int i = 0; i < count; ++i) {
      __builtin_memcpy(re[0] + i * W, &z[i].re.hi, sizeof(D)), __builtin_memcpy(re[1] + i * W, &z[i].re.lo, sizeof(D));
      __builtin_memcpy(im[0] + i * W, &z[i].im.hi, sizeof(D)), __builtin_memcpy(im[1] + i * W, &z[i].im.lo, sizeof(D));
    }
  }
  C at(int i) const {
    C z;
    __builtin_memcpy(&z.re.hi, re[0] + i * W, sizeof(D)), __builtin_memcpy(&z.re.lo, re[1] + i * W, sizeof(D));
    __builtin_memcpy(&z.im.hi, im[0] + i * W, sizeof(D)), __builtin_memcpy(&z.im.lo, im[1] + i * W, sizeof(D));
    return z;
  }
  operator FineNumbers() { return {{re[0], im[0]}, {re[1], im[1]}}; }
};

// Points of 64 digits.
struct FinerPoint {
  double re[kFinerParts][N * W], im[kFinerParts][N * W];

  operator FinerNumbers() {
    FinerNumbers numbers;
    for (int part = 0; part < kFinerParts; ++part) numbers.part[part] = {re[part], im[part]};
    return numbers;
  }
  // The first two parts.
  void load(C* z) const {
    for (int i = 0; i < N; ++i) {
      __builtin_memcpy(&z[i].re.hi, re[0] + i * W, sizeof(D)), __builtin_memcpy(&z[i].re.lo, re[1] + i * W, sizeof(D));
      __builtin_memcpy(&z[i].im.hi, im[0] + i * W, sizeof(D)), __builtin_memcpy(&z[i].im.lo, im[1] + i * W, sizeof(D));
    }
  }
};

// Bounds of the moduli of the entries of the Hessian matrices, (quadrics, 8, 8).
void bound_entries(const FinerPlatform& platform, double* moduli) {
  for (int q = 0; q < platform.equations.quadrics; ++q) {
    double* const entry = moduli + q * N * N;
    const double* bound = platform.bound + q * kMonomials;
    for (int i = 0; i < N * N; ++i) entry[i] = 0.0;
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j) entry[N * i + j] = entry[N * j + i] = (i == j ? 2.0 : 1.0) * *bound++;
    for (int i = 0; i < 4; ++i)
      for (int j = 4; j < N; ++j) entry[N * i + j] = entry[N * j + i] = *bound++;
    for (int j = 4; j < N; ++j) entry[N * j + j] = 2.0 * *bound;
  }
}

struct Decision {
  const FinerPlatform& platform;
  ProofSystem system;
  const FinerPoses& out;
  int count;
};

// An approximate inverse, by elimination with the largest pivots of each column, as parts of their rows:
// orthogonal rows (`invert`) would lose twice as many digits where the equations are nearly dependent.
void invert_by_pivots(const C (&jacobian)[kRows][kRows], C (&inverse)[kRows][kRows]) {
  C row[kRows][2 * kRows];
  D factor[kRows];
  for (int i = 0; i < kRows; ++i) {
    D size = D{};
    for (int k = 0; k < kRows; ++k) {
      row[i][k] = jacobian[i][k], row[i][kRows + k] = {splat(i == k ? 1.0 : 0.0), splat(0.0)};
      size = maximum(bound(row[i][k]), size);
    }
    factor[i] = 1.0 / size;
  }
  for (int c = 0; c < kRows; ++c) {
    D largest = factor[c] * bound(row[c][c]), place = D{} + double(c);
    for (int i = c + 1; i < kRows; ++i) {
      const D size = factor[i] * bound(row[i][c]);
      place = size > largest ? D{} + double(i) : place;
      largest = maximum(size, largest);
    }
    for (int i = c + 1; i < kRows; ++i) {
      const Mask here = place == D{} + double(i);
      for (int k = c; k < 2 * kRows; ++k) {
        const C x = row[c][k];
        row[c][k] = select(here, row[i][k], x), row[i][k] = select(here, x, row[i][k]);
      }
      const D x = factor[c];
      factor[c] = here ? factor[i] : x, factor[i] = here ? x : factor[i];
    }
    const V square_of = 1.0 / square(row[c][c]);
    const C part{square_of * row[c][c].re, -(square_of * row[c][c].im)};
    for (int k = c; k < 2 * kRows; ++k) row[c][k] = part * row[c][k];
    for (int i = 0; i < kRows; ++i) {
      if (i == c) continue;
      const C by_this = row[i][c];
      for (int k = c + 1; k < 2 * kRows; ++k) subtract_product(row[i][k], by_this, row[c][k]);
    }
  }
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < kRows; ++k) inverse[i][k] = row[i][kRows + k];
}

// Newton's method from points; afterwards they are one step ahead of where the theorem was applied. Returns the unit
// of the errors of f.
D prove_points(const Decision& d, FinerPoint& point, const Mask* above, const Mask* below, Isolation& found) {
  Linear at;
  C z[N];
  Room<kRows> value;
  Room<kRows * N> derivative;
  D length = D{} + __builtin_inf();
  for (int step = 0;; ++step) {
    point.load(z);
    const Units units(z);
    GSP_FINER.linearize(d.platform.equations, point, value, derivative);
    for (int r = 0; r < kRows; ++r) {
      C row[N];
      for (int i = 0; i < N; ++i) row[i] = units.from(i, derivative.at(r * N + i));
      free_columns(row, above, at.jacobian[r]);
      at.value[r] = value.at(r);
    }
    invert_by_pivots(at.jacobian, at.inverse);
    C change[kRows], moved[N];
    newton_step(at, change);
    const C none{splat(0.0), splat(0.0)};
    D size = D{}, before = length;
    length = D{};
    for (int k = 0; k < N; ++k) {
      // Free coordinate k is coordinate k below the patch, k + 1 above it.
      moved[k] = k < kRows ? select(below[k], change[k], none) : none;
      if (k > 0) moved[k] = moved[k] + select(above[k - 1], change[k - 1], none);
      size = maximum(units.into(k, bound(z[k])), size), length = maximum(bound(moved[k]), length);
      moved[k] = units.from(k, moved[k]);
    }
    bool arrived = true;
    for (int l = 0; l < W; ++l)
      arrived = arrived && !(length[l] > kArrived * size[l] &&
                             !(length[l] < kShort * size[l] && length[l] > kStalled * before[l]));
    const bool last = arrived || step == kFinerSteps;
    const D no_gap[kEquations] = {};  // of values: they are among the coefficients
    if (last) isolate(d.system, units, z, above, at, kFinerRounding, no_gap, found);
    Room<N> change_of;
    change_of.store(moved);
    GSP_FINER.move(point, change_of);
    if (last) {
      // Of that move.
      found.error_after += kFinerRounding * (size + length);
      return units.of_f;
    }
  }
}

void decide_lanes(const Decision& d, int parts, const Complex* points, int begin) {
  const int lanes = d.count - begin < W ? d.count - begin : W;
  FinerPoint point;
  // Lanes beyond the last point repeat the first point.
  for (int part = 0; part < kFinerParts; ++part)
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < W; ++l) {
        const int p = begin + (l < lanes ? l : 0);
        const Complex x = part < parts ? points[N * (part * d.count + p) + i] : Complex{0.0, 0.0};
        point.re[part][i * W + l] = x.re, point.im[part][i * W + l] = x.im;
      }
  D patch;
  double which[W];
  GSP_FINER.place(d.platform.frames, point, which);
  __builtin_memcpy(&patch, which, sizeof patch);
  Mask above[kRows], below[kRows];
  for (int k = 0; k < kRows; ++k) above[k] = patch <= D{} + double(k), below[k] = ~above[k];
  C z[N];
  Isolation found;
  const D unit_of_f = prove_points(d, point, above, below, found);
  Room<kMotion> motion;
  GSP_FINER.motion(point, motion);
  point.load(z);
  Room<N> reached;
  reached.store(z);
  double error[W], real[W], f_unit[W], deviation[W], rounded[W], re[kNumbers * W], im[kNumbers * W];
  for (int l = 0; l < W; ++l) error[l] = found.error_after[l], real[l] = found.real[l] ? 1.0 : 0.0, f_unit[l] = unit_of_f[l];
  GSP_FINE.poses_of(reached, motion, error, f_unit, real, 1.0, {{re, im}, deviation, rounded});
  for (int l = 0; l < lanes; ++l) {
    const int p = begin + l;
    const auto number = [&](int i) { return Complex{re[i * W + l], im[i * W + l]}; };
    double largest = 1.0;
    for (int i = 0; i < kEntries; ++i) {
      const Complex x = number(i);
      const double size = __builtin_sqrt(x.re * x.re + x.im * x.im);
      if (size > largest) largest = size;
    }
    const FinerPoses& out = d.out;
    for (int i = 0; i < 9; ++i) out.rotation[9 * p + i] = number(i);
    for (int i = 0; i < 3; ++i) {
      const Complex x = number(9 + i);
      out.translation[3 * p + i] = {d.platform.scale * x.re, d.platform.scale * x.im};
    }
    for (int i = 0; i < 4; ++i) out.quaternion[4 * p + i] = number(kEntries + i);
    for (int part = 0; part < kFinerParts; ++part)
      for (int i = 0; i < N; ++i)
        out.reached[N * (part * d.count + p) + i] = {point.re[part][i * W + l], point.im[part][i * W + l]};
    out.deviation[p] = deviation[l];
    const bool known = found.isolated[l] && deviation[l] <= d.platform.tolerance * largest;
    out.proved[p] = static_cast<std::uint8_t>(
        known ? kIsolated | (found.real[l] ? kReal : 0) | (found.imaginary[l] ? kComplex : 0) |
                    (rounded[l] != 0.0 ? kRounded : 0)
              : 0);
  }
}

}  // namespace

void GSP_DECIDE_FINER(const FinerPlatform& platform, int parts, int count, const Complex* points, double* work,
                      const FinerPoses& out) {
  bound_entries(platform, work);
  const FinerQuadrics& g = platform.equations;
  const Decision d{platform, {g.quadrics, nullptr, work, g.equation}, out, count};
  for (int begin = 0; begin < count; begin += W) decide_lanes(d, parts, points, begin);
}

}  // namespace gsp
