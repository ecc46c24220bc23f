// Proves that a motor is within its range at all poses of a box, or at none.
//
// Let F(X; q) be the square of the distance of the two points at the pose X, less that of the rod,
// when the motor is at q. Of a crank F is a constant and a sinusoid of q, of a slide a parabola. So
// it has two roots. They are distinguished by the sign of the derivative there, which is opposite
// to the sign s of the gain (the knee). On the circle, or on the line, s F falls through zero once.
// Therefore, if a < b and, for a crank, b - a < 2 pi,
//
//     s F(X; a) > 0 > s F(X; b) for all X of a box
//
// proves for each X exactly one root in [a, b]; it is that of the knee, and the gain is not zero
// there. F(X; a) is a distance from the fixed point of the motor at a, so that nothing but squares
// of distances is enclosed (box_forms.hpp). If [a, b] is in the range, the motor is within it; if
// it is outside, so is the motor. The ends of the range are tried first. If both roots may be in
// the range, or none, other a and b are chosen. They are two of the ends of the range, and of the
// half circle (half line) on which s F falls at the centre of the box. The choice decides whether
// something is proved; what is proved is true for any choice.
//
// No root: let 2 S and 2 K be the first and second derivatives of F by q. Then the least F of all q
// is at least F(X; q) - S^2 / K for any q with K > 0. For with F = m - n cos(q - u) these are S = n
// sin(q - u) / 2 and K = n cos(q - u) / 2, and n - n cos(q - u) <= n sin(q - u)^2 / (2 cos(q - u)).
#include "drives.hpp"

#include <cmath>

#include "box_forms.hpp"

