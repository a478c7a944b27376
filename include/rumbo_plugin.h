/*
 * The plugin ABI of Rumbo, major 1: planners, avoiders, localizers, map builders, SLAM and sensors in a shared library.
 *
 * Generated from core/src/boundary/abi; do not edit. RUMBO_UPDATE=1 cargo test --test boundary header writes it anew.
 *
 * A plugin in ten lines, a planner that goes straight:
 *
 *     #include "rumbo_plugin.h"
 *     static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
 *                           const rumbo_context *context, void **instance, rumbo_error *error)
 *     { (void)entry; (void)config; (void)context; (void)error; *instance = (void *)host; return RUMBO_OK; }
 *     static void destroy(void *instance) { (void)instance; }
 *     static int32_t plan(void *instance, const rumbo_call *call, const rumbo_plan_request *request,
 *                         rumbo_path_out *path, rumbo_error *error)
 *     { rumbo_push_point(path, request->start.x_m, request->start.y_m);
 *       rumbo_push_point(path, request->goal.x_m, request->goal.y_m);
 *       (void)instance; (void)call; (void)error; return RUMBO_OK; }
 *     static const rumbo_planner_table table = { sizeof table, destroy, plan };
 *     static const rumbo_entry straight = { .size = sizeof straight, .stage = RUMBO_PLANNER,
 *         .name = RUMBO_TEXT("straight"), .version = RUMBO_TEXT("1.0.0"), .summary = RUMBO_TEXT("Goes straight"),
 *         .table = &table, .create = create };
 *     RUMBO_PLUGINS("straight 1.0.0", &straight)
 *
 *     cc -std=c11 -O2 -shared -fPIC -fvisibility=hidden -I include straight.c -o libstraight.so -lm
 *     rumbo plugins list --plugin ./libstraight.so
 *
 * Rules:
 * - Every function answers a status: RUMBO_OK, or another one and the words for it in `error` (see rumbo_fail).
 * - Structs with a `size` grow at their end. Fill in `sizeof`; before you read a field that is younger than ABI 1.0 ask
 *   RUMBO_HAS. Structs without a `size` never change.
 * - What comes in is lent until the function returns, unless something else is said. Memory that one side allocated
 *   is freed by that side; only the host allocates blocks.
 * - Text is UTF-8 with a length. Angles are radians, counter-clockwise, unless the name says degrees.
 * - Instances are used by one thread at a time, not always the same. Never print, never exit, read no clock.
 * - No exception and no longjmp may leave a function; that is what RUMBO_CATCHES promises.
 */

#ifndef RUMBO_PLUGIN_H
#define RUMBO_PLUGIN_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* The mark of the symbol that a library exports. */
#if defined(_WIN32)
#define RUMBO_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define RUMBO_EXPORT __attribute__((visibility("default")))
#else
#define RUMBO_EXPORT
#endif

/* Things of the host, known by their address only. */

/* The header of a reference-counted array; its elements start 64 bytes further on. Only the host allocates blocks:
   `block_new`, `block_retain` and `block_release` of the host table make, keep and drop one. */
typedef struct rumbo_block rumbo_block;
/* The parameters that a pipeline gives, parsed by the host; for `config_...` of the host table. */
typedef struct rumbo_values rumbo_values;
/* A flag that long work looks at: `give_up_is_raised`; `give_up_retain` and `give_up_release` to keep it. */
typedef struct rumbo_give_up rumbo_give_up;
/* A random stream of one instance, for `random_...` of the host table; lives as long as the instance. */
typedef struct rumbo_rng rumbo_rng;
/* Debug drawings and counters of one call. */
typedef struct rumbo_trace rumbo_trace;
/* The world as a sensor may ask it. */
typedef struct rumbo_world rumbo_world;
/* Takes what a sensor sees, through `observe` of the host table. */
typedef struct rumbo_observations rumbo_observations;
/* The map, to be written: the host's own, through `map_take_...` and `map_put_...` of the host table. Take a layer,
   change it, put it back; what is taken and not put back is gone. */
typedef struct rumbo_map_mut rumbo_map_mut;

// The call did what it should.
#define RUMBO_OK 0

// It could not; `message` says why.
#define RUMBO_ERROR 1

// The plugin panicked (or threw): this instance is never called again but to destroy it.
#define RUMBO_PANIC 2

// A parameter is wrong: `path` names the key, `message` says what was found and expected.
#define RUMBO_BAD_CONFIG 3

// There is no such key, and no such thing.
#define RUMBO_MISSING 4

// The other side is too old for this.
#define RUMBO_UNSUPPORTED 5

// A message holds a number that must not go on.
#define RUMBO_BAD_NUMBER 6

// The map lacks a layer; `text` names it.
#define RUMBO_MISSING_LAYER 7

// Planner: the goal (`place`) lies outside the map.
#define RUMBO_GOAL_OUTSIDE 20

// Planner: the goal (`place`) is `text`: occupied or unknown.
#define RUMBO_GOAL_OCCUPIED 21

// Planner: the goal (`place`) is `values[0]` m from an obstacle, the planner keeps `values[1]` m.
#define RUMBO_GOAL_TOO_CLOSE 22

// Planner: the start (`place`) lies outside the map.
#define RUMBO_START_OUTSIDE 23

// Planner: the start (`place`) is `text`: occupied, unknown or too close.
#define RUMBO_START_OCCUPIED 24

// Planner: no way leads to the goal; `text` says what closes it.
#define RUMBO_UNREACHABLE 25

// Planner: its search ended at `place`; `text` says why.
#define RUMBO_STUCK 26

// Planner: `give_up` was raised.
#define RUMBO_GIVEN_UP 27

// Localizer and Slam: cannot start from what it is told; `text` says what it needs.
#define RUMBO_BAD_PRIOR 40

// Localizer: it was not started.
#define RUMBO_NOT_STARTED 41

// Localizer: it needs the robot to move; `text` says how.
#define RUMBO_NEEDS_MOTION 42

// Slam: it has no saved form.
#define RUMBO_CANNOT_SAVE 43

// Slam: it cannot be told where the robot is once it has begun (since 1.1).
#define RUMBO_CANNOT_RELOCATE 44

// Avoider: no reading of the kind `text` for `values[0]` s.
#define RUMBO_NO_READING 60

// Sensor: the device `path` does not answer; `text` says why.
#define RUMBO_DEVICE 80

// Sensor: it has inputs but derives nothing.
#define RUMBO_NOT_VIRTUAL 81

// Sensor: the world cannot answer the probe.
#define RUMBO_NO_ANSWER 82

// Map builder: the file `path` cannot be read; `text` says why.
#define RUMBO_MAP_FILE 100

// First bytes of every module record: "RUMBOPLG".
#define RUMBO_MAGIC 5137569576267896146

// Major of this ABI: changes when an old plugin can no longer be loaded.
#define RUMBO_ABI_MAJOR 1

// Minor of this ABI: goes up when something is appended.
#define RUMBO_ABI_MINOR 1

// Flag of a module: panics and exceptions are caught inside. A library without it is refused.
#define RUMBO_CATCHES 1

// Stage of an entry: `rumbo_sensor_table`.
#define RUMBO_SENSOR 1

// Stage of an entry: `rumbo_map_builder_table`.
#define RUMBO_MAP_BUILDER 2

// Stage of an entry: `rumbo_localizer_table`.
#define RUMBO_LOCALIZER 3

// Stage of an entry: `rumbo_slam_table`.
#define RUMBO_SLAM 4

// Stage of an entry: `rumbo_planner_table`.
#define RUMBO_PLANNER 5

// Stage of an entry: `rumbo_avoider_table`.
#define RUMBO_AVOIDER 6

// Bit of a map layer: occupancy of cells.
#define RUMBO_LAYER_GRID 1

