// Constraints of two points of which a motor moves one: which poses of a box its range reaches.
#pragma once

#include "pose_box.hpp"

namespace gsp {

// Judges the range of a motor, and whether the rod reaches its point at all: takes out of `open` what
// holds for all poses of the box; outside if one of both is violated by all of them.
Verdict judge_drive(const Drive& drive, const Limit& limit, const Place& at, Conditions& open);

// Where the motor is at the poses of the box that the rod reaches: the leg at the centre, or near it at a
// dead point, and how far the motor goes from there. False if nothing is proved.
bool locate(const Drive& drive, const Limit& limit, const Place& at, Placed& leg, Swing& swing);

}  // namespace gsp
