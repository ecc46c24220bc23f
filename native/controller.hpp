// The step of a controller (gspcli/export/controller/platform.c) for the numbers of any platform.
#pragma once

#include <cstddef>
#include <memory>

namespace gsp {

// The results of forward besides its status; see platform.h.
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
  // The ranges and cones for what follows: kLimits numbers, cones of `cones` legs.
  static const std::size_t kLimits;
  static constexpr std::size_t kMostCones = 12, kMostSlacks = 24;
  void limit(const double* numbers, std::size_t cones, const unsigned char* legs,
             const unsigned char* on_base, bool still);
  int nearest(const double* pose);
  // Moves a pose to the nearest one to a goal that a search finds from it, with the sides and knees
  // of the state; returns the distance, negative if none is found.
  double seek(const double* goal, double* pose) const;
  // How far a pose is within the limits, and the derivatives by twists of PLATFORM_MIDDLE; lengths.
  int slack(const double* pose, double* room, double* rows) const;
  int jacobian(double* J) const;      // of the values by a twist, 6 x 6

  const double* position() const;
  const double* rotation() const;
  const double* values() const;
  double error() const;
  StepReport report() const;

  struct Parts;

 private:
  std::unique_ptr<Parts> parts_;
};

}  // namespace gsp
