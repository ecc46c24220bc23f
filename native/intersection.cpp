// Points of planes and quadrics in general position, one system in each lane.
//
// Planes are eliminated by a unitary basis of the points that lie on all of them. The n quadrics on
// them meet in 2^n points, by Bezout's theorem: the joint eigenvectors of the multiplications
// modulo the quadrics. They are refined by Newton's method on the planes and quadrics as given.
// Uncertain systems are marked, and solved by other methods.

#include "intersection.hpp"

#include "lanes.hpp"

namespace gsp {
namespace {

// Multiplication modulo n quadrics in affine n-space, n = 1, 2, 3.
//
// In general the products of different coordinates are a basis of the polynomials modulo the
// quadrics: 2^n of them, written as sets of coordinates, one bit each. Products x^2 s, s a set
// without x, are reduced to the basis one degree after the other; those of one degree are unknowns
// of linear equations. This is elimination in Macaulay's matrix of degree n + 1 by blocks. See
// D. Cox, J. Little, D. O'Shea, Using Algebraic Geometry, chapters 2 and 3.

// Linear equations and eigenvectors of small complex matrices, one matrix in each lane.
//
// Nothing here branches between lanes: equations are solved by orthogonalization, which needs no
// pivots, and the QR algorithm takes as many steps as the slowest lane needs.

INLINE C real(double a) { return {splat(a), V{}}; }
INLINE C conjugate(const C& a) { return {a.re, -a.im}; }
INLINE C operator-(const C& a) { return {-a.re, -a.im}; }
INLINE C operator*(double a, const C& b) { return {a * b.re, a * b.im}; }
INLINE C quotient(const C& a, const C& b) { return (1.0 / square(b)) * (conjugate(b) * a); }

INLINE C root(const C& x) {
  const V re = root(0.5 * (root(square(x)) + maximum(x.re, -x.re)));
  const V im = 0.5 * x.im / select(re > 0.0, re, splat(1.0));
  const C left = {maximum(im, -im), select(x.im < 0.0, -re, re)};
  return select(x.re >= 0.0, C{re, im}, left);
}

// Solves A X = B. A is overwritten, B becomes X.
template <int n, int r>
void solve(C (&a)[n][n], C (&b)[n][r]) {
  C upper[n][n]{}, y[n][r];
  V inverse[n];
  for (int j = 0; j < n; ++j) {
    V s{};
    for (int i = 0; i < n; ++i) s += square(a[i][j]);
    inverse[j] = 1.0 / root(s);
    for (int i = 0; i < n; ++i) a[i][j] = inverse[j] * a[i][j];
    for (int k = j + 1; k < n; ++k) {
      C d{};
      for (int i = 0; i < n; ++i) add_conjugate_product(d, a[i][j], a[i][k]);
      for (int i = 0; i < n; ++i) subtract_product(a[i][k], d, a[i][j]);
      upper[j][k] = d;
    }
    for (int k = 0; k < r; ++k) {
      C d{};
      for (int i = 0; i < n; ++i) add_conjugate_product(d, a[i][j], b[i][k]);
      for (int i = 0; i < n; ++i) subtract_product(b[i][k], d, a[i][j]);
      y[j][k] = d;
    }
  }
  for (int j = n; j-- > 0;)
    for (int k = 0; k < r; ++k) {
      C s = y[j][k];
      for (int l = j + 1; l < n; ++l) subtract_product(s, upper[j][l], b[l][k]);
      b[j][k] = inverse[j] * s;
    }
}

// A becomes the upper Hessenberg matrix P* A P, and R becomes R P, for a unitary P.
template <int n, int r>
void reduce_to_hessenberg(C (&a)[n][n], C (&rows)[r][n]) {
  for (int k = 0; k + 2 < n; ++k) {
    // The reflection I - beta v v* that takes the column below the diagonal to its first entry.
    C v[n];
    V tail{};
    for (int i = k + 2; i < n; ++i) tail += square(v[i] = a[i][k]);
    const C first = a[k + 1][k];
    const V absolute = root(square(first)), size = root(square(first) + tail);
    const Mask zero = absolute == 0.0;
    const C phase = (1.0 / select(zero, splat(1.0), absolute)) * first;
    const C end = size * select(zero, real(1.0), phase);
    v[k + 1] = first + end;
    const V beta = select(size > 0.0, 1.0 / (size * (size + absolute)), splat(0.0));
    a[k + 1][k] = -end;
    for (int i = k + 2; i < n; ++i) a[i][k] = C{};
    for (int j = k + 1; j < n; ++j) {
      C d{};
      for (int i = k + 1; i < n; ++i) add_conjugate_product(d, v[i], a[i][j]);
      d = beta * d;
      for (int i = k + 1; i < n; ++i) subtract_product(a[i][j], d, v[i]);
    }
    const auto from_the_right = [&](C* row) {
      C d{};
      for (int j = k + 1; j < n; ++j) add_product(d, row[j], v[j]);
      d = beta * d;
      for (int j = k + 1; j < n; ++j) subtract_product(row[j], d, conjugate(v[j]));
    };
    for (int i = 0; i < n; ++i) from_the_right(a[i]);
    for (int i = 0; i < r; ++i) from_the_right(rows[i]);
  }
}

// The unitary [c* s*; -s c] that takes (a, b) to (its norm, 0); nothing happens in waiting lanes.
struct Turn {
  C c, s;
};

INLINE Turn turn_of(const C& a, const C& b, const Mask& waits = Mask{}) {
  const V size = square(a) + square(b);
  const Mask none = waits | (size == 0.0);
  const V scale = 1.0 / root(select(none, splat(1.0), size));
  return {select(none, real(1.0), scale * a), select(none, C{}, scale * b)};
}

INLINE void turn_rows(const Turn& g, C& x, C& y) {
  C u{}, w{};
  add_conjugate_product(u, g.c, x);
  add_conjugate_product(u, g.s, y);
  add_product(w, g.c, y);
  subtract_product(w, g.s, x);
  x = u;
  y = w;
}

INLINE void turn_columns(const Turn& g, C& x, C& y) {
  C u{}, w{};
  add_product(u, g.c, x);
  add_product(u, g.s, y);
  add_conjugate_product(w, g.c, y);
  const C s = conjugate(g.s);
  subtract_product(w, s, x);
  x = u;
  y = w;
}

// The eigenvalues of an upper Hessenberg matrix, which is overwritten, by the QR algorithm. A lane
// that has found one waits for the others; one that does not converge has wrong ones.
template <int n>
void eigenvalues(C (&h)[n][n], C (&values)[n]) {
  constexpr double kNegligible = 1e-13;
  constexpr int kMostSweeps = 40, kUnusual = 12;
  for (int last = n - 1; last > 0; --last) {
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      C &a = h[last - 1][last - 1], &b = h[last - 1][last], &c = h[last][last - 1],
        &d = h[last][last];
      const Mask small = square(c) <= kNegligible * kNegligible * (square(a) + square(d));
      bool converged = true;
      for (int l = 0; l < W; ++l) converged &= small[l] != 0;
      if (converged) break;
      // Wilkinson's shift: the eigenvalue of the last 2 x 2 matrix that is nearer to d.
      const C half = 0.5 * (a - d), product = b * c;
      const C r = root(half * half + product);
      const C away = half + select(half.re * r.re + half.im * r.im >= 0.0, r, -r);
      C shift = select(square(away) > 0.0, d - quotient(product, away), d);
      if (sweep % kUnusual == kUnusual - 1) shift = shift + 0.75 * c;
      shift = select(small, C{}, shift);
      Turn turns[n];
      for (int i = 0; i <= last; ++i) h[i][i] = h[i][i] - shift;
      for (int i = 0; i < last; ++i) {
        turns[i] = turn_of(h[i][i], h[i + 1][i], small);
        for (int j = i; j <= last; ++j) turn_rows(turns[i], h[i][j], h[i + 1][j]);
      }
      for (int i = 0; i < last; ++i)
        for (int j = 0; j <= i + 1; ++j) turn_columns(turns[i], h[j][i], h[j][i + 1]);
      for (int i = 0; i <= last; ++i) h[i][i] = h[i][i] + shift;
    }
    values[last] = h[last][last];
  }
  values[0] = h[0][0];
}

// An eigenvector of an upper Hessenberg matrix for a known eigenvalue, by one step of inverse
// iteration: H - value = Q R, and R v = (1, ..., 1).
template <int n>
void eigenvector(const C (&matrix)[n][n], const C& value, C (&v)[n]) {
  C h[n][n];
  V size{};
  for (int i = 0; i < n; ++i)
    for (int j = i > 0 ? i - 1 : 0; j < n; ++j) size += square(h[i][j] = matrix[i][j]);
  for (int i = 0; i < n; ++i) h[i][i] = h[i][i] - value;
  for (int i = 0; i + 1 < n; ++i) {
    const Turn g = turn_of(h[i][i], h[i + 1][i]);
    for (int j = i; j < n; ++j) turn_rows(g, h[i][j], h[i + 1][j]);
  }
  const V least = 1e-32 * size;
  for (int i = n; i-- > 0;) {
    C s = real(1.0);
    for (int j = i + 1; j < n; ++j) subtract_product(s, h[i][j], v[j]);
    v[i] = quotient(s, select(square(h[i][i]) < least, C{root(least), V{}}, h[i][i]));
  }
}

constexpr int degree(int set) { return __builtin_popcount(static_cast<unsigned>(set)); }

template <int n>
struct Quotient {
  static constexpr int kSize = 1 << n;

