// How far a pose may move before its six screws become dependent: a proved lower bound.
//
// The theorem is that of gspcli.motion.singularities.pose_clearances, for balls about a pose; the bounds are
// those of forms of first order, so the numbers differ a little from those of the package.
#pragma once

#include <vector>

#include "numbers.hpp"

namespace gsp::live {

class Clearance {
 public:
  explicit Clearance(Numbers& numbers);
  // Of the pose with rotation R and translation T; in lengths, zero if nothing is proved.
  double operator()(const double (&R)[3][3], const double* T) const;
  // From now on with base points that are there, (6, 3).
  void read(const double* base) { x_ = base; }

 private:
  std::vector<int> kind_;
  const double *y_, *x_, *u_, *v_;       // (6, 3)
  const double *centre_, *axes_, *radii_;  // of the points of the platform: (3), (3, 3), (3)
};

}  // namespace gsp::live
