// The step of a controller (gspcli/export/controller/platform.c) for the numbers of any platform.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace gsp {

// The results of forward besides its status; see platform.h.
struct StepReport {
  double fraction, sigma, alone;
  int steps, tries;
};

// How a mode is followed: how far its pose may be from the start (0: the one that Newton's method
// finds), the shortest part of a line between rows, the most tries for a line, whether to keep pieces.
struct FollowLimits {
  double near, shortest;
  int tries;
  bool keep;
};

// A mode followed along rows: the last row reached, from 0 (-1: no pose at the first one), and the part
// of the line to the next one; poses at the rows and the last pose, a bound of its error, and a distance
// within which there is no other pose.
struct FollowedRows {
  // Of a piece: row, begin, end, from; rotation and place of the frame; d, radius, error, alone.
  static constexpr std::size_t kPiece = 20;
  long reached = -1;
  double fraction = 0.0, error = 0.0, alone = 0.0, worst = 0.0;
  long steps = 0, tries = 0;
  double last[7] = {};
  std::vector<double> poses, pieces;
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
  // Moves a pose to the nearest one to a goal that a search finds from it, with the sides and working modes
  // of the state; returns the distance, negative if none is found.
  double seek(const double* goal, double* pose) const;
  // How far a pose is within the limits, and the derivatives by twists of PLATFORM_MIDDLE; lengths.
  int slack(const double* pose, double* room, double* rows) const;
  // Follows a mode along rows of the numbers of equations: the units are not applied.
  FollowedRows follow_rows(const double* values, std::size_t rows, const double* pose,
                           const FollowLimits& limits) const;
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