  // forms[k][i][j], symmetric, of (1, x_1 ... x_n).
  explicit Quotient(const C (&forms)[n][n + 1][n + 1]) {
    C left[n][n], right[n][kSize];
    for (int k = 0; k < n; ++k) {
      const auto& q = forms[k];
      for (int x = 0; x < n; ++x) left[k][x] = q[x + 1][x + 1];
      for (int set = 0; set < kSize; ++set) right[k][set] = C{};
      right[k][0] = -q[0][0];
      for (int x = 0; x < n; ++x) right[k][1 << x] = -2.0 * q[0][x + 1];
      for (int x = 0; x < n; ++x)
        for (int y = x + 1; y < n; ++y) right[k][1 << x | 1 << y] = -2.0 * q[x + 1][y + 1];
    }
    solve(left, right);
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set) squares_[x][0][set] = right[x][set];
    if constexpr (n > 1) reduce_degree<1>();
    if constexpr (n > 2) reduce_degree<2>();
  }

  // Row s has the coefficients of x_1 s.
  void first_multiplication(C (&matrix)[kSize][kSize]) const {
    for (int set = 0; set < kSize; ++set)
      for (int t = 0; t < kSize; ++t)
        matrix[set][t] = set & 1 ? squares_[0][set & ~1][t]
                                 : real(t == (set | 1));
  }