// Bit of a map layer: wall lines.
#define RUMBO_LAYER_LINES 2

// Bit of a map layer: points that can be recognized.
#define RUMBO_LAYER_LANDMARKS 4

// Bit of a map layer: occupancy in space.
#define RUMBO_LAYER_VOXELS 8

// Drive with two driven wheels; bit 0 of `drives`.
#define RUMBO_DIFFERENTIAL 0

// Drive with one steered wheel; bit 1 of `drives`.
#define RUMBO_TRICYCLE 1

// Drive that moves every way; bit 2 of `drives`.
#define RUMBO_OMNIDIRECTIONAL 2

// Groups of observation kinds at most in a manifest.
#define RUMBO_MOST_CONSUMED 8

// `data` is a `rumbo_odometry`.
#define RUMBO_ODOMETRY 0

// `data` is a `rumbo_wheel_speeds`.
#define RUMBO_WHEEL_SPEEDS 1

// `data` is a `rumbo_steering_angle`.
#define RUMBO_STEERING_ANGLE 2

// `data` is a `rumbo_laser_scan`.
#define RUMBO_LASER_SCAN 3

// `data` is a `rumbo_range_ring`.
#define RUMBO_RANGE_RING 4

// `data` is a `rumbo_bumpers`.
#define RUMBO_BUMPERS 5

// `data` is a `rumbo_depth_image`.
#define RUMBO_DEPTH_IMAGE 6

// `data` is a `rumbo_point_cloud`.
#define RUMBO_POINT_CLOUD 7

// `data` is a `rumbo_imu`.
#define RUMBO_IMU 8

// `data` is a `rumbo_position_fix`.
#define RUMBO_POSITION_FIX 9

// `data` is a `rumbo_marks`.
#define RUMBO_MARKS 10

// `data` is a `rumbo_custom`.
#define RUMBO_CUSTOM 11

// Status of an estimate: no idea where the robot is.
#define RUMBO_LOST 0

// Status of an estimate: on the way to one answer.
#define RUMBO_CONVERGING 1

// Status of an estimate: one answer, kept up to date.
#define RUMBO_TRACKING 2

// Status of an estimate: several places fit.
#define RUMBO_AMBIGUOUS 3

// No wish.
#define RUMBO_WISH_NONE 0

// It would help to stand still.
#define RUMBO_WISH_HOLD_STILL 1

// It would help to turn by `wish` radians.
#define RUMBO_WISH_TURN_BY 2

// It would help to drive ahead by `wish` meters.
#define RUMBO_WISH_MOVE_BY 3

// Steering: drive with `twist`.
#define RUMBO_DRIVE 0

// Steering: stop, something is in the way; push what it is into the obstacles of the call.
#define RUMBO_BLOCKED 1

// Steering: the end of the path is reached.
#define RUMBO_ARRIVED 2

// The robot may be anywhere.
#define RUMBO_PRIOR_UNKNOWN 0

// The robot is about here.
#define RUMBO_PRIOR_POSE 1

// What the same plugin saved before.
#define RUMBO_PRIOR_SAVED 2

// Probe: exact distances along beams; the answer is `RUMBO_ANSWER_RANGES`.
#define RUMBO_PROBE_BEAMS 0

// Probe: nearest echo in cones; the answer is `RUMBO_ANSWER_RANGES`.
#define RUMBO_PROBE_CONES 1

// Probe: a depth picture; the answer is `RUMBO_ANSWER_RANGES`.
#define RUMBO_PROBE_DEPTH 2

// Probe: how far the wheels have turned.
#define RUMBO_PROBE_WHEELS 3

// Probe: attitude, rates, accelerations.
#define RUMBO_PROBE_ATTITUDE 4

// Probe: the position in the map's frame.
#define RUMBO_PROBE_POSITION 5

// Probe: where the hull touches something.
#define RUMBO_PROBE_CONTACTS 6

// Probe: marks in view.
#define RUMBO_PROBE_MARKS 7

// Probe: what was recorded under `name` since the last such probe.
#define RUMBO_PROBE_CHANNEL 8

// Probe: where the person called `name` is in the map's frame; the answer is `RUMBO_ANSWER_POSITION`.
#define RUMBO_PROBE_PERSON 9

// Answer: `ranges`.
#define RUMBO_ANSWER_RANGES 0

// Answer: `rolled_m` and what follows it.
#define RUMBO_ANSWER_WHEELS 1

// Answer: `attitude_rad`, `rates_rad_s`, `accelerations_m_s2`.
#define RUMBO_ANSWER_ATTITUDE 2

// Answer: `position_m`.
#define RUMBO_ANSWER_POSITION 3

// Answer: `contacts_rad`.
#define RUMBO_ANSWER_CONTACTS 4

// Answer: `marks`.
#define RUMBO_ANSWER_MARKS 5

// Answer: `recorded`.
#define RUMBO_ANSWER_RECORDED 6

// Answer: read your own device.
#define RUMBO_ANSWER_LIVE 7

// Level of a message: something is wrong.
#define RUMBO_LOG_ERROR 1

// Level of a message: something is odd.
#define RUMBO_LOG_WARN 2

// Level of a message: worth knowing.
#define RUMBO_LOG_INFO 3

// Level of a message: for the author.
#define RUMBO_LOG_DEBUG 4

// Text in UTF-8, not ended by a zero; `data` may be null where `len` is 0.
typedef struct rumbo_str {
    // First byte.
    const char *data;
    // Number of bytes.
    size_t len;
} rumbo_str;

// A point of the map, meters.
typedef struct rumbo_point {
    // x, meters.
    double x_m;
    // y, meters.
    double y_m;
} rumbo_point;

// Why a call did not end with `RUMBO_OK`, filled in by the side that was called. Texts end with a zero; what does not
// fit is cut off.
typedef struct rumbo_error {
    // Bytes of this struct.
    size_t size;
    // A place in the map, where the status has one.
    struct rumbo_point place;
    // Numbers, where the status has some.
    double values[2];
    // The key, device or file at fault, such as `weights[2]`; empty for none.
    char path[256];
    // The word or reason that the status asks for.
    char text[512];
    // What was found and what was expected, for people.
    char message[1024];
    // What to do; may be empty.
    char help[512];
} rumbo_error;

// A pose in the plane. The heading as cosine and sine, so that nothing is rounded on the way.
typedef struct rumbo_pose2 {
    // x, meters.
    double x_m;
    // y, meters.
    double y_m;
    // Cosine of the heading.
    double cos_yaw;
    // Sine of the heading.
    double sin_yaw;
} rumbo_pose2;

// A pose in space: a position and a unit quaternion.
typedef struct rumbo_pose3 {
    // x, y, z, meters.
    double position_m[3];
    // i, j, k, w of a unit quaternion.
    double quaternion[4];
} rumbo_pose3;

// Velocity of the base in its own frame.
typedef struct rumbo_twist {
    // Ahead, m/s.
    double forward_m_s;
    // To the left, m/s; zero for robots that cannot.
    double left_m_s;
    // Counter-clockwise, rad/s.
    double turn_rad_s;
} rumbo_twist;

// A shared array of `float`. As an input it is lent: retain `block` to keep it longer than the call. As an output its
// reference is given away; with a null `block` the host copies `len` elements from `data`.
typedef struct rumbo_f32_array {
    // The block that holds the elements; null for none.
    rumbo_block *block;
    // Number of elements.
    size_t len;
    // The elements.
    const float *data;
} rumbo_f32_array;

// A shared array of `uint16_t`, as `rumbo_f32_array`.
typedef struct rumbo_u16_array {
    // The block that holds the elements; null for none.
    rumbo_block *block;
    // Number of elements.
    size_t len;
    // The elements.
    const uint16_t *data;
} rumbo_u16_array;

