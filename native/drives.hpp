// Constraints of two points of which a motor moves one: which poses of a box its range reaches.
#pragma once

#include "pose_box.hpp"

namespace gsp {

// Judges the range of a motor, and whether the rod reaches its point at all. A condition that holds
// for all poses of the box is removed from `open`. The box is outside if all its poses violate one
// of both.
Verdict judge_drive(const Drive& drive, const Limit& limit, const Place& at, Conditions& open);

// Encloses the places of the motor at the poses of the box that the rod reaches. `leg` is the leg
// at the centre (or near it, at a dead point), `swing` how far the motor moves from there. False if
// nothing is proved.
bool locate(const Drive& drive, const Limit& limit, const Place& at, Placed& leg, Swing& swing);

}  // namespace gsp
