// The theorem of gspcli.certification.poses.isolation for quadrics, with numbers of 288 binary places.
//
// Let u be one unit in the last place, F the quadrics with any coefficients within their errors, H
// their Hessian matrices, of which all entries are known to h. A sum is exact, a product of real
// numbers is off by less than u, one of complex numbers by less than 3 u. So at a point x, exact, with
// |x|_1 the sum of the moduli of its coordinates,
//
// * a derivative, eight products with real coefficients, is off by at most g = h |x|_1 + 16 u,
// * twice a value, eight products of x with derivatives, by at most |x|_1 g + 24 u,
// * an entry of 2 Y F by at most |Y_i|_1 (|x|_1 g + 24 u) + 21 u, where Y is exact, however it was
//   found, and |Y_i|_1 is the sum of a row of it,
// * an entry of I - Y F' by |Y_i|_1 g for that of F', and because 32 digits do for it: numbers are
//   rounded to 2^-96 of them, a product of reals is off by less than 2^-100 of it, a sum by less
//   than 2^-100 of the sum of the moduli of both, and there are fifteen: by 2^-90 of the sum of
//   the moduli of all products, and of 1,
// * second derivatives of a quadric are constant, and the sum of their moduli is off by 64 h,
// * N and N R, of at most twelve products of reals each, and N T, of sixteen, twice, by less than 32 u.
//
// Moduli are bounded above by the sums of those of both parts, below by the larger. Bounds are
// sums and products of nonnegative doubles, and rounded outward as in gspcli.certification.
#include "digits.hpp"

#include <algorithm>
#include <vector>

#include "fixed.hpp"

