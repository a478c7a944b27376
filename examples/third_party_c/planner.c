/*
 * The planner `wave`: a wave front runs over the free cells from the goal until it meets the robot, and the way back down
 * is pulled straight. Uniform-cost search (Dijkstra 1959) on the 8-connected grid with the steps 5 and 7 of the chamfer
 * metric (Borgefors 1986) and a ring of buckets (Dial 1969), so that there is no heap and nothing is rounded.
 */
#include "rumbo_plugin.h"

#include <stdlib.h>

enum { STRAIGHT = 5, DIAGONAL = 7, N_BUCKETS = DIAGONAL + 1, EXPANSIONS_PER_LOOK = 1000 };
static const uint32_t FAR = UINT32_MAX;

/* What a cell is: bits. */
enum { OCCUPIED = 1, UNKNOWN = 2, TOO_CLOSE = 4 };

typedef struct {
    uint32_t *cells;
    size_t len, room;
} bucket;

typedef struct {
    const rumbo_host *host;
    double clearance_m;
    /* Kept from call to call, for the largest grid so far. */
    size_t room;
    uint8_t *kinds;
    uint32_t *costs;
    uint32_t *way;
    bucket buckets[N_BUCKETS];
} wave;

/* One request, in cells. */
typedef struct {
    wave *self;
    const rumbo_grid *grid;
    int32_t width, height;
    int32_t start_x, start_y, goal_x, goal_y;
    double clearance;
} job;

static const int32_t STEP_X[8] = { 1, 0, -1, 0, 1, -1, -1, 1 };
static const int32_t STEP_Y[8] = { 0, 1, 0, -1, 1, 1, -1, -1 };

static bool is_inside(const job *job, int32_t x, int32_t y)
{
    return x >= 0 && y >= 0 && x < job->width && y < job->height;
}

static uint32_t at(const job *job, int32_t x, int32_t y)
{
    return (uint32_t)y * (uint32_t)job->width + (uint32_t)x;
}

/* The robot may stand closer to an obstacle than it would drive: free cells around it are a way out. */
static bool is_open(const job *job, int32_t x, int32_t y)
{
    uint8_t kind;
    if (!is_inside(job, x, y))
        return false;
    kind = job->self->kinds[at(job, x, y)];
    if (kind == TOO_CLOSE)
        return hypot(x - job->start_x, y - job->start_y) <= job->clearance;
    return kind == 0;
}

static bool cell_of(const job *job, rumbo_point point, int32_t *x, int32_t *y)
{
    const double *origin = job->grid->origin;
    double dx = point.x_m - origin[0], dy = point.y_m - origin[1];
    double c = cos(origin[2]), s = sin(origin[2]);
    double column = floor((c * dx + s * dy) / job->grid->resolution_m);
    double row = floor((c * dy - s * dx) / job->grid->resolution_m);
    if (!(column >= 0.0 && row >= 0.0 && column < job->width && row < job->height))
        return false;
    *x = (int32_t)column;
    *y = (int32_t)row;
    return true;
}

static rumbo_point middle_of(const job *job, int32_t x, int32_t y)
{
    const double *origin = job->grid->origin;
    double dx = (x + 0.5) * job->grid->resolution_m, dy = (y + 0.5) * job->grid->resolution_m;
    double c = cos(origin[2]), s = sin(origin[2]);
    rumbo_point point;
    point.x_m = origin[0] + c * dx - s * dy;
    point.y_m = origin[1] + s * dx + c * dy;
    return point;
}

static bool make_room(wave *self, size_t n_cells)
{
    uint8_t *kinds;
    uint32_t *costs, *way;
    if (n_cells <= self->room)
        return true;
    /* What was enlarged is kept at once: where a later one fails, nothing is lost. */
    if ((kinds = realloc(self->kinds, n_cells * sizeof *kinds)) == NULL)
        return false;
    self->kinds = kinds;
    if ((costs = realloc(self->costs, n_cells * sizeof *costs)) == NULL)
        return false;
    self->costs = costs;
    if ((way = realloc(self->way, n_cells * sizeof *way)) == NULL)
        return false;
    self->way = way;
    self->room = n_cells;
    return true;
}