// A shared array of bytes, as `rumbo_f32_array`.
typedef struct rumbo_u8_array {
    // The block that holds the elements; null for none.
    rumbo_block *block;
    // Number of elements.
    size_t len;
    // The elements.
    const uint8_t *data;
} rumbo_u8_array;

// A shared array of points x, y, z in `float`, as `rumbo_f32_array`.
typedef struct rumbo_point3_array {
    // The block that holds the elements; null for none.
    rumbo_block *block;
    // Number of points.
    size_t len;
    // The points.
    const float (*data)[3];
} rumbo_point3_array;

// The parameters of one plugin: as text, and through `config_...` of the host table.
typedef struct rumbo_config {
    // Bytes of this struct.
    size_t size;
    // The plugin's own keys as a TOML document.
    struct rumbo_str toml;
    // The same with the defaults, for the accessors.
    const rumbo_values *values;
} rumbo_config;

// A pinhole camera without distortion.
typedef struct rumbo_intrinsics {
    // Columns.
    uint32_t width;
    // Rows.
    uint32_t height;
    // Focal lengths, pixels.
    double focal_px[2];
    // Where the optical axis meets the picture, pixels.
    double center_px[2];
} rumbo_intrinsics;

// What a sensor asks the world; fields that the kind does not name are ignored.
typedef struct rumbo_probe {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_PROBE_BEAMS`, ...
    uint32_t kind;
    // Beams: how many.
    uint32_t n_beams;
    // The mount (beams, cones, depth, marks).
    struct rumbo_pose3 base_from_sensor;
    // Beams: bearing of the first, radians.
    double first_bearing_rad;
    // Beams: from one to the next, radians.
    double bearing_step_rad;
    // Beyond this nothing is seen, meters (beams, cones, depth, marks).
    double max_range_m;
    // Cones: how many.
    size_t n_cones;
    // Cones: bearing of each axis, radians.
    const double *bearings_rad;
    // Cones: full opening, radians.
    double cone_rad;
    // Cones: distance of the transducers from the mount, meters.
    double ring_radius_m;
    // Depth: the camera.
    struct rumbo_intrinsics intrinsics;
    // Marks: full field of view, radians.
    double field_of_view_rad;
    // Channel, person: its name.
    struct rumbo_str name;
} rumbo_probe;

// One recognized mark.
typedef struct rumbo_mark {
    // 1 where `identity` is known.
    uint32_t has_identity;
    // Which mark.
    uint32_t identity;
    // Distance in the plane, meters.
    double range_m;
    // Direction in the sensor's frame, radians.
    double bearing_rad;
} rumbo_mark;

// Marks recognized at one time.
typedef struct rumbo_marks {
    // Bytes of this struct.
    size_t size;
    // Number of marks.
    size_t len;
    // The marks.
    const struct rumbo_mark *marks;
    // Standard deviation of the range, meters.
    double range_deviation_m;
    // Standard deviation of the bearing, radians.
    double bearing_deviation_rad;
} rumbo_marks;

// One reading of one sensor. Skip kinds that you do not know.
typedef struct rumbo_observation {
    // Bytes of this struct.
    size_t size;
    // When it was seen, nanoseconds.
    int64_t stamp_ns;
    // One of `RUMBO_ODOMETRY`, `RUMBO_LASER_SCAN`, ...
    uint32_t kind;
    // Which sensor of the pipeline, in the order of the file; the host overwrites what a sensor says here.
    uint16_t sensor;
    // 1 where the device stands by this reading.
    uint8_t valid;
    // 0.
    uint8_t reserved;
    // Where the sensor sat on the robot.
    struct rumbo_pose3 base_from_sensor;
    // The reading: a struct that `kind` names.
    const void *data;
} rumbo_observation;

// Everything since the last call, oldest stamp first: element `k` is `stride` bytes times `k` behind `first`.
typedef struct rumbo_seen {
    // Bytes of this struct.
    size_t size;
    // Number of observations.
    size_t len;
    // Bytes from one to the next.
    size_t stride;
    // The oldest.
    const struct rumbo_observation *first;
} rumbo_seen;

// What the world answers. Pointers hold until the next probe or the end of the call.
typedef struct rumbo_answer {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_ANSWER_RANGES`, ...
    uint32_t kind;
    // Wheels: how many of `rolled_m` are used.
    uint32_t n_wheels;
    // Number of ranges.
    size_t n_ranges;
    // One distance each, meters; infinite where nothing is within reach.
    const float *ranges_m;
    // Distance rolled by each wheel, meters.
    double rolled_m[4];
    // Turn of an omnidirectional base, radians.
    double turned_rad;
    // Steering angle, radians.
    double steering_rad;
    // Velocity of the base as its wheels have it.
    struct rumbo_twist twist;
    // Roll, pitch, yaw, radians.
    double attitude_rad[3];
    // Turning rates, rad/s.
    double rates_rad_s[3];
    // Specific force, m/s².
    double accelerations_m_s2[3];
    // x, y, z in the map's frame, meters.
    double position_m[3];
    // Number of contacts.
    size_t n_contacts;
    // Bearings of contacts in the base frame, radians.
    const double *contacts_rad;
    // Marks, exact; else null.
    const struct rumbo_marks *marks;
    // Recorded observations, oldest first; else null.
    const struct rumbo_seen *recorded;
} rumbo_answer;

// A grid of log-odds in rows, row 0 at the bottom.
typedef struct rumbo_grid {
    // Bytes of this struct.
    size_t size;
    // Cells along x.
    uint32_t width;
    // Cells along y.
    uint32_t height;
    // Edge of a cell, meters.
    double resolution_m;
    // The lower left corner in the map's frame: x and y in meters, turn in radians.
    double origin[3];
    // A cell with more log-odds than this is occupied.
    float occupied_above;
    // A cell with less log-odds than this is free; between the two it is unknown.
    float free_below;
    // `width` times `height` cells.
    struct rumbo_f32_array cells;
} rumbo_grid;

// A straight piece of wall.
typedef struct rumbo_line {
    // One end in the map's frame, meters.
    double from[2];
    // The other end.
    double to[2];
    // Covariance of the normal form: distance (m²), distance and angle (m·rad), angle (rad²).
    double covariance[3];
} rumbo_line;

// A shared array of lines, as `rumbo_f32_array`.
typedef struct rumbo_line_array {
    // The block that holds the elements; null for none.
    rumbo_block *block;
    // Number of lines.
    size_t len;
    // The lines.
    const struct rumbo_line *data;
} rumbo_line_array;

// A point that can be recognized.
typedef struct rumbo_landmark {
    // Which one it is.
    uint32_t identity;
    // What kind of thing it is.
    uint32_t kind;
    // Where it is in the map's frame, meters.
    double position[2];
    // Covariance xx, xy, yy, m².
    double covariance[3];
} rumbo_landmark;

// A shared array of landmarks, as `rumbo_f32_array`.
typedef struct rumbo_landmark_array {
    // The block that holds the elements; null for none.
    rumbo_block *block;
    // Number of landmarks.
    size_t len;
    // The landmarks.
    const struct rumbo_landmark *data;
} rumbo_landmark_array;

// A cube of 16 x 16 x 16 voxels.
typedef struct rumbo_voxel_chunk {
    // Which cube, counted in cubes from the origin.
    int32_t index[3];
    // 0.
    int32_t reserved;
    // Log-odds, x fastest, then y, then z.
    struct rumbo_f32_array log_odds;
} rumbo_voxel_chunk;

