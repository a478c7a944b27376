/* The localizer `{{name}}`: dead reckoning from a known start.
   Replace what `update` does by your own algorithm; the rest can stay. */
#include "rumbo_plugin.h"

#include <stdlib.h>

/* Error that each meter adds to the heading, radians; and no robot goes farther from one reading to the next, meters. */
static const double ERROR_RAD_PER_M = 0.01, LONGEST_STEP_M = 1000.0;

typedef struct {
    double error_m_per_m;
    bool is_started, has_reading;
    rumbo_pose2 map_from_base, odom_from_base;
    /* Variances of x, y and yaw. */
    double variances[3];
    int64_t stamp_ns;
} localizer;

static bool is_finite(rumbo_pose2 pose)
{
    return isfinite(pose.x_m + pose.y_m + pose.cos_yaw + pose.sin_yaw);
}

static int32_t start(void *instance, const rumbo_prior *prior, const rumbo_map *map, rumbo_error *error)
{
    localizer *self = instance;
    (void)map;
    if (prior->kind != RUMBO_PRIOR_POSE) {
        snprintf(error->text, sizeof error->text, "a pose");
        return rumbo_fail(error, RUMBO_BAD_PRIOR, "needs a pose");
    }
    if (!is_finite(prior->map_from_base) || !is_finite(prior->odom_from_base) ||
        !isfinite(prior->covariance[0] + prior->covariance[4] + prior->covariance[8]))
        return rumbo_fail(error, RUMBO_BAD_NUMBER, "the start is not a finite number");
    self->map_from_base = prior->map_from_base;
    self->odom_from_base = prior->odom_from_base;
    for (int k = 0; k < 3; k++)
        self->variances[k] = fmax(prior->covariance[4 * k], 0.0);
    self->is_started = true;
    self->has_reading = false;
    return RUMBO_OK;
}

static int32_t update(void *instance, const rumbo_call *call, const rumbo_seen *seen, const rumbo_map *map,
                      rumbo_estimate *estimate, rumbo_candidate_out *candidates, rumbo_error *error)
{
    localizer *self = instance;
    (void)map, (void)candidates;
    if (!self->is_started)
        return rumbo_fail(error, RUMBO_NOT_STARTED, "it was not started");
    for (size_t k = 0; k < seen->len; k++) {
        const rumbo_observation *observation = rumbo_seen_at(seen, k);
        const rumbo_odometry *odometry = observation->data;
        rumbo_pose2 step;
        double length_m, error_m, error_rad;
        if (observation->kind != RUMBO_ODOMETRY || !observation->valid)
            continue;
        /* A newer reading has told the whole way already. */
        if (self->has_reading && observation->stamp_ns <= self->stamp_ns)
            continue;
        if (!is_finite(odometry->odom_from_base))
            return rumbo_fail(error, RUMBO_BAD_NUMBER, "the odometer's reading is not a finite number");
        step = rumbo_compose(rumbo_inverse(self->odom_from_base), odometry->odom_from_base);
        length_m = fmin(hypot(step.x_m, step.y_m), LONGEST_STEP_M);
        error_m = self->error_m_per_m * length_m;
        error_rad = ERROR_RAD_PER_M * length_m;
        self->map_from_base = rumbo_compose(self->map_from_base, step);
        self->odom_from_base = odometry->odom_from_base;
        self->variances[0] += error_m * error_m;
        self->variances[1] += error_m * error_m;
        self->variances[2] += error_rad * error_rad;
        self->stamp_ns = observation->stamp_ns;
        self->has_reading = true;
    }
    estimate->stamp_ns = self->has_reading ? self->stamp_ns : call->now_ns;
    estimate->map_from_base = rumbo_lift(self->map_from_base);
    estimate->map_from_odom = rumbo_lift(rumbo_compose(self->map_from_base, rumbo_inverse(self->odom_from_base)));
    memset(estimate->covariance, 0, sizeof estimate->covariance);
    /* Rows of x, y and yaw among x, y, z, roll, pitch and yaw. */
    estimate->covariance[0] = self->variances[0];
    estimate->covariance[7] = self->variances[1];
    estimate->covariance[35] = self->variances[2];
    estimate->status = RUMBO_TRACKING;
    return RUMBO_OK;
}

static void destroy(void *instance)
{
    free(instance);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    localizer *self = calloc(1, sizeof *self);
    (void)entry, (void)context;
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    /* The schema below has a default, and the host has looked at type and limits already. */
    host->config_f64(config, RUMBO_STR("error_m_per_m"), &self->error_m_per_m);
    *instance = self;
    return RUMBO_OK;
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest, rumbo_error *error)
{
    (void)entry, (void)config, (void)error;
    manifest->n_consumes = 1;
    manifest->consumes[0] = 1u << RUMBO_ODOMETRY;
    manifest->needs_start_pose = 1;
    return RUMBO_OK;
}

static const rumbo_localizer_table table = {
    .size = sizeof table, .destroy = destroy, .start = start, .update = update
};

static const rumbo_entry plugin = {
    .size = sizeof plugin,
    .stage = RUMBO_LOCALIZER,
    .name = RUMBO_TEXT("{{name}}"),
    .version = RUMBO_TEXT("0.1.0"),
    .summary = RUMBO_TEXT("follows the odometer from a known start"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": { \"error_m_per_m\": {"
        "  \"type\": \"number\", \"default\": 0.02, \"minimum\": 0.0, \"maximum\": 1.0,"
        "  \"description\": \"Error that each meter of the way adds to the place, meters.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("{{name}} 0.1.0", &plugin)
