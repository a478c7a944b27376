/*
 * The sensor `kinect_live`: a Kinect v1 through libfreenect, which is opened when a real world first asks for a picture; a
 * program without it runs as before. A thread of its own waits for the device and fills a queue of four pictures, the
 * oldest of which goes when nobody comes for them; pictures are stamped when they arrive.
 *
 * In a simulated world it sees what the simulator shows such a camera; of a recording it passes on the recorded pictures.
 *
 * Interface: libfreenect_sync.h of the OpenKinect project; of it the two functions and the format below.
 */
#define _POSIX_C_SOURCE 200809L
#include "rumbo_plugin.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <time.h>

enum { COLUMNS = 640, ROWS = 480, N_PIXELS = COLUMNS * ROWS, N_QUEUED = 4 };
/* FREENECT_DEPTH_MM: whole millimeters along the optical axis, 0 for no reading. */
enum { DEPTH_MM = 5 };
#define UNIT_M 0.001f
/* The device's format ends at 10 m. */
#define MAX_RANGE_M 10.0
static const int64_t SECOND_NS = 1000000000;

/* Newest names first; the ones with a number come with the library, the one without with its headers. */
static const char *const LIBRARIES[] = { "libfreenect_sync.so.0.5", "libfreenect_sync.so.0", "libfreenect_sync.so" };

typedef int (*get_depth_function)(void **depth, uint32_t *stamp, int index, int format);
typedef void (*stop_function)(void);

typedef struct {
    int64_t arrived_ns;
    uint16_t counts[N_PIXELS];
} picture;

/* What the thread and the sensor share. Whoever of the two leaves last frees it. */
typedef struct {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    int index;
    get_depth_function get_depth;
    stop_function stop_device;
    picture queue[N_QUEUED];
    size_t first, len;
    uint64_t n_dropped;
    int64_t last_ns;
    int failure;
    bool shall_end, has_ended, is_left;
} device;

typedef struct {
    const rumbo_host *host;
    char name[128];
    char library[512];
    rumbo_pose3 base_from_sensor;
    /* Of the picture that is shown: every so many columns and rows of the device's. */
    rumbo_intrinsics intrinsics;
    uint32_t every;
    int64_t index;
    double silence_s;
    bool is_dry;
    device *device;
} kinect;

/* Time that no setting of a clock changes; only to know how old a picture is. */
static int64_t clock_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * SECOND_NS + now.tv_nsec;
}

static void free_device(device *device)
{
    pthread_cond_destroy(&device->changed);
    pthread_mutex_destroy(&device->lock);
    free(device);
}

/* Waits until the device may be tried again, or the thread shall end. */
static void pause_after_failure(device *device)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += 200000000;
    if (until.tv_nsec >= SECOND_NS) {
        until.tv_nsec -= SECOND_NS;
        until.tv_sec += 1;
    }
    while (!device->shall_end && pthread_cond_timedwait(&device->changed, &device->lock, &until) != ETIMEDOUT)
        ;
}

/* The place for the next picture; the oldest one gives way. */
static picture *next_place(device *device)
{
    if (device->len == N_QUEUED) {
        device->first = (device->first + 1) % N_QUEUED;
        device->len--;
        device->n_dropped++;
    }
    return &device->queue[(device->first + device->len++) % N_QUEUED];
}

/* The device's thread. Waiting for a picture may take for ever: nothing is locked meanwhile. */
static void *watch(void *shared)
{
    device *device = shared;
    bool is_left;
    pthread_mutex_lock(&device->lock);
    while (!device->shall_end) {
        void *data = NULL;
        uint32_t stamp = 0;
        int failure;
        pthread_mutex_unlock(&device->lock);
        failure = device->get_depth(&data, &stamp, device->index, DEPTH_MM);
        pthread_mutex_lock(&device->lock);
        if (failure == 0 && data == NULL)
            failure = -1;
        device->failure = failure;
        if (device->shall_end)
            break;
        if (failure != 0) {
            pause_after_failure(device);
        } else {
            picture *place = next_place(device);
            memcpy(place->counts, data, sizeof place->counts);
            place->arrived_ns = device->last_ns = clock_ns();
        }
    }
    pthread_mutex_unlock(&device->lock);
    device->stop_device();
    pthread_mutex_lock(&device->lock);
    device->has_ended = true;
    is_left = device->is_left;
    pthread_cond_broadcast(&device->changed);
    pthread_mutex_unlock(&device->lock);
    if (is_left)
        free_device(device);
    return NULL;
}