// The host's functions; they may be called from any thread unless they take what a call handed over. Lives as long as
// the program.
typedef struct rumbo_host {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_ABI_MAJOR` of the host.
    uint32_t abi_major;
    // `RUMBO_ABI_MINOR` of the host.
    uint32_t abi_minor;
    // Says something to people: level, who, what.
    void (*log)(uint32_t level, struct rumbo_str target, struct rumbo_str message);
    // A fresh block for `bytes` bytes of elements, with one reference; null where there is no memory.
    rumbo_block *(*block_new)(size_t bytes);
    // Keeps a block.
    void (*block_retain)(rumbo_block *block);
    // Drops a block.
    void (*block_release)(rumbo_block *block);
    // The array for writing; copied first if anybody else holds it. Null where there is no memory.
    float *(*make_mut_f32)(struct rumbo_f32_array *array);
    // A number of the parameters (whole numbers too): `RUMBO_OK`, `RUMBO_MISSING` or `RUMBO_BAD_CONFIG`. Paths such as
    // `weights[2]` or `limits.speed_m_s`.
    int32_t (*config_f64)(const struct rumbo_config *config, struct rumbo_str path, double *out);
    // A whole number of the parameters.
    int32_t (*config_i64)(const struct rumbo_config *config, struct rumbo_str path, int64_t *out);
    // True (1) or false (0) of the parameters.
    int32_t (*config_bool)(const struct rumbo_config *config, struct rumbo_str path, uint32_t *out);
    // A text of the parameters, valid as long as they are.
    int32_t (*config_str)(const struct rumbo_config *config, struct rumbo_str path, struct rumbo_str *out);
    // How many elements the array there has.
    int32_t (*config_len)(const struct rumbo_config *config, struct rumbo_str path, size_t *out);
    // 64 random bits.
    uint64_t (*random_u64)(rumbo_rng *rng);
    // A number from [0, 1).
    double (*random_uniform)(rumbo_rng *rng);
    // A number of the standard normal distribution.
    double (*random_normal)(rumbo_rng *rng);
    // 1 when somebody asked to stop.
    uint32_t (*give_up_is_raised)(const rumbo_give_up *flag);
    // Keeps a flag longer than the call.
    void (*give_up_retain)(const rumbo_give_up *flag);
    // Drops a flag that was kept.
    void (*give_up_release)(const rumbo_give_up *flag);
    // Draws a chain of straight pieces.
    void (*draw_polyline)(rumbo_trace *trace,
                          struct rumbo_str name,
                          const struct rumbo_point *points,
                          size_t len);
    // Draws points.
    void (*draw_points)(rumbo_trace *trace,
                        struct rumbo_str name,
                        const struct rumbo_point *points,
                        size_t len);
    // Shows a number.
    void (*count)(rumbo_trace *trace, struct rumbo_str name, double value);
    // The time of the world, nanoseconds.
    int64_t (*world_now_ns)(const rumbo_world *world);
    // 1 where time passes by itself.
    uint32_t (*world_is_real_time)(const rumbo_world *world);
    // Asks the world: `RUMBO_OK` and the answer, or `RUMBO_NO_ANSWER` and a text in `why` that holds until the next
    // probe.
    int32_t (*probe)(rumbo_world *world,
                     const struct rumbo_probe *probe,
                     struct rumbo_answer *answer,
                     struct rumbo_str *why);
    // A pooled array of zeros for ranges.
    struct rumbo_f32_array (*lend_f32)(rumbo_observations *out, size_t len);
    // A pooled array of zeros for depths.
    struct rumbo_u16_array (*lend_u16)(rumbo_observations *out, size_t len);
    // A pooled array of zeros for points.
    struct rumbo_point3_array (*lend_point3)(rumbo_observations *out, size_t len);
    // Adds an observation. References of its arrays are given away: `RUMBO_OK`, or `RUMBO_BAD_NUMBER` where the
    // struct does not hold together, `RUMBO_UNSUPPORTED` where the host does not know its kind; the whole call fails
    // then.
    int32_t (*observe)(rumbo_observations *out, const struct rumbo_observation *observation);
    // Version of the map.
    uint64_t (*map_version)(const rumbo_map_mut *map);
    // Says that a layer changed: sets the version.
    void (*map_set_version)(rumbo_map_mut *map, uint64_t version);
    // Number of coarser grids.
    size_t (*map_n_coarse)(const rumbo_map_mut *map);
    // Takes the grid (level 0) or the last of the coarser ones (level 1) with its reference; `RUMBO_MISSING` where
    // there is none.
    int32_t (*map_take_grid)(rumbo_map_mut *map, uint32_t level, struct rumbo_grid *grid);
    // Puts the grid (level 0), or one more coarser grid (level 1) behind the others.
    int32_t (*map_put_grid)(rumbo_map_mut *map, uint32_t level, const struct rumbo_grid *grid);
    // Takes the lines.
    int32_t (*map_take_lines)(rumbo_map_mut *map, struct rumbo_line_array *lines);
    // Puts the lines.
    int32_t (*map_put_lines)(rumbo_map_mut *map, const struct rumbo_line_array *lines);
    // Takes the landmarks.
    int32_t (*map_take_landmarks)(rumbo_map_mut *map, struct rumbo_landmark_array *landmarks);
    // Puts the landmarks.
    int32_t (*map_put_landmarks)(rumbo_map_mut *map, const struct rumbo_landmark_array *landmarks);
    // Resolution and origin (x, y, z) of the voxels.
    int32_t (*map_voxels)(const rumbo_map_mut *map, double *resolution_m, double *origin, size_t *n_chunks);
    // Takes the last cube of the voxels.
    int32_t (*map_take_chunk)(rumbo_map_mut *map, struct rumbo_voxel_chunk *chunk);
    // Makes an empty voxel layer in place of the one that was there.
    int32_t (*map_new_voxels)(rumbo_map_mut *map, double resolution_m, const double *origin);
    // Puts one more cube behind the others.
    int32_t (*map_put_chunk)(rumbo_map_mut *map, const struct rumbo_voxel_chunk *chunk);
    // Removes a layer (`RUMBO_LAYER_GRID`, ...).
    void (*map_remove)(rumbo_map_mut *map, uint32_t layer);
} rumbo_host;

// The robot.
typedef struct rumbo_robot {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_DIFFERENTIAL`, ...
    uint32_t drive;
    // 1 where the guard watches the stop zone.
    uint32_t guard_stop_zone;
    // Distance between the wheels, meters (differential, tricycle).
    double track_m;
    // Tricycle: from the fixed axle to the steered wheel, meters.
    double wheelbase_m;
    // Tricycle: largest steering angle, degrees.
    double max_steer_deg;
    // Tricycle: largest steering rate, deg/s.
    double max_steer_rate_deg_s;
    // Radius of a round hull, meters.
    double radius_m;
    // Corners of the hull; 0 for a round one.
    size_t n_corners;
    // The corners in the base frame, meters.
    const struct rumbo_point *corners;
    // Height, meters.
    double height_m;
    // Top speed, m/s.
    double max_speed_m_s;
    // Top turning rate, deg/s.
    double max_turn_deg_s;
    // Top acceleration, m/s².
    double max_accel_m_s2;
    // Top turning acceleration, deg/s².
    double max_turn_accel_deg_s2;
    // Deceleration when stopping, m/s².
    double braking_m_s2;
    // The guard's distance from obstacles, meters.
    double guard_margin_m;
    // The guard's reaction time, seconds.
    double guard_latency_s;
    // Age at which data are stale, seconds.
    double guard_stale_after_s;
    // Tricycle: 1 where the steered wheel is behind the axle (since 1.1).
    uint32_t is_steered_behind;
    // 0.
    uint32_t reserved;
} rumbo_robot;

