#include "values.hpp"

#include <algorithm>
#include <cmath>

namespace gsp::live {
namespace {

Doubled two_sum(double a, double b) {
  const double s = a + b, v = s - a;
  return {s, (a - (s - v)) + (b - v)};
}

// T. J. Dekker, A floating-point technique for extending the available precision, 1971.
Doubled split(double a) {
  const double c = 134217729.0 * a, high = c - (c - a);
  return {high, a - high};
}

Doubled two_product(double a, double b) {
  const double p = a * b;
  const Doubled x = split(a), y = split(b);
  return {p, ((x.high * y.high - p) + x.high * y.low + x.low * y.high) + x.low * y.low};
}

Doubled normal(double high, double low) {
  const double total = high + low;
  return {total, low - (total - high)};
}

Doubled times(const Doubled& a, const Doubled& b) {
  const Doubled p = two_product(a.high, b.high);
  return normal(p.high, p.low + (a.high * b.low + a.low * b.high));
}

}  // namespace

Values::Values(Numbers& numbers) {
  for (Constraint& c : constraint_) {
    c.is_distance = numbers.integer() != 0;
    c.is_square = numbers.integer() != 0;
    c.is_height = numbers.integer() != 0;
    c.is_complement = numbers.integer() != 0;
    c.sign = numbers.number();
    c.factor = numbers.number();
    c.offset = numbers.number();
  }
  choices_ = numbers.integer();
  choice_ = numbers.doubles(choices_ * kEquations);
  length_ = numbers.number();
  degrees_ = numbers.integer() != 0;
  quarter_ = {numbers.number(), numbers.number()};
  unit_ = {numbers.number(), numbers.number()};
  terms_ = numbers.integer();
  small_ = numbers.integer();
  term_ = numbers.doubles(2 * terms_);
  error_ = numbers.number();
  gap_ = numbers.number();
}

void Values::correct(const double* readings, double* corrected) const {
  for (int i = 0; i < kEquations; ++i)
    corrected[i] = readings[i] * constraint_[i].factor + constraint_[i].offset;
}

// As `sines` has it.
Doubled Values::sine(double angle, bool complement) const {
  Doubled x = two_sum(complement ? quarter_.high : 0.0, complement ? -angle : angle);
  x = normal(x.high, x.low + (complement ? quarter_.low : 0.0));
  if (degrees_) x = times(x, unit_);
  const Doubled square = times(x, x);
  double rest = term_[2 * (terms_ - 1)];
  for (int k = terms_ - 2; k >= small_; --k) rest = rest * square.high + term_[2 * k];
  Doubled total{rest, 0.0};
  for (int k = small_ - 1; k >= 0; --k) {
    const Doubled product = times(total, square), sum = two_sum(product.high, term_[2 * k]);
    total = normal(sum.high, sum.low + (product.low + term_[2 * k + 1]));
  }
  return times(total, x);
}

Doubled Values::cosine(double angle, int i) const {
  const Doubled found = sine(angle, constraint_[i].is_complement);
  const double sign = constraint_[i].sign;
  return {found.high * sign, found.low * sign};
}

void Values::inner(const double* values, int choice, double* out) const {
  for (int i = 0; i < kEquations; ++i) {
    const double x = constraint_[i].is_distance ? values[i] / length_ : cosine(values[i], i).high;
    out[i] = x * choice_[choice * kEquations + i];
  }
}

void Values::parameters(const double* values, int choice, double* out) const {
  inner(values, choice, out);
  for (int i = 0; i < kEquations; ++i)
    if (constraint_[i].is_square) out[i] *= out[i];
}

void Values::proved(const double* values, int choice, double scale, double* out) const {
  const auto at = [&](int row, int i) -> double& { return out[row * kEquations + i]; };
  for (int i = 0; i < kEquations; ++i) {
    const Constraint& c = constraint_[i];
    Doubled x;
    double gap = 0.0, error = 0.0;
    if (!c.is_distance) {
      x = cosine(values[i], i);
      gap = gap_, error = error_;
    } else if (c.is_height) {
      x = {values[i] / scale * choice_[choice * kEquations + i], 0.0};
    } else {
      x = two_product(values[i] / scale, values[i] / scale);
    }
    at(0, i) = x.high;
    at(1, i) = std::abs(x.high) + error;
    at(2, i) = std::abs(values[i]) / scale;
    at(3, i) = x.low;
    at(4, i) = gap;
    at(5, i) = 0.0;
  }
}

double Values::largest(const double* values) const {
  double largest = 0.0;
  for (int i = 0; i < kEquations; ++i)
    if (constraint_[i].is_distance) largest = std::max(largest, std::abs(values[i]));
  return largest;
}

}  // namespace gsp::live
