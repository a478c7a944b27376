/* The planner `{{name}}`: a wave runs from the goal over the free cells, and the way leads down to where it began.
   Replace what `plan` does by your own algorithm; the rest can stay. */
#include "rumbo_plugin.h"

#include <stdlib.h>

typedef struct {
    const rumbo_host *host;
    double clearance_m;
} planner;

/* Lengths in thousandths of a cell; a heap is not needed for so few cells: a ring of buckets would be faster. */
static const int STEP_X[8] = { 1, -1, 0, 0, 1, -1, 1, -1 };
static const int STEP_Y[8] = { 0, 0, 1, -1, 1, 1, -1, -1 };
static const int32_t STEP_LENGTH[8] = { 1000, 1000, 1000, 1000, 1414, 1414, 1414, 1414 };

/* One search. */
typedef struct {
    const rumbo_grid *grid;
    long width, height;
    /* Length of the way from the goal, or -1; closed cells are -2. */
    int32_t *length;
    long *queue;
    unsigned char *queued;
} search;

static bool cell_of(const rumbo_grid *grid, double x_m, double y_m, long *cell)
{
    double dx = x_m - grid->origin[0], dy = y_m - grid->origin[1];
    double c = cos(grid->origin[2]), s = sin(grid->origin[2]);
    double col = floor((c * dx + s * dy) / grid->resolution_m), row = floor((c * dy - s * dx) / grid->resolution_m);
    if (!(col >= 0 && row >= 0 && col < grid->width && row < grid->height))
        return false;
    *cell = (long)row * (long)grid->width + (long)col;
    return true;
}

static rumbo_point middle_of(const rumbo_grid *grid, long cell)
{
    double x = ((double)(cell % (long)grid->width) + 0.5) * grid->resolution_m;
    double y = ((double)(cell / (long)grid->width) + 0.5) * grid->resolution_m;
    double c = cos(grid->origin[2]), s = sin(grid->origin[2]);
    rumbo_point point = { grid->origin[0] + c * x - s * y, grid->origin[1] + s * x + c * y };
    return point;
}

static bool is_open(const search *at, long x, long y)
{
    return x >= 0 && y >= 0 && x < at->width && y < at->height && at->length[y * at->width + x] != -2;
}

/* Closes every cell that is not free, or nearer to an occupied one than the clearance; never the robot's own. */
static void close_cells(search *at, double clearance_m, long start)
{
    const rumbo_grid *grid = at->grid;
    long reach = (long)ceil(clearance_m / grid->resolution_m + 0.5), n_cells = at->width * at->height;
    for (long cell = 0; cell < n_cells; cell++)
        at->length[cell] = grid->cells.data[cell] < grid->free_below ? -1 : -2;
    for (long cell = 0; cell < n_cells; cell++) {
        if (!(grid->cells.data[cell] > grid->occupied_above))
            continue;
        for (long dy = -reach; dy <= reach; dy++)
            for (long dx = -reach; dx <= reach; dx++) {
                long x = cell % at->width + dx, y = cell / at->width + dy;
                if (hypot((double)dx, (double)dy) < (double)reach && is_open(at, x, y))
                    at->length[y * at->width + x] = -2;
            }
    }
    if (start >= 0)
        at->length[start] = -1;
}

/* The wave: cells whose length became shorter are looked at again, in the order in which that happened. */
static int32_t spread(const planner *self, search *at, const rumbo_plan_request *request, long goal, rumbo_error *error)
{
    long n_cells = at->width * at->height, first = 0, n_queued = 1;
    at->length[goal] = 0;
    at->queue[0] = goal;
    at->queued[goal] = 1;
    for (unsigned long n_done = 0; n_queued > 0; n_done++) {
        long cell = at->queue[first], x = cell % at->width, y = cell / at->width;
        first = (first + 1) % n_cells;
        n_queued--;
        at->queued[cell] = 0;
        if (n_done % 500 == 0 && self->host->give_up_is_raised(request->give_up))
            return rumbo_fail(error, RUMBO_GIVEN_UP, "given up");
        for (int k = 0; k < 8; k++) {
            long next = (y + STEP_Y[k]) * at->width + x + STEP_X[k];
            int32_t length = at->length[cell] + STEP_LENGTH[k];
            /* No squeezing between two corners. */
            if (!is_open(at, x + STEP_X[k], y + STEP_Y[k]) || !is_open(at, x + STEP_X[k], y) || !is_open(at, x, y + STEP_Y[k]))
                continue;
            if (at->length[next] >= 0 && at->length[next] <= length)
                continue;
            at->length[next] = length;
            if (!at->queued[next]) {
                at->queued[next] = 1;
                at->queue[(first + n_queued++) % n_cells] = next;
            }
        }
    }
    return RUMBO_OK;
}

