// Constraints of two points of which a motor moves one: which poses of a box its range reaches.
#pragma once

#include <cmath>
#include <optional>

#include "box_forms.hpp"

namespace gsp {

// A motor that moves a point, and the rod from there to the other body, over a box of poses.
//
// F(X; q), its working mode and the places of a motor are explained in drives.cpp.

// Of the cosine and sine of the direction to a point, and of the place of a slide, relatively.
constexpr double kDirection = 0x1p-48;
inline double middle_of(const Vector& a, const Vector& b) {
  return a[0].m * b[0].m + a[1].m * b[1].m + a[2].m * b[2].m;
}

// A place of a motor: the cosine and sine of a crank; the number of a slide, and nothing.
struct Stand {
  Ball c, s;

  static Stand of_angle(const Ball& q) {
    const double rough = kTrigonometry + q.r;
    return {{std::cos(q.m), rough}, {std::sin(q.m), rough}};
  }
  Stand opposite() const { return {-c, -s}; }
};

// The point of a motor, and the vectors that its derivatives consist of.
struct Arc {
  Vector point, rate, out;  // out: from the middle to the point

  Arc(const Drive& drive, const Stand& at) {
    const Vector along = vector(drive.along);
    if (drive.slide) {
      rate = along;
      out = at.c * along;
    } else {
      const Vector beside = vector(drive.beside);
      rate = at.c * beside - at.s * along;
      out = at.c * along + at.s * beside;
    }
    point = vector(drive.middle) + out;
  }
};

// A motor and a box of poses.
class Chain {
 public:
  Chain(const Drive& drive, const Limit& limit, const Place& at)
      : drive_(drive), at_(at), x_(vector(limit.x)) {
    most_ = (drive.square.m + drive.square.r) * kOutward;
    least_ = (drive.square.m - drive.square.r) * (1.0 - 0x1p-40);
    if (drive.of_platform) {
      fixed_ = at.p - x_;
      return;
    }
    y_ = at.turned(vector(limit.y));
    fixed_ = at.p + y_;
    if (at.rho == 0.0) return;
    bend_ = at.bend * length(y_);
    reach_ = at.shift + at.rho * length(y_);
    for (int i = 0; i < 3; ++i) turns_[i] = bend_;
    for (int k = 0; k < 3; ++k)
      if (at.d[k] != 0.0) {
        moves_[k] = cross(at.axis[k], y_);
        for (int i = 0; i < 3; ++i) turns_[i] += size(moves_[k][i]) * at.d[k];
      }
  }

  Placed leg(const Vector& point) const {
    return drive_.of_platform ? placed_points(at_.turned(point), x_, at_)
                              : placed_points(y_, point, at_);
  }

  // The square of the distance when the point of the motor is here: of a motor of the base as
  // square_over_box and point_point have it, with what is the same for all its points.
  Range square(const Vector& point) const {
    if (drive_.of_platform && at_.rho != 0.0) {
      const Placed b = leg(point);
      return both(square_over_box(b, at_), range(point_point(b), at_));
    }
    const Vector r = drive_.of_platform ? fixed_ + at_.turned(point) : fixed_ - point;
    Range sum{0.0, 0.0};
    for (int i = 0; i < 3; ++i) {
      const double half = (at_.h[i] + r[i].r + (at_.rho == 0.0 ? 0.0 : turns_[i])) * kOutward;
      const double near = std::max(std::abs(r[i].m) - half, 0.0), far = std::abs(r[i].m) + half;
      sum.low += near * near;
      sum.high += far * far;
    }
    sum = {sum.low * (1.0 - 0x1p-40), sum.high * kOutward};
    if (at_.rho == 0.0) return sum;
    const Vector s = at_.p - point;
    const Ball value = dot(r, r);
    double slope = 2.0 * length(r) * bend_ + value.r;
    for (int i = 0; i < 3; ++i) {
      if (at_.h[i] != 0.0) slope += 2.0 * size(r[i]) * at_.h[i];
      if (at_.d[i] != 0.0) slope += 2.0 * size(dot(moves_[i], s)) * at_.d[i];
    }
    const double rough = value.m * kUnit * 4;
    return both(sum, {value.m - slope * kOutward - rough,
                      value.m + (slope + reach_ * reach_) * kOutward + rough});
  }

