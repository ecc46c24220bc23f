/* A kinematics module for LinuxCNC (2.9): forward kinematics that never change the assembly mode.
 *
 *   gsp export @linuxcnc-hexapod --to c --mode 8 -o hexapod.c
 *   halcompile --install --extra-compile-args=-std=gnu99 provedkins.c    # with hexapod.c beside it
 *   # in the INI file: [KINS] KINEMATICS = provedkins, JOINTS = 6; [HAL] HALFILE = provedkins.hal
 *
 * LinuxCNC does not stop when kinematicsForward returns -1: it shows the world home position and
 * goes on. So connect the pins, as provedkins.hal does. */
#include "kinematics.h"
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_math.h"
#include "hal.h"

#include "hexapod.c"

#define DEGREE (3.14159265358979323846 / 180.0)

static hexapod_state where; /* the last proved pose */
static int started;
static struct {
  hal_bit_t *homed;    /* in: FALSE while joints have no true positions; TRUE if nothing is connected */
  hal_bit_t *proved;   /* out: the last pose is proved, or the machine is not homed */
  hal_u32_t *refusals; /* out: how many poses were refused */
  hal_s32_t *status;   /* out: of the last pose; the numbers are those of hexapod.h */
} *pins;

/* R = Rz(c) Ry(b) Rx(a), angles in degrees. */
static hexapod_pose pose_of(const struct EmcPose *world) {
  const double a = 0.5 * DEGREE * world->a, b = 0.5 * DEGREE * world->b, c = 0.5 * DEGREE * world->c;
  const double ca = cos(a), sa = sin(a), cb = cos(b), sb = sin(b), cc = cos(c), sc = sin(c);
  hexapod_pose pose = {{world->tran.x, world->tran.y, world->tran.z},
                       {ca * cb * cc + sa * sb * sc, sa * cb * cc - ca * sb * sc,
                        ca * sb * cc + sa * cb * sc, ca * cb * sc - sa * sb * cc}};
  return pose;
}

static void world_of(const hexapod_pose *pose, struct EmcPose *world) {
  const double w = pose->rotation[0], x = pose->rotation[1], y = pose->rotation[2],
               z = pose->rotation[3];
  double sine = 2.0 * (w * y - x * z);
  sine = sine > 1.0 ? 1.0 : sine < -1.0 ? -1.0 : sine;
  world->tran.x = pose->position[0];
  world->tran.y = pose->position[1];
  world->tran.z = pose->position[2];
  world->a = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)) / DEGREE;
  world->b = asin(sine) / DEGREE;
  world->c = atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)) / DEGREE;
}

int kinematicsForward(const double *joints, struct EmcPose *world,
                      const KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags) {
  const hexapod_pose home = HEXAPOD_HOME;
  int status;
  (void)fflags, (void)iflags;
  if (!*pins->homed) return -1; /* LinuxCNC calls this once before homing */
  status = started ? HEXAPOD_PROVED : hexapod_start(&home, &where, 0);
  if (!status) {
    started = 1;
    status = hexapod_forward(joints, &where, 0);
  }
  *pins->status = status;
  *pins->proved = !status;
  if (status) {
    ++*pins->refusals;
    return -1;
  }
  world_of(&where.pose, world);
  return 0;
}

int kinematicsInverse(const struct EmcPose *world, double *joints,
                      const KINEMATICS_INVERSE_FLAGS *iflags, KINEMATICS_FORWARD_FLAGS *fflags) {
  const hexapod_pose pose = pose_of(world);
  (void)fflags, (void)iflags;
  return hexapod_inverse(&pose, joints) ? -1 : 0;
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_BOTH; }

MODULE_LICENSE("GPL");
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
KINS_NOT_SWITCHABLE

static int component;

/* Before homing nothing can be proved, and the machine must move: the next proof starts from home. */
static void watch(void *unused, long period) {
  (void)unused, (void)period;
  if (*pins->homed) return;
  started = 0;
  *pins->proved = 1;
}

static int export_pins(void) {
  pins = hal_malloc(sizeof *pins);
  if (!pins) return -1;
  if (hal_pin_bit_newf(HAL_IN, &pins->homed, component, "provedkins.homed") ||
      hal_pin_bit_newf(HAL_OUT, &pins->proved, component, "provedkins.proved") ||
      hal_pin_u32_newf(HAL_OUT, &pins->refusals, component, "provedkins.refusals") ||
      hal_pin_s32_newf(HAL_OUT, &pins->status, component, "provedkins.status") ||
      hal_export_funct("provedkins.watch", watch, 0, 0, 0, component))
    return -1;
  *pins->homed = *pins->proved = 1;
  return 0;
}

int rtapi_app_main(void) {
  component = hal_init("provedkins");
  if (component < 0) return component;
  if (export_pins()) {
    hal_exit(component);
    return -1;
  }
  hal_ready(component);
  return 0;
}

void rtapi_app_exit(void) { hal_exit(component); }