/* From the robot down to the goal. */
static void push_way(const search *at, const rumbo_plan_request *request, long start, long goal, rumbo_path_out *path)
{
    rumbo_path_point end = { request->goal, request->goal_yaw_rad };
    rumbo_push_point(path, request->start.x_m, request->start.y_m);
    for (long cell = start; cell != goal;) {
        long x = cell % at->width, y = cell / at->width, best = cell;
        int32_t best_length = INT32_MAX;
        for (int k = 0; k < 8; k++) {
            long next = (y + STEP_Y[k]) * at->width + x + STEP_X[k];
            if (!is_open(at, x + STEP_X[k], y + STEP_Y[k]) || !is_open(at, x + STEP_X[k], y) || !is_open(at, x, y + STEP_Y[k]))
                continue;
            if (at->length[next] >= 0 && at->length[next] + STEP_LENGTH[k] < best_length) {
                best = next;
                best_length = at->length[next] + STEP_LENGTH[k];
            }
        }
        cell = best;
        if (cell != goal) {
            rumbo_point middle = middle_of(at->grid, cell);
            rumbo_push_point(path, middle.x_m, middle.y_m);
        }
    }
    path->push(path->ctx, &end, 1);
    path->cost = at->length[start] / 1000.0 * at->grid->resolution_m;
}

static int32_t plan(void *instance, const rumbo_call *call, const rumbo_plan_request *request, rumbo_path_out *path,
                    rumbo_error *error)
{
    const planner *self = instance;
    const rumbo_grid *grid = request->grid;
    double yaw_rad = isnan(request->goal_yaw_rad) ? 0.0 : request->goal_yaw_rad;
    size_t n_cells;
    long start, goal;
    search at;
    int32_t status;
    (void)call;
    if (!isfinite(request->start.x_m + request->start.y_m + rumbo_yaw(request->start) + yaw_rad) ||
        !isfinite(request->goal.x_m + request->goal.y_m)) {
        snprintf(error->text, sizeof error->text, "the start or the goal");
        return rumbo_fail(error, RUMBO_BAD_NUMBER, "the start or the goal is not a finite number");
    }
    if (grid == NULL) {
        snprintf(error->text, sizeof error->text, "grid");
        return rumbo_fail(error, RUMBO_MISSING_LAYER, "the map has no grid");
    }
    error->place = request->goal;
    if (!cell_of(grid, request->goal.x_m, request->goal.y_m, &goal))
        return rumbo_fail(error, RUMBO_GOAL_OUTSIDE, "the goal lies outside the map");
    snprintf(error->text, sizeof error->text, "not free");
    if (!(grid->cells.data[goal] < grid->free_below))
        return rumbo_fail(error, RUMBO_GOAL_OCCUPIED, "the goal is not free");
    error->place.x_m = request->start.x_m;
    error->place.y_m = request->start.y_m;
    if (!cell_of(grid, request->start.x_m, request->start.y_m, &start))
        return rumbo_fail(error, RUMBO_START_OUTSIDE, "the start lies outside the map");
    n_cells = (size_t)grid->width * (size_t)grid->height;
    at.grid = grid;
    at.width = (long)grid->width;
    at.height = (long)grid->height;
    at.length = malloc(n_cells * sizeof *at.length);
    at.queue = malloc(n_cells * sizeof *at.queue);
    at.queued = calloc(n_cells, 1);
    if (at.length == NULL || at.queue == NULL || at.queued == NULL) {
        status = rumbo_fail(error, RUMBO_ERROR, "there is no memory for %zu cells", n_cells);
    } else {
        close_cells(&at, self->clearance_m, start);
        snprintf(error->text, sizeof error->text, "obstacles close every way; lower clearance_m");
        if (at.length[goal] == -2) {
            status = rumbo_fail(error, RUMBO_UNREACHABLE, "the goal is too close to an obstacle");
        } else {
            status = spread(self, &at, request, goal, error);
            if (status == RUMBO_OK && at.length[start] < 0)
                status = rumbo_fail(error, RUMBO_UNREACHABLE, "obstacles close every way");
        }
        if (status == RUMBO_OK)
            push_way(&at, request, start, goal, path);
    }
    free(at.length);
    free(at.queue);
    free(at.queued);
    return status;
}

static void destroy(void *instance)
{
    free(instance);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    planner *self = calloc(1, sizeof *self);
    (void)entry, (void)context;
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    self->host = host;
    /* The schema below has a default, and the host has looked at type and limits already. */
    host->config_f64(config, RUMBO_STR("clearance_m"), &self->clearance_m);
    *instance = self;
    return RUMBO_OK;
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest, rumbo_error *error)
{
    (void)entry, (void)config, (void)error;
    manifest->needs_layers = RUMBO_LAYER_GRID;
    return RUMBO_OK;
}

static const rumbo_planner_table table = { .size = sizeof table, .destroy = destroy, .plan = plan };

static const rumbo_entry plugin = {
    .size = sizeof plugin,
    .stage = RUMBO_PLANNER,
    .name = RUMBO_TEXT("{{name}}"),
    .version = RUMBO_TEXT("0.1.0"),
    .summary = RUMBO_TEXT("shortest paths over the free cells of the grid"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": { \"clearance_m\": {"
        "  \"type\": \"number\", \"default\": 0.35, \"minimum\": 0.0, \"maximum\": 5.0,"
        "  \"description\": \"Free space between the robot's middle and every obstacle, meters.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("{{name}} 0.1.0", &plugin)