// What an instance may know when it is made.
typedef struct rumbo_context {
    // Bytes of this struct.
    size_t size;
    // Name of the instance: the sensor's, else the section's.
    struct rumbo_str name;
    // Which sensor this is, in the order of the file; 0 for other stages.
    uint16_t sensor;
    // 1 for a check only: touch no device and start no thread.
    uint8_t dry_run;
    // 1 where slow work runs on threads of its own: time passes by itself.
    uint8_t is_threaded;
    // Layers that some stage of the pipeline needs: `RUMBO_LAYER_GRID | ...`.
    uint32_t wanted_layers;
    // The robot.
    const struct rumbo_robot *robot;
    // Where a sensor sits.
    struct rumbo_pose3 base_from_sensor;
    // How often the stage will run, Hz; not-a-number where the engine decides.
    double rate_hz;
    // Seed of the run.
    uint64_t seed;
    // This instance's random stream.
    rumbo_rng *rng;
    // Folder that relative paths start from.
    struct rumbo_str folder;
    // The map that belongs to the world; empty for none.
    struct rumbo_str world_map;
    // The recording that the world plays; empty for none.
    struct rumbo_str world_recording;
    // Time that inline background work takes, nanoseconds.
    int64_t latency_ns;
    // Raised when all work shall stop; lives as long as the instance.
    const rumbo_give_up *abort;
} rumbo_context;

// What a plugin needs and gives. The host hands it over with nothing needed and every drive steered.
typedef struct rumbo_manifest {
    // Bytes of this struct.
    size_t size;
    // Layers that it reads: `RUMBO_LAYER_GRID | ...`.
    uint32_t needs_layers;
    // Layers that it writes.
    uint32_t gives_layers;
    // Kinds that it makes: bit `RUMBO_LASER_SCAN`, ...
    uint32_t produces;
    // Drives that it can steer or plan for: bit `RUMBO_DIFFERENTIAL`, ...
    uint32_t drives;
    // How many of `consumes` are used.
    uint32_t n_consumes;
    // Kinds that it cannot do without: of each group at least one.
    uint32_t consumes[RUMBO_MOST_CONSUMED];
    // It writes on top of layers that another builder gives.
    uint8_t overlays;
    // It derives its observations from other sensors'.
    uint8_t is_virtual;
    // It cannot find a robot whose pose nobody names.
    uint8_t needs_start_pose;
    // It asks for motion while it looks for the robot.
    uint8_t wishes_motion;
    // How often it runs when the pipeline does not say, Hz; not-a-number for no wish.
    double default_rate_hz;
    // The fastest that it can do, Hz; not-a-number for no limit.
    double max_rate_hz;
    // Kinds that it takes where some sensor makes them, and does without where none does (since 1.1).
    uint32_t uses;
    // 0.
    uint32_t reserved;
    // How wide a range sensor sees to its sides, radians in all; not-a-number of what has no such view (since 1.1).
    double field_of_view_rad;
} rumbo_manifest;

// Takes faults of parameters.
typedef struct rumbo_fault_out {
    // Bytes of this struct.
    size_t size;
    // For `push`.
    void *ctx;
    // Adds a fault: the key (`weights[2]`; empty for the whole section), what is wrong, what to do (may be empty).
    void (*push)(void *ctx, struct rumbo_str path, struct rumbo_str message, struct rumbo_str help);
} rumbo_fault_out;

// Takes text or bytes.
typedef struct rumbo_bytes_out {
    // Bytes of this struct.
    size_t size;
    // For `push`.
    void *ctx;
    // Appends bytes.
    void (*push)(void *ctx, struct rumbo_str bytes);
} rumbo_bytes_out;

