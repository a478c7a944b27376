/* The avoider `{{name}}`: drives along the path, and stops where its laser sees something in the way.
   Replace what `steer` does by your own algorithm; the rest can stay. */
#include "rumbo_plugin.h"

#include <stdlib.h>

enum { MOST_HITS = 4096 };
static const double STALE_S = 1.0, TURNS_FIRST_RAD = 0.4, TURN_GAIN = 2.0, PI = 3.14159265358979323846;

typedef struct {
    double look_ahead_m;
    /* The path that is followed, and the piece of it where the robot was last. */
    uint64_t following;
    size_t piece;
    /* The newest scan: when, and its hits in the odometer's frame, which does not jump. */
    int64_t scan_ns;
    bool has_scan;
    size_t n_hits;
    rumbo_point hits[MOST_HITS];
} avoider;

static rumbo_point moved(rumbo_pose2 a_from_b, rumbo_point point)
{
    rumbo_point to = { a_from_b.x_m + a_from_b.cos_yaw * point.x_m - a_from_b.sin_yaw * point.y_m,
                       a_from_b.y_m + a_from_b.sin_yaw * point.x_m + a_from_b.cos_yaw * point.y_m };
    return to;
}

static double distance_m(rumbo_point a, rumbo_point b)
{
    return hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

/* Keeps the newest scan. */
static void look(avoider *self, const rumbo_seen *seen, rumbo_pose2 odom_from_base)
{
    for (size_t k = 0; k < seen->len; k++) {
        const rumbo_observation *observation = rumbo_seen_at(seen, k);
        const rumbo_laser_scan *scan = observation->data;
        rumbo_pose2 odom_from_sensor;
        if (observation->kind != RUMBO_LASER_SCAN || !observation->valid || !isfinite(scan->first_bearing_rad) ||
            !isfinite(scan->bearing_step_rad))
            continue;
        odom_from_sensor = rumbo_compose(odom_from_base, rumbo_flatten(observation->base_from_sensor));
        self->has_scan = true;
        self->scan_ns = observation->stamp_ns;
        self->n_hits = 0;
        for (size_t i = 0; i < scan->ranges_m.len && self->n_hits < MOST_HITS; i++) {
            double range_m = scan->ranges_m.data[i], bearing_rad = scan->first_bearing_rad + scan->bearing_step_rad * (double)i;
            rumbo_point hit = { range_m * cos(bearing_rad), range_m * sin(bearing_rad) };
            if (range_m >= scan->min_range_m && range_m <= scan->max_range_m)
                self->hits[self->n_hits++] = moved(odom_from_sensor, hit);
        }
    }
}

static double share_of(rumbo_point from, rumbo_point to, rumbo_point robot)
{
    double x = to.x_m - from.x_m, y = to.y_m - from.y_m, square = x * x + y * y;
    double share = square > 1e-12 ? ((robot.x_m - from.x_m) * x + (robot.y_m - from.y_m) * y) / square : 1.0;
    return share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share;
}

static rumbo_point between(rumbo_point from, rumbo_point to, double share)
{
    rumbo_point point = { from.x_m + (to.x_m - from.x_m) * share, from.y_m + (to.y_m - from.y_m) * share };
    return point;
}

static double off_m(const rumbo_path *path, size_t piece, rumbo_point robot)
{
    rumbo_point from = path->points[piece].position, to = path->points[piece + 1].position;
    return distance_m(between(from, to, share_of(from, to, robot)), robot);
}

/* The point of the path `look_ahead_m` beyond the one nearest to the robot. */
static rumbo_point point_ahead(avoider *self, const rumbo_path *path, rumbo_point robot)
{
    double left_m = self->look_ahead_m;
    while (self->piece + 2 < path->len && off_m(path, self->piece + 1, robot) <= off_m(path, self->piece, robot))
        self->piece++;
    for (size_t k = self->piece; k + 1 < path->len; k++) {
        rumbo_point from = path->points[k].position, to = path->points[k + 1].position;
        double begins = k == self->piece ? share_of(from, to, robot) : 0.0;
        double length_m = distance_m(from, to) * (1.0 - begins);
        if (left_m <= length_m)
            return between(from, to, begins + (1.0 - begins) * left_m / fmax(length_m, 1e-9));
        left_m -= length_m;
    }
    return path->points[path->len - 1].position;
}

static double hull_m(const rumbo_robot *robot)
{
    double radius_m = robot->n_corners < 3 ? robot->radius_m : 0.0;
    for (size_t k = 0; k < robot->n_corners; k++)
        radius_m = fmax(radius_m, hypot(robot->corners[k].x_m, robot->corners[k].y_m));
    return radius_m + robot->guard_margin_m;
}

/* Says what is in the strip ahead of the hull. Returns whether something is. */
static bool push_in_the_way(const avoider *self, const rumbo_avoid_input *input, rumbo_pose2 base_from_odom, double stop_m,
                            int64_t now_ns, rumbo_obstacle_out *obstacles)
{
    double half_m = hull_m(input->robot);
    bool is_blocked = false;
    for (size_t k = 0; k < self->n_hits; k++) {
        rumbo_point hit = moved(base_from_odom, self->hits[k]);
        if (hit.x_m > 0.0 && hit.x_m < half_m + stop_m && fabs(hit.y_m) < half_m) {
            rumbo_obstacle obstacle = { moved(input->map_from_base, hit), 0.0, now_ns };
            obstacles->push(obstacles->ctx, &obstacle, 1);
            is_blocked = true;
        }
    }
    return is_blocked;
}

static int32_t steer(void *instance, const rumbo_call *call, const rumbo_avoid_input *input, rumbo_steering *steering,
                     rumbo_obstacle_out *obstacles, rumbo_error *error)
{
    avoider *self = instance;
    const rumbo_robot *robot = input->robot;
    rumbo_point here = { input->map_from_base.x_m, input->map_from_base.y_m }, target;
    rumbo_pose2 odom_from_base = rumbo_compose(rumbo_inverse(rumbo_flatten(input->estimate->map_from_odom)), input->map_from_base);
    double left_m, way_rad, fastest = robot->max_turn_deg_s * PI / 180.0, speed_m_s, stop_m;
    if (!isfinite(here.x_m + here.y_m + rumbo_yaw(input->map_from_base)) ||
        !isfinite(input->twist.forward_m_s + input->twist.left_m_s + input->twist.turn_rad_s) ||
        !isfinite(odom_from_base.x_m + odom_from_base.y_m + rumbo_yaw(odom_from_base)))
        return rumbo_fail(error, RUMBO_ERROR, "the robot's place or velocity is not a finite number");
    look(self, input->seen, odom_from_base);
    steering->kind = RUMBO_DRIVE;
    steering->twist.forward_m_s = steering->twist.left_m_s = steering->twist.turn_rad_s = 0.0;
    if (input->path == NULL)
        return RUMBO_OK;
    if (self->following != input->path_number) {
        self->following = input->path_number;
        self->piece = 0;
    }
    left_m = distance_m(here, input->path->points[input->path->len - 1].position);
    if (!isfinite(left_m))
        return rumbo_fail(error, RUMBO_ERROR, "the end of the path is not a finite number");
    if (left_m <= input->arrival_radius_m) {
        steering->kind = RUMBO_ARRIVED;
        return RUMBO_OK;
    }
    if (!self->has_scan)
        return RUMBO_OK;
    if ((double)(call->now_ns - self->scan_ns) * 1e-9 > STALE_S) {
        snprintf(error->text, sizeof error->text, "laser scan");
        error->values[0] = (double)(call->now_ns - self->scan_ns) * 1e-9;
        return rumbo_fail(error, RUMBO_NO_READING, "no laser scan");
    }
    target = moved(rumbo_inverse(input->map_from_base), point_ahead(self, input->path, here));
    way_rad = atan2(target.y_m, target.x_m);
    steering->twist.turn_rad_s = fmax(-fastest, fmin(fastest, TURN_GAIN * way_rad));
    if (fabs(way_rad) > TURNS_FIRST_RAD)
        return RUMBO_OK;
    speed_m_s = fmin(robot->max_speed_m_s, sqrt(2.0 * robot->braking_m_s2 * left_m));
    stop_m = fmin(left_m, speed_m_s * speed_m_s / (2.0 * robot->braking_m_s2) + speed_m_s * robot->guard_latency_s + 0.1);
    if (push_in_the_way(self, input, rumbo_inverse(odom_from_base), stop_m, call->now_ns, obstacles)) {
        steering->kind = RUMBO_BLOCKED;
        return RUMBO_OK;
    }
    steering->twist.forward_m_s = speed_m_s * cos(way_rad);
    return RUMBO_OK;
}

static void destroy(void *instance)
{
    free(instance);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    avoider *self = calloc(1, sizeof *self);
    (void)entry, (void)context;
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    /* The schema below has a default, and the host has looked at type and limits already. */
    host->config_f64(config, RUMBO_STR("look_ahead_m"), &self->look_ahead_m);
    *instance = self;
    return RUMBO_OK;
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest, rumbo_error *error)
{
    (void)entry, (void)config, (void)error;
    manifest->n_consumes = 1;
    manifest->consumes[0] = 1u << RUMBO_LASER_SCAN;
    /* It turns in place. */
    manifest->drives = 1u << RUMBO_DIFFERENTIAL | 1u << RUMBO_OMNIDIRECTIONAL;
    return RUMBO_OK;
}

static const rumbo_avoider_table table = { .size = sizeof table, .destroy = destroy, .steer = steer };

static const rumbo_entry plugin = {
    .size = sizeof plugin,
    .stage = RUMBO_AVOIDER,
    .name = RUMBO_TEXT("{{name}}"),
    .version = RUMBO_TEXT("0.1.0"),
    .summary = RUMBO_TEXT("drives along the path and stops in front of obstacles"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": { \"look_ahead_m\": {"
        "  \"type\": \"number\", \"default\": 0.3, \"minimum\": 0.05, \"maximum\": 5.0,"
        "  \"description\": \"The robot goes for a point of the path this far ahead, meters.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("{{name}} 0.1.0", &plugin)
