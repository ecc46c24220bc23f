// Constraints of two points of which a motor moves one: which poses of a box its range reaches.
#pragma once

#include <optional>

#include "drive_chain.hpp"

namespace gsp {

// Judges one motor at the poses of a box, or of a part of a box; each number is computed once, when
// it is needed.
class DriveJudge {
 public:
  DriveJudge(const Drive& drive, const Limit& limit, const Place& at);
  DriveJudge(DriveJudge& whole, const Limit& limit, const Place& at);

  // Whether the motor is within its range at all poses, or at none.
  Verdict range();
  // Whether the rod reaches the point of the motor at all poses, or at none.
  Verdict reach();

 private:
  // Places of the motor: the ends of the range; where F is least at the centre, and greatest.
  enum Spot { kFirst, kLast, kTurn, kOpposite };
  struct Turns {
    Arc arc[2];
    Fall fall;
  };

  bool never();
  int sign(Spot spot);
  const Range& square(Spot spot);
  const Vector& point(Spot spot);
  Turns& turns();
  const Fall& fall() { return turns().fall; }
  double more(bool least);
  bool keeps(int s);
  // Where s F begins to fall, or where it ends to.
  int start() { return sign(s_ > 0 ? kOpposite : kTurn); }
  int end() { return sign(s_ > 0 ? kTurn : kOpposite); }

  static constexpr int kUnknown = 2;
  const Drive& drive_;
  DriveJudge* whole_ = nullptr;
  const int s_;
  int sign_[4] = {kUnknown, kUnknown, kUnknown, kUnknown}, keeps_[2] = {kUnknown, kUnknown};
  Range square_[4] = {{0.0, -1.0}, {0.0, -1.0}, {0.0, -1.0}, {0.0, -1.0}};
  double more_[2] = {-1.0, -1.0};
  Chain chain_;
  std::optional<Turns> turns_;
};

// Those of the motor of a limit: its range, and that the rod reaches its point.
inline Conditions conditions_of(int row) { return Conditions{1} << row | kReach << row; }

// A box that is divided: its motors are judged for all its parts.
struct Whole {
  Place at;
  std::optional<DriveJudge> drive[6];

  Whole(const Reach& reach, const double* centre, const double* half, Conditions open);
};

// Judges the range of a motor, and whether the rod reaches its point at all. A condition that holds
// for all poses of the box is removed from `open`. The box is outside if all its poses violate one
// of both.
Verdict judge_drive(DriveJudge&& judge, int row, Conditions& open);

// Encloses the places of the motor at the poses of the box that the rod reaches. `leg` is the leg
// at the centre (or near it, at a dead point), `swing` how far the motor moves from there. False if
// nothing is proved.
bool locate(const Drive& drive, const Limit& limit, const Place& at, Placed& leg, Swing& swing);

}  // namespace gsp