namespace gsp {
namespace {

constexpr int kRows = kEquations + 1, kSize = kVariables;
constexpr double kOutward = 1.0 + 0x1p-40, kReach = 0.125;
constexpr int kNewtonSteps = 9;
constexpr double kShrinks = 0x1p-10;  // by which steps shrink at least, those past the first few
constexpr int kFirstSteps = 4;
constexpr double kShort = 0x1p-40;   // Newton steps after which a proof may be worth it
constexpr double kSmall = 0x1p-80;   // after which the inverse does as well as before
constexpr double kKnown = 0x1p-54;   // relative error of what is rounded to doubles
constexpr double kRounding = 0x1p-90;  // of sums of products with 32 digits

template <class T>
struct Of {  // a complex number
  T re, im;
};
using Number = Of<Fixed>;
using Rough = Of<Pair>;

Number operator+(const Number& a, const Number& b) { return {a.re + b.re, a.im + b.im}; }
Number operator-(const Number& a, const Number& b) { return {a.re - b.re, a.im - b.im}; }
Number operator*(const Number& a, const Number& b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
Number operator*(const Fixed& a, const Number& b) { return {a * b.re, a * b.im}; }
Number halved(const Number& a) { return {half(a.re), half(a.im)}; }
Number number(double re, double im) { return {fixed(re), fixed(im)}; }

double size(const Fixed& a) { return kOutward * magnitude(a); }
double size(const Number& a) { return kOutward * (size(a.re) + size(a.im)); }
double least(const Rough& a) {
  return std::max(std::fabs(a.re.hi), std::fabs(a.im.hi)) / kOutward;
}

Pair operator-(const Pair& a) { return {-a.hi, -a.lo}; }
Rough operator-(const Rough& a, const Rough& b) { return {sum(a.re, -b.re), sum(a.im, -b.im)}; }
Rough operator*(const Rough& a, const Rough& b) {
  return {sum(product(a.re, b.re), -product(a.im, b.im)),
          sum(product(a.re, b.im), product(a.im, b.re))};
}
Rough rounded(const Number& a) { return {rounded(a.re), rounded(a.im)}; }
Pair quotient(const Pair& a, const Pair& b) {
  const double first = a.hi / b.hi;
  const Pair left = sum(a, -product({first, 0.0}, b));
  return sum({first, 0.0}, {left.hi / b.hi, 0.0});
}
Rough quotient(const Rough& a, const Rough& b) {
  const Pair square = sum(product(b.re, b.re), product(b.im, b.im));
  const Rough c = a * Rough{b.re, -b.im};
  return {quotient(c.re, square), quotient(c.im, square)};
}
double roughly(const Rough& a) { return std::fabs(a.re.hi) + std::fabs(a.im.hi); }
Complex complex(const Rough& a) { return {a.re.hi, a.im.hi}; }

// About the inverse of a matrix, by Gauss's and Jordan's elimination; false if there is none.
bool invert(const Number (&given)[kRows][kRows], Number (&inverse)[kRows][kRows]) {
  constexpr int columns = 2 * kRows;
  Rough a[kRows][columns];
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < kRows; ++k) {
      a[i][k] = rounded(given[i][k]);
      a[i][kRows + k] = {{i == k ? 1.0 : 0.0, 0.0}, {0.0, 0.0}};
    }
  for (int k = 0; k < kRows; ++k) {
    int pivot = k;
    for (int i = k + 1; i < kRows; ++i)
      if (roughly(a[i][k]) > roughly(a[pivot][k])) pivot = i;
    if (!(roughly(a[pivot][k]) > 0.0)) return false;
    if (pivot != k) std::swap_ranges(a[k], a[k] + columns, a[pivot]);
    const Rough unit = quotient({{1.0, 0.0}, {0.0, 0.0}}, a[k][k]);
    for (int j = k + 1; j < columns; ++j) a[k][j] = a[k][j] * unit;
    for (int i = 0; i < kRows; ++i) {
      if (i == k) continue;
      const Rough factor = a[i][k];
      for (int j = k + 1; j < columns; ++j)
        if (roughly(a[k][j]) > 0.0) a[i][j] = a[i][j] - factor * a[k][j];
    }
  }
  for (int i = 0; i < kRows; ++i)
    for (int k = 0; k < kRows; ++k) {
      const Rough& entry = a[i][kRows + k];
      inverse[i][k] = {fixed(entry.re), fixed(entry.im)};
    }
  return true;
}

// The quadrics for all points.
class Quadrics {
 public:
  explicit Quadrics(const DigitSystem& system) : hessian_(kRows * kSize * kSize) {
    constexpr int entries = kSize * kSize;
    double most = 0.0;
    for (int i = 0; i < entries; ++i) {
      double weight = 0.0;
      for (int f = 0; f < system.forms; ++f) weight += std::fabs(system.table[f * entries + i]);
      most = std::max(most, weight);
    }
    error = kOutward * most * system.error;
    for (int r = 0; r < kRows; ++r) {
      double sum = 0.0;
      for (int i = 0; i < entries; ++i) {
        Fixed& entry = hessian_[r * entries + i];
        for (int f = 0; f < system.forms; ++f) {
          const int factor = static_cast<int>(system.table[f * entries + i]);
          if (!factor) continue;
          Fixed coefficient;
          std::copy_n(system.numbers + kWords * (r * system.forms + f), kWords, coefficient.word);
          entry = entry + factor * checked(coefficient);
        }
        sum += size(entry);
      }
      second[r] = kOutward * (sum + entries * error);
    }
  }

  // Derivatives by all coordinates, and twice the values.
  void evaluate(const Number* z, Number (&jacobian)[kRows][kSize], Number* twice) const {
    const Fixed* entry = hessian_.data();
    for (int r = 0; r < kRows; ++r) {
      twice[r] = {};
      for (int i = 0; i < kSize; ++i) {
        Number s{};
        for (int j = 0; j < kSize; ++j, ++entry)
          if (!entry->is_zero()) s = s + *entry * z[j];
        jacobian[r][i] = s;
        twice[r] = twice[r] + z[i] * s;
      }
    }
  }

  double error;          // of an entry of the Hessian matrices
  double second[kRows];  // of each quadric a bound of the sum of the moduli of all second derivatives