  // The sign of F at all poses of the box, 0 if it is not proved.
  int sign(const Vector& point) const { return sign(square(point)); }
  int sign(const Range& found) const {
    if (found.low > most_) return 1;
    return found.high < least_ ? -1 : 0;
  }

  // Whether the square is above that of the rod by more than this at all poses, or below it.
  bool above_by(const Range& found, double more) const {
    return found.low > (most_ + more) * kOutward;
  }
  bool below_by(const Range& found, double more) const {
    return (found.high + more) * kOutward < least_;
  }
  int sign(const Stand& at) const { return sign(Arc(drive_, at).point); }

  // Where F turns at the centre of the box, by floating point: its least number, of a crank also the
  // largest on the other side. F there, less that of the rod: `above` if it is not negative; `reached` if
  // both signs of F are there.
  void find() {
    const Vector middle = vector(drive_.middle), along = vector(drive_.along);
    Vector r;
    double cosine, sine = 0.0;
    if (drive_.of_platform) {
      r = fixed_ + at_.turned(middle);
      cosine = -middle_of(r, at_.turned(along));
      if (!drive_.slide) sine = -middle_of(r, at_.turned(vector(drive_.beside)));
    } else {
      r = fixed_ - middle;
      cosine = middle_of(r, along);
      if (!drive_.slide) sine = middle_of(r, vector(drive_.beside));
    }
    const double here = middle_of(r, r) - drive_.square.m;
    if (drive_.slide) {
      rest = here - cosine * cosine;
      above = rest >= 0.0;
      reached = rest < 0.0;
      turn = {{cosine, std::abs(cosine) * kDirection}, {0.0, 0.0}};
      return;
    }
    const double size_of = std::sqrt(cosine * cosine + sine * sine);
    rest = (here + middle_of(along, along)) * 0.5 / size_of;
    above = rest >= 1.0;
    reached = std::abs(rest) < 1.0;
    turn = {{cosine / size_of, kDirection}, {sine / size_of, kDirection}};
  }

  // How much less than here the least F of all places can be, at any pose of the box; of `least` false
  // how much greater the greatest. Infinite without a proof.
  double more(const Arc& arc, bool least) const {
    const Range slope = range(rate(arc), at_);
    const double steepest = std::max(-slope.low, slope.high);
    double curve = 1.0;
    if (!drive_.slide) {
      const Range curved = range(product(arc.out, vector(drive_.middle)), at_);
      // The product is K of a motor of the base, -K of one of the platform; of the largest F the reverse.
      curve = drive_.of_platform == least ? -curved.high : curved.low;
    }
    return curve > 0.0 ? steepest * steepest / curve * kOutward : kInfinity;
  }

  // Whether F keeps its sign s in the range, given that it has this sign at both ends. On a half
  // circle s F has at most one minimum. It has none inside if it rises at the first end or falls at
  // the last.
  bool keeps(int s) const {
    if (turns_within(s)) return false;
    if (drive_.slide) return s < 0 || misses(1, drive_.low, drive_.high);
    const double width = drive_.high.m - drive_.low.m;
    if (width < 3.14) return misses(s, drive_.low, drive_.high);
    const Ball middle{drive_.low.m + 0.5 * width, 0.0};
    return width < 6.28 && sign(Stand::of_angle(middle)) == s && misses(s, drive_.low, middle) &&
           misses(s, middle, drive_.high);
  }

  // How far the square of the distance is from that of the rod, at most.
  double off(const Arc& arc) const {
    const Range found = square(arc.point);
    return std::max(most_ - found.low, found.high - least_);
  }

