#include "paths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace gsp::live {
namespace {

constexpr int kFactor = kEquations * kCoefficients, kSystem = 2 * kFactor + kEquations;

Side side_of(const std::complex<double>* system) {
  return {system, system + kFactor, system + 2 * kFactor};
}

void lose(Complex* study, const std::uint8_t* status, int paths) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (int p = 0; p < paths; ++p)
    if (status[p] != kRegular) std::fill_n(study + p * kVariables, kVariables, Complex{kNone, kNone});
}

}  // namespace

PoolPaths::PoolPaths(Numbers& numbers) {
  const int stages = numbers.integer();
  if (stages == 0) return;
  geometry_.scalars = numbers.integer();
  geometry_.has_h = numbers.integer() != 0;
  const int pivots = (geometry_.has_h ? kQuantities : kQuantities - 1) - geometry_.scalars;
  for (int i = 0; i < pivots; ++i) geometry_.pivot[i] = numbers.integer();
  for (int i = 0; i < geometry_.scalars; ++i) geometry_.free[i] = numbers.integer();
  for (auto& row : geometry_.form)
    for (double& x : row) x = numbers.number();
  for (auto& row : geometry_.slope)
    for (int i = 0; i < geometry_.scalars; ++i) row[i] = numbers.number();
  combinations_ = numbers.doubles(kEquations * kEquations);
  paths_ = numbers.integer();
  unit_ = numbers.number();
  for (int k = 0; k < stages; ++k) {
    Stage stage;
    stage.members = numbers.integer();
    const Complex* const parameters = numbers.complexes(stage.members * kEquations);
    stage.parameters = reinterpret_cast<const double*>(parameters);
    stage.values = left_sides(parameters, stage.members);
    stage.unit = numbers.doubles(kEquations);
    stage.points = numbers.complexes(stage.members * paths_ * (4 + geometry_.scalars));
    const double* const x = numbers.doubles(4);
    stage.options = {x[0], x[1], x[2], x[3], numbers.integer()};
    stage_.push_back(stage);
  }
}

std::vector<Complex> PoolPaths::left_sides(const Complex* parameters, int count) const {
  std::vector<Complex> found(count * kEquations, Complex{0.0, 0.0});
  for (int k = 0; k < count; ++k)
    for (int j = 0; j < kEquations; ++j)
      for (int i = 0; i < kEquations; ++i) {
        const double c = combinations_[j * kEquations + i];
        const Complex& x = parameters[k * kEquations + i];
        found[k * kEquations + j].re += c * x.re;
        found[k * kEquations + j].im += c * x.im;
      }
  return found;
}

Ends PoolPaths::follow(const Values& given, const double* values, int index) const {
  const Stage& stage = stage_[index];
  const int choices = given.choices(), total = choices * paths_;
  std::vector<Complex> target(choices * kEquations);
  std::vector<std::int32_t> start(choices), order(choices), steps(total);
  for (int c = 0; c < choices; ++c) {
    double parameters[kEquations], nearest = 0.0;
    given.parameters(values, c, parameters);
    for (int m = 0; m < stage.members; ++m) {
      double far = 0.0;
      for (int i = 0; i < kEquations; ++i)
        far += std::pow((parameters[i] - stage.parameters[2 * (m * kEquations + i)]) / stage.unit[i], 2);
      if (m == 0 || far < nearest) nearest = far, start[c] = m;
    }
    for (int i = 0; i < kEquations; ++i) target[c * kEquations + i] = {parameters[i], 0.0};
    order[c] = c;
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return start[a] < start[b]; });
  const std::vector<Complex> sides = left_sides(target.data(), choices);
  std::vector<Complex> points(total * (4 + geometry_.scalars));
  std::vector<std::uint8_t> status(total);
  Ends ends{std::vector<Complex>(total * kVariables), unit_};
  track_values_portable(geometry_, stage.options,
                        {paths_, stage.values.data(), stage.points, start.data(), order.data(), sides.data(),
                         nullptr},
                        0, choices, {points.data(), ends.study.data(), status.data(), steps.data()});
  lose(ends.study.data(), status.data(), total);
  return ends;
}