// One plugin of a library.
typedef struct rumbo_entry {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_PLANNER`, ...
    uint32_t stage;
    // 0.
    uint32_t reserved;
    // Its name in a pipeline: lower case letters, digits and `_`.
    struct rumbo_str name;
    // Its version.
    struct rumbo_str version;
    // What it is, in one line.
    struct rumbo_str summary;
    // JSON schema of its parameters (draft 2020-12), with their defaults, limits and descriptions; empty for none.
    struct rumbo_str schema_json;
    // All parameters at their defaults as TOML; where it is empty the schema's `default`s count.
    struct rumbo_str defaults_toml;
    // For the library's own use.
    const void *user;
    // Functions of the stage: `rumbo_planner_table`, ...
    const void *table;
    // Makes an instance; may be called from any thread.
    int32_t (*create)(const struct rumbo_entry *entry,
                      const struct rumbo_host *host,
                      const struct rumbo_config *config,
                      const struct rumbo_context *context,
                      void **instance,
                      struct rumbo_error *error);
    // Says what it needs and gives with these parameters; null where that is nothing.
    int32_t (*manifest)(const struct rumbo_entry *entry,
                        const struct rumbo_config *config,
                        struct rumbo_manifest *manifest,
                        struct rumbo_error *error);
    // Reads the parameters: `RUMBO_BAD_CONFIG` where they cannot be understood, else `RUMBO_OK` and every impossible
    // value into `faults`. Null where the schema says it all.
    int32_t (*check)(const struct rumbo_entry *entry,
                     const struct rumbo_config *config,
                     struct rumbo_fault_out *faults,
                     struct rumbo_error *error);
    // Writes all parameters, defaults included, as TOML. Null where the schema's `default`s say it all.
    int32_t (*parameters)(const struct rumbo_entry *entry,
                          const struct rumbo_config *config,
                          struct rumbo_bytes_out *text,
                          struct rumbo_error *error);
} rumbo_entry;

// The record that the entry function returns; it lives as long as the library.
typedef struct rumbo_module {
    // `RUMBO_MAGIC`.
    uint64_t magic;
    // Bytes of this struct.
    size_t size;
    // `RUMBO_ABI_MAJOR` of the header that the plugin was built with.
    uint32_t abi_major;
    // `RUMBO_ABI_MINOR` of that header.
    uint32_t abi_minor;
    // `RUMBO_CATCHES`, ...
    uint64_t flags;
    // Compiler and versions: told, never compared.
    struct rumbo_str build_info;
    // Number of entries.
    size_t n_entries;
    // The entries, with a null pointer behind the last.
    const struct rumbo_entry *const *entries;
} rumbo_module;

// Type of the only symbol that a library exports, `rumbo_plugin_entry_v1`; null says that it cannot work with this
// host. Only the record behind the answer is read before it is checked.
typedef const struct rumbo_module *(*rumbo_plugin_entry)(const struct rumbo_host *host);

// Occupancy in space.
typedef struct rumbo_voxels {
    // Bytes of this struct.
    size_t size;
    // Edge of a voxel, meters.
    double resolution_m;
    // Lower corner of voxel (0, 0, 0) in the map's frame, meters.
    double origin[3];
    // Number of cubes.
    size_t n_chunks;
    // The cubes.
    const struct rumbo_voxel_chunk *chunks;
} rumbo_voxels;

// The map, to be read. Layers that are not there are null.
typedef struct rumbo_map {
    // Bytes of this struct.
    size_t size;
    // Goes up with every change.
    uint64_t version;
    // Occupancy of cells.
    const struct rumbo_grid *grid;
    // Number of coarser grids.
    size_t n_coarse;
    // Bytes from one coarser grid to the next.
    size_t coarse_stride;
    // The same area at twice, four times, ... the cell's edge.
    const struct rumbo_grid *coarse;
    // Wall lines.
    const struct rumbo_line_array *lines;
    // Points that can be recognized.
    const struct rumbo_landmark_array *landmarks;
    // Occupancy in space.
    const struct rumbo_voxels *voxels;
} rumbo_map;

// Where the wheels say the base is, seen from where it started.
typedef struct rumbo_odometry {
    // Bytes of this struct.
    size_t size;
    // The base in the odometer's frame.
    struct rumbo_pose2 odom_from_base;
    // Velocity of the base.
    struct rumbo_twist twist;
    // Standard deviations that grow: distance (m/m), direction (rad/m), turn (rad/rad).
    double noise[3];
} rumbo_odometry;

// Rolling speeds of at most four wheels.
typedef struct rumbo_wheel_speeds {
    // Bytes of this struct.
    size_t size;
    // How many are used.
    uint32_t n_wheels;
    // 0.
    uint32_t reserved;
    // Speed of each rim over the floor, m/s.
    double rim_m_s[4];
} rumbo_wheel_speeds;

// Angle of the steered wheel.
typedef struct rumbo_steering_angle {
    // Bytes of this struct.
    size_t size;
    // Counter-clockwise from straight ahead, radians.
    double angle_rad;
} rumbo_steering_angle;

// A planar scan. Finite ranges are hits, infinity is nothing within reach, not-a-number no reading (REP-117).
typedef struct rumbo_laser_scan {
    // Bytes of this struct.
    size_t size;
    // Bearing of the first beam in the sensor's frame, radians.
    double first_bearing_rad;
    // Bearing from one beam to the next, radians.
    double bearing_step_rad;
    // Time from the first beam to the last, seconds.
    double sweep_s;
    // Shorter ranges are not readings, meters.
    float min_range_m;
    // Reach of the device, meters.
    float max_range_m;
    // One range a beam, meters.
    struct rumbo_f32_array ranges_m;
    // One intensity a beam, or none at all.
    struct rumbo_f32_array intensities;
} rumbo_laser_scan;

// Single ranges around the hull, each a cone.
typedef struct rumbo_range_ring {
    // Bytes of this struct.
    size_t size;
    // Bearing of the first cone's axis, radians.
    double first_bearing_rad;
    // Bearing from one axis to the next, radians.
    double bearing_step_rad;
    // Full opening of a cone, radians.
    double cone_rad;
    // Distance of the transducers from the ring's center, meters.
    double ring_radius_m;
    // Shorter ranges are not readings, meters.
    float min_range_m;
    // Reach, meters.
    float max_range_m;
    // One range a transducer, meters.
    struct rumbo_f32_array ranges_m;
} rumbo_range_ring;

// Touch sensors around the hull.
typedef struct rumbo_bumpers {
    // Bytes of this struct.
    size_t size;
    // Bit `k` is set while bumper `k` touches something.
    uint64_t pressed;
    // Bearing of bumper 0, radians.
    double first_bearing_rad;
    // Bearing from one bumper to the next, radians.
    double bearing_step_rad;
    // Distance of the bumpers from the ring's center, meters.
    double ring_radius_m;
    // How many there are, at most 64.
    uint32_t n_bumpers;
    // 0.
    uint32_t reserved;
} rumbo_bumpers;

// A depth picture, row 0 on top.
typedef struct rumbo_depth_image {
    // Bytes of this struct.
    size_t size;
    // The camera.
    struct rumbo_intrinsics intrinsics;
    // Meters of one count.
    float unit_m;
    // 0.
    uint32_t reserved;
    // Counts, row by row; 0 is no reading.
    struct rumbo_u16_array depth;
} rumbo_depth_image;

// Points in the sensor's frame.
typedef struct rumbo_point_cloud {
    // Bytes of this struct.
    size_t size;
    // x, y, z, meters.
    struct rumbo_point3_array points_m;
} rumbo_point_cloud;

// Attitude, turning rates and specific force.
typedef struct rumbo_imu {
    // Bytes of this struct.
    size_t size;
    // 1 where `attitude_rad` is given.
    uint32_t has_attitude;
    // 0.
    uint32_t reserved;
    // Roll, pitch, yaw, radians.
    double attitude_rad[3];
    // Turning rates about x, y, z, rad/s.
    double rates_rad_s[3];
    // Specific force along x, y, z, m/s².
    double accelerations_m_s2[3];
} rumbo_imu;

// A position in the map's frame from outside the robot.
typedef struct rumbo_position_fix {
    // Bytes of this struct.
    size_t size;
    // x, y, z, meters.
    double position_m[3];
    // Standard deviation along each axis, meters.
    double deviation_m[3];
} rumbo_position_fix;

// A message of a third party's own kind.
typedef struct rumbo_custom {
    // Bytes of this struct.
    size_t size;
    // Name of the schema, `vendor/Kind`.
    struct rumbo_str schema;
    // The message.
    struct rumbo_u8_array bytes;
} rumbo_custom;

// What every call gets.
typedef struct rumbo_call {
    // Bytes of this struct.
    size_t size;
    // The time it is, nanoseconds: the only clock a plugin may read.
    int64_t now_ns;
    // Where to draw.
    rumbo_trace *trace;
    // 1 while somebody looks at drawings and counters.
    uint32_t is_watched;
    // 0.
    uint32_t reserved;
} rumbo_call;

// A place that fits what was seen.
typedef struct rumbo_candidate {
    // The place.
    struct rumbo_pose2 map_from_base;
    // How well it fits; all scores of one estimate sum to 1.
    double score;
} rumbo_candidate;

// Where the robot is.
typedef struct rumbo_estimate {
    // Bytes of this struct.
    size_t size;
    // The time this is true for, nanoseconds.
    int64_t stamp_ns;
    // The correction of the odometer.
    struct rumbo_pose3 map_from_odom;
    // The robot.
    struct rumbo_pose3 map_from_base;
    // Covariance of x, y, z, roll, pitch, yaw in the map's axes, row by row.
    double covariance[36];
    // `RUMBO_TRACKING`, ...
    uint32_t status;
    // `RUMBO_WISH_NONE`, ...
    uint32_t wish_kind;
    // How far, radians or meters.
    double wish;
    // Number of candidates; an answer pushes its own into the `candidates` of the call.
    size_t n_candidates;
    // Places that fit, best first.
    const struct rumbo_candidate *candidates;
} rumbo_estimate;

// One point of a path.
typedef struct rumbo_path_point {
    // Where, in the map's frame.
    struct rumbo_point position;
    // Which way to look there, radians; not-a-number where that is free.
    double yaw_rad;
} rumbo_path_point;

// A way from start to goal.
typedef struct rumbo_path {
    // Bytes of this struct.
    size_t size;
    // What the planner minimized.
    double cost;
    // Number of points, at least 1.
    size_t len;
    // The points.
    const struct rumbo_path_point *points;
} rumbo_path;

// Something in the way that the map does not show.
typedef struct rumbo_obstacle {
    // Its middle in the map's frame.
    struct rumbo_point position;
    // Its radius, meters; zero for a single point.
    double radius_m;
    // When it was last seen, nanoseconds.
    int64_t stamp_ns;
} rumbo_obstacle;

// What a planner gets.
typedef struct rumbo_plan_request {
    // Bytes of this struct.
    size_t size;
    // The map, without obstacles.
    const struct rumbo_map *map;
    // The map's grid with all obstacles as occupied; null where the map has no grid.
    const struct rumbo_grid *grid;
    // The robot in the map.
    struct rumbo_pose2 start;
    // Where to.
    struct rumbo_point goal;
    // Which way to look at the end, radians; not-a-number where that is free.
    double goal_yaw_rad;
    // The robot.
    const struct rumbo_robot *robot;
    // Number of obstacles.
    size_t n_obstacles;
    // What is in the way and not on the map.
    const struct rumbo_obstacle *obstacles;
    // Raised when nobody waits any more: ask `give_up_is_raised` at least every 1,000 expansions.
    const rumbo_give_up *give_up;
} rumbo_plan_request;

// What an avoider gets.
typedef struct rumbo_avoid_input {
    // Bytes of this struct.
    size_t size;
    // The robot in the map, now.
    struct rumbo_pose2 map_from_base;
    // Velocity of the base by the odometer.
    struct rumbo_twist twist;
    // The last estimate.
    const struct rumbo_estimate *estimate;
    // Observations since the last call.
    const struct rumbo_seen *seen;
    // The map.
    const struct rumbo_map *map;
    // The map's grid with the known obstacles; may be null.
    const struct rumbo_grid *grid;
    // The path; null while the robot wanders without a goal.
    const struct rumbo_path *path;
    // Goes up with every new path.
    uint64_t path_number;
    // Distance at which the path's end counts as reached, meters.
    double arrival_radius_m;
    // Number of obstacles.
    size_t n_obstacles;
    // Obstacles that the navigator remembers.
    const struct rumbo_obstacle *obstacles;
    // The robot.
    const struct rumbo_robot *robot;
} rumbo_avoid_input;

// What an avoider wants.
typedef struct rumbo_steering {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_DRIVE`, `RUMBO_BLOCKED` or `RUMBO_ARRIVED`.
    uint32_t kind;
    // 0.
    uint32_t reserved;
    // How to drive.
    struct rumbo_twist twist;
} rumbo_steering;

