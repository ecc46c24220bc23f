#include "closed_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "products.hpp"

namespace gsp {
namespace {

using Number = std::complex<double>;

constexpr int kStudy = 8;
constexpr double kRounding = std::numeric_limits<double>::epsilon();
// Rotations with a larger error relative to N are not good enough.
constexpr double kAccuracy = 1e-11;
// A coordinate of a point of norm one is not zero if it is larger than this and its error.
constexpr double kCertain = 1e-12;
// Squared sine below which lines are not trusted to be skew.
constexpr double kNearlyParallel = 1e-6;

bool certainly_not_zero(double size, double error) {
  return size > std::max(kCertain, 100.0 * error);
}

// The quadric N (v . R u - cosine) of quaternions e = (e0, w), symmetric: its part in N is
// (e0^2 - w.w) u.v + 2 e0 w.(u x v) + 2 (w.u)(w.v).
void make_angle_form(const double* u, const double* v, double cosine, Number (*form)[4]) {
  const double along = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
  form[0][0] = along - cosine;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    form[0][1 + i] = form[1 + i][0] = u[j] * v[k] - u[k] * v[j];
    for (int l = 0; l < 3; ++l) form[1 + i][1 + l] = u[i] * v[l] + u[l] * v[i];
    form[1 + i][1 + i] -= along + cosine;
  }
}

// Where systems of k planes and 3 - k quadrics meet.
struct Meeting {
  std::vector<Number> point;  // (systems, 2^(3-k), 4)
  std::vector<double> error;  // (systems, 2^(3-k))
  std::unique_ptr<bool[]> ok;

  Meeting(Intersect* intersect, int groups, int systems, int planes, const Number* plane,
          const Number* quadric, const double* accuracy, const bool* real)
      : point(4 * count(groups * systems, planes)), error(count(groups * systems, planes)),
        ok(new bool[groups * systems]) {
    intersect({groups, systems, reinterpret_cast<const Complex*>(plane),
               reinterpret_cast<const Complex*>(quadric), accuracy, real},
              planes, {reinterpret_cast<Complex*>(point.data()), error.data(), ok.get()});
  }

 private:
  static std::size_t count(int systems, int planes) {
    return static_cast<std::size_t>(systems) << (3 - planes);
  }
};

// The rotations of sets of values; of a pair of conjugates only one.
struct Rotations {
  std::vector<Number> e;         // (rotations, 4), norm 1
  std::vector<double> accuracy;  // of what is computed from them
  std::vector<char> real;
  std::vector<int> owner;  // whose set they are

  int count() const { return static_cast<int>(owner.size()); }
};

// Sets whose quadrics do not certainly meet in eight simple finite points have no rotations.
Rotations find_rotations(const Directions& given, const ValueSets& values, Intersect* intersect) {
  std::vector<Number> form(values.count * kAngles * 16);
  for (int b = 0; b < values.count; ++b)
    for (int k = 0; k < kAngles; ++k)
      make_angle_form(given.u + 3 * k, given.v + 3 * k, values.cosine[kAngles * b + k],
                      reinterpret_cast<Number(*)[4]>(&form[(b * kAngles + k) * 16]));
  const std::vector<double> accuracy(values.count, kRounding);
  const std::unique_ptr<bool[]> real(new bool[values.count]);
  std::fill(real.get(), real.get() + values.count, true);
  const Meeting found(intersect, values.count, 1, 0, nullptr, form.data(), accuracy.data(),
                      real.get());
  Rotations out;
  for (int b = 0; b < values.count; ++b) {
    const Number* const points = &found.point[b * kRotations * 4];
    const double* const errors = &found.error[b * kRotations];
    bool known = found.ok[b];
    for (int p = 0; p < kRotations; ++p) {
      Number square = 0.0;
      for (int i = 0; i < 4; ++i) square += product(points[4 * p + i], points[4 * p + i]);
      const double norm = std::abs(square);
      known = known && certainly_not_zero(norm, errors[p]) && errors[p] < kAccuracy * norm;
    }
    if (!known) continue;
    for (int p = 0; p < kRotations;) {
      const Number* const e = points + 4 * p;
      const bool is_real = std::all_of(e, e + 4, [](const Number& x) { return x.imag() == 0.0; });
      out.e.insert(out.e.end(), e, e + 4);
      out.accuracy.push_back(errors[p] + kRounding);
      out.real.push_back(is_real);
      out.owner.push_back(b);
      // Conjugates come one directly after the other.
      p += is_real ? 1 : 2;
    }
  }
  return out;
}

int points_of(const Measures& given) { return 1 << (3 - given.planes()); }

}  // namespace

