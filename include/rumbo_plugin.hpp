/*
 * The plugin ABI of Rumbo for C++17: one class to derive from for each stage, over rumbo_plugin.h.
 *
 *     #include "rumbo_plugin.hpp"
 *     struct Straight : rumbo::planner {
 *         explicit Straight(const rumbo::setting &) {}
 *         void plan(const rumbo_call &, const rumbo_plan_request &request, rumbo_path_out &path) override {
 *             rumbo_push_point(&path, request.start.x_m, request.start.y_m);
 *             rumbo_push_point(&path, request.goal.x_m, request.goal.y_m);
 *         }
 *     };
 *     RUMBO_CPP_PLUGINS("straight 1.0.0", rumbo::entry<Straight>("straight", "1.0.0", "Goes straight"))
 *
 *     c++ -std=c++17 -O2 -shared -fPIC -fvisibility=hidden -I include straight.cpp -o libstraight.so
 *
 * No exception leaves the library. Throw rumbo::failure for what can happen (no way to the goal, no start pose); any
 * other exception becomes RUMBO_PANIC with its what(), after which the host destroys the instance and stops the robot.
 */
#ifndef RUMBO_PLUGIN_HPP
#define RUMBO_PLUGIN_HPP

#include "rumbo_plugin.h"

#include <algorithm>
#include <exception>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace rumbo {

/* A view of text that outlives the view. */
inline rumbo_str view(const std::string &text) { return rumbo_str{ text.data(), text.size() }; }
inline rumbo_str view(const char *text) { return rumbo_str_of(text); }

/* What a call says instead of an answer: throw failure(RUMBO_UNREACHABLE, "...").because("a closed door"). */
class failure : public std::exception {
public:
    failure(int32_t code, std::string message) : code_(code), message_(std::move(message)) {}
    /* The word or reason that the status asks for. */
    failure &because(std::string text) { return text_ = std::move(text), *this; }
    /* The place that the status asks for. */
    failure &at(rumbo_point place) { return place_ = place, *this; }
    /* The key, device or file at fault. */
    failure &of(std::string path) { return path_ = std::move(path), *this; }
    /* What to do. */
    failure &help(std::string help) { return help_ = std::move(help), *this; }

    const char *what() const noexcept override { return message_.c_str(); }

    int32_t write(rumbo_error *error) const noexcept
    {
        error->place = place_;
        std::snprintf(error->text, sizeof error->text, "%s", text_.c_str());
        std::snprintf(error->path, sizeof error->path, "%s", path_.c_str());
        std::snprintf(error->help, sizeof error->help, "%s", help_.c_str());
        return rumbo_fail(error, code_, "%s", message_.c_str());
    }

private:
    int32_t code_;
    rumbo_point place_{ 0.0, 0.0 };
    std::string message_, text_, path_, help_;
};

/* What an instance is made from. The host lives as long as the program, the rest until the constructor returns. */
struct setting {
    const rumbo_host &host;
    const rumbo_config *config;
    const rumbo_context &context;

    double number(const char *path) const { return get<double>(path, host.config_f64); }
    int64_t integer(const char *path) const { return get<int64_t>(path, host.config_i64); }
    bool flag(const char *path) const { return get<uint32_t>(path, host.config_bool) != 0; }
    size_t length(const char *path) const { return get<size_t>(path, host.config_len); }
    std::string text(const char *path) const
    {
        const rumbo_str text = get<rumbo_str>(path, host.config_str);
        return text.len == 0 ? std::string() : std::string(text.data, text.len);
    }

private:
    template <class T>
    T get(const char *path, int32_t (*from)(const rumbo_config *, rumbo_str, T *)) const
    {
        T value{};
        const int32_t code = from(config, rumbo_str_of(path), &value);
        if (code != RUMBO_OK)
            throw failure(RUMBO_BAD_CONFIG, code == RUMBO_MISSING ? "is missing" : "has another type").of(path);
        return value;
    }
};

/* What every stage has; hide `manifest` with one of your own where the plugin needs or gives something. */
struct stage {
    /* May throw, so that what an author's destructor throws can be caught; else it would end the program. */
    virtual ~stage() noexcept(false) {}
    static void manifest(rumbo_manifest &) {}
};

struct planner : stage {
    /* Pushes a path from start to goal. */
    virtual void plan(const rumbo_call &call, const rumbo_plan_request &request, rumbo_path_out &path) = 0;
};

struct avoider : stage {
    /* What to do until the next call. */
    virtual void steer(const rumbo_call &call, const rumbo_avoid_input &input, rumbo_steering &steering,
                       rumbo_obstacle_out &obstacles) = 0;
};

struct localizer : stage {
    /* Begins anew from what is known now. */
    virtual void start(const rumbo_prior &prior, const rumbo_map &map) = 0;
    /* Takes in what was seen and fills `estimate`, which comes as that of a lost robot. */
    virtual void update(const rumbo_call &call, const rumbo_seen &seen, const rumbo_map &map,
                        rumbo_estimate &estimate, rumbo_candidate_out &candidates) = 0;
};

