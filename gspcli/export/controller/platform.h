/* @NAME@: kinematics of one platform; written by gsp export --to c.
 *
 * A pose is x_base = R x_platform + position, R of the quaternion (w, x, y, z) of any length.
 * Lengths are in @LENGTH@, angles of values in @ANGLE@, twists in radians.
 * Values: @VALUES@.@SIGNED@@CRANKED@
 *
 * No allocation, no state but what is passed, no recursion; of the C library only math.h.
 * Data: @DIGEST@ */
#ifndef PLATFORM_H
#define PLATFORM_H

#define PLATFORM_API 3 /* grows when a signature or a struct changes */

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
  double position[3];
  double rotation[4];
} platform_pose;

/* Where the platform is: what the next call of forward starts from. */
typedef struct {
  platform_pose pose;
  double values[6];
  double error; /* the exact pose of the values is so near: lengths, or radians times PLATFORM_REACH */
} platform_state;

typedef struct {
  double fraction; /* how much of the line of values was proved; 1 if all */
  double sigma;    /* where the last part began: not above the least singular value of the Jacobian
                      matrix of twists about PLATFORM_MIDDLE with lengths divided by PLATFORM_REACH;
                      seldom less than a third of it */
  double alone;    /* no other pose with these values is nearer than this, as for `error` */
  int steps;       /* proved parts of the line */
  int tries;       /* parts tried, at most PLATFORM_TRIES */
} platform_report;

#define PLATFORM_REACH @REACH@ /* rotations by a radian count as this length */
#define PLATFORM_MIDDLE @MIDDLE@ /* a point of the platform */
#define PLATFORM_MARGIN @MARGIN@ /* values may leave their ranges by this part of the range */
#define PLATFORM_TRIES 48
#define PLATFORM_PIVOT @PIVOT@ /* a point of the platform: its shift counts in distances of poses, */
#define PLATFORM_TURN @TURN@ /* and a turn by a radian as this length */
#if HAS_HOME

/* A pose of the values in the file. */
#define PLATFORM_HOME @HOME@
#endif

enum {
  PLATFORM_PROVED = 0,     /* the pose is the continuation along the line of values */
  PLATFORM_NOT_FINITE = 1, /* an argument is not finite, or a quaternion is zero */
  PLATFORM_RANGE = 2,      /* a value is outside its range or cannot change, or a crank does not reach */
  PLATFORM_SINGULAR = 3,   /* refused: too near to a singular pose, here or ahead; or the distance of
                              two lines becomes zero, from where both sides are as good */
  PLATFORM_TRIES_SPENT = 4, /* refused: not proved in PLATFORM_TRIES tries: the line is too long */
  PLATFORM_NOT_FOUND = 5   /* no pose within the limits was found */
};

/* Values of a pose@HINT@. */
int platform_inverse(const platform_pose *pose, double values[6]);

/* Derivatives of the values by (omega, velocity of `position`) in the axes of the base. */
int platform_jacobian(const platform_pose *pose, const double values[6], double J[6][6]);

/* A state from a pose@ZERO@.
 * `report` may be null. Its sigma and alone are those of the pose; its fraction is 1, or 0 if the pose
 * is so nearly singular that no step from it can be proved. */
int platform_start(const platform_pose *pose, platform_state *state, platform_report *report);

/* Moves the state to these values. PROVED: for every value on the straight line between, exactly
 * one pose is near, it is not singular, and the new pose is its end. Otherwise the state is as
 * before. `report` may be null. */
int platform_forward(const double values[6], platform_state *state, platform_report *report);

/* Moves the state to the pose nearest to `given` that keeps all ranges and cones of the file, without
 * the margin. Distance: the shift of PLATFORM_PIVOT, and the turn times PLATFORM_TURN. PROVED: the state
 * is there, within the limits; a search found no nearer pose; straight lines of values lead there, as
 * for forward. Otherwise the state is the last pose on the way there that is proved and within the
 * limits; where it was, if there is none. */
int platform_nearest(const platform_pose *given, platform_state *state, platform_report *report);

/* What a status means, for people. */
const char *platform_text(int status);

#ifdef __cplusplus
}
#endif
#endif