int poses_of(const Measures& given) { return kRotations * points_of(given); }

void solve_closed_forms(const Directions& directions, const Measures& measures,
                        const ValueSets& values, Intersect* intersect, Number* point,
                        bool* general) {
  const Rotations turned = find_rotations(directions, values, intersect);
  const int rotations = turned.count(), planes = measures.planes(), squares = measures.squares();
  // Of the spheres one is left: the others are planes.
  const int quadrics = squares - measures.circles();
  std::vector<Number> plane(rotations * measures.signs * planes * 4),
      quadric(rotations * quadrics * 16), basis(rotations * 12), each(squares * 16);
  std::vector<double> skewness(rotations);
  for (int r = 0; r < rotations; ++r) {
    const int b = turned.owner[r];
    make_surfaces(measures, &turned.e[4 * r], values.flat + b * measures.heights,
                  values.curved + b * squares,
                  {plane.data() + r * measures.signs * planes * 4, each.data(), &basis[12 * r],
                   &skewness[r]});
    for (int i = 0, j = 0; i < squares; ++i)
      if (i == 0 || i >= measures.spheres)
        std::copy_n(&each[16 * i], 16, &quadric[(r * quadrics + j++) * 16]);
  }
  const std::unique_ptr<bool[]> real(new bool[rotations]);
  std::copy(turned.real.begin(), turned.real.end(), real.get());
  const Meeting placed(intersect, rotations, measures.signs, planes, plane.data(), quadric.data(),
                       turned.accuracy.data(), real.get());

  const int points = points_of(measures), poses = kRotations * points;
  const std::size_t each_set = static_cast<std::size_t>(measures.signs) * poses * kStudy;
  std::vector<int> filled(values.count);  // poses of each side
  std::fill(general, general + values.count, true);
  std::fill(point, point + values.count * each_set, Number());
  for (int r = 0; r < rotations; ++r) {
    const int b = turned.owner[r], copies = turned.real[r] ? 1 : 2;
    bool good = skewness[r] > kNearlyParallel;
    for (int s = 0; s < measures.signs; ++s) {
      const int system = r * measures.signs + s;
      good = good && placed.ok[system];
      for (int p = 0; p < points; ++p) {
        const Number* const x = &placed.point[(system * points + p) * 4];
        good = good && certainly_not_zero(std::abs(x[0]), placed.error[system * points + p]);
        Number* const study =
            point + b * each_set + (s * poses + filled[b] + copies * p) * kStudy;
        for (int l = 0; l < 4; ++l) {
          study[l] = product(x[0], turned.e[4 * r + l]);
          for (int c = 0; c < 3; ++c)
            study[4 + l] += product(basis[12 * r + 3 * l + c], x[1 + c]);
        }
        if (!turned.real[r])
          std::transform(study, study + kStudy, study + kStudy,
                         [](const Number& z) { return std::conj(z); });
      }
    }
    filled[b] += copies * points;
    general[b] = general[b] && good;
  }
  for (int b = 0; b < values.count; ++b) {
    general[b] = general[b] && filled[b] == poses;
    if (!general[b]) std::fill_n(point + b * each_set, each_set, Number());
  }
}

}  // namespace gsp
