/* Interface between `bench` and a velocity law of one axis in a shared library: version 1.
 *
 * The library exports four functions: bench_law_describe, bench_law_create, bench_law_step, bench_law_destroy.
 * All rows consist of double only, in SI units, and keep their layout for as long as the version stays the same.
 * docs/controllers.md explains when bench calls what, and what happens when a law fails.
 *
 * Rules
 * - bench_law_step must not block, allocate, print or read a clock: it runs in every tick of the loop.
 * - One instance is used by one thread at a time, but not always by the same one. Several instances run at the same
 *   time: the library must not keep state outside its instances.
 * - The same calls must give the same torques, otherwise a run cannot be repeated.
 * - The functions must leave the floating-point environment (rounding, flush to zero) as they find it: in process it is
 *   that of bench.
 */
#ifndef BENCH_LAW_H
#define BENCH_LAW_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define BENCH_LAW_ABI_VERSION 1u

/* Most parameters that a law may have. */
#define BENCH_LAW_MOST_PARAMETERS 64u

/* A parameter that bench gives to bench_law_create. */
typedef struct bench_law_parameter {
    const char *name;     /* a key of an axis in the parameter file, e.g. "velocity-kp", or a name of the law's own */
    const char *unit;     /* SI unit of the value, e.g. "N*m*s/rad" */
    double default_value; /* for a name that the parameter file does not have; NaN: the file must have it */
} bench_law_parameter;

/* What a library says of itself. All strings are UTF-8 and, like the description, stay valid until it is unloaded. */
typedef struct bench_law_description {
    uint32_t abi_version;     /* BENCH_LAW_ABI_VERSION; first in every version */
    uint32_t parameter_bytes; /* sizeof(bench_law_parameter) */
    uint32_t setup_bytes;     /* sizeof(bench_law_setup) */
    uint32_t input_bytes;     /* sizeof(bench_law_input) */
    uint32_t output_bytes;    /* sizeof(bench_law_output) */
    uint32_t parameter_count; /* entries of `parameters` */
    const char *name;         /* name of the law */
    const char *version;      /* version of the law, as its authors count */
    const bench_law_parameter *parameters; /* may be NULL where there are none */
} bench_law_description;

/* What does not change during the life of an instance. */
typedef struct bench_law_setup {
    double period_s;                      /* time from step to step */
    double torque_limit_nm;               /* a torque beyond +- this stops the axis */
    double velocity_limit_rad_per_s;      /* largest speed of the axis in the rig file */
    double acceleration_limit_rad_per_s2; /* largest acceleration of the axis in the rig file */
    double inertia_kg_m2;                 /* inertia of the axis in the rig file */
} bench_law_setup;

/* One step. */
typedef struct bench_law_input {
    double take_over;                     /* 0: make a torque; 1: take over, see below */
    double reference_rad_per_s;           /* commanded rate, any excitation of the test included */
    double rate_rad_per_s;                /* measured rate: gyro or encoder, as the rig file says */
    double feed_forward_nm;               /* inertia times commanded acceleration */
    double acceleration_rad_per_s2;       /* commanded acceleration */
    double sent_nm;                       /* torque that went to the drive in the last tick */
} bench_law_input;

/* What a step gives. With take_over = 1 torque and saturation are not used. */
typedef struct bench_law_output {
    double torque_nm; /* torque demand */
    double saturated; /* 1 where the torque was limited, else 0; for information */
    double fault;     /* 0; any other value stops the axis and is recorded: a code of the law's own */
} bench_law_output;

/* Describes the library; must not return NULL. */
const bench_law_description *bench_law_describe(void);

/* Makes an instance. `parameters` has a value for each described parameter, in that order. NULL on failure. */
void *bench_law_create(const bench_law_setup *setup, const double *parameters);

/* One step. With take_over = 1 the law sets its state so that a step with this reference, rate and feed-forward would
 * go on with the torque `sent_nm`, but for one step of an integral: the loop closes without a jump of the torque.
 * bench calls it with 1 before the first step of an instance and wherever the loop was open in between. */
void bench_law_step(void *law, const bench_law_input *input, bench_law_output *output);

/* Frees an instance. */
void bench_law_destroy(void *law);

#ifdef __cplusplus
}
#endif

#endif