 private:
  // squares_[x][s][t]: the coefficient of t in x^2 s.
  C squares_[n][kSize][kSize];

  // Reduces x^2 s for the sets s of d coordinates: as y times x^2 (s - y), for one y of s.
  template <int d>
  void reduce_degree() {
    constexpr int kUnknowns = n * (n - 1) / d;  // n times binomial(n - 1, d), for n <= 3
    int number[n][kSize], count = 0;
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set)
        if (!(set >> x & 1) && degree(set) == d) number[x][set] = count++;
    C left[kUnknowns][kUnknowns], right[kUnknowns][kSize];
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set) {
        if (set >> x & 1 || degree(set) != d) continue;
        // The next coordinate after x, cyclically, that is in the set.
        int y = (x + 1) % n;
        while (!(set >> y & 1)) y = (y + 1) % n;
        const int row = number[x][set];
        for (int k = 0; k < kUnknowns; ++k) left[row][k] = real(k == row);
        for (int t = 0; t < kSize; ++t) right[row][t] = C{};
        const C* lower = squares_[x][set & ~(1 << y)];
        for (int t = 0; t < kSize; ++t) {
          const int rest = t & ~(1 << y);
          if (rest == t)
            right[row][t | 1 << y] = right[row][t | 1 << y] + lower[t];
          else if (degree(rest) == d)
            left[row][number[y][rest]] = left[row][number[y][rest]] - lower[t];
          else if (degree(rest) < d)
            for (int u = 0; u < kSize; ++u)
              add_product(right[row][u], lower[t], squares_[y][rest][u]);
        }
      }
    solve(left, right);
    for (int x = 0; x < n; ++x)
      for (int set = 0; set < kSize; ++set)
        if (!(set >> x & 1) && degree(set) == d)
          for (int t = 0; t < kSize; ++t) squares_[x][set][t] = right[number[x][set]][t];
  }
};

