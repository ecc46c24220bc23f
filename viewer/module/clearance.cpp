#include "clearance.hpp"

#include <algorithm>

#include "matrices.hpp"

namespace gsp::live {
namespace {

constexpr int kParameters = 6, kHalvings = 40, kSquarings = 5;
constexpr double kRounding = 0x1p-48, kOutward = 1.0 + 0x1p-30, kClose = 1.01;

enum Kind { kDPP, kDPL, kDLP, kDPH, kDHP, kDLL };  // others are angles

// Taylor forms of first order over the unit ball: value, linear part, rest; one component a number.
struct Form {
  double value[3]{}, linear[3][kParameters]{}, rest = 0.0;

  double size() const { return std::sqrt(value[0] * value[0] + value[1] * value[1] + value[2] * value[2]); }
  double reach() const {
    double sum = 0.0;
    for (const auto& row : linear)
      for (const double x : row) sum += x * x;
    return std::sqrt(sum) + rest;
  }
  Form loosened(double more) const {
    Form f = *this;
    f.rest += more;
    return f;
  }
};

Form constant(double a, double b, double c) {
  Form f;
  f.value[0] = a, f.value[1] = b, f.value[2] = c;
  f.rest = kRounding * f.size();
  return f;
}
Form constant(const double* a) { return constant(a[0], a[1], a[2]); }

Form operator*(double factor, Form f) {  // by a power of two, or its negative
  for (int i = 0; i < 3; ++i) {
    f.value[i] *= factor;
    for (double& x : f.linear[i]) x *= factor;
  }
  f.rest *= std::abs(factor);
  return f;
}
Form operator+(const Form& a, const Form& b) {
  Form f = a;
  for (int i = 0; i < 3; ++i) {
    f.value[i] += b.value[i];
    for (int k = 0; k < kParameters; ++k) f.linear[i][k] += b.linear[i][k];
  }
  f.rest = a.rest + b.rest + kRounding * (a.size() + b.size());
  return f;
}
Form operator-(const Form& a, const Form& b) { return a + -1.0 * b; }

// A bilinear product that is no longer than that of the norms.
template <class Times>
Form product(const Form& a, const Form& b, const Times& times) {
  Form f;
  double column[3], other[3], first[3], second[3];
  times(a.value, b.value, f.value);
  for (int k = 0; k < kParameters; ++k) {
    for (int i = 0; i < 3; ++i) column[i] = a.linear[i][k], other[i] = b.linear[i][k];
    times(a.value, other, first);
    times(column, b.value, second);
    for (int i = 0; i < 3; ++i) f.linear[i][k] = first[i] + second[i];
  }
  const double s = a.size(), t = b.size(), ds = a.reach(), dt = b.reach();
  f.rest = s * b.rest + a.rest * t + ds * dt + kRounding * (s + ds) * (t + dt);
  return f;
}
Form cross(const Form& a, const Form& b) {
  return product(a, b, [](const double* x, const double* y, double* out) {
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      out[i] = x[j] * y[k] - x[k] * y[j];
    }
  });
}
Form dot(const Form& a, const Form& b) {
  return product(a, b, [](const double* x, const double* y, double* out) {
    out[0] = x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    out[1] = out[2] = 0.0;
  });
}
Form operator*(const Form& a, const Form& number) {
  return product(a, number, [](const double* x, const double* y, double* out) {
    // One of them is a number: its first component.
    for (int i = 0; i < 3; ++i) out[i] = x[i] * y[0];
  });
}

struct Screw {
  Form moment, force;
};

// As `screw_forms.screw`.
Screw screw(int kind, const Form& arm, const Form& offset, const Form& w, const Form& v) {
  const Form r = arm + offset;
  switch (kind) {
    case kDPP:
      return {cross(arm, offset), r};
    case kDPL: {
      const Form force = r - v * dot(v, r);
      return {cross(arm, force), force};
    }
    case kDLP: {
      const Form along = dot(w, r);
      return {cross(arm, offset) - cross(w, offset) * along, r - w * along};
    }
    case kDPH:
      return {cross(arm, v), v};
    case kDHP:
      return {cross(w, offset), w};
    case kDLL: {
      const Form normal = cross(w, v), square = dot(normal, normal), moment = dot(r, normal),
                 cosine = dot(w, v), turning = cross(arm, normal) + cross(w, cross(v, r));
      return {turning * square + normal * (moment * cosine), normal * square};
    }
    default:
      return {cross(w, v), {}};
  }
}

// Entries of the matrix of screws, their derivatives, and bounds of the terms of higher order.
struct Rows {
  Matrix value{}, rest{};
  double linear[6][6][kParameters]{};
};

// Whether all matrices are regular, the bound of Perron and Frobenius being below one.
bool are_regular(const Rows& rows, const Matrix& inverse, const Matrix& basis) {
  Matrix bound, p;
  for (int j = 0; j < 6; ++j)
    for (int k = 0; k < 6; ++k) {
      double moved[kParameters]{}, left_out = 0.0, middle = j == k ? -1.0 : 0.0;
      for (int m = 0; m < 6; ++m)
        for (int l = 0; l < 6; ++l) {
          const double factor = inverse[j][m] * basis[l][k];
          double sum = std::abs(rows.value[m][l]);
          for (int i = 0; i < kParameters; ++i) {
            moved[i] += factor * rows.linear[m][l][i];
            sum += std::abs(rows.linear[m][l][i]);
          }
          left_out += std::abs(factor) * (rows.rest[m][l] + kRounding * sum);
          middle += factor * rows.value[m][l];
        }
      bound[j][k] = length(moved) + left_out + std::abs(middle);
      if (!std::isfinite(bound[j][k])) return false;
      p[j][k] = bound[j][k] + 1e-300;
    }
  for (int squaring = 0; squaring < kSquarings; ++squaring) {
    Matrix next{};
    double largest = 0.0;
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 6; ++k) {
        for (int m = 0; m < 6; ++m) next[j][k] += p[j][m] * p[m][k];
        largest = std::max(largest, next[j][k]);
      }
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 6; ++k) p[j][k] = next[j][k] / largest;
  }
  double weight[6], worst = 0.0;
  for (int j = 0; j < 6; ++j) {
    weight[j] = 1e-9;
    for (int k = 0; k < 6; ++k) weight[j] += p[j][k];
  }
  for (int j = 0; j < 6; ++j) {
    double sum = 0.0;
    for (int k = 0; k < 6; ++k) sum += bound[j][k] * weight[k];
    worst = std::max(worst, sum / weight[j]);
  }
  return worst * kOutward < 1.0;
}

