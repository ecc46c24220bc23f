// The step of a controller (gspcli/export/controller/platform.c) for the numbers of any platform.
#pragma once

#include <cstddef>
#include <memory>

namespace gsp {

// What forward says besides its status; see platform.h.
struct StepReport {
  double fraction, sigma, alone;
  int steps, tries;
};

// A platform with the state of its controller.
class Controller {
 public:
  // How many doubles the numbers of a platform are.
  static const std::size_t kNumbers;

  Controller(const unsigned char* kind, const unsigned char* either, const double* numbers);
  ~Controller();

  // The statuses are those of platform.h.
  int start(const double* pose);      // position and quaternion
  int start(const double* pose, double* near);  // of the numbers of cranks and slides those near these
  int forward(const double* values);
  int jacobian(double* J) const;      // of the values by a twist, 6 x 6

  const double* position() const;
  const double* rotation() const;
  const double* values() const;
  double error() const;
  StepReport report() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gsp
