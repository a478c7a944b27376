/* The sensor `{{name}}`: a planar laser range finder with noise.
   Replace what `poll` does by your own device; the rest can stay. */
#include "rumbo_plugin.h"

#include <stdlib.h>

/* One beam a degree, from the right to the left. */
enum { N_BEAMS = 181 };
static const double DEGREE = 3.14159265358979323846 / 180.0, MIN_RANGE_M = 0.05, MAX_RANGE_M = 8.0;

typedef struct {
    const rumbo_host *host;
    double noise_m;
    uint16_t sensor;
    rumbo_pose3 base_from_sensor;
    /* All chance comes from here: the same seed gives the same readings. */
    rumbo_rng *rng;
    size_t name_len;
    char name[256];
} scanner;

/* Passes on what was recorded under this sensor's name. */
static int32_t pass_on(const scanner *self, const rumbo_seen *recorded, rumbo_observations *out)
{
    for (size_t k = 0; k < recorded->len; k++) {
        const rumbo_observation *observation = rumbo_seen_at(recorded, k);
        rumbo_observation copy = *observation;
        int32_t status;
        copy.size = sizeof copy;
        copy.sensor = self->sensor;
        copy.base_from_sensor = self->base_from_sensor;
        /* What is handed out takes a reference along. */
        if (copy.kind == RUMBO_LASER_SCAN) {
            const rumbo_laser_scan *scan = copy.data;
            if (scan->ranges_m.block != NULL)
                self->host->block_retain(scan->ranges_m.block);
            if (scan->intensities.block != NULL)
                self->host->block_retain(scan->intensities.block);
        } else if (copy.kind != RUMBO_ODOMETRY) {
            continue;
        }
        status = self->host->observe(out, &copy);
        if (status != RUMBO_OK)
            return status;
    }
    return RUMBO_OK;
}

static int32_t poll(void *instance, const rumbo_call *call, rumbo_world *world, rumbo_observations *out, rumbo_error *error)
{
    scanner *self = instance;
    rumbo_probe beams = { .size = sizeof beams, .kind = RUMBO_PROBE_BEAMS, .n_beams = N_BEAMS,
                          .base_from_sensor = self->base_from_sensor, .first_bearing_rad = -90.0 * DEGREE,
                          .bearing_step_rad = DEGREE, .max_range_m = MAX_RANGE_M };
    rumbo_probe channel = { .size = sizeof channel, .kind = RUMBO_PROBE_CHANNEL };
    rumbo_answer answer = { .size = sizeof answer };
    rumbo_str why = { NULL, 0 };
    rumbo_f32_array ranges_m;
    float *readings;
    if (self->host->probe(world, &beams, &answer, &why) != RUMBO_OK) {
        /* A recording has no beams to trace, but what was recorded under this sensor's name. */
        channel.name.data = self->name;
        channel.name.len = self->name_len;
        if (self->host->probe(world, &channel, &answer, &why) != RUMBO_OK)
            return rumbo_fail(error, RUMBO_NO_ANSWER, "%.*s", (int)why.len, why.data == NULL ? "" : why.data);
    }
    if (answer.kind == RUMBO_ANSWER_RECORDED && answer.recorded != NULL)
        return pass_on(self, answer.recorded, out);
    if (answer.kind != RUMBO_ANSWER_RANGES || answer.n_ranges != N_BEAMS)
        return rumbo_fail(error, RUMBO_ERROR, "the world answered something else than %d ranges", N_BEAMS);
    /* Lent from a pool of the host: no memory is asked for in a warm run. */
    ranges_m = self->host->lend_f32(out, N_BEAMS);
    readings = self->host->make_mut_f32(&ranges_m);
    if (readings == NULL || ranges_m.len != N_BEAMS)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    for (size_t k = 0; k < N_BEAMS; k++) {
        double exact_m = answer.ranges_m[k];
        double off_m = self->noise_m * (2.0 * self->host->random_uniform(self->rng) - 1.0);
        /* No reading, and nothing within reach (REP-117). */
        if (!(exact_m >= MIN_RANGE_M))
            readings[k] = NAN;
        else if (exact_m > MAX_RANGE_M)
            readings[k] = INFINITY;
        else
            readings[k] = (float)fmax(MIN_RANGE_M, fmin(MAX_RANGE_M, exact_m + off_m));
    }
    {
        rumbo_laser_scan scan = { .size = sizeof scan, .first_bearing_rad = -90.0 * DEGREE, .bearing_step_rad = DEGREE,
                                  .min_range_m = (float)MIN_RANGE_M, .max_range_m = (float)MAX_RANGE_M,
                                  .ranges_m = ranges_m };
        rumbo_observation observation = { .size = sizeof observation, .stamp_ns = call->now_ns, .kind = RUMBO_LASER_SCAN,
                                          .sensor = self->sensor, .valid = 1,
                                          .base_from_sensor = self->base_from_sensor, .data = &scan };
        return self->host->observe(out, &observation);
    }
}

static void destroy(void *instance)
{
    free(instance);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    scanner *self = calloc(1, sizeof *self);
    (void)entry;
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    self->host = host;
    self->sensor = context->sensor;
    self->base_from_sensor = context->base_from_sensor;
    self->rng = context->rng;
    self->name_len = context->name.len < sizeof self->name ? context->name.len : sizeof self->name;
    memcpy(self->name, context->name.data, self->name_len);
    /* The schema below has a default, and the host has looked at type and limits already. */
    host->config_f64(config, RUMBO_STR("noise_m"), &self->noise_m);
    *instance = self;
    return RUMBO_OK;
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest, rumbo_error *error)
{
    (void)entry, (void)config, (void)error;
    manifest->produces = 1u << RUMBO_LASER_SCAN;
    manifest->default_rate_hz = 10.0;
    return RUMBO_OK;
}

static const rumbo_sensor_table table = { .size = sizeof table, .destroy = destroy, .poll = poll };

static const rumbo_entry plugin = {
    .size = sizeof plugin,
    .stage = RUMBO_SENSOR,
    .name = RUMBO_TEXT("{{name}}"),
    .version = RUMBO_TEXT("0.1.0"),
    .summary = RUMBO_TEXT("a planar laser range finder that sees half of the surroundings"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": { \"noise_m\": {"
        "  \"type\": \"number\", \"default\": 0.01, \"minimum\": 0.0, \"maximum\": 1.0,"
        "  \"description\": \"Ranges are off by at most this much to both sides, meters.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("{{name}} 0.1.0", &plugin)