struct map_builder : stage {
    /* Prepares its layers. */
    virtual void start(rumbo_map_mut *map) = 0;
    /* Adds what was seen. */
    virtual void insert(const rumbo_call &call, const rumbo_seen &seen, const rumbo_estimate &estimate,
                        rumbo_map_mut *map) = 0;
    /* Asked when somebody saves the map: brings what only a whole visit tells into `map`, and gives what must be kept beside
       it until the next visit, or nothing. */
    virtual std::string save(rumbo_map_mut *) const { return {}; }
};

struct slam : stage {
    /* Begins anew and prepares its layers. */
    virtual void start(const rumbo_prior &prior, rumbo_map_mut *map) = 0;
    /* Takes in what was seen, writes its layers and fills `estimate`. */
    virtual void update(const rumbo_call &call, const rumbo_seen &seen, rumbo_map_mut *map, rumbo_estimate &estimate,
                        rumbo_candidate_out &candidates) = 0;
    /* Its whole state, to continue from later. */
    virtual std::string save() const { throw failure(RUMBO_CANNOT_SAVE, "it has no saved form"); }
    /* Where the robot was at all scans, as it is known now, oldest first. */
    virtual std::vector<rumbo_stamped_pose> trajectory() const { return {}; }
    /* Somebody says where the robot is in the map that was built so far, or that it may be anywhere in it; the map stays. */
    virtual void relocate(const rumbo_prior &, rumbo_map_mut *)
    {
        throw failure(RUMBO_CANNOT_RELOCATE, "it cannot be told where the robot is once it has a map");
    }
};

struct sensor : stage {
    /* Reads what is there now; never blocks. */
    virtual void poll(const rumbo_call &call, rumbo_world *world, rumbo_observations *out) = 0;
    /* As `poll` for a virtual sensor: makes something of what its inputs saw. */
    virtual void derive(const rumbo_call &, const rumbo_seen &, rumbo_observations *)
    {
        throw failure(RUMBO_NOT_VIRTUAL, "it derives nothing");
    }
};

namespace detail {

/* Where every exception ends. */
template <class Body>
int32_t guarded(rumbo_error *error, Body &&body) noexcept
{
    try {
        body();
        return RUMBO_OK;
    } catch (const failure &failed) {
        return failed.write(error);
    } catch (const std::exception &thrown) {
        return rumbo_fail(error, RUMBO_PANIC, "%s", thrown.what());
    } catch (...) {
        return rumbo_fail(error, RUMBO_PANIC, "an exception that is no std::exception");
    }
}

template <class T>
void destroy(void *instance)
{
    try {
        delete static_cast<T *>(instance);
    } catch (...) {
        /* A destructor has nobody to tell. */
    }
}

template <class T>
int32_t create(const rumbo_entry *, const rumbo_host *host, const rumbo_config *config, const rumbo_context *context,
               void **instance, rumbo_error *error)
{
    return guarded(error, [&] { *instance = new T(setting{ *host, config, *context }); });
}

template <class T>
int32_t manifest(const rumbo_entry *, const rumbo_config *, rumbo_manifest *to, rumbo_error *error)
{
    return guarded(error, [&] { T::manifest(*to); });
}

/* The number and the table of a stage, by what T derives from. */
template <class T, class Stage>
struct table_of;

template <class T>
struct table_of<T, planner> {
    static constexpr uint32_t number = RUMBO_PLANNER;
    static int32_t plan(void *self, const rumbo_call *call, const rumbo_plan_request *request, rumbo_path_out *path,
                        rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->plan(*call, *request, *path); });
    }
    static constexpr rumbo_planner_table table = { sizeof(rumbo_planner_table), destroy<T>, plan };
};

template <class T>
struct table_of<T, avoider> {
    static constexpr uint32_t number = RUMBO_AVOIDER;
    static int32_t steer(void *self, const rumbo_call *call, const rumbo_avoid_input *input, rumbo_steering *steering,
                         rumbo_obstacle_out *obstacles, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->steer(*call, *input, *steering, *obstacles); });
    }
    static constexpr rumbo_avoider_table table = { sizeof(rumbo_avoider_table), destroy<T>, steer };
};

template <class T>
struct table_of<T, localizer> {
    static constexpr uint32_t number = RUMBO_LOCALIZER;
    static int32_t start(void *self, const rumbo_prior *prior, const rumbo_map *map, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->start(*prior, *map); });
    }
    static int32_t update(void *self, const rumbo_call *call, const rumbo_seen *seen, const rumbo_map *map,
                          rumbo_estimate *estimate, rumbo_candidate_out *candidates, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->update(*call, *seen, *map, *estimate, *candidates); });
    }
    static constexpr rumbo_localizer_table table = { sizeof(rumbo_localizer_table), destroy<T>, start, update };
};

