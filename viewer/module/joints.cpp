#include "joints.hpp"

#include <cmath>

#include "../../native/pair.hpp"

namespace gsp::live {
namespace {

using Fine = gsp::Doubled;

// Of sums and products of few numbers that err by 2^-98 of their sizes.
Fine operator+(const Fine& a, const Fine& b) {
  const Pair s = sum({a.high, a.low}, {b.high, b.low});
  return {s.hi, s.lo, a.size + b.size};
}
Fine operator*(const Fine& a, const Fine& b) {
  const Pair p = product({a.high, a.low}, {b.high, b.low});
  return {p.hi, p.lo, a.size * b.size};
}

// Cosine and sine of an angle in the unit of the file, by those of its half, which err by 2^-96 each:
// these err by 2^-94, which is less than 2^-98 of a size of 32.
constexpr double kSize = 32.0;
void turn(const Values& given, double angle, Fine& cosine, Fine& sine) {
  // Exact: a whole number of turns less.
  if (given.degrees()) angle = std::remainder(angle, 360.0);
  const double half = 0.5 * angle;
  const auto s = given.sine(half, false), c = given.sine(std::fabs(half), true);
  const Pair a{s.high, s.low}, b{c.high, c.low}, square = product(a, a), both = product(a, b);
  const Pair rest = sum({1.0, 0.0}, {-2.0 * square.hi, -2.0 * square.lo});
  cosine = {rest.hi, rest.lo, kSize};
  sine = {2.0 * both.hi, 2.0 * both.lo, kSize};
}

Fine fine(Numbers& numbers) { return {numbers.number(), numbers.number(), numbers.number()}; }

}  // namespace

Joints::Joints(Numbers& numbers) : are_moved_(numbers.integer() != 0) {
  if (!are_moved_) return;
  scale_ = numbers.number();
  for (int i = 0; i < kEquations; ++i) {
    Motor& m = motor_[i];
    m.sort = numbers.integer(), m.on_platform = numbers.integer() != 0, m.rod = numbers.number();
    for (auto* const part : {m.middle, m.across, m.beside})
      for (int k = 0; k < 3; ++k) part[k] = fine(numbers);
  }
  for (Primitives& p : primitives_) {
    p.relation = static_cast<Relation>(numbers.integer());
    for (auto* const part : {p.a, p.b, p.u, p.v})
      for (int k = 0; k < 3; ++k) part[k] = fine(numbers);
  }
  constexpr int kSquare = kVariables * kVariables, kEntries = kMostQuadrics * kSquare;
  forms_ = numbers.doubles(kStudyForms * kSquare);
  tiny_ = numbers.number();
  for (auto* const part : {&hessian_, &low_, &moduli_}) part->resize(kEntries);
  weights_.resize(4 * kEquations);
  table_.resize(3 * kEquations), turned_.resize(kEquations);
  double* const w = weights_.data();
  open_ = {0, hessian_.data(), low_.data(), moduli_.data(), w, w + kEquations, w + 2 * kEquations,
           w + 3 * kEquations, table_.data(), turned_.data()};
}

void Joints::hold(double* numbers) const {
  for (int i = 0; i < kEquations; ++i)
    if (moves(i)) numbers[i] = motor_[i].rod;
}

void Joints::place(const Values& given, const double* numbers) {
  for (int i = 0; i < kEquations; ++i) {
    Motor& m = motor_[i];
    Primitives& p = primitives_[i];
    if (m.sort != kValue) {
      Fine first, second;
      if (m.sort == kCrank) {
        turn(given, numbers[i], first, second);
        m.terms[0] = first.high, m.terms[1] = second.high;
      } else {
        const double q = numbers[i] / scale_;
        first = {q, 0.0, std::fabs(q)};
        m.terms[0] = numbers[i], m.terms[1] = numbers[i] * numbers[i];
      }
      auto* const point = m.on_platform ? p.a : p.b;
      for (int k = 0; k < 3; ++k)
        point[k] = m.sort == kCrank ? m.middle[k] + (m.across[k] * first + m.beside[k] * second)
                                    : m.middle[k] + m.beside[k] * first;
    }
    for (int k = 0; k < 3; ++k) y_[3 * i + k] = p.a[k].high * scale_, x_[3 * i + k] = p.b[k].high * scale_;
  }
  open_equations(primitives_, forms_, tiny_, open_);
}

}  // namespace gsp::live
