#include "proofs.hpp"

#include <algorithm>
#include <cmath>

namespace gsp::live {
namespace {

constexpr double kOutward = 1.0 + 0x1p-40;

double distance(const Complex& a, const Complex& b) { return std::hypot(a.re - b.re, a.im - b.im); }

// Whether the balls of two poses have no common point (gspcli.certification.poses.isolation).
bool are_apart(const Found& found, int a, int b, double scale) {
  double gap = 0.0;
  for (int k = 0; k < 9; ++k) gap = std::max(gap, distance(found.rotation[9 * a + k], found.rotation[9 * b + k]));
  for (int k = 0; k < 3; ++k)
    gap = std::max(gap, distance(found.translation[3 * a + k], found.translation[3 * b + k]) / scale);
  return gap > (found.deviation[a] + found.deviation[b]) * kOutward;
}

}  // namespace

bool is_pose(std::uint8_t bits) { return (bits & kIsolated) && (bits & (kReal | kComplex)); }

int Found::poses() const { return static_cast<int>(std::count_if(proved.begin(), proved.end(), is_pose)); }

bool Found::are_different(double scale) const {
  for (int a = 0; a < count(); ++a)
    for (int b = a + 1; b < count(); ++b)
      if (!are_apart(*this, a, b, scale)) return false;
  return true;
}

void Found::single_out(double scale) {
  for (int a = 0; a < count(); ++a)
    for (int b = a + 1; b < count() && is_pose(proved[a]); ++b)
      if (is_pose(proved[b]) && !are_apart(*this, a, b, scale)) proved[b] = 0;
}

Proofs::Proofs(Numbers& numbers) {
  quadrics_ = numbers.integer();
  const int size = quadrics_ * kVariables * kVariables;
  hessian_ = numbers.doubles(size);
  low_ = numbers.doubles(size);
  moduli_ = numbers.doubles(size);
  for (ProofEquation& e : equation_) e = {numbers.integer(), {numbers.integer(), numbers.integer()}};
  weights_ = numbers.doubles(4 * kEquations);
  turned_ = numbers.integers<std::int32_t>(kEquations);
  base_ = numbers.doubles(3);
  platform_ = numbers.doubles(3);
  scale_ = numbers.number();
  tolerance_ = numbers.number();
  reach_ = numbers.number();
  lines_ = numbers.integer();
  line_ = numbers.doubles(9 * lines_);
  rounding_ = numbers.number();
}

void Proofs::read(const OpenEquations& equations) {
  hessian_ = equations.hessian, low_ = equations.low, moduli_ = equations.moduli;
  weights_ = equations.weight;
}

double Proofs::unit(double largest) const {
  const double size = std::max(reach_, largest);
  int exponent = 0;
  std::frexp(size > 0.0 ? size : 0.5, &exponent);
  return std::exp2(exponent) / scale_;
}

// As gspcli.certification.equations.skew_lines says.
bool Proofs::are_skew(const Complex* rotation, double deviation) const {
  for (int l = 0; l < lines_; ++l) {
    const double* const w = line_ + 9 * l;
    std::complex<double> cosine = 0.0;
    double size = 0.0, reach = 0.0;
    for (int k = 0; k < 9; ++k) {
      const std::complex<double> r(rotation[k].re, rotation[k].im);
      cosine += w[k] * r;
      size += std::abs(w[k]) * std::abs(r);
      reach += std::abs(w[k]);
    }
    const double error = kOutward * (deviation * reach + rounding_ * size), modulus = std::abs(cosine);
    const double rounding = rounding_ * (1.0 + modulus * modulus);
    const double enough = kOutward * ((2.0 * modulus + error) * error + rounding);
    if (!(std::abs(1.0 - cosine * cosine) > enough)) return false;
  }
  return true;
}

Found Proofs::decide(const Values& given, const double* values, const Ends& ends) const {
  const int choices = given.choices(), count = static_cast<int>(ends.study.size()) / (choices * kVariables);
  Found found(choices * count);
  if (count == 0) return found;
  const OpenGeometry open{{quadrics_, hessian_, moduli_, equation_},
                          weights_,
                          weights_ + kEquations,
                          weights_ + 2 * kEquations,
                          turned_.data(),
                          ends.unit / scale_,
                          {base_[0] / scale_, base_[1] / scale_, base_[2] / scale_},
                          {platform_[0] / scale_, platform_[1] / scale_, platform_[2] / scale_},
                          scale_,
                          tolerance_,
                          low_,
                          weights_ + 3 * kEquations};
  constexpr int kMonomials = 36;
  std::vector<double> room(2 * quadrics_ * (kVariables * kVariables + kMonomials) + 3 * count);
  for (int c = 0; c < choices; ++c) {
    double v[kOfValue * kEquations];
    given.proved(values, c, scale_, v);
    std::uint8_t complete = 0;
    const int first = c * count;
    decide_portable(open,
                    {v, v + 6, v + 12, v + 18, v + 24, v + 30, unit(given.largest(values))}, count,
                    ends.study.data() + first * kVariables, room.data(), found.at(first, &complete));
    for (int k = first; k < first + count; ++k)
      if (!are_skew(&found.rotation[9 * k], found.deviation[k])) found.proved[k] = 0;
  }
  return found;
}

FarPart::FarPart(Numbers& numbers) {
  count_ = numbers.integer();
  if (count_ == 0) {
    bent_ = 0;
    return;
  }
  products_ = static_cast<unsigned>(numbers.integer());
  number_ = numbers.complexes(count_ * far_numbers(products_));
  low_ = numbers.complexes(count_ * far_numbers(products_));
  error_ = numbers.doubles(count_);
  real_ = numbers.integers<std::uint8_t>(count_);
  values_ = numbers.doubles(kOfValue * kEquations);
  powers_ = numbers.doubles(kEquations);
  scale_ = numbers.number();
  tolerance_ = numbers.number();
  bent_ = numbers.integer();
  // Conjugates of poses that need paths are poses of the list, too.
  for (int k = 0; k < count_; ++k) paired_.push_back(real_[k] == 0 && k < count_ - bent_);
  pairs_ = static_cast<int>(std::count(paired_.begin(), paired_.end(), 1));
  origin_ = numbers.complexes(kEquations);
  start_ = numbers.complexes(bent_ * kLocal);
}

// By how much values are greater than those of the platform that is known, (3, 6).
void FarPart::shift(const double* proved, double ratio, double* out) const {
  constexpr double kDifference = 0x1p-100;
  for (int i = 0; i < kEquations; ++i) {
    const double factor = std::pow(ratio, powers_[i]);  // exact: a power of two
    const auto given = [&](int row) { return proved[row * kEquations + i] * factor; };
    const auto own = [&](int row) { return values_[row * kEquations + i]; };
    const double high = given(0), minus = -own(0), s = high + minus, v = s - high;
    const double rest = (high - (s - v)) + (minus - v);
    out[i] = s;
    out[kEquations + i] = rest + (given(3) - own(3));
    out[2 * kEquations + i] =
        kOutward * (given(4) + own(4) + kDifference * (std::abs(high) + std::abs(own(0))));
  }
}

Found FarPart::beside(Found near, const double* proved_values, double unit, double scale) const {
  double shifts[3 * kEquations];
  shift(proved_values, scale / scale_, shifts);
  const double units = unit * (scale / scale_);
  std::vector<double> room(kFarRoom);
  Found far(poses());
  std::uint8_t complete = 0;
  decide_far_portable({count_, number_, low_, error_, real_.data(), paired_.data(), bent_, origin_, start_, scale_,
                       tolerance_, products_},
                      {1, shifts, &units}, room.data(), far.at(0, &complete));
  // In units of the other equations.
  for (double& deviation : far.deviation) deviation *= std::max(scale_ / scale, 1.0);
  const auto join = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  join(near.rotation, far.rotation);
  join(near.translation, far.translation);
  join(near.deviation, far.deviation);
  join(near.proved, far.proved);
  return near;
}

}  // namespace gsp::live
