/*
 * The plugin ABI of Rumbo, major 1: planners, avoiders, localizers, map builders, SLAM and sensors in a shared library.
 *
 * Generated from core/src/boundary/abi; do not edit. RUMBO_UPDATE=1 cargo test --test boundary header writes it anew.
 *
 * A plugin in ten lines, a planner that goes straight:
 *
 *     #include "rumbo_plugin.h"
 *     static int32_t create(const rumbo_entry *entry, const rumbo_host *host, const rumbo_config *config,
 *                           const rumbo_context *context, void **instance, rumbo_error *error)
 *     { (void)entry; (void)config; (void)context; (void)error; *instance = (void *)host; return RUMBO_OK; }
 *     static void destroy(void *instance) { (void)instance; }
 *     static int32_t plan(void *instance, const rumbo_call *call, const rumbo_plan_request *request,
 *                         rumbo_path_out *path, rumbo_error *error)
 *     { rumbo_push_point(path, request->start.x_m, request->start.y_m);
 *       rumbo_push_point(path, request->goal.x_m, request->goal.y_m);
 *       (void)instance; (void)call; (void)error; return RUMBO_OK; }
 *     static const rumbo_planner_table table = { sizeof table, destroy, plan };
 *     static const rumbo_entry straight = { .size = sizeof straight, .stage = RUMBO_PLANNER,
 *         .name = RUMBO_TEXT("straight"), .version = RUMBO_TEXT("1.0.0"), .summary = RUMBO_TEXT("Goes straight"),
 *         .table = &table, .create = create };
 *     RUMBO_PLUGINS("straight 1.0.0", &straight)
 *
 *     cc -std=c11 -O2 -shared -fPIC -fvisibility=hidden -I include straight.c -o libstraight.so -lm
 *     rumbo plugins list --plugin ./libstraight.so
 *
 * Rules:
 * - Every function answers a status: RUMBO_OK, or another one and the words for it in `error` (see rumbo_fail).
 * - Structs with a `size` grow at their end. Fill in `sizeof`; before you read a field that is younger than ABI 1.0 ask
 *   RUMBO_HAS. Structs without a `size` never change.
 * - What comes in is lent until the function returns, unless something else is said. Memory that one side allocated
 *   is freed by that side; only the host allocates blocks.
 * - Text is UTF-8 with a length. Angles are radians, counter-clockwise, unless the name says degrees.
 * - Instances are used by one thread at a time, not always the same. Never print, never exit, read no clock.
 * - No exception and no longjmp may leave a function; that is what RUMBO_CATCHES promises.
 */
