// Which ends of paths are poses, proved (gspcli.certification.poses.many_values and far_poses).
#pragma once

#include <vector>

#include "../../native/far_poses.hpp"
#include "../../native/open_equations.hpp"
#include "paths.hpp"

namespace gsp::live {

bool is_pose(std::uint8_t bits);

// What is proved of points.
struct Found {
  explicit Found(int count)
      : rotation(9 * count), translation(3 * count), quaternion(4 * count), deviation(count), proved(count) {}
  // How many are proved to be poses; whether they are proved to be different, lengths in a scale.
  int poses() const;
  bool are_different(double scale) const;
  int count() const { return static_cast<int>(proved.size()); }
  // Leave of those that are not proved to be different the first.
  void single_out(double scale);
  Poses at(int first, std::uint8_t* complete) {
    return {rotation.data() + 9 * first, translation.data() + 3 * first, quaternion.data() + 4 * first,
            deviation.data() + first, proved.data() + first, complete};
  }

  std::vector<Complex> rotation, translation, quaternion;
  std::vector<double> deviation;
  std::vector<std::uint8_t> proved;
};

// Poses to which no paths lead.
class FarPart {
 public:
  explicit FarPart(Numbers& numbers);
  int poses() const { return count_ == 0 ? 0 : count_ + pairs_; }
  // These besides the poses that are near.
  Found beside(Found near, const double* proved_values, double unit, double scale) const;

 private:
  void shift(const double* proved_values, double ratio, double* out) const;

  int count_, pairs_ = 0, bent_;
  unsigned products_ = 0;
  const Complex *number_, *low_;
  const double* error_;
  std::vector<std::uint8_t> real_, paired_;
  const double *values_, *powers_;
  double scale_, tolerance_;
  const Complex *origin_, *start_;  // (6), (bent, 7)
};

class Proofs {
 public:
  explicit Proofs(Numbers& numbers);
  double scale() const { return scale_; }
  // Of digits of translations, in lengths of the equations.
  double unit(double largest) const;
  // From now on with equations that are there, of the same kinds.
  void read(const OpenEquations& equations);
  // Decides about ends (choices, paths, 8).
  Found decide(const Values& given, const double* values, const Ends& ends) const;

 private:
  bool are_skew(const Complex* rotation, double deviation) const;

  int quadrics_;
  const double *hessian_, *low_, *moduli_, *weights_;
  ProofEquation equation_[kEquations];
  std::vector<std::int32_t> turned_;
  const double *base_, *platform_;
  double scale_, tolerance_, reach_;
  int lines_;
  const double* line_;  // (lines, 9): the cosine of two lines is this times the rotation
  double rounding_;
};

}  // namespace gsp::live