template <class T>
struct table_of<T, map_builder> {
    static constexpr uint32_t number = RUMBO_MAP_BUILDER;
    static int32_t start(void *self, rumbo_map_mut *map, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->start(map); });
    }
    static int32_t insert(void *self, const rumbo_call *call, const rumbo_seen *seen, const rumbo_estimate *estimate,
                          rumbo_map_mut *map, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->insert(*call, *seen, *estimate, map); });
    }
    static int32_t save(const void *self, rumbo_map_mut *map, rumbo_bytes_out *bytes, rumbo_error *error)
    {
        return guarded(error, [&] { bytes->push(bytes->ctx, view(static_cast<const T *>(self)->save(map))); });
    }
    static constexpr rumbo_map_builder_table table = { sizeof(rumbo_map_builder_table), destroy<T>, start, insert, save };
};

template <class T>
struct table_of<T, slam> {
    static constexpr uint32_t number = RUMBO_SLAM;
    static int32_t start(void *self, const rumbo_prior *prior, rumbo_map_mut *map, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->start(*prior, map); });
    }
    static int32_t update(void *self, const rumbo_call *call, const rumbo_seen *seen, rumbo_map_mut *map,
                          rumbo_estimate *estimate, rumbo_candidate_out *candidates, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->update(*call, *seen, map, *estimate, *candidates); });
    }
    static int32_t save(const void *self, rumbo_bytes_out *bytes, rumbo_error *error)
    {
        return guarded(error, [&] { bytes->push(bytes->ctx, view(static_cast<const T *>(self)->save())); });
    }
    static int32_t trajectory(const void *self, rumbo_trajectory_out *poses, rumbo_error *error)
    {
        return guarded(error, [&] {
            const std::vector<rumbo_stamped_pose> all = static_cast<const T *>(self)->trajectory();
            poses->push(poses->ctx, all.data(), all.size());
        });
    }
    static int32_t relocate(void *self, const rumbo_prior *prior, rumbo_map_mut *map, rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->relocate(*prior, map); });
    }
    static constexpr rumbo_slam_table table = { sizeof(rumbo_slam_table), destroy<T>, start, update, save,
                                                trajectory, relocate, nullptr };
};

template <class T>
struct table_of<T, sensor> {
    static constexpr uint32_t number = RUMBO_SENSOR;
    static int32_t poll(void *self, const rumbo_call *call, rumbo_world *world, rumbo_observations *out,
                        rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->poll(*call, world, out); });
    }
    static int32_t derive(void *self, const rumbo_call *call, const rumbo_seen *inputs, rumbo_observations *out,
                          rumbo_error *error)
    {
        return guarded(error, [&] { static_cast<T *>(self)->derive(*call, *inputs, out); });
    }
    static constexpr rumbo_sensor_table table = { sizeof(rumbo_sensor_table), destroy<T>, poll, derive };
};

template <class T, class... Stages>
struct first_base;
template <class T, class Stage, class... Others>
struct first_base<T, Stage, Others...>
    : std::conditional_t<std::is_base_of_v<Stage, T>, table_of<T, Stage>, first_base<T, Others...>> {};
template <class T>
struct first_base<T> {
    static_assert(sizeof(T) == 0, "a plugin derives from rumbo::planner, avoider, localizer, map_builder, slam or sensor");
};

} // namespace detail

/* The plugin T under a name. T has a constructor from `const rumbo::setting &`; all texts are literals. */
template <class T>
rumbo_entry entry(const char *name, const char *version, const char *summary, const char *schema_json = "")
{
    using table = detail::first_base<T, planner, avoider, localizer, map_builder, slam, sensor>;
    rumbo_entry made{};
    made.size = sizeof made;
    made.stage = table::number;
    made.name = rumbo_str_of(name);
    made.version = rumbo_str_of(version);
    made.summary = rumbo_str_of(summary);
    made.schema_json = rumbo_str_of(schema_json);
    made.table = &table::table;
    made.create = detail::create<T>;
    made.manifest = detail::manifest<T>;
    return made;
}

/* Entries that live as long as the library, with the record of it. */
template <size_t N>
struct library {
    rumbo_entry entries[N];
    const rumbo_entry *pointers[N + 1];
    rumbo_module module;

    library(const char *info, const rumbo_entry (&given)[N]) : entries{}, pointers{}, module{}
    {
        for (size_t k = 0; k < N; k++) {
            entries[k] = given[k];
            pointers[k] = &entries[k];
        }
        module.magic = RUMBO_MAGIC;
        module.size = sizeof module;
        module.abi_major = RUMBO_ABI_MAJOR;
        module.abi_minor = RUMBO_ABI_MINOR;
        module.flags = RUMBO_CATCHES;
        module.build_info = rumbo_str_of(info);
        module.n_entries = N;
        module.entries = pointers;
    }
    library(const library &) = delete;
};

} // namespace rumbo

/* The whole entry function of a C++ library: RUMBO_CPP_PLUGINS("name and version", rumbo::entry<...>(...), ...). */
#define RUMBO_CPP_PLUGINS(info, ...)                                                                        \
    extern "C" const rumbo_module *rumbo_plugin_entry_v1(const rumbo_host *host)                            \
    {                                                                                                       \
        static const rumbo_entry given[] = { __VA_ARGS__ };                                                 \
        static const rumbo::library<sizeof given / sizeof given[0]> made(info, given);                      \
        return host != nullptr && host->abi_major == RUMBO_ABI_MAJOR ? &made.module : nullptr;              \
    }

#endif
