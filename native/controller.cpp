// The source that `gsp export --to c` writes for one platform, here with all kinds.
#include "controller.hpp"

#include <math.h>

#include <algorithm>
#include <cstring>

#define HAS_DPP 1
#define HAS_DPL 1
#define HAS_DLP 1
#define HAS_DPH 1
#define HAS_DHP 1
#define HAS_DLL 1
#define HAS_ALL 1
#define HAS_ALH 1
#define HAS_AHL 1
#define HAS_AHH 1
#define HAS_BASE_CRANK 1
#define HAS_PLATFORM_CRANK 1
#define HAS_BASE_SLIDE 1
#define HAS_PLATFORM_SLIDE 1
#define HAS_CONES 1
#define HAS_PIECES 1

namespace gsp {
namespace {
#include "../gspcli/export/controller/platform.c"
#include "../gspcli/export/controller/nearest.c"

// Position and quaternion as a struct.
platform_pose given(const double* pose) {
  platform_pose p;
  std::copy(pose, pose + 3, p.position);
  std::copy(pose + 3, pose + 7, p.rotation);
  return p;
}
}  // namespace

struct Controller::Parts {
  geometry numbers;
  platform_state state;
  platform_report report;
  limits within;
};

namespace {
// A search with the sides and working modes of the state; false if it has no pose.
bool begun(const Controller::Parts& parts, search* s) {
  const geometry* g = &parts.numbers;
  frame f;
  double c[6];
  if (!load(g, &parts.state.pose, &f)) return false;
  for (int k = 0; k < 6; ++k) c[k] = (parts.state.values[k] + g->offset[k]) * g->unit[k];
  search_from(s, g, &parts.within, &f, c);
  return true;
}
}  // namespace

// From Y to the last one before `either` all fields are doubles.
const std::size_t Controller::kNumbers =
    (offsetof(geometry, either) - offsetof(geometry, Y)) / sizeof(double);

Controller::Controller(const unsigned char* kind, const unsigned char* either,
                       const double* numbers)
    : parts_(std::make_unique<Parts>()) {
  std::copy(kind, kind + 6, parts_->numbers.kind);
  std::copy(either, either + 6, parts_->numbers.either);
  std::memcpy(parts_->numbers.Y, numbers, kNumbers * sizeof(double));
}

Controller::~Controller() = default;

int Controller::start(const double* pose) {
  const platform_pose p = given(pose);
  return begin(&parts_->numbers, &p, &parts_->state, &parts_->report);
}

int Controller::start(const double* pose, double* near) {
  const platform_pose p = given(pose);
  return begin_near(&parts_->numbers, &p, near, &parts_->state, &parts_->report);
}

int Controller::forward(const double* values) {
  return follow(&parts_->numbers, values, &parts_->state, &parts_->report);
}

int Controller::jacobian(double* J) const {
  const platform_state& s = parts_->state;
  return differentiate(&parts_->numbers, &s.pose, s.values, reinterpret_cast<double(*)[6]>(J));
}

const std::size_t Controller::kLimits = offsetof(limits, cones) / sizeof(double);

void Controller::limit(const double* numbers, std::size_t cones, const unsigned char* legs,
                       const unsigned char* on_base, bool still) {
  limits& l = parts_->within;
  std::memcpy(l.low, numbers, kLimits * sizeof(double));
  l.cones = static_cast<unsigned char>(cones);
  l.still = still;
  std::copy(legs, legs + cones, l.leg);
  std::copy(on_base, on_base + cones, l.on_base);
}

int Controller::nearest(const double* pose) {
  const platform_pose p = given(pose);
  return approach(&parts_->numbers, &parts_->within, &p, &parts_->state, &parts_->report);
}

double Controller::seek(const double* goal, double* pose) const {
  const Parts& parts = *parts_;
  const geometry* g = &parts.numbers;
  const platform_pose wanted = given(goal);
  platform_pose at = given(pose);
  search s;
  frame target, f;
  double distance = 0.0;
  if (!begun(parts, &s) || !load(g, &wanted, &target) || !load(g, &at, &f)) return -1.0;
  search_for(&s, &target);
  if (!gsp::seek(&s, &f, &distance)) return -1.0;
  unload(g, &f, &at);
  std::copy(at.position, at.position + 3, pose);
  std::copy(at.rotation, at.rotation + 4, pose + 3);
  return distance * g->reach;
}

int Controller::slack(const double* pose, double* room, double* rows) const {
  const Parts& parts = *parts_;
  const platform_pose at = given(pose);
  search s;
  frame f;
  if (!begun(parts, &s) || !load(&parts.numbers, &at, &f)) return 0;
  slacks(&s, &f, nullptr, room, reinterpret_cast<double(*)[6]>(rows));
  const int count = slack_count(&s);
  for (int i = 0; i < count; ++i) {
    room[i] *= parts.numbers.reach;
    for (int j = 0; j < 3; ++j) rows[6 * i + j] *= parts.numbers.reach;
  }
  return count;
}

namespace {
int keep(void* where, const piece* p) {
  std::vector<double>& out = static_cast<FollowedRows*>(where)->pieces;
  const double row = static_cast<double>(static_cast<FollowedRows*>(where)->reached);
  for (const double x : {row, p->begin, p->end, p->from}) out.push_back(x);
  out.insert(out.end(), p->at.q, p->at.q + 4);
  out.insert(out.end(), p->at.T, p->at.T + 3);
  out.insert(out.end(), p->d, p->d + 6);
  for (const double x : {p->radius, p->error, p->alone}) out.push_back(x);
  return 1;
}
}  // namespace

FollowedRows Controller::follow_rows(const double* values, std::size_t rows, const double* pose,
                                     const FollowLimits& limits) const {
  const geometry* g = &parts_->numbers;
  FollowedRows out;
  platform_pose p = given(pose);
  walk w{};
  double c[6], next[6], inverse[6][6];
  if (!load(g, &p, &w.at.f)) return out;
  std::copy(values, values + 6, c);
  std::copy(values, values + 6, next);
  if (limits.near == 0.0) {  // the pose that Newton's method finds
    (void)orient(g, &w.at.f, 0.0, c, next);
    set(g, c, &w.at.at);
    evaluate(g, &w.at);
    if (!(linearize(&w.at, inverse) < 0.5) || !converge(g, inverse, &w.at)) return out;
  }
  if (limits.keep) w.keep = keep, w.kept = &out;
  w.error = limits.near / g->reach, w.step = 1.0, w.shortest = limits.shortest;
  const auto store = [&] {
    unload(g, &w.at.f, &p);
    out.poses.insert(out.poses.end(), p.position, p.position + 3);
    out.poses.insert(out.poses.end(), p.rotation, p.rotation + 4);
  };
  store();
  for (out.reached = 0; out.reached + 1 < static_cast<long>(rows); ++out.reached) {
    std::copy(values + 6 * out.reached, values + 6 * out.reached + 6, c);
    std::copy(values + 6 * out.reached + 6, values + 6 * out.reached + 12, next);
    w.done = 0.0, w.step = std::min(w.step, 1.0), w.tries = 0, w.most_tries = limits.tries;
    if (!orient(g, &w.at.f, w.error, c, next)) break;
    const int status = chase(g, c, next, &w);
    out.tries += w.tries;
    if (status || !keeps_sides(g, &w.at.f, w.error, c, next)) break;
    store();
  }
  if (out.reached + 1 == static_cast<long>(rows)) w.done = 0.0;
  unload(g, &w.at.f, &p);
  std::copy(p.position, p.position + 3, out.last);
  std::copy(p.rotation, p.rotation + 4, out.last + 3);
  out.fraction = w.done, out.error = w.error * g->reach, out.alone = w.alone * g->reach, out.steps = w.steps, out.worst = w.worst;
  return out;
}

const double* Controller::position() const { return parts_->state.pose.position; }
const double* Controller::rotation() const { return parts_->state.pose.rotation; }
const double* Controller::values() const { return parts_->state.values; }
double Controller::error() const { return parts_->state.error; }
StepReport Controller::report() const {
  const platform_report& r = parts_->report;
  return {r.fraction, r.sigma, r.alone, r.steps, r.tries};
}

}  // namespace gsp