/* A function of a library; object and function pointers have the same form wherever dlsym exists. */
static bool find_function(void *library, const char *name, void *function, size_t size)
{
    void *found = dlsym(library, name);
    memcpy(function, &found, size);
    return found != NULL;
}

static int32_t device_error(const kinect *self, rumbo_error *error, const char *reason)
{
    snprintf(error->path, sizeof error->path, "%s", self->name);
    snprintf(error->text, sizeof error->text, "%s", reason);
    return rumbo_fail(error, RUMBO_DEVICE, "%s: %s", self->name, reason);
}

/* The library stays open until the program ends: threads of its own may outlive the last picture. */
static void *open_library(const kinect *self)
{
    void *library = NULL;
    if (self->library[0] != '\0')
        return dlopen(self->library, RTLD_NOW | RTLD_LOCAL);
    for (size_t k = 0; k < sizeof LIBRARIES / sizeof LIBRARIES[0] && library == NULL; k++)
        library = dlopen(LIBRARIES[k], RTLD_NOW | RTLD_LOCAL);
    return library;
}

static bool begin_lock(device *device)
{
    pthread_condattr_t monotonic;
    bool is_ready = pthread_condattr_init(&monotonic) == 0;
    is_ready = is_ready && pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC) == 0;
    is_ready = is_ready && pthread_cond_init(&device->changed, &monotonic) == 0;
    pthread_condattr_destroy(&monotonic);
    return is_ready && pthread_mutex_init(&device->lock, NULL) == 0;
}

static int32_t open_device(kinect *self, rumbo_error *error)
{
    char reason[sizeof error->text];
    pthread_t thread;
    device *device;
    void *library = open_library(self);
    if (library == NULL) {
        const char *why = dlerror();
        snprintf(reason, sizeof reason, "libfreenect_sync cannot be loaded (%s); install libfreenect, or set `library`",
                 why != NULL ? why : "no reason given");
        return device_error(self, error, reason);
    }
    device = calloc(1, sizeof *device);
    if (device == NULL || !begin_lock(device)) {
        free(device);
        return device_error(self, error, "there is no memory for its queue");
    }
    if (!find_function(library, "freenect_sync_get_depth", &device->get_depth, sizeof device->get_depth)
        || !find_function(library, "freenect_sync_stop", &device->stop_device, sizeof device->stop_device)) {
        free_device(device);
        return device_error(self, error, "`library` has no freenect_sync_get_depth and freenect_sync_stop: it is not libfreenect_sync");
    }
    device->index = (int)self->index;
    device->last_ns = clock_ns();
    if (pthread_create(&thread, NULL, watch, device) != 0) {
        free_device(device);
        return device_error(self, error, "the system gives no thread for it");
    }
    pthread_detach(thread);
    self->device = device;
    return RUMBO_OK;
}

/* A picture of whole millimeters, `age_ns` old. */
static int32_t show(const kinect *self, const rumbo_call *call, rumbo_observations *out, rumbo_u16_array depth,
                    int64_t age_ns, rumbo_error *error)
{
    rumbo_depth_image image = { .size = sizeof image, .intrinsics = self->intrinsics, .unit_m = UNIT_M, .depth = depth };
    rumbo_observation observation = {
        .size = sizeof observation,
        .stamp_ns = call->now_ns - age_ns,
        .kind = RUMBO_DEPTH_IMAGE,
        .valid = 1,
        .base_from_sensor = self->base_from_sensor,
        .data = &image,
    };
    int32_t status = self->host->observe(out, &observation);
    return status == RUMBO_OK ? status : rumbo_fail(error, status, "the host takes no depth pictures");
}

/* What a lent array holds is ours to write until it is given away. */
static uint16_t *writable(rumbo_u16_array array)
{
    return (uint16_t *)(uintptr_t)array.data;
}