namespace gsp {
namespace {

// Of the cosine and sine of the direction to a point, and of the place of a slide, relatively.
constexpr double kDirection = 0x1p-48;
// Places of a motor that are nearer to each other have no order.
constexpr double kTie = 0x1p-45;

double middle_of(const Vector& a, const Vector& b) {
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
    if (drive.of_platform) return;
    y_ = at.turned(vector(limit.y));
    py_ = at.p + y_;
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
    if (drive_.of_platform) {
      const Placed b = leg(point);
      const Range found = square_over_box(b, at_);
      return at_.rho == 0.0 ? found : both(found, range(point_point(b), at_));
    }
    const Vector r = py_ - point;
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
  int sign(const Vector& point) const {
    const Range found = square(point);
    if (found.low > most_) return 1;
    return found.high < least_ ? -1 : 0;
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
      r = at_.p - x_ + at_.turned(middle);
      cosine = -middle_of(r, at_.turned(along));
      if (!drive_.slide) sine = -middle_of(r, at_.turned(vector(drive_.beside)));
    } else {
      r = py_ - middle;
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

  // That F has no root at any pose of the box: its least number is positive, or its largest negative.
  bool never() const {
    const Stand q = above || drive_.slide ? turn : turn.opposite();
    const Arc arc(drive_, q);
    const Range found = square(arc.point);
    const Range slope = range(rate(arc), at_);
    const double steepest = std::max(-slope.low, slope.high);
    double curve = 1.0;
    if (!drive_.slide) {
      const Range curved = range(product(arc.out, vector(drive_.middle)), at_);
      // The product is K of a motor of the base, -K of one of the platform; of the largest F the reverse.
      curve = drive_.of_platform == above ? -curved.high : curved.low;
    }
    if (!(curve > 0.0)) return false;
    const double more = steepest * steepest / curve * kOutward;
    return above ? found.low > (most_ + more) * kOutward
                 : (found.high + more) * kOutward < least_;
  }

  // Whether F keeps its sign s in the range, given that it has this sign at both ends. On a half
  // circle s F has at most one minimum. It has none inside if it rises at the first end or falls at
  // the last.
  bool keeps(int s) const {
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

  bool misses(int s, const Ball& first, const Ball& last) const {
    const auto stand = [&](const Ball& q) {
      return drive_.slide ? Stand{q, {0.0, 0.0}} : Stand::of_angle(q);
    };
    const Range a = range(rate(Arc(drive_, stand(first))), at_);
    const Range b = range(rate(Arc(drive_, stand(last))), at_);
    const bool opposite = (s < 0) == drive_.of_platform;
    return opposite ? a.high <= 0.0 || b.low >= 0.0 : a.low >= 0.0 || b.high <= 0.0;
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
  Vector x_, y_, py_, moves_[3];
  double turns_[3], bend_, reach_, most_, least_;
};

// The order of places of a motor on the half circle (half line) on which s F falls at the centre of
// the box. The places are its first, its last, and the ends of the range between them.
struct Fall {
  bool known;          // no two places are too near to each other to be in order
  bool starts_within;  // the first place is in the range
  int count = 0;       // ends of the range on the way,
  bool is_first[2];    // in this order; at the first one it begins

  void add(bool first) { is_first[count++] = first; }
};

Fall fall_of_slide(const Drive& drive, double turn) {
  Fall way{};
  const double low = drive.low.m, high = drive.high.m;
  const double near = kTie * (std::abs(turn) + std::abs(low) + std::abs(high));
  way.known = std::abs(turn - low) > near && std::abs(turn - high) > near;
  const bool down = drive.knee > 0.0;  // from far below up to the turn, else from there to far above
  way.starts_within = !down && turn > low && turn < high;
  if (down == (low < turn)) way.add(true);
  if (down == (high < turn)) way.add(false);
  return way;
}

Fall fall_of_crank(const Drive& drive, const Stand& start) {
  Fall way{};
  const double to_first = start.c.m * drive.at_low[1] - start.s.m * drive.at_low[0];
  const double to_last = start.c.m * drive.at_high[1] - start.s.m * drive.at_high[0];
  const bool wide = drive.high.m - drive.low.m > 3.141592653589793;  // half a circle
  way.known = std::abs(to_first) > kTie && std::abs(to_last) > kTie;
  way.starts_within = wide ? to_last > 0.0 || to_first < 0.0 : to_last > 0.0 && to_first < 0.0;
  // The half circle has both ends of a narrow range in their order, of a wide one the last end first.
  if (to_last > 0.0 && wide) way.add(false);
  if (to_first > 0.0) way.add(true);
  if (to_last > 0.0 && !wide) way.add(false);
  return way;
}

// Judges one motor at the poses of a box; each sign is computed once, when it is needed.
class Judge {
 public:
  Judge(const Drive& drive, const Limit& limit, const Place& at)
      : drive_(drive), chain_(drive, limit, at), s_(drive.knee > 0.0 ? 1 : -1) {}

  // Whether the motor is within its range at all poses, or at none.
  Verdict range() {
    if (first() == s_ && last() == -s_) return Verdict::kInside;
    find();
    if (chain_.reached) {
      const Fall way = drive_.slide ? fall_of_slide(drive_, chain_.turn.c.m)
                                    : fall_of_crank(drive_, turn(true));
      bool within = way.starts_within;
      int passed = 0;
      for (; way.known && passed < way.count; ++passed) {
        const int here = way.is_first[passed] ? first() : last();
        if (here == 0) return Verdict::kOpen;
        if (here == -s_) break;
        within = way.is_first[passed];
      }
      if (way.known && (passed > 0 || start() == s_) && (passed < way.count || end() == -s_))
        return within ? Verdict::kInside : Verdict::kOutside;
    }
    return first() != 0 && first() == last() && chain_.keeps(first()) ? Verdict::kOutside
                                                                      : Verdict::kOpen;
  }

  // Whether the rod reaches the point of the motor at all poses, or at none.
  Verdict reach() {
    find();
    if (chain_.reached) return start() == s_ && end() == -s_ ? Verdict::kInside : Verdict::kOpen;
    return chain_.never() ? Verdict::kOutside : Verdict::kOpen;
  }

 private:
  void find() {
    if (!found_) chain_.find();
    found_ = true;
  }

  // Where s F begins to fall, or where it ends to: of a slide one of both is infinitely far away.
  Stand turn(bool starts) const {
    return starts == (s_ > 0) && !drive_.slide ? chain_.turn.opposite() : chain_.turn;
  }

  int first() { return known(first_, vector(drive_.first)); }
  int last() { return known(last_, vector(drive_.last)); }
  int start() {
    if (drive_.slide && s_ > 0) return s_;
    return known(start_, [&] { return Arc(drive_, turn(true)).point; });
  }
  int end() {
    if (drive_.slide && s_ < 0) return -s_;
    return known(end_, [&] { return Arc(drive_, turn(false)).point; });
  }
  int known(int& sign, const Vector& point) {
    if (sign == kUnknown) sign = chain_.sign(point);
    return sign;
  }
  template <class Point>
  int known(int& sign, const Point& point) {
    if (sign == kUnknown) sign = chain_.sign(point());
    return sign;
  }

  static constexpr int kUnknown = 2;
  const Drive& drive_;
  Chain chain_;
  const int s_;
  bool found_ = false;
  int first_ = kUnknown, last_ = kUnknown, start_ = kUnknown, end_ = kUnknown;
};

}  // namespace

Verdict judge_drive(const Drive& drive, const Limit& limit, const Place& at, Conditions& open) {
  const Conditions range = Conditions{1} << drive.row, reach = kReach << drive.row;
  if (!(open & (range | reach))) return Verdict::kInside;
  Judge judge(drive, limit, at);
  if (open & range) {
    const Verdict found = judge.range();
    if (found == Verdict::kInside) open &= ~(range | reach);
    if (found == Verdict::kOutside) return found;
  }
  if (open & reach) {
    const Verdict found = judge.reach();
    if (found == Verdict::kInside) open &= ~reach;
    if (found == Verdict::kOutside) return found;
  }
  return open & (range | reach) ? Verdict::kOpen : Verdict::kInside;
}

bool locate(const Drive& drive, const Limit& limit, const Place& at, Placed& leg, Swing& swing) {
  Chain chain(drive, limit, at);
  chain.find();
  const int s = drive.knee > 0.0 ? 1 : -1;
  const auto stand = [&](double q) {
    return drive.slide ? Stand{{q, 0.0}, {0.0, 0.0}} : Stand::of_angle({q, 0.0});
  };
  const double turn = drive.slide ? chain.turn.c.m : std::atan2(chain.turn.s.m, chain.turn.c.m);
  double q = turn, delta = kInfinity;
  if (chain.reached) {
    q -= s * (drive.slide ? std::sqrt(-chain.rest) : std::acos(chain.rest));
    const Arc arc(drive, stand(q));
    // To first order, and a margin for the rest; the proof is that of the root.
    delta = 0.65 * chain.off(arc) / std::abs(chain.rate(arc).value.m) + 1e-13 * (1.0 + std::abs(q));
    const double most = drive.slide ? kInfinity : 1.0;
    if (!(delta < most) || chain.sign(stand(q - delta)) != s || chain.sign(stand(q + delta)) != -s)
      delta = kInfinity;
  }
  if (std::isinf(delta)) {
    const bool least = drive.slide || chain.rest > 0.0;
    q = least ? turn : turn + 3.141592653589793;
    delta = chain.near_turn(stand, q, least ? 1 : -1, s);
    if (std::isinf(delta)) return false;
  }
  const Arc arc(drive, stand(q));
  leg = chain.leg(arc.point);
  leg.v = leg.w = Vector{};
  swing.drive = &drive;
  swing.q = q;
  swing.delta = delta * kOutward;
  swing.rate = drive.of_platform ? at.turned(arc.rate) : arc.rate;
  swing.bend = drive.slide ? 0.0 : 0.5 * length(arc.out) * delta * delta * kOutward;
  if (drive.of_platform) swing.bend += at.rho * (length(arc.rate) * delta + swing.bend) * kOutward;
  return true;
}

}  // namespace gsp