// What a localizer is told when it starts.
typedef struct rumbo_prior {
    // Bytes of this struct.
    size_t size;
    // `RUMBO_PRIOR_UNKNOWN`, ...
    uint32_t kind;
    // 0.
    uint32_t reserved;
    // The robot in the map.
    struct rumbo_pose2 map_from_base;
    // The odometer's reading at that time.
    struct rumbo_pose2 odom_from_base;
    // Covariance of x, y, yaw, row by row.
    double covariance[9];
    // What was saved.
    struct rumbo_u8_array saved;
} rumbo_prior;

// Takes the points of a path, in order.
typedef struct rumbo_path_out {
    // Bytes of this struct.
    size_t size;
    // For `push`.
    void *ctx;
    // Appends `len` points.
    void (*push)(void *ctx, const struct rumbo_path_point *points, size_t len);
    // What the planner minimized; write it here.
    double cost;
} rumbo_path_out;

// Takes obstacles.
typedef struct rumbo_obstacle_out {
    // Bytes of this struct.
    size_t size;
    // For `push`.
    void *ctx;
    // Appends `len` obstacles.
    void (*push)(void *ctx, const struct rumbo_obstacle *obstacles, size_t len);
} rumbo_obstacle_out;

// Takes candidates, best first.
typedef struct rumbo_candidate_out {
    // Bytes of this struct.
    size_t size;
    // For `push`.
    void *ctx;
    // Appends `len` candidates.
    void (*push)(void *ctx, const struct rumbo_candidate *candidates, size_t len);
} rumbo_candidate_out;

// Where the robot was at a time.
typedef struct rumbo_stamped_pose {
    // When, nanoseconds.
    int64_t stamp_ns;
    // The robot in the map.
    struct rumbo_pose3 map_from_base;
} rumbo_stamped_pose;

// Takes the poses of a trajectory, oldest first.
typedef struct rumbo_trajectory_out {
    // Bytes of this struct.
    size_t size;
    // For `push`.
    void *ctx;
    // Appends `len` poses.
    void (*push)(void *ctx, const struct rumbo_stamped_pose *poses, size_t len);
} rumbo_trajectory_out;

// Functions of a planner.
typedef struct rumbo_planner_table {
    // Bytes of this struct.
    size_t size;
    // Ends an instance.
    void (*destroy)(void *instance);
    // Pushes a path from start to goal, or says why there is none.
    int32_t (*plan)(void *instance,
                    const struct rumbo_call *call,
                    const struct rumbo_plan_request *request,
                    struct rumbo_path_out *path,
                    struct rumbo_error *error);
} rumbo_planner_table;

// Functions of an avoider.
typedef struct rumbo_avoider_table {
    // Bytes of this struct.
    size_t size;
    // Ends an instance.
    void (*destroy)(void *instance);
    // What to do until the next call.
    int32_t (*steer)(void *instance,
                     const struct rumbo_call *call,
                     const struct rumbo_avoid_input *input,
                     struct rumbo_steering *steering,
                     struct rumbo_obstacle_out *obstacles,
                     struct rumbo_error *error);
} rumbo_avoider_table;

// Functions of a localizer.
typedef struct rumbo_localizer_table {
    // Bytes of this struct.
    size_t size;
    // Ends an instance.
    void (*destroy)(void *instance);
    // Begins anew from what is known now.
    int32_t (*start)(void *instance,
                     const struct rumbo_prior *prior,
                     const struct rumbo_map *map,
                     struct rumbo_error *error);
    // Takes in what was seen and fills `estimate`, which comes as that of a lost robot.
    int32_t (*update)(void *instance,
                      const struct rumbo_call *call,
                      const struct rumbo_seen *seen,
                      const struct rumbo_map *map,
                      struct rumbo_estimate *estimate,
                      struct rumbo_candidate_out *candidates,
                      struct rumbo_error *error);
} rumbo_localizer_table;

// Functions of a map builder.
typedef struct rumbo_map_builder_table {
    // Bytes of this struct.
    size_t size;
    // Ends an instance.
    void (*destroy)(void *instance);
    // Prepares its layers.
    int32_t (*start)(void *instance, rumbo_map_mut *map, struct rumbo_error *error);
    // Adds what was seen.
    int32_t (*insert)(void *instance,
                      const struct rumbo_call *call,
                      const struct rumbo_seen *seen,
                      const struct rumbo_estimate *estimate,
                      rumbo_map_mut *map,
                      struct rumbo_error *error);
    // Asked when somebody saves the map: brings what only a whole visit tells into `map`, which is what will be saved, and
    // pushes what must be kept beside it until the next visit, or nothing; may be null. Since ABI 1.1.
    int32_t (*save)(const void *instance,
                    rumbo_map_mut *map,
                    struct rumbo_bytes_out *bytes,
                    struct rumbo_error *error);
} rumbo_map_builder_table;

// Functions of a plugin that builds the map and finds the robot in it.
typedef struct rumbo_slam_table {
    // Bytes of this struct.
    size_t size;
    // Ends an instance.
    void (*destroy)(void *instance);
    // Begins anew and prepares its layers.
    int32_t (*start)(void *instance,
                     const struct rumbo_prior *prior,
                     rumbo_map_mut *map,
                     struct rumbo_error *error);
    // Takes in what was seen, writes its layers and fills `estimate`.
    int32_t (*update)(void *instance,
                      const struct rumbo_call *call,
                      const struct rumbo_seen *seen,
                      rumbo_map_mut *map,
                      struct rumbo_estimate *estimate,
                      struct rumbo_candidate_out *candidates,
                      struct rumbo_error *error);
    // Writes its whole state, to continue from later; may be null.
    int32_t (*save)(const void *instance, struct rumbo_bytes_out *bytes, struct rumbo_error *error);
    // Pushes where the robot was at all scans, as it is known now, oldest first; null where it does not keep that.
    // Since ABI 1.1.
    int32_t (*trajectory)(const void *instance, struct rumbo_trajectory_out *poses, struct rumbo_error *error);
    // Is told where the robot is in the map that it has built (`RUMBO_PRIOR_POSE`), or that it may be anywhere in it
    // (`RUMBO_PRIOR_UNKNOWN`). The map stays; a pose is where the next match begins. Null where it cannot be told.
    // Since ABI 1.1.
    int32_t (*relocate)(void *instance,
                        const struct rumbo_prior *prior,
                        rumbo_map_mut *map,
                        struct rumbo_error *error);
    // Asked when somebody saves the map: brings its layers of `map`, which is what will be saved, to the poses of
    // `trajectory`; null where its map is always so. Since ABI 1.1.
    int32_t (*save_map)(const void *instance, rumbo_map_mut *map, struct rumbo_error *error);
} rumbo_slam_table;

