// Points of planes and quadrics in general position, one system in each lane.
//
// Planes are eliminated by a unitary basis of the points that lie on all of them. The n quadrics on
// them meet in 2^n points, by Bezout's theorem: the joint eigenvectors of the multiplications
// modulo the quadrics. They are refined by Newton's method on the planes and quadrics as given.
// Uncertain systems are marked, and solved by other methods.
#include "intersection.hpp"

#include "quotient.hpp"

namespace gsp {
namespace {

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