constexpr int kCoordinates = 4;
// Points of norm 1 that are nearer than this are not trusted, ...
constexpr double kSeparation = 1e-4;
// ... nor systems with a point whose error is larger than the first number, or whose last step of
// Newton's method, with a square that is about what remains, than the second.
constexpr double kAccuracy = 1e-9, kLastStep = 1e-6;
// Planes of a smaller norm are mostly rounding errors.
constexpr double kSmall = 1e-4;
constexpr int kNewtonSteps = 2;
// A point of norm 1 with a smaller imaginary part is real: else its conjugate would be too near.
constexpr double kImaginary = 1e-6;
// A fixed orthogonal matrix without special position.
constexpr double kA = 0.36055512754639896, kB = 0.4358898943540674, kC = 0.5385164807134504,
                 kD = 0.6244997998398398;
constexpr double kDirections[kCoordinates][kCoordinates] = {
    {kA, kB, kC, kD}, {-kB, kA, -kD, kC}, {-kC, kD, kA, -kB}, {-kD, -kC, kB, kA}};

using Point = C[kCoordinates];

INLINE V square(const Point& x) {
  V s{};
  for (int i = 0; i < kCoordinates; ++i) s += square(x[i]);
  return s;
}
INLINE void scale(const V& factor, Point& x) {
  for (int i = 0; i < kCoordinates; ++i) x[i] = factor * x[i];
}
INLINE C bilinear(const Point& x, const Point& y) {
  C s{};
  for (int i = 0; i < kCoordinates; ++i) add_product(s, x[i], y[i]);
  return s;
}
INLINE C hermitian(const Point& x, const Point& y) {
  C s{};
  for (int i = 0; i < kCoordinates; ++i) add_conjugate_product(s, x[i], y[i]);
  return s;
}
INLINE void subtract(Point& y, const C& factor, const Point& x) {
  for (int i = 0; i < kCoordinates; ++i) subtract_product(y[i], factor, x[i]);
}

template <int n>  // quadrics, and 3 - n planes
class System {
 public:
  static constexpr int kPlanes = 3 - n, kPoints = 1 << n;

  Point plane[kPlanes ? kPlanes : 1];
  Point quadric[n ? n : 1][kCoordinates];
  V accuracy;

  Point point[kPoints];
  V error[kPoints];
  Mask ok;

  void solve() {
    ok = Mask{} - 1;
    for (int k = 0; k < kPlanes; ++k) {
      const V size = root(square(plane[k]));
      ok &= size > kSmall;
      scale(1.0 / size, plane[k]);
    }
    for (int k = 0; k < n; ++k) {
      V s{};
      for (const Point& row : quadric[k]) s += square(row);
      for (Point& row : quadric[k]) scale(1.0 / root(s), row);
    }
    start();
    for (int p = 0; p < kPoints; ++p) {
      V length;
      for (int k = 0; k < kNewtonSteps; ++k) length = step(p);
      ok &= (length < kLastStep) & (error[p] < kAccuracy);
    }
    constexpr double kNear = (1 - kSeparation * kSeparation) * (1 - kSeparation * kSeparation);
    for (int p = 0; p < kPoints; ++p)
      for (int q = p + 1; q < kPoints; ++q) ok &= square(hermitian(point[p], point[q])) < kNear;
  }