/* What each cell is; then a disk of `clearance` around every occupied cell that has a cell beside it that is not. */
static void classify(const job *job)
{
    uint8_t *kinds = job->self->kinds;
    const float *cells = job->grid->cells.data;
    size_t n_cells = (size_t)job->width * (size_t)job->height;
    int32_t reach = (int32_t)floor(job->clearance);
    for (size_t k = 0; k < n_cells; k++) {
        if (cells[k] > job->grid->occupied_above)
            kinds[k] = OCCUPIED;
        else
            kinds[k] = cells[k] < job->grid->free_below ? 0 : UNKNOWN;
    }
    for (int32_t y = 0; y < job->height; y++) {
        for (int32_t x = 0; x < job->width; x++) {
            bool is_edge = false;
            if (!(kinds[at(job, x, y)] & OCCUPIED))
                continue;
            for (int side = 0; side < 4 && !is_edge; side++) {
                int32_t to_x = x + STEP_X[side], to_y = y + STEP_Y[side];
                is_edge = is_inside(job, to_x, to_y) && !(kinds[at(job, to_x, to_y)] & OCCUPIED);
            }
            if (!is_edge)
                continue;
            for (int32_t dy = -reach; dy <= reach; dy++) {
                int32_t half = (int32_t)floor(sqrt(job->clearance * job->clearance - (double)dy * dy));
                for (int32_t dx = -half; dx <= half; dx++) {
                    if (is_inside(job, x + dx, y + dy))
                        kinds[at(job, x + dx, y + dy)] |= TOO_CLOSE;
                }
            }
        }
    }
}

static bool put(wave *self, uint32_t cost, uint32_t cell)
{
    bucket *bucket = &self->buckets[cost % N_BUCKETS];
    if (bucket->len == bucket->room) {
        size_t room = bucket->room == 0 ? 256 : 2 * bucket->room;
        uint32_t *cells = realloc(bucket->cells, room * sizeof *cells);
        if (cells == NULL)
            return false;
        bucket->cells = cells;
        bucket->room = room;
    }
    bucket->cells[bucket->len++] = cell;
    return true;
}

/* The wave: `costs` of every cell that it reaches until it reaches the start. */
static int32_t spread(const job *job, const rumbo_plan_request *request, size_t *n_expanded, rumbo_error *error)
{
    wave *self = job->self;
    const uint32_t start = at(job, job->start_x, job->start_y);
    size_t n_cells = (size_t)job->width * (size_t)job->height, n_waiting = 1;
    for (size_t k = 0; k < n_cells; k++)
        self->costs[k] = FAR;
    for (int k = 0; k < N_BUCKETS; k++)
        self->buckets[k].len = 0;
    *n_expanded = 0;
    self->costs[at(job, job->goal_x, job->goal_y)] = 0;
    if (!put(self, 0, at(job, job->goal_x, job->goal_y)))
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory for the wave");
    for (uint32_t cost = 0; n_waiting > 0; cost++) {
        bucket *bucket = &self->buckets[cost % N_BUCKETS];
        while (bucket->len > 0) {
            uint32_t cell = bucket->cells[--bucket->len];
            int32_t x = (int32_t)(cell % (uint32_t)job->width), y = (int32_t)(cell / (uint32_t)job->width);
            n_waiting--;
            if (self->costs[cell] != cost)
                continue; /* A shorter way was found after it was put here. */
            if (cell == start)
                return RUMBO_OK;
            if (++*n_expanded % EXPANSIONS_PER_LOOK == 0 && self->host->give_up_is_raised(request->give_up))
                return rumbo_fail(error, RUMBO_GIVEN_UP, "given up");
            for (int k = 0; k < 8; k++) {
                int32_t to_x = x + STEP_X[k], to_y = y + STEP_Y[k];
                uint32_t to_cost = cost + (k < 4 ? STRAIGHT : DIAGONAL), to;
                /* A diagonal step squeezes through no corner. */
                if (!is_open(job, to_x, to_y) || (k >= 4 && !(is_open(job, to_x, y) && is_open(job, x, to_y))))
                    continue;
                to = at(job, to_x, to_y);
                if (to_cost >= self->costs[to])
                    continue;
                self->costs[to] = to_cost;
                if (!put(self, to_cost, to))
                    return rumbo_fail(error, RUMBO_ERROR, "there is no memory for the wave");
                n_waiting++;
            }
        }
    }
    snprintf(error->text, sizeof error->text,
             "obstacles close every way with %.2f m of clearance; lower clearance_m or open a way", self->clearance_m);
    return rumbo_fail(error, RUMBO_UNREACHABLE, "%s", error->text);
}

/* Down the wave from the start to the goal into `way`; how many cells that are. */
static size_t descend(const job *job)
{
    wave *self = job->self;
    int32_t x = job->start_x, y = job->start_y;
    size_t len = 0;
    self->way[len++] = at(job, x, y);
    while (self->costs[at(job, x, y)] > 0) {
        uint32_t cost = self->costs[at(job, x, y)];
        for (int k = 0; k < 8; k++) {
            int32_t to_x = x + STEP_X[k], to_y = y + STEP_Y[k];
            if (!is_open(job, to_x, to_y) || (k >= 4 && !(is_open(job, to_x, y) && is_open(job, x, to_y))))
                continue;
            if (self->costs[at(job, to_x, to_y)] == cost - (k < 4 ? STRAIGHT : DIAGONAL)) {
                x = to_x;
                y = to_y;
                break;
            }
        }
        self->way[len++] = at(job, x, y);
    }
    return len;
}

