// Proves that a motor is within its range at all poses of a box, or at none.
//
// Let F(X; q) be the square of the distance of the two points at the pose X, less that of the rod,
// when the motor is at q. Of a crank F is a constant and a sinusoid of q, of a slide a parabola. So
// it has two roots. They are distinguished by the sign of the derivative there, which is opposite
// to the sign s of the gain (the working mode). On the circle, or on the line, s F falls through zero once.
// Therefore, if a < b and, for a crank, b - a < 2 pi,
//
//     s F(X; a) > 0 > s F(X; b) for all X of a box
//
// proves for each X exactly one root in [a, b]; it is that of the working mode, and the gain is not zero
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
//
// A box that is divided is judged once more, for all its parts: the places a and b, and what is
// proved at them, hold for each part. A part computes what is not proved of the whole box.
#include "drives.hpp"

namespace gsp {
namespace {

// Places of a motor that are nearer to each other have no order.
constexpr double kTie = 0x1p-45;

Fall fall_of_slide(const Drive& drive, double turn) {
  Fall way{};
  const double low = drive.low.m, high = drive.high.m;
  const double near = kTie * (std::abs(turn) + std::abs(low) + std::abs(high));
  way.known = std::abs(turn - low) > near && std::abs(turn - high) > near;
  const bool down = drive.working_mode > 0.0;  // from far below up to the turn, else from there to far above
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

}  // namespace

DriveJudge::DriveJudge(const Drive& drive, const Limit& limit, const Place& at)
    : drive_(drive), s_(drive.working_mode > 0.0 ? 1 : -1), chain_(drive, limit, at) {}

DriveJudge::DriveJudge(DriveJudge& whole, const Limit& limit, const Place& at)
    : drive_(whole.drive_), whole_(&whole), s_(whole.s_), chain_(whole.drive_, limit, at) {}

Verdict DriveJudge::range() {
  if (sign(kFirst) == s_ && sign(kLast) == -s_) return Verdict::kInside;
  const Fall& way = fall();
  bool within = way.starts_within;
  int passed = 0;
  for (; way.known && passed < way.count; ++passed) {
    const int here = sign(way.is_first[passed] ? kFirst : kLast);
    if (here == 0) return Verdict::kOpen;
    if (here == -s_) break;
    within = way.is_first[passed];
  }
  if (way.known && (passed > 0 || start() == s_) && (passed < way.count || end() == -s_))
    return within ? Verdict::kInside : Verdict::kOutside;
  const int both = sign(kFirst);
  return both != 0 && both == sign(kLast) && keeps(both) ? Verdict::kOutside : Verdict::kOpen;
}

Verdict DriveJudge::reach() {
  if (start() == s_ && end() == -s_) return Verdict::kInside;
  return never() ? Verdict::kOutside : Verdict::kOpen;
}

// That F has no root at any pose: its least number is positive, or its largest negative.
bool DriveJudge::never() {
  if (sign(kTurn) > 0) return chain_.above_by(square(kTurn), more(true));
  return !drive_.slide && sign(kOpposite) < 0 && chain_.below_by(square(kOpposite), more(false));
}

int DriveJudge::sign(Spot spot) {
  int& sign = sign_[spot];
  if (sign != kUnknown) return sign;
  if (whole_) sign = whole_->sign(spot);
  // Infinitely far away.
  else if (drive_.slide && spot == kOpposite) sign = 1;
  if (sign == kUnknown || (sign == 0 && whole_)) sign = chain_.sign(square(spot));
  return sign;
}

const Range& DriveJudge::square(Spot spot) {
  Range& found = square_[spot];
  if (found.high < 0.0) found = chain_.square(point(spot));
  return found;
}

const Vector& DriveJudge::point(Spot spot) {
  if (spot == kFirst) return drive_.first;
  if (spot == kLast) return drive_.last;
  return turns().arc[spot - kTurn].point;
}

DriveJudge::Turns& DriveJudge::turns() {
  if (whole_) return whole_->turns();
  if (turns_) return *turns_;
  chain_.find();
  const Stand at[] = {chain_.turn, drive_.slide ? chain_.turn : chain_.turn.opposite()};
  turns_.emplace(Turns{{Arc(drive_, at[0]), Arc(drive_, at[1])},
                       drive_.slide ? fall_of_slide(drive_, at[0].c.m)
                                    : fall_of_crank(drive_, at[s_ > 0])});
  return *turns_;
}

double DriveJudge::more(bool least) {
  if (whole_) return whole_->more(least);
  double& found = more_[least];
  if (found < 0.0) found = chain_.more(turns().arc[!least], least);
  return found;
}

bool DriveJudge::keeps(int s) {
  if (whole_) return whole_->keeps(s);
  int& found = keeps_[s > 0];
  if (found == kUnknown) found = chain_.keeps(s);
  return found;
}

Whole::Whole(const Reach& reach, const double* centre, const double* half, Conditions open)
    : at(place(reach, centre, half)) {
  for (std::size_t k = 0; k < reach.drive.size(); ++k) {
    const int row = reach.drive[k].row;
    if (open & conditions_of(row)) drive[k].emplace(reach.drive[k], reach.limit[row], at);
  }
}

Verdict judge_drive(DriveJudge&& judge, int row, Conditions& open) {
  const Conditions range = Conditions{1} << row, reach = kReach << row;
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
  const int s = drive.working_mode > 0.0 ? 1 : -1;
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