 private:
  std::vector<Fixed> hessian_;
};

// The equations at a point of a patch, an approximate inverse, and twice Newton's step.
struct Newton {
  Number jacobian[kRows][kRows], inverse[kRows][kRows], twice[kRows], step[kRows];
  double length;
};

// False if there is no inverse; `fresh` is whether it is computed, and not that from before.
bool linearize(const Quadrics& quadrics, const Number* z, int patch, bool fresh, Newton& at) {
  Number whole[kRows][kSize];
  quadrics.evaluate(z, whole, at.twice);
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kRows; ++k) at.jacobian[r][k] = whole[r][k < patch ? k : k + 1];
  if (fresh && !invert(at.jacobian, at.inverse)) return false;
  at.length = 0.0;
  for (int i = 0; i < kRows; ++i) {
    at.step[i] = {};
    for (int r = 0; r < kRows; ++r) at.step[i] = at.step[i] + at.inverse[i][r] * at.twice[r];
    at.length = std::max(at.length, size(at.step[i]));
  }
  return true;
}

struct Isolation {
  double error = 0.0;
  std::uint8_t proved = 0;
};

Isolation isolate(const Quadrics& quadrics, const Number* z, const Newton& at) {
  double length = 0.0, height = 0.0, total = 0.0;
  for (int i = 0; i < kSize; ++i) {
    length += size(z[i]);
    height = std::max(height, size(z[i].im));
  }
  const double slope = kOutward * (quadrics.error * length + 16.0 * kPlace);
  const double value = kOutward * (length * slope + 24.0 * kPlace);
  Rough jacobian[kRows][kRows];
  double entry[kRows][kRows];
  for (int r = 0; r < kRows; ++r)
    for (int k = 0; k < kRows; ++k) {
      jacobian[r][k] = rounded(at.jacobian[r][k]);
      entry[r][k] = roughly(jacobian[r][k]);
    }
  double a = 0.0, b = 0.0, delta = 0.0;
  for (int i = 0; i < kRows; ++i) {
    double row = 0.0, bent = 0.0, defect = 0.0;
    Rough inverse[kRows];
    double y[kRows];
    for (int r = 0; r < kRows; ++r) {
      inverse[r] = rounded(at.inverse[i][r]);
      y[r] = kOutward * roughly(inverse[r]);
      row += y[r];
      bent += y[r] * quadrics.second[r];
    }
    for (int k = 0; k < kRows; ++k) {
      Rough s{{i == k ? 1.0 : 0.0, 0.0}, {0.0, 0.0}};
      double products = 1.0;
      for (int r = 0; r < kRows; ++r) {
        s = s - inverse[r] * jacobian[r][k];
        products += y[r] * entry[r][k];
      }
      defect += kOutward * roughly(s) + kRounding * products + row * slope;
    }
    const double moved = 0.5 * (size(at.step[i]) + row * value + 21.0 * kPlace);
    a = std::max(a, defect);
    b = std::max(b, bent);
    delta = std::max(delta, moved);
    total += defect + bent + moved;
  }
  a *= kOutward, b *= kOutward, delta *= kOutward;
  const double radius = std::min((1.0 - a) / (2.0 * b), kReach);
  const double q = kOutward * (a + b * radius);
  Isolation found;
  // Whatever is not a number proves nothing: it is in the sums.
  if (!(total + length < std::numeric_limits<double>::infinity()) || !(q < 1.0) || !(radius > 0.0) ||
      !(kOutward * delta <= (1.0 - q) * radius))
    return found;
  found.error = kOutward * (delta / (1.0 - q));
  found.proved = kIsolated;
  if (kOutward * (2.0 * height + found.error) <= radius) found.proved |= kReal;
  // The height itself is rounded outward.
  if (height > kOutward * kOutward * kOutward * found.error) found.proved |= kComplex;
  return found;
}

// N, N R by rows, N T (`study.motion`).
void motion(const Number* z, Number& norm, Number* entry) {
  const Number *e = z, *f = z + 4;
  Number p[4][4];
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) p[i][j] = p[j][i] = e[i] * e[j];
  norm = p[0][0] + p[1][1] + p[2][2] + p[3][3];
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    entry[4 * i] = p[0][0] + p[i + 1][i + 1] - p[j + 1][j + 1] - p[k + 1][k + 1];
    const Number skew = p[0][k + 1] + p[0][k + 1], even = p[i + 1][j + 1] + p[i + 1][j + 1];
    entry[3 * i + j] = even - skew;
    entry[3 * j + i] = even + skew;
    const Number t = f[i + 1] * e[0] - f[0] * e[i + 1] - f[j + 1] * e[k + 1] + f[k + 1] * e[j + 1];
    entry[9 + i] = t + t;
  }
}