double size(const double* a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

}  // namespace

Clearance::Clearance(Numbers& numbers) : kind_(numbers.integers<int>(6)) {
  for (const double** body : {&y_, &x_, &u_, &v_}) *body = numbers.doubles(18);
  centre_ = numbers.doubles(3);
  axes_ = numbers.doubles(9);
  radii_ = numbers.doubles(3);
}

double Clearance::operator()(const double (&R)[3][3], const double* T) const {
  const auto turned = [&](const double* a, double* out) {
    for (int i = 0; i < 3; ++i) out[i] = R[i][0] * a[0] + R[i][1] * a[1] + R[i][2] * a[2];
  };
  double home[3], axes[3][3];
  turned(centre_, home);
  for (int i = 0; i < 3; ++i) {
    home[i] += T[i];
    for (int k = 0; k < 3; ++k) axes[i][k] = R[i][0] * axes_[k] + R[i][1] * axes_[3 + k] + R[i][2] * axes_[6 + k];
  }
  // Over a ball of poses.
  const auto rows_of = [&](double radius, Rows& rows) {
    const double half = radius * kOutward;
    Form shift, turn;
    for (int i = 0; i < 3; ++i) {
      shift.linear[i][i] = half;
      for (int k = 0; k < 3; ++k) turn.linear[i][3 + k] = axes[i][k] * half / (2.0 * radii_[k]);
    }
    const Form v = turn * constant(1.0, 0.0, 0.0);
    const double reach = v.reach();
    const Form w = [&] {
      Form f;
      f.value[0] = 1.0;
      f.rest = reach * reach / (1.0 + std::sqrt(1.0 - reach * reach)) * kOutward;
      return f;
    }();
    const auto moved = [&](const double* a, double moduli) {
      double b[3];
      turned(a, b);
      const Form fixed = constant(b).loosened(2.0 * kRounding * moduli), across = cross(v, fixed);
      return fixed + 2.0 * (across * w + cross(v, across));
    };
    const double centre = size(centre_);
    for (int k = 0; k < 6; ++k) {
      const double *y = y_ + 3 * k, *x = x_ + 3 * k;
      const double from[3] = {y[0] - centre_[0], y[1] - centre_[1], y[2] - centre_[2]};
      const Form arm = moved(from, size(y) + centre) + shift;
      const Form offset = constant(home[0] - x[0], home[1] - x[1], home[2] - x[2])
                              .loosened(kRounding * (size(T) + centre + size(x)));
      const Screw s = screw(kind_[k], arm, offset, moved(u_ + 3 * k, 1.0), constant(v_ + 3 * k));
      const double error[2] = {s.moment.rest + kRounding * (s.moment.size() + s.moment.reach()),
                               s.force.rest + kRounding * (s.force.size() + s.force.reach())};
      for (int b = 0; b < 3; ++b) {
        rows.value[k][b] = 0.0;
        std::fill_n(rows.linear[k][b], kParameters, 0.0);
        for (int a = 0; a < 3; ++a) {
          const double column = axes[a][b] / radii_[b];
          rows.value[k][b] += s.moment.value[a] * column;
          for (int i = 0; i < kParameters; ++i) rows.linear[k][b][i] += s.moment.linear[a][i] * column;
        }
        rows.rest[k][b] = error[0] / radii_[b];
        rows.value[k][3 + b] = s.force.value[b];
        std::copy_n(s.force.linear[b], kParameters, rows.linear[k][3 + b]);
        rows.rest[k][3 + b] = error[1];
      }
    }
  };
  Rows rows;
  rows_of(0.0, rows);
  // inverse = S^-1 U^T of the rows of length one, basis = V.
  Matrix scaled, inverse{}, basis;
  double scale[6];
  for (int k = 0; k < 6; ++k) {
    const double norm = length(rows.value[k]);
    scale[k] = norm > 0.0 ? 1.0 / norm : 1.0;
    for (int l = 0; l < 6; ++l) scaled[k][l] = rows.value[k][l] * scale[k];
    inverse[k][k] = 1.0;
  }
  decompose(scaled, inverse);
  for (int j = 0; j < 6; ++j) {
    const double s = length(scaled[j]);
    if (!(s > 0.0)) return 0.0;
    for (int k = 0; k < 6; ++k) {
      basis[k][j] = scaled[j][k] / s;
      inverse[j][k] *= scale[k] / s;
    }
  }
  double low = 0.0, high = 2.0 * std::min({radii_[0], radii_[1], radii_[2]});
  for (int halving = 0; halving < kHalvings && high > low * kClose; ++halving) {
    const double radius = low > 0.0 ? (low + high) / 2.0 : high / 4.0;
    rows_of(radius, rows);
    (are_regular(rows, inverse, basis) ? low : high) = radius;
  }
  return low * (1.0 - 0x1p-30);
}

}  // namespace gsp::live
