// Errors of fine_far_poses.cpp with 32 digits. For tests/unit/motion/following/test_roundings.py.
#define GSP_PARTS 2
#define GSP_LANES 2
#define GSP_FINE_FAR fine_far_sampled
#include "fine_far_poses.cpp"
#include "quad.hpp"

using namespace gsp;

// A form at local coordinates, from its first coefficient on.
Number form(const Numbers& number, int first, int l, const std::vector<Number>& s) {
  Number sum = number.at(first++, l);
  for (const Number& x : s) sum = sum + number.at(first++, l) * x;
  for (int i = 0; i < kLocal; ++i)
    for (int j = i; j < kLocal; ++j) sum = sum + number.at(first++, l) * (s[i] * s[j]);
  return sum;
}

int main() {
  std::mt19937_64 random(1);
  double worst[3] = {};
  const unsigned products = 0b0101010;
  const int count = far_numbers(products);
  int second[kLocal] = {};
  for (int r = 0, at = kFarNumbers; r < kLocal; ++r)
    if (products >> r & 1) second[r] = at, at += kOfProduct;
  for (int round = 0; round < 400; ++round) {
    Numbers number(count, W), local(kLocal, W), mixed(kLocal, W), zero(kLocal, W), value(kLocal, W);
    double shift[kEquations * W], low[kEquations * W];
    for (int l = 0; l < W; ++l) {
      for (int k = 0; k < count; ++k) number.draw(random, k, l);
      for (int k = 0; k < kLocal; ++k) local.draw(random, k, l, round % 2 ? 1.0 : 0.01);
      for (int k = 0; k < kEquations; ++k)
        shift[k * W + l] = std::uniform_real_distribution<double>(-1, 1)(random),
                      low[k * W + l] = 0x1p-54 * shift[k * W + l] * (k % 2 ? 1 : -0.7);
      // Values of about zero: the first coefficient makes up for the rest.
      std::vector<Number> s;
      for (int i = 0; i < kLocal; ++i) s.push_back(local.at(i, l));
      for (int r = 0; r < kLocal; ++r) {
        mixed.draw(random, r, l);
        const Number norm = form(number, kOfNorm * kLocalMonomials, l, s);
        Number wanted = mixed.at(r, l) * norm;
        if (second[r]) {
          const Number q = form(number, second[r], l, s);
          wanted = (mixed.at(r, l) + number.at(second[r] + kConstant, l)) * norm * norm;
          const Q size = q.re * q.re + q.im * q.im;
          wanted = wanted * Number{q.re / size, -q.im / size, 0};
        }
        const int first = r * kLocalMonomials;
        const Number rest = form(number, first, l, s) - number.at(first, l);
        number.put(first, l, wanted.re - rest.re, wanted.im - rest.im);
      }
    }
    values(number.given(), second, local.given(), mixed.given(), value.high());
    for (int l = 0; l < W; ++l) {
      std::vector<Number> s;
      for (int i = 0; i < kLocal; ++i) s.push_back(local.at(i, l));
      const Number norm = form(number, kOfNorm * kLocalMonomials, l, s);
      for (int r = 0; r < kLocal; ++r) {
        Number exact = form(number, r * kLocalMonomials, l, s), constant = mixed.at(r, l);
        if (second[r]) {
          exact = exact * form(number, second[r], l, s);
          constant = (constant + number.at(second[r] + kConstant, l)) * norm;
        }
        exact = exact - constant * norm;
        double& most = worst[second[r] ? 2 : 1];
        most = std::max(most, error(value.at(r, l), exact, exact.size));
      }
    }
    mix(number.given(), shift, low, mixed.given());
    for (int l = 0; l < W; ++l)
      for (int i = 0, k = kMixed; i < kLocal; ++i) {
        Number exact;
        for (int r = 0; r < kEquations; ++r, ++k) {
          const Q by = Q(shift[r * W + l]) + low[r * W + l];
          exact = exact + Number{by, 0, modulus(by)} * number.at(k, l);
        }
        worst[0] = std::max(worst[0], error(mixed.at(i, l), exact, exact.size));
      }
  }
  std::printf("%g %g %g\n", worst[0], worst[1], worst[2]);
}
