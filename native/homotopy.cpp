#include "homotopy.hpp"

#include <algorithm>
#include <cmath>

namespace gsp {
namespace {

// A feature that is smaller than this part of a quadric is a rounding error, and set to zero: the
// path must stay in the linear space of quadrics that contains both ends. For numbers in doubles,
// and with 32 digits.
constexpr double kNoise = 1e-15, kDeepNoise = 1e-30;

constexpr int kParts = 1 + kMore;

// The unevaluated sum of doubles, large ones first: only sums, and products by powers of two.
struct Sum {
  double part[kParts];

  // Adds a double; the last part is rounded.
  void add(double x) {
    for (double& p : part) {
      const double s = p + x, v = s - p;
      x = (p - (s - v)) + (x - v);
      p = s;
    }
  }
  // Makes the parts overlap by no bits.
  void renormalize() {
    for (int pass = 0; pass < 2; ++pass)
      for (int k = kParts - 1; k > 0; --k) {
        const double s = part[k - 1] + part[k], v = s - part[k - 1];
        part[k] = (part[k - 1] - (s - v)) + (part[k] - v);
        part[k - 1] = s;
      }
  }
};

Sum operator+(Sum a, const Sum& b) {
  for (const double x : b.part) a.add(x);
  a.renormalize();
  return a;
}
Sum operator*(double x, Sum a) {
  for (double& p : a.part) p *= x;
  return a;
}

// A complex number in 32 digits.
struct Wide {
  Sum re, im;
  Complex operator[](int k) const { return {re.part[k], im.part[k]}; }
};

Wide operator+(const Wide& a, const Wide& b) { return {a.re + b.re, a.im + b.im}; }
Wide operator-(const Wide& a, const Wide& b) { return {a.re + -1.0 * b.re, a.im + -1.0 * b.im}; }
Wide operator*(double x, const Wide& a) { return {x * a.re, x * a.im}; }

Wide wide(const std::complex<double>& x) { return {{{x.real()}}, {{x.imag()}}}; }
std::complex<double> rounded(const Wide& x) { return {x.re.part[0], x.im.part[0]}; }

// Coefficients of e_i e_j, e_i f_j, f.f to those of the features of tracker.hpp (modulo e.f).
template <class T>
void to_features(const T* q, T* out) {
  const auto b = [&](int i, int j) { return q[10 + 4 * i + j]; };
  for (int i = 0; i < 10; ++i) out[i] = q[i];
  for (int i = 1; i < 4; ++i) {
    const int j = i % 3 + 1, k = j % 3 + 1;
    const T d = 0.25 * (b(0, i) - b(i, 0)), x = 0.25 * (b(j, k) - b(k, j));
    out[kOffsetT + i - 1] = d + x;
    out[kOffsetU + i - 1] = d - x;
  }
  int n = kOffsetS;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) out[n++] = 0.5 * (b(i, j) + b(j, i));
  for (int i = 1; i < 4; ++i) out[n++] = b(i, i) - b(0, 0);
  out[kOffsetRho] = q[26];
}

double size_of(const std::complex<double>* q) {
  double size = 0.0;
  for (int i = 0; i < kFeatures; ++i) size += std::norm(q[i]);
  return std::sqrt(size);
}

bool uses(const std::complex<double>* q, int begin, int end) {
  return std::any_of(q + begin, q + end, [](const auto& x) { return x != 0.0; });
}

unsigned groups(const std::complex<double>* q) {
  return (uses(q, kOffsetT, kOffsetT + 3) ? kT : 0) | (uses(q, kOffsetU, kOffsetU + 3) ? kU : 0) |
         (uses(q, kOffsetS, kOffsetS + 9) ? kS : 0) |
         (uses(q, kOffsetRho, kOffsetRho + 1) ? kRho : 0);
}

Complex plain(const std::complex<double>& x) { return {x.real(), x.imag()}; }

// The features of one end without noise; returns the groups in use.
unsigned clean(const std::complex<double>* q, std::complex<double>* out) {
  to_features(q, out);
  const double noise = kNoise * size_of(out);
  for (int k = 0; k < kFeatures; ++k)
    if (std::abs(out[k]) < noise) out[k] = 0.0;
  return groups(out);
}

// The same in 32 digits.
unsigned clean(const Wide* q, Wide* out) {
  to_features(q, out);
  std::complex<double> high[kFeatures];
  for (int k = 0; k < kFeatures; ++k) high[k] = rounded(out[k]);
  const double noise = kDeepNoise * size_of(high);
  for (int k = 0; k < kFeatures; ++k)
    if (std::abs(high[k]) < noise) high[k] = 0.0, out[k] = Wide{};
  return groups(high);
}

// The number at a place of a target and of what is added to it.
Wide gathered(const std::complex<double>* Side::* field, int at, const Side& target,
              const Side* more) {
  Wide sum = wide((target.*field)[at]);
  for (int k = 0; k < kMore; ++k) sum = sum + wide((more[k].*field)[at]);
  return sum;
}

// Parts of quadrics of norm 1 that are no larger are rounding.
constexpr double kRounding = 1e-14;

// Row i of one end of a RealHomotopy: the quadrics and the value; false if it is none.
bool real_parts(bool product, const Side& side, int i, std::complex<double>* a,
                std::complex<double>* b, double& value) {
  constexpr int kSquares[4] = {0, 4, 7, 9};  // whose sum is N
  std::complex<double> g[kFeatures], h[kFeatures];
  to_features(side.g + i * kCoefficients, g);
  const double rounding = kRounding * size_of(g);
  double rest = 0.0;
  value = 0.0;
  if (product) {
    to_features(side.h + i * kCoefficients, h);
    for (int k = 0; k < kFeatures; ++k) {
      rest = std::max(rest, std::abs(h[k] - std::conj(g[k])));
      a[k] = 0.5 * (g[k].real() + h[k].real());
      b[k] = 0.5 * (g[k].imag() - h[k].imag());
    }
  } else {
    for (const int k : kSquares) value += 0.25 * g[k].imag();
    for (const int k : kSquares) g[k] -= std::complex<double>(0.0, value);
    for (int k = 0; k < kFeatures; ++k) {
      rest = std::max(rest, std::abs(g[k].imag()));
      a[k] = g[k].real();
      b[k] = 0.0;
    }
  }
  return rest <= rounding;
}

void set_line(const std::complex<double>* from, const std::complex<double>* to, RealLine& q) {
  const double noise_from = kNoise * size_of(from), noise_to = kNoise * size_of(to);
  std::complex<double> used[kFeatures];
  for (int k = 0; k < kFeatures; ++k) {
    const double x = std::abs(from[k]) < noise_from ? 0.0 : from[k].real();
    const double y = std::abs(to[k]) < noise_to ? 0.0 : to[k].real();
    q.start[k] = x, q.change[k] = y - x;
    used[k] = std::abs(x) + std::abs(y);
  }
  q.groups = groups(used);
}

void split(const Wide& x, Complex& first, Complex* more, int stride) {
  first = x[0];
  for (int k = 0; k < kMore; ++k) more[k * stride] = x[k + 1];
}

}  // namespace

