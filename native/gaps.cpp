// Gilbert's algorithm with simplices (E. G. Gilbert, D. W. Johnson, S. S. Keerthi, IEEE J. Robotics
// and Automation 4 (1988), 193-203): the point of a hull that is nearest to the origin.
//
// Each step proves both bounds. The distance of a convex combination of the points is at least that
// of the hull. If all points lie beyond a plane, the distance of the plane is at most that of the
// hull. So the answer
// depends on no tolerance of the algorithm, only on rounding, which is bounded.
#include "gaps.hpp"

#include <algorithm>
#include <cmath>

namespace gsp {
namespace {

constexpr int kMostSteps = 100;
// Errors of coordinates, of differences, of products of them: relative to the largest coordinate.
constexpr double kRounding = 0x1p-45;

struct Vec {
  double x, y, z;
};

Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator*(double s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// A point of the hull of some points, as a convex combination, and the square of its distance from the
// origin; `direction` is parallel to it up to rounding, and more accurate if it is short.
struct Nearest {
  Vec point{}, direction{};
  double square = INFINITY;
  int part = 0;
};

// At most four points, and the point of their hull that is nearest to the origin.
struct Simplex {
  Vec point[4];
  int count = 0;
  Nearest nearest;
};

void better(Nearest& best, const Vec& p, const Vec& direction, int part) {
  const double square = dot(p, p);
  if (square < best.square) best = {p, direction, square, part};
}

void of_edge(Nearest& best, const Vec& a, const Vec& b, int part) {
  const Vec d = b - a;
  const double dd = dot(d, d), t = -dot(a, d) / dd;
  if (!(t > 0.0 && t < 1.0)) return;
  const Vec p = a + t * d;
  better(best, p, p - (dot(p, d) / dd) * d, part);
}

void of_triangle(Nearest& best, const Vec& a, const Vec& b, const Vec& c, int part) {
  const Vec n = cross(b - a, c - a);
  const double nn = dot(n, n);
  const double r = dot(cross(b, c), n), s = dot(cross(c, a), n), t = dot(cross(a, b), n);
  if (!(nn > 0.0 && r > 0.0 && s > 0.0 && t > 0.0)) return;
  const Vec p = (1.0 / (r + s + t)) * (r * a + s * b + t * c);
  better(best, p, (dot(a, n) / nn) * n, part);
}

void of_tetrahedron(Nearest& best, const Vec* p) {
  double weight[4], sum = 0.0;
  int positive = 0, negative = 0;
  for (int k = 0; k < 4; ++k) {
    const Vec &a = p[(k + 1) % 4], &b = p[(k + 2) % 4], &c = p[(k + 3) % 4];
    weight[k] = (k % 2 ? -1.0 : 1.0) * dot(a, cross(b, c));
    positive += weight[k] > 0.0;
    negative += weight[k] < 0.0;
    sum += weight[k];
  }
  if (positive < 4 && negative < 4) return;
  Vec q{};
  for (int k = 0; k < 4; ++k) q = q + (weight[k] / sum) * p[k];
  better(best, q, q, 15);
}

// Finds the nearest point of a simplex, and leaves the points that it depends on.
void reduce(Simplex& s) {
  Nearest best;
  for (int i = 0; i < s.count; ++i) {
    better(best, s.point[i], s.point[i], 1 << i);
    for (int j = 0; j < i; ++j) {
      of_edge(best, s.point[i], s.point[j], 1 << i | 1 << j);
      for (int k = 0; k < j; ++k)
        of_triangle(best, s.point[i], s.point[j], s.point[k], 1 << i | 1 << j | 1 << k);
    }
  }
  if (s.count == 4) of_tetrahedron(best, s.point);
  int count = 0;
  for (int i = 0; i < s.count; ++i)
    if (best.part >> i & 1) s.point[count++] = s.point[i];
  s.count = count;
  s.nearest = best;
}

Vec vec(const double* p, double scale) { return {p[0] * scale, p[1] * scale, p[2] * scale}; }

// The point of a hull that is farthest in a direction.
Vec farthest(const double* points, int count, double scale, const Vec& direction) {
  Vec best = vec(points, scale);
  double most = dot(best, direction);
  for (int i = 1; i < count; ++i) {
    const Vec p = vec(points + 3 * i, scale);
    const double along = dot(p, direction);
    if (along > most) most = along, best = p;
  }
  return best;
}

}  // namespace

Gap hull_gap(const double* a, int m, const double* b, int n) {
  double size = 0.0;
  bool known = true;
  for (int i = 0; i < 3 * m; ++i) size = std::max(size, std::abs(a[i])), known &= std::isfinite(a[i]);
  for (int i = 0; i < 3 * n; ++i) size = std::max(size, std::abs(b[i])), known &= std::isfinite(b[i]);
  if (!known) return {NAN, NAN};
  if (size == 0.0) return {0.0, 0.0};
  // Powers of two change no digits; products of scaled coordinates neither over- nor underflow.
  const int exponent = std::clamp(std::ilogb(size), -1000, 1000);
  const double scale = std::ldexp(1.0, -exponent), room = 2.0 * kRounding;
  Simplex s;
  s.point[0] = vec(a, scale) - vec(b, scale);
  s.count = 1;
  reduce(s);
  double low = 0.0;
  for (int step = 0; step < kMostSteps && s.nearest.square > 0.0; ++step) {
    const double far = std::sqrt(s.nearest.square), along = dot(s.nearest.direction, s.nearest.direction);
    if (!(along > 0.0)) break;
    const Vec back = (-1.0 / std::sqrt(along)) * s.nearest.direction;
    const Vec w = farthest(a, m, scale, back) - farthest(b, n, scale, -1.0 * back);
    low = std::max(low, -dot(w, back));
    if (!(far - low > 0x1p-50 * far)) break;
    Simplex next = s;
    if (next.count == 4) break;
    next.point[next.count++] = w;
    reduce(next);
    if (!(next.nearest.square < s.nearest.square)) break;
    s = next;
  }
  const double high = std::sqrt(s.nearest.square);
  return {std::ldexp(std::max(std::min(low, high) - room, 0.0), exponent),
          std::ldexp(high + room, exponent)};
}

}  // namespace gsp