static size_t n_shown(const kinect *self)
{
    return (size_t)self->intrinsics.width * self->intrinsics.height;
}

/* The first column and row that is shown: the middle ones of the first `every`. */
static uint32_t first_shown(uint32_t every)
{
    return (every - 1) / 2;
}

static void thin_out(const kinect *self, const uint16_t *from, uint16_t *to)
{
    uint32_t first = first_shown(self->every);
    for (uint32_t row = 0; row < self->intrinsics.height; row++) {
        const uint16_t *pixels = from + (size_t)(row * self->every + first) * COLUMNS + first;
        for (uint32_t column = 0; column < self->intrinsics.width; column++)
            *to++ = pixels[column * self->every];
    }
}

/* Everything that arrived since the last time. The lock is held only while one picture is copied. */
static int32_t poll_device(kinect *self, const rumbo_call *call, rumbo_observations *out, rumbo_error *error)
{
    device *device = self->device;
    int failure;
    int64_t silent_ns;
    uint64_t n_dropped;
    int32_t status = RUMBO_OK;
    for (size_t k = 0; k < N_QUEUED && status == RUMBO_OK; k++) {
        rumbo_u16_array depth = self->host->lend_u16(out, n_shown(self));
        int64_t age_ns = -1;
        if (depth.data == NULL)
            return rumbo_fail(error, RUMBO_ERROR, "there is no memory for a picture");
        pthread_mutex_lock(&device->lock);
        if (device->len > 0) {
            const picture *oldest = &device->queue[device->first];
            thin_out(self, oldest->counts, writable(depth));
            age_ns = clock_ns() - oldest->arrived_ns;
            device->first = (device->first + 1) % N_QUEUED;
            device->len--;
        }
        pthread_mutex_unlock(&device->lock);
        if (age_ns < 0) {
            self->host->block_release(depth.block);
            break;
        }
        status = show(self, call, out, depth, age_ns, error);
    }
    pthread_mutex_lock(&device->lock);
    failure = device->failure;
    silent_ns = clock_ns() - device->last_ns;
    n_dropped = device->n_dropped;
    pthread_mutex_unlock(&device->lock);
    if (call->is_watched)
        self->host->count(call->trace, RUMBO_STR("dropped_pictures"), (double)n_dropped);
    if (status == RUMBO_OK && failure != 0) {
        char reason[sizeof error->text];
        snprintf(reason, sizeof reason,
                 "no Kinect answers as number %d (libfreenect_sync says %d); is it plugged in and powered, and may you open it?",
                 device->index, failure);
        return device_error(self, error, reason);
    }
    if (status == RUMBO_OK && (double)silent_ns > self->silence_s * (double)SECOND_NS) {
        char reason[sizeof error->text];
        snprintf(reason, sizeof reason, "no picture for %.1f s (`silence_s` is %g)", (double)silent_ns / (double)SECOND_NS,
                 self->silence_s);
        return device_error(self, error, reason);
    }
    return status;
}

