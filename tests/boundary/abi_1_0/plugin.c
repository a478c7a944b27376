/*
 * One plugin of each stage, built against the header of ABI 1.0 that lies beside this file. Every later host of major 1
 * must load and run it as it is: never change it to make a test pass.
 */
#include "rumbo_plugin.h"

#include <stdlib.h>

enum { N_BEAMS = 181, EDGE_CELLS = 16 };
#ifndef SLAM_SIZE /* A test says that the table ends before `save`. */
#define SLAM_SIZE sizeof(rumbo_slam_table)
#endif
static const double PI = 3.14159265358979323846;

/* Every instance of this library. */
typedef struct {
    const rumbo_host *host;
    rumbo_pose3 base_from_sensor;
    rumbo_pose2 map_from_odom;
    rumbo_pose2 odom_from_base;
    uint32_t n_updates;
} instance;

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **out, rumbo_error *error)
{
    instance *self = calloc(1, sizeof *self);
    (void)entry, (void)config;
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    self->host = host;
    self->base_from_sensor = context->base_from_sensor;
    *out = self;
    return RUMBO_OK;
}

static void destroy(void *self)
{
    free(self);
}

static int32_t plan(void *self, const rumbo_call *call, const rumbo_plan_request *request, rumbo_path_out *path,
                    rumbo_error *error)
{
    (void)self, (void)call, (void)error;
    rumbo_push_point(path, request->start.x_m, request->start.y_m);
    rumbo_push_point(path, request->goal.x_m, request->goal.y_m);
    path->cost = hypot(request->goal.x_m - request->start.x_m, request->goal.y_m - request->start.y_m);
    return RUMBO_OK;
}