  // How far from q, where m F is least at the centre, the motor is at most at the poses of the box that the
  // rod reaches; infinite without a proof. At each pose m F is least between the places at which its
  // derivative is proved to have either sign. The motor is on the side of that on which s F falls
  // towards it or away from it, and before the place at which m F is positive.
  template <class At>
  double near_turn(const At& stand, double q, int m, int s) const {
    const Arc arc(drive_, stand(q));
    const double curve =
        drive_.slide ? 1.0 : std::abs(product(arc.out, vector(drive_.middle)).value.m);
    const Range slope = range(rate(arc), at_);
    const double aside = 1.5 * std::max(-slope.low, slope.high) / curve + 1e-13 * (1.0 + std::abs(q));
    const double far = aside + std::sqrt(1.5 * off(arc) / curve);
    if (!(far < (drive_.slide ? kInfinity : 1.0))) return kInfinity;
    const int side = -s * m;
    if (sign(stand(q + side * far)) != m || rises(stand(q + side * far)) != side * m ||
        rises(stand(q - side * aside)) != -side * m)
      return kInfinity;
    return far;
  }

  // The sign of the derivative of F by q at all poses of the box, 0 if it is not proved.
  int rises(const Stand& at) const {
    const Range found = range(rate(Arc(drive_, at)), at_);
    const int sign = found.low > 0.0 ? 1 : found.high < 0.0 ? -1 : 0;
    return drive_.of_platform ? sign : -sign;
  }

  // Half of the derivative of F by q, of a motor of the base with the other sign.
  Form rate(const Arc& arc) const { return product(arc.rate, arc.point); }

  Stand turn;
  double rest;
  bool reached, above;

 private:
  static Range both(const Range& a, const Range& b) {
    return {std::max(a.low, b.low), std::min(a.high, b.high)};
  }

  // Whether s F is least in the range at the centre, by floating point.
  bool turns_within(int s) const {
    if (drive_.slide) return s > 0 && turn.c.m > drive_.low.m && turn.c.m < drive_.high.m;
    const double c = s * turn.c.m, sine = s * turn.s.m;
    const bool after = drive_.at_low[0] * sine > drive_.at_low[1] * c;
    const bool before = drive_.at_high[1] * c > drive_.at_high[0] * sine;
    return drive_.high.m - drive_.low.m > 3.141592653589793 ? after || before : after && before;
  }

  bool misses(int s, const Ball& first, const Ball& last) const {
    const auto stand = [&](const Ball& q) {
      return drive_.slide ? Stand{q, {0.0, 0.0}} : Stand::of_angle(q);
    };
    const bool opposite = (s < 0) == drive_.of_platform;
    const Range a = range(rate(Arc(drive_, stand(first))), at_);
    if (opposite ? a.high <= 0.0 : a.low >= 0.0) return true;
    const Range b = range(rate(Arc(drive_, stand(last))), at_);
    return opposite ? b.low >= 0.0 : b.high <= 0.0;
  }

  // The product of a vector of the motor's body and of the leg to one of its points.
  Form product(const Vector& a, const Vector& point) const {
    const Placed b = leg(point);
    const double far = length(a);
    if (!drive_.of_platform) return {dot(a, b.r), a, cross(b.y, a), b.bend * far, b.bend * far};
    Form f = along(at_.turned(a), b, at_);
    f.below *= far;
    f.above *= far;
    return f;
  }

  const Drive& drive_;
  const Place& at_;
  Vector x_, y_, fixed_, moves_[3];  // fixed: the leg, without the point of the motor
  double turns_[3], bend_, reach_, most_, least_;
};

// The order of the places of a motor on the half circle (half line) on which s F falls at the centre of
// the box. The places are its first, its last, and the ends of the range between them.
struct Fall {
  bool known;          // no two places are too near to each other to be in order
  bool starts_within;  // the first place is in the range
  int count = 0;       // ends of the range on the way,
  bool is_first[2];    // in this order; at the first one it begins

  void add(bool first) { is_first[count++] = first; }
};

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
