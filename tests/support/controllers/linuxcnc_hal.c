/* What a kinematics module needs of LinuxCNC's HAL, and calls of its kinematics on arrays: the module
 * that halcompile built is loaded after it into a process without LinuxCNC. */
#include <stdlib.h>

#include "hal.h"
#include "kinematics.h"

typedef int forward_t(const double *, EmcPose *, const KINEMATICS_FORWARD_FLAGS *, KINEMATICS_INVERSE_FLAGS *);
typedef int inverse_t(const EmcPose *, double *, const KINEMATICS_INVERSE_FLAGS *, KINEMATICS_FORWARD_FLAGS *);

int hal_init(const char *name) { return name ? 1 : -1; }
int hal_ready(int component) { return component - 1; }
int hal_exit(int component) { return component - 1; }
void *hal_malloc(long size) { return calloc(1, (size_t)size); }

/* What the module exports. */
static hal_bit_t *homed;
static void (*watch)(void *, long);

static int pin(void **place) { return (*place = calloc(1, sizeof(double))) ? 0 : -1; }
int hal_pin_bit_newf(hal_pin_dir_t dir, hal_bit_t **place, int component, const char *format, ...) {
  (void)component, (void)format;
  if (pin((void **)place)) return -1;
  if (dir == HAL_IN) homed = *place;
  return 0;
}
int hal_pin_u32_newf(hal_pin_dir_t dir, hal_u32_t **place, int component, const char *format, ...) {
  (void)dir, (void)component, (void)format;
  return pin((void **)place);
}
int hal_pin_s32_newf(hal_pin_dir_t dir, hal_s32_t **place, int component, const char *format, ...) {
  (void)dir, (void)component, (void)format;
  return pin((void **)place);
}
int hal_export_funct(const char *name, void (*call)(void *, long), void *arg, int floats, int reentrant,
                     int component) {
  (void)name, (void)arg, (void)floats, (void)reentrant, (void)component;
  watch = call;
  return 0;
}

/* Worlds (x, y, z, a, b, c) of walks from home, shape (n, rows, 6), to joints and back. Status: 0, 1 no
 * joints, 2 refused; a walk ends there, what comes after has the same status. */
void round_trips(inverse_t *inverse, forward_t *forward, long n, long rows, const double *worlds,
                 double *joints, double *back, int *status) {
  for (long i = 0; i < n * rows; ++i) {
    const double *w = worlds + 6 * i;
    EmcPose pose = {{w[0], w[1], w[2]}, w[3], w[4], w[5], 0.0, 0.0, 0.0}, found = pose;
    if (i % rows == 0) { /* homed again: the next proof starts from home */
      *homed = 0;
      watch(0, 0);
      *homed = 1;
    } else {
      /* Of the two angles of a crank the one is meant that is nearer to the last. */
      for (int k = 0; k < 6; ++k) joints[6 * i + k] = joints[6 * i + k - 6];
      if ((status[i] = status[i - 1])) continue;
    }
    if (inverse(&pose, joints + 6 * i, 0, 0)) {
      status[i] = 1;
      continue;
    }
    if (forward(joints + 6 * i, &found, 0, 0)) {
      status[i] = 2;
      continue;
    }
    const double out[6] = {found.tran.x, found.tran.y, found.tran.z, found.a, found.b, found.c};
    for (int k = 0; k < 6; ++k) back[6 * i + k] = out[k];
  }
}