static int32_t steer(void *self, const rumbo_call *call, const rumbo_avoid_input *input, rumbo_steering *steering,
                     rumbo_obstacle_out *obstacles, rumbo_error *error)
{
    (void)self, (void)call, (void)obstacles;
    if (input->path == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no path to follow");
    const rumbo_point end = input->path->points[input->path->len - 1].position;
    if (hypot(end.x_m - input->map_from_base.x_m, end.y_m - input->map_from_base.y_m) <= input->arrival_radius_m) {
        steering->kind = RUMBO_ARRIVED;
        return RUMBO_OK;
    }
    steering->kind = RUMBO_DRIVE;
    steering->twist.forward_m_s = 0.1;
    return RUMBO_OK;
}

static int32_t start_from(instance *self, const rumbo_prior *prior, rumbo_error *error)
{
    if (prior->kind != RUMBO_PRIOR_POSE) {
        snprintf(error->path, sizeof error->path, "an unknown pose");
        snprintf(error->text, sizeof error->text, "a pose");
        return rumbo_fail(error, RUMBO_BAD_PRIOR, "needs a pose");
    }
    self->odom_from_base = prior->odom_from_base;
    self->map_from_odom = rumbo_compose(prior->map_from_base, rumbo_inverse(prior->odom_from_base));
    return RUMBO_OK;
}

static void follow(instance *self, const rumbo_call *call, const rumbo_seen *seen, rumbo_estimate *estimate)
{
    estimate->stamp_ns = call->now_ns;
    for (size_t k = 0; k < seen->len; k++) {
        const rumbo_observation *observation = rumbo_seen_at(seen, k);
        if (observation->kind == RUMBO_ODOMETRY && observation->valid) {
            self->odom_from_base = ((const rumbo_odometry *)observation->data)->odom_from_base;
            estimate->stamp_ns = observation->stamp_ns;
        }
    }
    estimate->map_from_odom = rumbo_lift(self->map_from_odom);
    estimate->map_from_base = rumbo_lift(rumbo_compose(self->map_from_odom, self->odom_from_base));
    for (int k = 0; k < 36; k++)
        estimate->covariance[k] = 0.0;
    for (int k = 0; k < 6; k++)
        estimate->covariance[k * 7] = 0.0001;
    estimate->status = RUMBO_TRACKING;
    self->n_updates++;
}

static int32_t localizer_start(void *self, const rumbo_prior *prior, const rumbo_map *map, rumbo_error *error)
{
    (void)map;
    return start_from(self, prior, error);
}

static int32_t localizer_update(void *self, const rumbo_call *call, const rumbo_seen *seen, const rumbo_map *map,
                                rumbo_estimate *estimate, rumbo_candidate_out *candidates, rumbo_error *error)
{
    (void)map, (void)candidates, (void)error;
    follow(self, call, seen, estimate);
    return RUMBO_OK;
}

/* A grid of free cells around the origin. */
static int32_t lay_floor(const rumbo_host *host, rumbo_map_mut *map, rumbo_error *error)
{
    rumbo_grid grid = { .size = sizeof grid };
    float *cells;
    grid.width = grid.height = EDGE_CELLS;
    grid.resolution_m = 1.0;
    grid.occupied_above = 0.5f;
    grid.free_below = -0.5f;
    grid.cells.len = EDGE_CELLS * EDGE_CELLS;
    grid.cells.block = host->block_new(grid.cells.len * sizeof *cells);
    cells = host->make_mut_f32(&grid.cells);
    if (cells == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    for (size_t k = 0; k < grid.cells.len; k++)
        cells[k] = -1.0f;
    if (host->map_put_grid(map, 0, &grid) != RUMBO_OK)
        return rumbo_fail(error, RUMBO_ERROR, "the host refuses the grid");
    host->map_set_version(map, host->map_version(map) + 1);
    return RUMBO_OK;
}

/* The first cell counts the calls. */
static int32_t count_up(const rumbo_host *host, rumbo_map_mut *map, rumbo_error *error)
{
    rumbo_grid grid = { .size = sizeof grid };
    float *cells;
    if (host->map_take_grid(map, 0, &grid) != RUMBO_OK) {
        snprintf(error->text, sizeof error->text, "grid");
        return rumbo_fail(error, RUMBO_MISSING_LAYER, "there is no grid");
    }
    cells = host->make_mut_f32(&grid.cells);
    if (cells != NULL)
        cells[0] += 1.0f;
    host->map_set_version(map, host->map_version(map) + 1);
    if (host->map_put_grid(map, 0, &grid) != RUMBO_OK)
        return rumbo_fail(error, RUMBO_ERROR, "the host refuses the grid");
    return RUMBO_OK;
}

static int32_t builder_start(void *self, rumbo_map_mut *map, rumbo_error *error)
{
    return lay_floor(((instance *)self)->host, map, error);
}

static int32_t builder_insert(void *self, const rumbo_call *call, const rumbo_seen *seen,
                              const rumbo_estimate *estimate, rumbo_map_mut *map, rumbo_error *error)
{
    (void)call, (void)seen, (void)estimate;
    return count_up(((instance *)self)->host, map, error);
}

static int32_t slam_start(void *self, const rumbo_prior *prior, rumbo_map_mut *map, rumbo_error *error)
{
    int32_t status = start_from(self, prior, error);
    return status == RUMBO_OK ? lay_floor(((instance *)self)->host, map, error) : status;
}

static int32_t slam_update(void *self, const rumbo_call *call, const rumbo_seen *seen, rumbo_map_mut *map,
                           rumbo_estimate *estimate, rumbo_candidate_out *candidates, rumbo_error *error)
{
    (void)candidates;
    follow(self, call, seen, estimate);
    return count_up(((instance *)self)->host, map, error);
}

static int32_t slam_save(const void *self, rumbo_bytes_out *bytes, rumbo_error *error)
{
    char text[32];
    (void)error;
    snprintf(text, sizeof text, "%u updates", (unsigned)((const instance *)self)->n_updates);
    bytes->push(bytes->ctx, rumbo_str_of(text));
    return RUMBO_OK;
}

static int32_t sensor_poll(void *self_, const rumbo_call *call, rumbo_world *world, rumbo_observations *out,
                           rumbo_error *error)
{
    instance *self = self_;
    rumbo_probe probe = { .size = sizeof probe, .kind = RUMBO_PROBE_BEAMS, .n_beams = N_BEAMS };
    rumbo_answer answer = { .size = sizeof answer };
    rumbo_laser_scan scan = { .size = sizeof scan };
    rumbo_observation observation = { .size = sizeof observation };
    rumbo_str why = RUMBO_TEXT("");
    float *ranges;
    probe.base_from_sensor = self->base_from_sensor;
    probe.first_bearing_rad = -PI / 2.0;
    probe.bearing_step_rad = PI / (N_BEAMS - 1);
    probe.max_range_m = 8.0;
    if (self->host->probe(world, &probe, &answer, &why) != RUMBO_OK)
        return rumbo_fail(error, RUMBO_ERROR, "the world does not answer: %.*s", (int)why.len, why.data);
    if (answer.kind != RUMBO_ANSWER_RANGES || answer.n_ranges != N_BEAMS)
        return rumbo_fail(error, RUMBO_ERROR, "the world answers something else");
    scan.first_bearing_rad = probe.first_bearing_rad;
    scan.bearing_step_rad = probe.bearing_step_rad;
    scan.max_range_m = 8.0f;
    scan.ranges_m = self->host->lend_f32(out, N_BEAMS);
    ranges = self->host->make_mut_f32(&scan.ranges_m);
    if (ranges == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    memcpy(ranges, answer.ranges_m, N_BEAMS * sizeof *ranges);
    observation.stamp_ns = call->now_ns;
    observation.kind = RUMBO_LASER_SCAN;
    observation.valid = 1;
    observation.base_from_sensor = self->base_from_sensor;
    observation.data = &scan;
    return self->host->observe(out, &observation);
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest,
                        rumbo_error *error)
{
    (void)config, (void)error;
    switch (entry->stage) {
    case RUMBO_SENSOR:
        manifest->produces = 1u << RUMBO_LASER_SCAN;
        break;
    case RUMBO_LOCALIZER:
        manifest->needs_start_pose = 1;
        manifest->consumes[0] = 1u << RUMBO_ODOMETRY;
        manifest->n_consumes = 1;
        break;
    case RUMBO_SLAM:
        manifest->needs_start_pose = 1;
        manifest->gives_layers = RUMBO_LAYER_GRID;
        break;
    case RUMBO_MAP_BUILDER:
        manifest->gives_layers = RUMBO_LAYER_GRID;
        break;
    default:
        break;
    }
    return RUMBO_OK;
}

static const rumbo_planner_table planner = { .size = sizeof planner, .destroy = destroy, .plan = plan };
static const rumbo_avoider_table avoider = { .size = sizeof avoider, .destroy = destroy, .steer = steer };
static const rumbo_localizer_table localizer = {
    .size = sizeof localizer, .destroy = destroy, .start = localizer_start, .update = localizer_update,
};
static const rumbo_map_builder_table builder = {
    .size = sizeof builder, .destroy = destroy, .start = builder_start, .insert = builder_insert,
};
static const rumbo_slam_table slam = {
    .size = SLAM_SIZE, .destroy = destroy, .start = slam_start, .update = slam_update, .save = slam_save,
};
static const rumbo_sensor_table sensor = { .size = sizeof sensor, .destroy = destroy, .poll = sensor_poll };

#define ENTRY(which, kind, called)                                                                          \
    static const rumbo_entry which##_entry = {                                                              \
        .size = sizeof which##_entry,                                                                       \
        .stage = kind,                                                                                      \
        .name = RUMBO_TEXT(called),                                                                         \
        .version = RUMBO_TEXT("1.0.0"),                                                                     \
        .summary = RUMBO_TEXT("Built for ABI 1.0"),                                                         \
        .table = &which,                                                                                    \
        .create = create,                                                                                   \
        .manifest = manifest,                                                                               \
    }

ENTRY(planner, RUMBO_PLANNER, "frozen_straight");
ENTRY(avoider, RUMBO_AVOIDER, "frozen_ahead");
ENTRY(localizer, RUMBO_LOCALIZER, "frozen_odometry");
ENTRY(builder, RUMBO_MAP_BUILDER, "frozen_floor");
ENTRY(slam, RUMBO_SLAM, "frozen_both");
ENTRY(sensor, RUMBO_SENSOR, "frozen_beams");

RUMBO_PLUGINS("frozen 1.0.0", &planner_entry, &avoider_entry, &localizer_entry, &builder_entry, &slam_entry,
              &sensor_entry)