WholePaths::WholePaths(Numbers& numbers) {
  for (bool& product : products_) product = numbers.integer() != 0;
  order_ = numbers.integers<int>(kEquations);
  const auto* const start = reinterpret_cast<const std::complex<double>*>(numbers.complexes(kSystem));
  start_ = side_of(start);
  paths_ = numbers.integer();
  points_ = numbers.complexes(paths_ * kVariables);
  polynomial_ = numbers.doubles(2 * 3 * kSystem);
  unit_ = numbers.number();
  for (Options& o : options_) {
    const double* const x = numbers.doubles(7);
    o = {x[0], x[1], x[2], x[3], x[4], x[5], x[6], numbers.integer(), numbers.integer()};
  }
}

// The equations at these values, factors of norm 1; those of motors in the norm of the start, so that
// joints with one motor stay on straight lines together.
void WholePaths::target(const double* inner, const Joints& joints, std::complex<double>* system) const {
  const auto* const part = reinterpret_cast<const std::complex<double>*>(polynomial_);
  const auto at = [&](int k, double v) {
    return part[k] + v * (part[kSystem + k] + v * part[2 * kSystem + k]);
  };
  for (int j = 0; j < kEquations; ++j) {
    const double v = inner[order_[j]];
    if (joints.moves(order_[j])) {
      const double* const t = joints.terms(order_[j]);
      const auto moved = [&](int k) { return part[k] + t[0] * part[kSystem + k] + t[1] * part[2 * kSystem + k]; };
      for (int k = j * kCoefficients; k < (j + 1) * kCoefficients; ++k) {
        system[k] = moved(k);
        system[kFactor + k] = moved(kFactor + k);
      }
      system[2 * kFactor + j] = moved(2 * kFactor + j);
      continue;
    }
    double product = 1.0;
    for (int factor = 0; factor < 2; ++factor) {
      std::complex<double>* const q = system + factor * kFactor + j * kCoefficients;
      double size = 0.0;
      for (int k = 0; k < kCoefficients; ++k) {
        q[k] = at(static_cast<int>(q - system) + k, v);
        size += std::norm(q[k]);
      }
      size = size > 0.0 ? std::sqrt(size) : 1.0;
      for (int k = 0; k < kCoefficients; ++k) q[k] /= size;
      product *= size;
    }
    system[2 * kFactor + j] = at(2 * kFactor + j, v) / product;
  }
}

Ends WholePaths::follow(const Values& given, const Joints& joints, const double* values, bool careful) const {
  const int choices = given.choices();
  Ends ends{std::vector<Complex>(choices * paths_ * kVariables), unit_};
  std::vector<std::uint8_t> status(paths_);
  std::vector<std::int32_t> steps(paths_);
  std::vector<double> left(paths_), condition(paths_), curvature(paths_), residual(paths_),
      correction(paths_);
  std::vector<std::complex<double>> system(kSystem);
  const auto line = std::make_unique<Homotopy>();
  const auto real_line = std::make_unique<RealHomotopy>();
  for (int c = 0; c < choices; ++c) {
    double inner[kEquations];
    given.inner(values, c, inner);
    target(inner, joints, system.data());
    Complex* const study = ends.study.data() + c * paths_ * kVariables;
    const Results results{study, nullptr, left.data(), status.data(), steps.data(), condition.data(),
                          curvature.data(), residual.data(), correction.data()};
    const Side to = side_of(system.data());
    if (!careful && make_real_homotopy(products_, start_, to, *real_line)) {
      track_portable_real(*real_line, options_[0], paths_, points_, nullptr, nullptr, results);
    } else {
      make_homotopy(products_, start_, to, nullptr, *line);
      Track* const run = careful ? track_portable : track_portable_short;
      run(*line, options_[careful], paths_, points_, nullptr, nullptr, results);
    }
    lose(study, status.data(), paths_);
  }
  return ends;
}

}  // namespace gsp::live