 private:
  // The points, not yet accurate.
  void start() {
    Point basis[n + 1];
    complement(basis);
    if constexpr (n == 0) {
      for (int i = 0; i < kCoordinates; ++i) point[0][i] = basis[0][i];
    } else {
      C forms[n][n + 1][n + 1];
      for (int k = 0; k < n; ++k)
        for (int i = 0; i <= n; ++i) {
          Point row;
          for (int j = 0; j < kCoordinates; ++j) row[j] = bilinear(quadric[k][j], basis[i]);
          for (int j = 0; j <= i; ++j) forms[k][i][j] = forms[k][j][i] = bilinear(row, basis[j]);
        }
      C matrix[kPoints][kPoints], rows[n + 1][kPoints];
      Quotient<n>(forms).first_multiplication(matrix);
      // Its eigenvectors are the values of the basis at the points: 1, x_1 ... x_n among them.
      for (int i = 0; i <= n; ++i)
        for (int set = 0; set < kPoints; ++set)
          rows[i][set] = real(set == (i ? 1 << (i - 1) : 0));
      reduce_to_hessenberg(matrix, rows);
      C triangular[kPoints][kPoints], values[kPoints];
      for (int i = 0; i < kPoints; ++i)
        for (int j = 0; j < kPoints; ++j) triangular[i][j] = matrix[i][j];
      eigenvalues(triangular, values);
      for (int p = 0; p < kPoints; ++p) {
        C vector[kPoints];
        eigenvector(matrix, values[p], vector);
        for (int j = 0; j < kCoordinates; ++j) point[p][j] = C{};
        for (int i = 0; i <= n; ++i) {
          C x{};
          for (int set = 0; set < kPoints; ++set) add_product(x, rows[i][set], vector[set]);
          for (int j = 0; j < kCoordinates; ++j) add_product(point[p][j], x, basis[i][j]);
        }
        scale(1.0 / root(square(point[p])), point[p]);
      }
    }
  }

  // A unitary basis of the points on all planes.
  void complement(Point (&basis)[n + 1]) const {
    Point all[kCoordinates];  // conjugates of the planes, orthogonalized, then the basis
    for (int k = 0; k < kCoordinates; ++k) {
      for (int i = 0; i < kCoordinates; ++i)
        all[k][i] = k < kPlanes ? conjugate(plane[k][i])
                                : real(kDirections[k - kPlanes][i]);
      // Twice, because the first time may leave little but rounding errors.
      for (int repeat = 0; repeat < 2; ++repeat) {
        for (int l = 0; l < k; ++l) subtract(all[k], hermitian(all[l], all[k]), all[l]);
        scale(1.0 / root(square(all[k])), all[k]);
      }
    }
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j < kCoordinates; ++j) basis[i][j] = all[kPlanes + i][j];
  }

  // Moves a point by a step of Newton's method, sets its error, and returns the length of the step.
  //
  // The Jacobian matrix J = L Q, with orthonormal rows of Q, has three rows with J x = 0 at a
  // solution x, so that least-norm corrections are orthogonal to the point. The step leaves at most
  // the norm of the inverse matrix (of J and x*) times the square of its length, besides errors of
  // planes and quadrics of norm 1.
  V step(int p) {
    Point& x = point[p];
    Point rows[3];
    C lower[3][3], b[3];
    V inverse[3];
    for (int k = 0; k < 3; ++k) {
      if (k < kPlanes) {
        for (int i = 0; i < kCoordinates; ++i) rows[k][i] = plane[k < kPlanes ? k : 0][i];
        b[k] = bilinear(rows[k], x);
      } else {
        for (int i = 0; i < kCoordinates; ++i)
          rows[k][i] = 2.0 * bilinear(quadric[k - kPlanes][i], x);
        b[k] = 0.5 * bilinear(rows[k], x);
      }
    }
    V size = splat(1.0);
    C columns[3][3];  // of the inverse of L
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < k; ++l) {
        lower[k][l] = hermitian(rows[l], rows[k]);
        subtract(rows[k], lower[k][l], rows[l]);
        subtract_product(b[k], lower[k][l], b[l]);
      }
      inverse[k] = 1.0 / root(square(rows[k]));
      scale(inverse[k], rows[k]);
      b[k] = inverse[k] * b[k];
      columns[k][k] = {inverse[k], V{}};
      for (int c = 0; c < k; ++c) {
        C s{};
        for (int l = c; l < k; ++l) subtract_product(s, lower[k][l], columns[c][l]);
        columns[c][k] = inverse[k] * s;
      }
      for (int c = 0; c <= k; ++c) size += square(columns[c][k]);
    }
    V length{};
    for (int k = 0; k < 3; ++k) length += square(b[k]);
    for (int i = 0; i < kCoordinates; ++i)
      for (int k = 0; k < 3; ++k) subtract_product(x[i], conjugate(rows[k][i]), b[k]);
    scale(1.0 / root(square(x)), x);
    error[p] = root(size) * (length + 4.0 * accuracy);
    return root(length);
  }
};

