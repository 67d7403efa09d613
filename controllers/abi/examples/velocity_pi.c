/* The built-in velocity law `pi` of the bench as an external law: the same torques, bit for bit where the compiler
 * fuses no multiplication with an addition (-ffp-contract=off).
 *
 *     cc -std=c11 -O2 -ffp-contract=off -shared -fPIC -I.. -o velocity_pi.so velocity_pi.c
 *
 * PI with feed-forward. The output is saturated; while it is, the integral takes no step that drives it further into
 * saturation.
 */
#include "bench_law.h"

#include <math.h>
#include <stdlib.h>

enum { KP, KI, PARAMETERS };

static const bench_law_parameter parameters[PARAMETERS] = {
    [KP] = {"velocity-kp", "N*m*s/rad", NAN},
    [KI] = {"velocity-ki", "N*m/rad", NAN},
};

static const bench_law_description description = {
    .abi_version = BENCH_LAW_ABI_VERSION,
    .parameter_bytes = sizeof(bench_law_parameter),
    .setup_bytes = sizeof(bench_law_setup),
    .input_bytes = sizeof(bench_law_input),
    .output_bytes = sizeof(bench_law_output),
    .parameter_count = PARAMETERS,
    .name = "velocity-pi",
    .version = "1.0",
    .parameters = parameters,
};

typedef struct pi_law {
    double kp_nm_s_per_rad;
    double ki_step_nm_s_per_rad; /* integral gain times period */
    double torque_limit_nm;
    double integral_nm;
} pi_law;

/* A broken sample must not stay in the state. */
static double finite_or_zero(double value) { return isfinite(value) ? value : 0.0; }

static double limited(const pi_law *law, double torque_nm) {
    return fmin(fmax(torque_nm, -law->torque_limit_nm), law->torque_limit_nm);
}

const bench_law_description *bench_law_describe(void) { return &description; }

void *bench_law_create(const bench_law_setup *setup, const double *values) {
    pi_law *law = calloc(1, sizeof *law);
    if (law != NULL) {
        law->kp_nm_s_per_rad = values[KP];
        law->ki_step_nm_s_per_rad = values[KI] * setup->period_s;
        law->torque_limit_nm = setup->torque_limit_nm;
    }
    return law;
}

void bench_law_step(void *instance, const bench_law_input *input, bench_law_output *output) {
    pi_law *law = instance;
    const double error = finite_or_zero(input->reference_rad_per_s - input->rate_rad_per_s);
    const double direct_nm = law->kp_nm_s_per_rad * error + finite_or_zero(input->feed_forward_nm);
    *output = (bench_law_output){0};
    if (input->take_over != 0.0) {
        law->integral_nm = limited(law, finite_or_zero(input->sent_nm)) - direct_nm;
        return;
    }
    const double step_nm = law->ki_step_nm_s_per_rad * error;
    const double wanted_nm = direct_nm + law->integral_nm + step_nm;
    output->torque_nm = limited(law, wanted_nm);
    output->saturated = output->torque_nm != wanted_nm;
    if (output->saturated == 0.0 || step_nm * wanted_nm < 0.0) {
        law->integral_nm += step_nm;
    }
}

void bench_law_destroy(void *law) { free(law); }
