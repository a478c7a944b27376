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