// Functions of a sensor.
typedef struct rumbo_sensor_table {
    // Bytes of this struct.
    size_t size;
    // Ends an instance.
    void (*destroy)(void *instance);
    // Reads what is there now; never blocks.
    int32_t (*poll)(void *instance,
                    const struct rumbo_call *call,
                    rumbo_world *world,
                    rumbo_observations *out,
                    struct rumbo_error *error);
    // As `poll` for a virtual sensor: makes something of what its inputs saw; may be null.
    int32_t (*derive)(void *instance,
                      const struct rumbo_call *call,
                      const struct rumbo_seen *inputs,
                      rumbo_observations *out,
                      struct rumbo_error *error);
} rumbo_sensor_table;

#endif  /* RUMBO_PLUGIN_H */

#ifdef __cplusplus
extern "C" {
#endif

/* The only symbol that a library exports: the record of its plugins, or null where it cannot work with this host. */
RUMBO_EXPORT const rumbo_module *rumbo_plugin_entry_v1(const rumbo_host *host);

#ifdef __cplusplus
}
#endif

/* What follows are conveniences; nothing of it crosses the boundary. */

/* A literal as the initializer of a rumbo_str: .name = RUMBO_TEXT("wave"). */
#define RUMBO_TEXT(literal) { "" literal, sizeof(literal) - 1 }

/* A literal as a rumbo_str inside an expression: host->log(RUMBO_LOG_INFO, RUMBO_STR("wave"), RUMBO_STR("hello")). */
#ifdef __cplusplus
#define RUMBO_STR(literal) (rumbo_str RUMBO_TEXT(literal))
#else
#define RUMBO_STR(literal) ((rumbo_str)RUMBO_TEXT(literal))
#endif

/* Whether the struct at `pointer`, which says its own size, reaches as far as `field`. */
#define RUMBO_HAS(pointer, field) \
    ((size_t)((const char *)(&(pointer)->field + 1) - (const char *)(pointer)) <= (pointer)->size)

/* The whole entry function of a C library: RUMBO_PLUGINS("name and version", &one_entry, &another_entry). */
#ifndef __cplusplus
#define RUMBO_PLUGINS(info, ...)                                                                            \
    const rumbo_module *rumbo_plugin_entry_v1(const rumbo_host *host)                                       \
    {                                                                                                       \
        static const rumbo_entry *const entries[] = { __VA_ARGS__, NULL };                                  \
        static const rumbo_module module = {                                                                \
            .magic = RUMBO_MAGIC,                                                                           \
            .size = sizeof module,                                                                          \
            .abi_major = RUMBO_ABI_MAJOR,                                                                   \
            .abi_minor = RUMBO_ABI_MINOR,                                                                   \
            .flags = RUMBO_CATCHES,                                                                         \
            .build_info = RUMBO_TEXT(info),                                                                 \
            .n_entries = sizeof entries / sizeof entries[0] - 1,                                            \
            .entries = entries,                                                                             \
        };                                                                                                  \
        return host != NULL && host->abi_major == RUMBO_ABI_MAJOR ? &module : NULL;                         \
    }
#endif

/* The view of a text that ends with a zero. */
static inline rumbo_str rumbo_str_of(const char *text)
{
    rumbo_str view;
    view.data = text;
    view.len = strlen(text);
    return view;
}

/* Whether a text is this one. */
static inline bool rumbo_str_is(rumbo_str text, const char *other)
{
    return text.len == strlen(other) && (text.len == 0 || memcmp(text.data, other, text.len) == 0);
}

/* Says why a call failed and gives `code` back: return rumbo_fail(error, RUMBO_ERROR, "%d cells", n).
   `place`, `text`, `path` and `values` are yours to fill in where the status asks for them. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
static inline int32_t rumbo_fail(rumbo_error *error, int32_t code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    return code;
}

/* The pose at x and y, meters, that looks along `yaw_rad`. */
static inline rumbo_pose2 rumbo_pose2_at(double x_m, double y_m, double yaw_rad)
{
    rumbo_pose2 pose;
    pose.x_m = x_m;
    pose.y_m = y_m;
    pose.cos_yaw = cos(yaw_rad);
    pose.sin_yaw = sin(yaw_rad);
    return pose;
}

/* The heading of a pose, radians, from -pi to pi. */
static inline double rumbo_yaw(rumbo_pose2 pose)
{
    return atan2(pose.sin_yaw, pose.cos_yaw);
}

/* a_from_c of a_from_b and b_from_c; the heading is scaled back to length 1. */
static inline rumbo_pose2 rumbo_compose(rumbo_pose2 a_from_b, rumbo_pose2 b_from_c)
{
    rumbo_pose2 pose;
    double c = a_from_b.cos_yaw * b_from_c.cos_yaw - a_from_b.sin_yaw * b_from_c.sin_yaw;
    double s = a_from_b.sin_yaw * b_from_c.cos_yaw + a_from_b.cos_yaw * b_from_c.sin_yaw;
    double length = hypot(c, s);
    pose.x_m = a_from_b.x_m + a_from_b.cos_yaw * b_from_c.x_m - a_from_b.sin_yaw * b_from_c.y_m;
    pose.y_m = a_from_b.y_m + a_from_b.sin_yaw * b_from_c.x_m + a_from_b.cos_yaw * b_from_c.y_m;
    pose.cos_yaw = c / length;
    pose.sin_yaw = s / length;
    return pose;
}

/* b_from_a of a_from_b. */
static inline rumbo_pose2 rumbo_inverse(rumbo_pose2 a_from_b)
{
    rumbo_pose2 pose;
    pose.x_m = -(a_from_b.cos_yaw * a_from_b.x_m + a_from_b.sin_yaw * a_from_b.y_m);
    pose.y_m = a_from_b.sin_yaw * a_from_b.x_m - a_from_b.cos_yaw * a_from_b.y_m;
    pose.cos_yaw = a_from_b.cos_yaw;
    pose.sin_yaw = -a_from_b.sin_yaw;
    return pose;
}

/* A pose in the plane as one in space. */
static inline rumbo_pose3 rumbo_lift(rumbo_pose2 pose)
{
    rumbo_pose3 lifted;
    double half = rumbo_yaw(pose) / 2.0;
    lifted.position_m[0] = pose.x_m;
    lifted.position_m[1] = pose.y_m;
    lifted.position_m[2] = 0.0;
    lifted.quaternion[0] = 0.0;
    lifted.quaternion[1] = 0.0;
    lifted.quaternion[2] = sin(half);
    lifted.quaternion[3] = cos(half);
    return lifted;
}

/* A pose in space as seen from above. */
static inline rumbo_pose2 rumbo_flatten(rumbo_pose3 pose)
{
    double i = pose.quaternion[0], j = pose.quaternion[1], k = pose.quaternion[2], w = pose.quaternion[3];
    double yaw_rad = atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k));
    return rumbo_pose2_at(pose.position_m[0], pose.position_m[1], yaw_rad);
}

/* Observation `k` of `seen`, counted from 0: they lie `stride` bytes apart, which may be more than you know of. */
static inline const rumbo_observation *rumbo_seen_at(const rumbo_seen *seen, size_t k)
{
    return (const rumbo_observation *)(const void *)((const char *)seen->first + k * seen->stride);
}

/* Coarser grid `k` of `map`, counted from 0. */
static inline const rumbo_grid *rumbo_coarse_at(const rumbo_map *map, size_t k)
{
    return (const rumbo_grid *)(const void *)((const char *)map->coarse + k * map->coarse_stride);
}

/* Appends a point to a path; which way to look there is free. */
static inline void rumbo_push_point(rumbo_path_out *path, double x_m, double y_m)
{
    rumbo_path_point point;
    point.position.x_m = x_m;
    point.position.y_m = y_m;
    point.yaw_rad = NAN;
    path->push(path->ctx, &point, 1);
}