/* What the simulator shows an exact camera, in whole millimeters. */
static int32_t poll_simulation(const kinect *self, const rumbo_call *call, const rumbo_answer *answer,
                               rumbo_observations *out, rumbo_error *error)
{
    rumbo_u16_array depth;
    if (answer->n_ranges != n_shown(self))
        return rumbo_fail(error, RUMBO_ERROR, "the world answers %zu depths, expected %zu", answer->n_ranges, n_shown(self));
    depth = self->host->lend_u16(out, n_shown(self));
    if (depth.data == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory for a picture");
    for (size_t k = 0; k < n_shown(self); k++) {
        float depth_m = answer->ranges_m[k];
        writable(depth)[k] = depth_m > 0.0f && depth_m <= (float)MAX_RANGE_M ? (uint16_t)(depth_m / UNIT_M + 0.5f) : 0;
    }
    return show(self, call, out, depth, 0, error);
}

/* Recorded pictures, under this sensor's name and mount. Their arrays are the world's: each is kept once more. */
static int32_t pass_on(const kinect *self, const rumbo_answer *answer, rumbo_observations *out, rumbo_error *error)
{
    for (size_t k = 0; k < answer->recorded->len; k++) {
        const rumbo_observation *recorded = rumbo_seen_at(answer->recorded, k);
        rumbo_observation observation;
        int32_t status;
        if (recorded->kind != RUMBO_DEPTH_IMAGE)
            continue;
        observation = *recorded;
        observation.size = sizeof observation;
        observation.base_from_sensor = self->base_from_sensor;
        self->host->block_retain(((const rumbo_depth_image *)recorded->data)->depth.block);
        status = self->host->observe(out, &observation);
        if (status != RUMBO_OK)
            return rumbo_fail(error, status, "a recorded picture does not hold together");
    }
    return RUMBO_OK;
}

static int32_t poll(void *instance, const rumbo_call *call, rumbo_world *world, rumbo_observations *out, rumbo_error *error)
{
    kinect *self = instance;
    rumbo_probe probe = {
        .size = sizeof probe,
        .kind = RUMBO_PROBE_DEPTH,
        .base_from_sensor = self->base_from_sensor,
        .intrinsics = self->intrinsics,
        .max_range_m = MAX_RANGE_M,
    };
    rumbo_answer answer = { .size = sizeof answer };
    rumbo_str why = { NULL, 0 };
    int32_t status = self->host->probe(world, &probe, &answer, &why);
    if (status == RUMBO_NO_ANSWER) {
        /* The first refusal says what this sensor needs; a second one only that there is no recording either. */
        char reason[256];
        snprintf(reason, sizeof reason, "%.*s", (int)why.len, why.data != NULL ? why.data : "");
        probe.kind = RUMBO_PROBE_CHANNEL;
        probe.name = rumbo_str_of(self->name);
        status = self->host->probe(world, &probe, &answer, &why);
        if (status != RUMBO_OK)
            return rumbo_fail(error, RUMBO_NO_ANSWER, "%s", reason);
    }
    if (status != RUMBO_OK)
        return rumbo_fail(error, status, "%.*s", (int)why.len, why.data != NULL ? why.data : "");
    switch (answer.kind) {
    case RUMBO_ANSWER_RANGES:
        return poll_simulation(self, call, &answer, out, error);
    case RUMBO_ANSWER_RECORDED:
        return pass_on(self, &answer, out, error);
    case RUMBO_ANSWER_LIVE:
        if (self->is_dry)
            return RUMBO_OK;
        status = self->device != NULL ? RUMBO_OK : open_device(self, error);
        return status == RUMBO_OK ? poll_device(self, call, out, error) : status;
    default:
        return rumbo_fail(error, RUMBO_ERROR, "the world answers neither depths nor a recording");
    }
}

/* A device that hangs must not keep the program from ending: after a second its thread is left to itself, which frees what
   is shared should it ever come back. */
static void close_device(device *device)
{
    struct timespec until;
    bool has_ended;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += 1;
    pthread_mutex_lock(&device->lock);
    device->shall_end = true;
    pthread_cond_broadcast(&device->changed);
    while (!device->has_ended && pthread_cond_timedwait(&device->changed, &device->lock, &until) != ETIMEDOUT)
        ;
    has_ended = device->has_ended;
    device->is_left = !has_ended;
    pthread_mutex_unlock(&device->lock);
    if (has_ended)
        free_device(device);
}

static void destroy(void *instance)
{
    kinect *self = instance;
    if (self->device != NULL)
        close_device(self->device);
    free(self);
}

static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
                      const rumbo_context *context, void **instance, rumbo_error *error)
{
    static const char *const NUMBERS[] = { "focal_x_px", "focal_y_px", "center_x_px", "center_y_px", "silence_s" };
    double numbers[5] = { 0.0 };
    rumbo_str library = { NULL, 0 };
    int64_t every = 1;
    kinect *self;
    (void)entry;
    for (size_t k = 0; k < 5; k++) {
        if (host->config_f64(config, rumbo_str_of(NUMBERS[k]), &numbers[k]) != RUMBO_OK)
            return rumbo_fail(error, RUMBO_BAD_CONFIG, "%s is missing", NUMBERS[k]);
    }
    if ((self = calloc(1, sizeof *self)) == NULL)
        return rumbo_fail(error, RUMBO_ERROR, "there is no memory");
    self->host = host;
    self->silence_s = numbers[4];
    self->base_from_sensor = context->base_from_sensor;
    self->is_dry = context->dry_run != 0;
    snprintf(self->name, sizeof self->name, "%.*s", (int)context->name.len, context->name.data);
    if (host->config_i64(config, RUMBO_STR("index"), &self->index) != RUMBO_OK
        || host->config_i64(config, RUMBO_STR("every"), &every) != RUMBO_OK || every < 1 || every > 16
        || host->config_str(config, RUMBO_STR("library"), &library) != RUMBO_OK || library.len >= sizeof self->library) {
        free(self);
        return rumbo_fail(error, RUMBO_BAD_CONFIG, "index, every and library: expected what the schema says");
    }
    self->every = (uint32_t)every;
    self->intrinsics = (rumbo_intrinsics){
        COLUMNS / self->every,
        ROWS / self->every,
        { numbers[0] / (double)every, numbers[1] / (double)every },
        { (numbers[2] - first_shown(self->every)) / (double)every, (numbers[3] - first_shown(self->every)) / (double)every },
    };
    snprintf(self->library, sizeof self->library, "%.*s", (int)library.len, library.data != NULL ? library.data : "");
    *instance = self;
    return RUMBO_OK;
}