void make_homotopy(const bool* products, const Side& start, const Side& target, const Side* more,
                   Homotopy& H) {
  for (int i = 0; i < kQuadrics; ++i) {
    const int row = i % kEquations;
    if (i >= kEquations && !products[row]) continue;
    const auto field = i < kEquations ? &Side::g : &Side::h;
    const int at = row * kCoefficients;
    Quadric& quadric = H.quadric[i];
    std::complex<double> from[kFeatures];
    quadric.groups = clean(start.*field + at, from);
    for (int k = 0; k < kFeatures; ++k) quadric.start[k] = plain(from[k]);
    if (more) {
      Wide given[kCoefficients], to[kFeatures];
      for (int k = 0; k < kCoefficients; ++k) given[k] = gathered(field, at + k, target, more);
      quadric.groups |= clean(given, to);
      for (int k = 0; k < kFeatures; ++k)
        split(to[k] - wide(from[k]), quadric.change[k], &quadric.more[0][k], kFeatures);
    } else {
      std::complex<double> to[kFeatures];
      quadric.groups |= clean(target.*field + at, to);
      for (int k = 0; k < kFeatures; ++k)
        split(wide(to[k] - from[k]), quadric.change[k], &quadric.more[0][k], kFeatures);
    }
  }
  for (int i = 0; i < kEquations; ++i) {
    const std::complex<double> begin = products[i] ? start.tau[i] : 0.0;
    const std::complex<double> end = products[i] ? target.tau[i] : 0.0;
    Wide change = wide(end - begin);
    if (more && products[i]) change = gathered(&Side::tau, i, target, more) - wide(begin);
    H.product[i] = products[i];
    H.tau_start[i] = plain(begin);
    split(change, H.tau_change[i], &H.tau_more[0][i], kEquations);
  }
}

bool make_real_homotopy(const bool* products, const Side& start, const Side& target, RealHomotopy& H) {
  for (int i = 0; i < kEquations; ++i) {
    std::complex<double> a[2][kFeatures], b[2][kFeatures];
    double value[2];
    if (!real_parts(products[i], start, i, a[0], b[0], value[0]) ||
        !real_parts(products[i], target, i, a[1], b[1], value[1]))
      return false;
    set_line(a[0], a[1], H.quadric[i]);
    set_line(b[0], b[1], H.quadric[i + kEquations]);
    H.product[i] = products[i];
    H.value_start[i] = value[0], H.value_change[i] = value[1] - value[0];
    H.tau_start[i] = plain(start.tau[i]);
    H.tau_change[i] = plain(target.tau[i] - start.tau[i]);
  }
  return true;
}

}  // namespace gsp