/* Whether every cell on the straight line between two cells' middles is open. */
static bool sees(const job *job, uint32_t from, uint32_t to)
{
    double x = from % (uint32_t)job->width, y = from / (uint32_t)job->width;
    double dx = (double)(to % (uint32_t)job->width) - x, dy = (double)(to / (uint32_t)job->width) - y;
    int32_t n_samples = (int32_t)ceil(4.0 * hypot(dx, dy));
    for (int32_t k = 1; k < n_samples; k++) {
        double part = (double)k / n_samples;
        if (!is_open(job, (int32_t)floor(x + part * dx + 0.5), (int32_t)floor(y + part * dy + 0.5)))
            return false;
    }
    return true;
}

/* Pulls the way straight and pushes where it turns. */
static void push_way(const job *job, const rumbo_plan_request *request, size_t len, rumbo_path_out *path)
{
    const uint32_t *way = job->self->way;
    rumbo_path_point end;
    rumbo_point last = { request->start.x_m, request->start.y_m };
    double length_m = 0.0;
    size_t anchor = 0;
    rumbo_push_point(path, last.x_m, last.y_m);
    for (size_t k = 2; k < len; k++) {
        if (!sees(job, way[anchor], way[k])) {
            uint32_t cell = way[k - 1];
            rumbo_point turn = middle_of(job, (int32_t)(cell % (uint32_t)job->width), (int32_t)(cell / (uint32_t)job->width));
            rumbo_push_point(path, turn.x_m, turn.y_m);
            length_m += hypot(turn.x_m - last.x_m, turn.y_m - last.y_m);
            last = turn;
            anchor = k - 1;
        }
    }
    end.position = request->goal;
    end.yaw_rad = request->goal_yaw_rad;
    path->push(path->ctx, &end, 1);
    path->cost = length_m + hypot(end.position.x_m - last.x_m, end.position.y_m - last.y_m);
}

/* Shows how far the wave came: every cell of the costs 0, 250, 500, ... */
static void draw_wave(const job *job, const rumbo_call *call, size_t n_expanded)
{
    const rumbo_host *host = job->self->host;
    rumbo_point points[512];
    size_t len = 0;
    if (!call->is_watched)
        return;
    host->count(call->trace, RUMBO_STR("expanded_cells"), (double)n_expanded);
    for (int32_t y = 0; y < job->height; y++) {
        for (int32_t x = 0; x < job->width; x++) {
            uint32_t cost = job->self->costs[at(job, x, y)];
            if (cost == FAR || cost % 250 != 0)
                continue;
            points[len++] = middle_of(job, x, y);
            if (len == sizeof points / sizeof points[0]) {
                host->draw_points(call->trace, RUMBO_STR("wave front"), points, len);
                len = 0;
            }
        }
    }
    host->draw_points(call->trace, RUMBO_STR("wave front"), points, len);
}

/* Meters from the middle of a cell to that of the nearest occupied one within the clearance. */
static double nearest_m(const job *job, int32_t x, int32_t y)
{
    int32_t reach = (int32_t)floor(job->clearance);
    double nearest = job->clearance;
    for (int32_t dy = -reach; dy <= reach; dy++) {
        for (int32_t dx = -reach; dx <= reach; dx++) {
            if (is_inside(job, x + dx, y + dy) && (job->self->kinds[at(job, x + dx, y + dy)] & OCCUPIED))
                nearest = fmin(nearest, hypot(dx, dy));
        }
    }
    return nearest * job->grid->resolution_m;
}