static int32_t manifest(const rumbo_entry *entry, const rumbo_config *config, rumbo_manifest *manifest, rumbo_error *error)
{
    (void)entry, (void)config, (void)error;
    manifest->produces = 1u << RUMBO_DEPTH_IMAGE;
    manifest->default_rate_hz = 30.0;
    return RUMBO_OK;
}

static const rumbo_sensor_table table = { .size = sizeof table, .destroy = destroy, .poll = poll };

static const rumbo_entry kinect_live_entry = {
    .size = sizeof kinect_live_entry,
    .stage = RUMBO_SENSOR,
    .name = RUMBO_TEXT("kinect_live"),
    .version = RUMBO_TEXT("1.0.0"),
    .summary = RUMBO_TEXT("A real Kinect v1 through libfreenect"),
    .schema_json = RUMBO_TEXT(
        "{ \"type\": \"object\", \"additionalProperties\": false, \"properties\": {"
        "  \"index\": { \"type\": \"integer\", \"default\": 0, \"minimum\": 0, \"maximum\": 15,"
        "    \"description\": \"Which Kinect, counted from 0 as libfreenect finds them.\" },"
        "  \"every\": { \"type\": \"integer\", \"default\": 4, \"minimum\": 1, \"maximum\": 16,"
        "    \"description\": \"Every so many columns and rows of the 640 x 480 are shown.\" },"
        "  \"library\": { \"type\": \"string\", \"default\": \"\","
        "    \"description\": \"File of libfreenect_sync; without it the system's.\" },"
        "  \"silence_s\": { \"type\": \"number\", \"default\": 2.0, \"minimum\": 0.05, \"maximum\": 60.0,"
        "    \"description\": \"Without a picture for so long the device counts as lost, seconds.\" },"
        "  \"focal_x_px\": { \"type\": \"number\", \"default\": 589.4, \"minimum\": 1.0,"
        "    \"description\": \"Focal length along the columns, pixels; the default is a view of 57 degrees.\" },"
        "  \"focal_y_px\": { \"type\": \"number\", \"default\": 589.4, \"minimum\": 1.0,"
        "    \"description\": \"Focal length along the rows, pixels.\" },"
        "  \"center_x_px\": { \"type\": \"number\", \"default\": 319.5,"
        "    \"description\": \"Column of the optical axis, pixels from 0.\" },"
        "  \"center_y_px\": { \"type\": \"number\", \"default\": 239.5,"
        "    \"description\": \"Row of the optical axis from the top, pixels from 0.\" } } }"),
    .table = &table,
    .create = create,
    .manifest = manifest,
};

RUMBO_PLUGINS("kinect_live 1.0.0, " __VERSION__, &kinect_live_entry)