// The pose of a proved point, and whether it is known well enough. As in `floating.deviations`, over
// a ball of radius r about x = (e, f) N and N R change by at most 2 |e|_1 r + 8 r^2, and N T by
// the same with x for e.
bool place(const Number* z, double error, int p, const DigitPoses& out) {
  Number norm, entry[12];
  motion(z, norm, entry);
  double turning = 0.0, moving = 0.0;
  for (int i = 0; i < kSize; ++i) (i < 4 ? turning : moving) += size(z[i]);
  moving += turning;
  for (double* change : {&turning, &moving})
    *change = kOutward * (2.0 * *change * error + 8.0 * error * error + 32.0 * kPlace);
  const Rough divisor = rounded(norm);
  const double away = least(divisor) - kOutward * turning;
  if (!(away > 0.0)) return false;
  bool known = true;
  for (int part = 0; part < 2; ++part) {
    double worst = 0.0, largest = 0.0, total = 0.0;
    for (int i = part ? 9 : 0; i < (part ? 12 : 9); ++i) {
      const Rough q = quotient(rounded(entry[i]), divisor);
      const Complex value = complex(q);
      (part ? out.translation[3 * p + i - 9] : out.rotation[9 * p + i]) = value;
      worst = std::max(worst, ((part ? moving : turning) + kOutward * roughly(q) * turning) / away);
      largest = std::max(largest, least(q));
      total += roughly(q);
    }
    known = known && total < std::numeric_limits<double>::infinity() &&
            kOutward * worst <= kKnown * largest;
  }
  out.norm[p] = complex(divisor);
  for (int i = 0; i < 4; ++i) out.quaternion[4 * p + i] = complex(rounded(z[i]));
  return known;
}

// Into the frames of the equations, to where the largest coordinate of e is 1; which that is.
int enter(const DigitSystem& system, int parts, const Complex* given, Number* z) {
  for (int i = 0; i < kSize; ++i) {
    z[i] = {};
    for (int k = 0; k < parts; ++k)
      z[i] = z[i] + number(given[k * kSize + i].re, given[k * kSize + i].im);
  }
  Fixed base[3], platform[3];
  for (int i = 0; i < 3; ++i) base[i] = fixed(system.base[i]), platform[i] = fixed(system.platform[i]);
  const Number* e = z;
  Number f[4] = {};  // base e - e platform
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    f[0] = f[0] + (platform[i] - base[i]) * e[i + 1];
    f[i + 1] = f[i + 1] + (base[i] - platform[i]) * e[0] + (base[j] + platform[j]) * e[k + 1] -
               (base[k] + platform[k]) * e[j + 1];
  }
  for (int i = 0; i < 4; ++i) z[4 + i] = fixed(system.unit) * z[4 + i] + halved(f[i]);
  int patch = 0;
  for (int i = 1; i < 4; ++i)
    if (size(z[i]) > size(z[patch])) patch = i;
  // By Newton's method.
  const Rough start = quotient({{1.0, 0.0}, {0.0, 0.0}}, rounded(z[patch]));
  Number inverse{fixed(start.re), fixed(start.im)};
  const Number two = number(2.0, 0.0);
  for (int step = 0; step < 2; ++step) inverse = inverse * (two - z[patch] * inverse);
  for (int i = 0; i < kSize; ++i)
    z[i] = i == patch ? number(1.0, 0.0) : inverse * z[i];
  return patch;
}

std::uint8_t prove(const DigitSystem& system, const Quadrics& quadrics, int parts,
                   const Complex* given, int p, const DigitPoses& out) {
  Number z[kSize];
  const int patch = enter(system, parts, given, z);
  Newton at;
  if (!linearize(quadrics, z, patch, true, at)) return 0;
  for (int step = 0;; ++step) {
    if (at.length < kShort) {
      const Isolation found = isolate(quadrics, z, at);
      if (found.proved & (kReal | kComplex) && place(z, found.error, p, out)) return found.proved;
    }
    if (step == kNewtonSteps) return 0;
    for (int k = 0; k < kRows; ++k) {
      Number& moved = z[k < patch ? k : k + 1];
      moved = moved - halved(at.step[k]);
    }
    const double before = at.length;
    if (!linearize(quadrics, z, patch, !(at.length < kSmall), at)) return 0;
    if (step >= kFirstSteps && !(at.length < kShrinks * before)) return 0;
  }
}

}  // namespace

void prove_with_digits(const DigitSystem& system, int count, int parts, const Complex* points,
                       const DigitPoses& out) {
  static_assert(kDigitWords == kWords);
  const Quadrics quadrics(system);
  for (int p = 0; p < count; ++p)
    out.proved[p] = prove(system, quadrics, parts, points + p * parts * kSize, p, out);
}

}  // namespace gsp
