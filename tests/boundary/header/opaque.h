/* The mark of the symbol that a library exports. */
#if defined(_WIN32)
#define RUMBO_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define RUMBO_EXPORT __attribute__((visibility("default")))
#else
#define RUMBO_EXPORT
#endif

/* Things of the host, known by their address only. */

/* The header of a reference-counted array; its elements start 64 bytes further on. Only the host allocates blocks:
   `block_new`, `block_retain` and `block_release` of the host table make, keep and drop one. */
typedef struct rumbo_block rumbo_block;
/* The parameters that a pipeline gives, parsed by the host; for `config_...` of the host table. */
typedef struct rumbo_values rumbo_values;
/* A flag that long work looks at: `give_up_is_raised`; `give_up_retain` and `give_up_release` to keep it. */
typedef struct rumbo_give_up rumbo_give_up;
/* A random stream of one instance, for `random_...` of the host table; lives as long as the instance. */
typedef struct rumbo_rng rumbo_rng;
/* Debug drawings and counters of one call. */
typedef struct rumbo_trace rumbo_trace;
/* The world as a sensor may ask it. */
typedef struct rumbo_world rumbo_world;
/* Takes what a sensor sees, through `observe` of the host table. */
typedef struct rumbo_observations rumbo_observations;
/* The map, to be written: the host's own, through `map_take_...` and `map_put_...` of the host table. Take a layer,
   change it, put it back; what is taken and not put back is gone. */
typedef struct rumbo_map_mut rumbo_map_mut;
