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

namespace gsp {
namespace {
#include "../gspcli/export/controller/platform.c"
}  // namespace

struct Controller::Parts {
  geometry numbers;
  platform_state state;
  platform_report report;
};

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
  platform_pose p;
  std::copy(pose, pose + 3, p.position);
  std::copy(pose + 3, pose + 7, p.rotation);
  return begin(&parts_->numbers, &p, &parts_->state, &parts_->report);
}

int Controller::start(const double* pose, double* near) {
  platform_pose p;
  std::copy(pose, pose + 3, p.position);
  std::copy(pose + 3, pose + 7, p.rotation);
  return begin_near(&parts_->numbers, &p, near, &parts_->state, &parts_->report);
}

int Controller::forward(const double* values) {
  return follow(&parts_->numbers, values, &parts_->state, &parts_->report);
}

int Controller::jacobian(double* J) const {
  const platform_state& s = parts_->state;
  return differentiate(&parts_->numbers, &s.pose, s.values, reinterpret_cast<double(*)[6]>(J));
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