// Makes points of norm 1 of a real system, well apart, exactly real or exactly conjugate. Returns
// whether that was possible.
bool pair_conjugates(int count, Complex (*point)[kCoordinates], double* error) {
  for (int p = 0; p < count;) {
    Complex* z = point[p];
    int pivot = 0;
    const auto size = [&](int i) { return z[i].re * z[i].re + z[i].im * z[i].im; };
    for (int i = 1; i < kCoordinates; ++i)
      if (size(i) > size(pivot)) pivot = i;
    const double absolute = __builtin_sqrt(size(pivot));
    const Complex phase = {z[pivot].re / absolute, -z[pivot].im / absolute};
    double real = 0.0, imaginary = 0.0;
    for (int i = 0; i < kCoordinates; ++i) {
      z[i] = {z[i].re * phase.re - z[i].im * phase.im, z[i].re * phase.im + z[i].im * phase.re};
      real += z[i].re * z[i].re;
      imaginary += z[i].im * z[i].im;
    }
    if (imaginary < kImaginary * kImaginary) {
      for (int i = 0; i < kCoordinates; ++i) z[i] = {z[i].re / __builtin_sqrt(real), 0.0};
      ++p;
      continue;
    }
    int partner = -1;
    double most = 1 - kImaginary;
    for (int q = p + 1; q < count; ++q) {
      Complex s{0.0, 0.0};
      for (int i = 0; i < kCoordinates; ++i) {
        s.re += z[i].re * point[q][i].re - z[i].im * point[q][i].im;
        s.im += z[i].re * point[q][i].im + z[i].im * point[q][i].re;
      }
      const double overlap = s.re * s.re + s.im * s.im;
      if (overlap > most) {
        most = overlap;
        partner = q;
      }
    }
    if (partner < 0) return false;
    for (int i = 0; i < kCoordinates; ++i) {
      point[partner][i] = point[p + 1][i];
      point[p + 1][i] = {z[i].re, -z[i].im};
    }
    error[partner] = error[p + 1];
    error[p + 1] = error[p];
    p += 2;
  }
  return true;
}

template <int n>
void intersect(const Intersections& given, const IntersectionResults& out) {
  using Lanes = System<n>;
  constexpr int kPlanes = Lanes::kPlanes, kPoints = Lanes::kPoints;
  Lanes lanes;
  const int total = given.groups * given.systems;
  for (int begin = 0; begin < total; begin += W) {
    for (int l = 0; l < W; ++l) {
      const int system = begin + l < total ? begin + l : begin, group = system / given.systems;
      for (int k = 0; k < kPlanes; ++k)
        for (int i = 0; i < kCoordinates; ++i)
          put(lanes.plane[k][i], l, given.plane[(system * kPlanes + k) * kCoordinates + i]);
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < kCoordinates; ++i)
          for (int j = 0; j < kCoordinates; ++j)
            put(lanes.quadric[k][i][j], l,
                given.quadric[((group * n + k) * kCoordinates + i) * kCoordinates + j]);
      put(lanes.accuracy, l, given.accuracy[group]);
    }
    lanes.solve();
    for (int l = 0; l < W && begin + l < total; ++l) {
      Complex point[kPoints][kCoordinates];
      double error[kPoints];
      for (int p = 0; p < kPoints; ++p) {
        for (int i = 0; i < kCoordinates; ++i) point[p][i] = lane(lanes.point[p][i], l);
        error[p] = lane(lanes.error[p], l);
      }
      const int system = begin + l;
      bool ok = lanes.ok[l];
      if (ok && given.real[system / given.systems]) ok = pair_conjugates(kPoints, point, error);
      for (int p = 0; p < kPoints; ++p) {
        for (int i = 0; i < kCoordinates; ++i)
          out.point[(system * kPoints + p) * kCoordinates + i] = ok ? point[p][i] : Complex{};
        out.error[system * kPoints + p] = ok ? error[p] : __builtin_inf();
      }
      out.ok[system] = ok;
    }
  }
}

}  // namespace

void GSP_INTERSECT(const Intersections& given, int planes, const IntersectionResults& out) {
  switch (planes) {
    case 0: return intersect<3>(given, out);
    case 1: return intersect<2>(given, out);
    case 2: return intersect<1>(given, out);
    default: return intersect<0>(given, out);
  }
}

}  // namespace gsp
