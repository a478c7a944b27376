/* The map builder `{{name}}`: a grid in which unseen floor counts as free until a scan shows something there.
   Replace what `insert` does by your own algorithm; the rest can stay. */
#include "rumbo_plugin.h"

#include <stdlib.h>

/* Edge of a cell, meters. */
static const double RESOLUTION_M = 0.05;
/* Log-odds of floor that nobody has seen, below what is free; what one hit adds; what a beam that passes takes away. */
static const float UNSEEN = -2.0f, HIT = 1.5f, PASS = -0.3f, MOST = 6.9f;
/* Log-odds of the probabilities 0.65 and 0.196, as in ROS map files. */
static const float OCCUPIED_ABOVE = 0.6190392f, FREE_BELOW = -1.4114846f;

typedef struct {
    const rumbo_host *host;
    double size_m;
} builder;

static int32_t start(void *instance, rumbo_map_mut *map, rumbo_error *error)
{
    const builder *self = instance;
    uint32_t edge = (uint32_t)ceil(self->size_m / RESOLUTION_M);
    double corner_m = -(double)edge * RESOLUTION_M / 2.0;
    size_t n_cells = (size_t)edge * (size_t)edge;
    rumbo_grid grid = { .size = sizeof grid, .width = edge, .height = edge, .resolution_m = RESOLUTION_M,
                        .origin = { corner_m, corner_m, 0.0 }, .occupied_above = OCCUPIED_ABOVE, .free_below = FREE_BELOW };
    float *cells;
    grid.cells.block = self->host->block_new(n_cells * sizeof *cells);
    if (grid.cells.block == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory for %zu cells", n_cells);
    /* The elements lie 64 bytes behind the header of the block. */
    cells = (float *)(void *)((char *)grid.cells.block + 64);
    for (size_t k = 0; k < n_cells; k++)
        cells[k] = UNSEEN;
    grid.cells.len = n_cells;
    grid.cells.data = cells;
    self->host->map_set_version(map, self->host->map_version(map) + 1);
    return self->host->map_put_grid(map, 0, &grid);
}

static void change(const rumbo_grid *grid, float *cells, double x_m, double y_m, float by, long *last)
{
    double col = floor((x_m - grid->origin[0]) / grid->resolution_m), row = floor((y_m - grid->origin[1]) / grid->resolution_m);
    long cell;
    if (!(col >= 0 && row >= 0 && col < grid->width && row < grid->height))
        return;
    cell = (long)row * (long)grid->width + (long)col;
    if (cell == *last)
        return;
    *last = cell;
    cells[cell] = fmaxf(UNSEEN, fminf(MOST, cells[cell] + by));
}

/* Puts one scan into the grid. */
static void paint(const rumbo_grid *grid, float *cells, rumbo_pose2 map_from_sensor, const rumbo_laser_scan *scan)
{
    for (size_t k = 0; k < scan->ranges_m.len; k++) {
        double range_m = scan->ranges_m.data[k], bearing_rad = scan->first_bearing_rad + scan->bearing_step_rad * (double)k;
        double c = cos(bearing_rad), s = sin(bearing_rad), x, y;
        long n_steps, last = -1;
        if (!(range_m >= scan->min_range_m && range_m <= scan->max_range_m))
            continue;
        x = map_from_sensor.cos_yaw * c - map_from_sensor.sin_yaw * s;
        y = map_from_sensor.sin_yaw * c + map_from_sensor.cos_yaw * s;
        /* Half a cell from one look to the next, and away from the hit itself. */
        n_steps = (long)fmin(range_m / RESOLUTION_M * 2.0, 10000.0);
        for (long step = 0; step + 3 < n_steps; step++) {
            double way_m = range_m * (double)step / (double)n_steps;
            change(grid, cells, map_from_sensor.x_m + x * way_m, map_from_sensor.y_m + y * way_m, PASS, &last);
        }
        last = -1;
        change(grid, cells, map_from_sensor.x_m + x * range_m, map_from_sensor.y_m + y * range_m, HIT, &last);
    }
}

static int32_t insert(void *instance, const rumbo_call *call, const rumbo_seen *seen, const rumbo_estimate *estimate,
                      rumbo_map_mut *map, rumbo_error *error)
{
    const builder *self = instance;
    rumbo_pose2 map_from_base = rumbo_flatten(estimate->map_from_base);
    rumbo_grid grid = { .size = sizeof grid };
    bool has_changed = false;
    float *cells;
    (void)call;
    if (estimate->status != RUMBO_TRACKING || !isfinite(map_from_base.x_m + map_from_base.y_m + rumbo_yaw(map_from_base)))
        return RUMBO_OK;
    snprintf(error->text, sizeof error->text, "grid");
    if (self->host->map_take_grid(map, 0, &grid) != RUMBO_OK)
        return rumbo_fail(error, RUMBO_MISSING_LAYER, "the map has no grid");
    /* Our own cells: nobody else's view of them changes. */
    cells = self->host->make_mut_f32(&grid.cells);
    for (size_t k = 0; cells != NULL && k < seen->len; k++) {
        const rumbo_observation *observation = rumbo_seen_at(seen, k);
        const rumbo_laser_scan *scan = observation->data;
        if (observation->kind != RUMBO_LASER_SCAN || !observation->valid ||
            !isfinite(scan->first_bearing_rad + scan->bearing_step_rad))
            continue;
        paint(&grid, cells, rumbo_compose(map_from_base, rumbo_flatten(observation->base_from_sensor)), scan);
        has_changed = true;
    }
    /* Who computed something from the map learns that it is stale. */
    if (has_changed)
        self->host->map_set_version(map, self->host->map_version(map) + 1);
    /* What was taken must be put back. */
    return self->host->map_put_grid(map, 0, &grid);
}

static void destroy(void *instance)
{
    free(instance);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    builder *self = calloc(1, sizeof *self);
    (void)entry, (void)context;
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    self->host = host;
    /* The schema below has a default, and the host has looked at type and limits already. */
    host->config_f64(config, RUMBO_STR("size_m"), &self->size_m);
    *instance = self;
    return RUMBO_OK;
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest, rumbo_error *error)
{
    (void)entry, (void)config, (void)error;
    manifest->gives_layers = RUMBO_LAYER_GRID;
    manifest->n_consumes = 1;
    manifest->consumes[0] = 1u << RUMBO_LASER_SCAN;
    return RUMBO_OK;
}

static const rumbo_map_builder_table table = {
    .size = sizeof table, .destroy = destroy, .start = start, .insert = insert
};

static const rumbo_entry plugin = {
    .size = sizeof plugin,
    .stage = RUMBO_MAP_BUILDER,
    .name = RUMBO_TEXT("{{name}}"),
    .version = RUMBO_TEXT("0.1.0"),
    .summary = RUMBO_TEXT("a grid from laser scans, free where nothing was seen"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": { \"size_m\": {"
        "  \"type\": \"number\", \"default\": 30.0, \"minimum\": 1.0, \"maximum\": 200.0,"
        "  \"description\": \"Edge of the square around the map's origin that is mapped, meters.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("{{name}} 0.1.0", &plugin)
