// Paths from solved systems of a geometry to the values asked for (gspcli.solver.start).
#pragma once

#include <vector>

#include "../../native/homotopy.hpp"
#include "../../native/reduced_homotopy.hpp"
#include "joints.hpp"

namespace gsp::live {

// Ends of paths, Study points of any norm, not numbers where one is lost; and their unit of f.
struct Ends {
  std::vector<Complex> study;  // (choices, paths, 8)
  double unit;
};

// With fewer unknowns: gspcli.solver.start, and its two sizes of steps.
class PoolPaths {
 public:
  explicit PoolPaths(Numbers& numbers);
  int stages() const { return static_cast<int>(stage_.size()); }
  Ends follow(const Values& given, const double* values, int stage) const;

 private:
  struct Stage {
    int members;
    const double *parameters, *unit;  // (members, 6) real parts; (6)
    std::vector<Complex> values;      // (members, 6), the left sides of the equations
    const Complex* points;            // (members, paths, coordinates)
    ReducedOptions options;
  };
  std::vector<Complex> left_sides(const Complex* parameters, int count) const;

  ReducedGeometry geometry_{};
  const double* combinations_;  // (6, 6)
  int paths_ = 0;
  double unit_;
  std::vector<Stage> stage_;
};

// Paths of the unreduced system.
class WholePaths {
 public:
  explicit WholePaths(Numbers& numbers);
  // With long steps, or with care.
  Ends follow(const Values& given, const Joints& joints, const double* values, bool careful) const;

 private:
  void target(const double* inner, const Joints& joints, std::complex<double>* system) const;

  bool products_[kEquations];
  Side start_;
  int paths_;
  const Complex* points_;  // (paths, 8)
  // (3, numbers of a system) complex: of 1, the value, its square; of motors of 1 and their two terms
  const double* polynomial_;
  std::vector<int> order_;  // whose value is in each equation
  double unit_;
  Options options_[2];
};

}  // namespace gsp::live