static int32_t refuse_ends(const job *job, const rumbo_plan_request *request, rumbo_error *error)
{
    uint8_t goal = job->self->kinds[at(job, job->goal_x, job->goal_y)];
    uint8_t start = job->self->kinds[at(job, job->start_x, job->start_y)];
    if (goal == TOO_CLOSE && !is_open(job, job->goal_x, job->goal_y)) {
        error->place = request->goal;
        error->values[0] = nearest_m(job, job->goal_x, job->goal_y);
        error->values[1] = job->self->clearance_m;
        return rumbo_fail(error, RUMBO_GOAL_TOO_CLOSE, "the goal is too close to an obstacle");
    }
    if (goal & (OCCUPIED | UNKNOWN)) {
        const char *found = goal & OCCUPIED ? "occupied" : "unknown";
        error->place = request->goal;
        snprintf(error->text, sizeof error->text, "%s", found);
        return rumbo_fail(error, RUMBO_GOAL_OCCUPIED, "the goal is %s", found);
    }
    if (start & (OCCUPIED | UNKNOWN)) {
        const char *found = start & OCCUPIED ? "occupied" : "unknown";
        error->place.x_m = request->start.x_m;
        error->place.y_m = request->start.y_m;
        snprintf(error->text, sizeof error->text, "%s", found);
        return rumbo_fail(error, RUMBO_START_OCCUPIED, "the start is %s", found);
    }
    return RUMBO_OK;
}

static int32_t plan(void *instance, const rumbo_call *call, const rumbo_plan_request *request, rumbo_path_out *path,
                    rumbo_error *error)
{
    rumbo_point start = { request->start.x_m, request->start.y_m };
    size_t n_expanded = 0;
    int32_t status;
    job job = { .self = instance, .grid = request->grid };
    if (job.grid == NULL) {
        snprintf(error->text, sizeof error->text, "grid");
        return rumbo_fail(error, RUMBO_MISSING_LAYER, "the map has no grid");
    }
    if (job.grid->width > INT32_MAX || job.grid->height > INT32_MAX || job.grid->cells.len >= FAR / DIAGONAL)
        return rumbo_fail(error, RUMBO_ERROR, "a grid of %zu cells is too large for this planner", job.grid->cells.len);
    job.width = (int32_t)job.grid->width;
    job.height = (int32_t)job.grid->height;
    job.clearance = job.self->clearance_m / job.grid->resolution_m;
    if (!isfinite(start.x_m + start.y_m + rumbo_yaw(request->start)) || !isfinite(request->goal.x_m + request->goal.y_m)) {
        snprintf(error->text, sizeof error->text, "%s", isfinite(request->goal.x_m + request->goal.y_m) ? "start" : "goal");
        return rumbo_fail(error, RUMBO_BAD_NUMBER, "the %s is not finite", error->text);
    }
    if (!cell_of(&job, request->goal, &job.goal_x, &job.goal_y)) {
        error->place = request->goal;
        return rumbo_fail(error, RUMBO_GOAL_OUTSIDE, "the goal lies outside of the map");
    }
    if (!cell_of(&job, start, &job.start_x, &job.start_y)) {
        error->place = start;
        return rumbo_fail(error, RUMBO_START_OUTSIDE, "the start lies outside of the map");
    }
    if (!make_room(job.self, job.grid->cells.len))
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory for a grid of %zu cells", job.grid->cells.len);
    classify(&job);
    status = refuse_ends(&job, request, error);
    if (status != RUMBO_OK)
        return status;
    status = spread(&job, request, &n_expanded, error);
    draw_wave(&job, call, n_expanded);
    if (status == RUMBO_OK)
        push_way(&job, request, descend(&job), path);
    return status;
}

static void destroy(void *instance)
{
    wave *self = instance;
    for (int k = 0; k < N_BUCKETS; k++)
        free(self->buckets[k].cells);
    free(self->kinds);
    free(self->costs);
    free(self->way);
    free(self);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    wave *self;
    double clearance_m = 0.0;
    (void)entry;
    /* The schema has a default, and the host has looked at type and limits already. */
    if (host->config_f64(config, RUMBO_STR("clearance_m"), &clearance_m) != RUMBO_OK)
        return rumbo_fail(error, RUMBO_BAD_CONFIG, "clearance_m is missing");
    if (context->robot != NULL && clearance_m < context->robot->radius_m) {
        snprintf(error->path, sizeof error->path, "clearance_m");
        return rumbo_fail(error, RUMBO_BAD_CONFIG, "%g m is less than the robot's radius of %g m", clearance_m,
                          context->robot->radius_m);
    }
    self = calloc(1, sizeof *self);
    if (self == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    self->host = host;
    self->clearance_m = clearance_m;
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

static const rumbo_entry wave_entry = {
    .size = sizeof wave_entry,
    .stage = RUMBO_PLANNER,
    .name = RUMBO_TEXT("wave"),
    .version = RUMBO_TEXT("1.0.0"),
    .summary = RUMBO_TEXT("A wave front over the grid, in plain C"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": { \"clearance_m\": {"
        "  \"type\": \"number\", \"default\": 0.35, \"minimum\": 0.0,"
        "  \"description\": \"Distance that the robot's middle keeps from obstacles, meters.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("wave 1.0.0, " __VERSION__, &wave_entry)
