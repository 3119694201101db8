/// Thrusters: what becomes of a command on its way to a force.
///
///     command -> steps of quantum -> dead band -> force by curve (effort) or as it is (newtons)
///             -> gain error -> limits -> first-order lag -> force
///
/// All zero: newtons straight through.
#ifndef SIM_THRUSTER_H
#define SIM_THRUSTER_H

#include "random.h"

#define SIM_THRUSTERS 6
#define SIM_CURVE_POINTS 32

/// Force over effort at the nominal voltage: straight lines between the points, level beyond the first and the last.
typedef struct {
    int num_points;                  ///< 0: commands are newtons; else 2 at least
    double effort[SIM_CURVE_POINTS]; ///< in [-1, 1], strictly rising
    double force_N[SIM_CURVE_POINTS];
    double voltage_ratio;    ///< of the supply to the nominal one; 0 means 1
    double voltage_exponent; ///< force grows as voltage_ratio to this power
} sim_curve_t;

typedef struct {
    sim_curve_t curve;
    double quantum;                   ///< commands are rounded to its multiples, halves away from zero; 0: none
    double dead_band;                 ///< commands of this size and below give no force
    double gain_error[SIM_THRUSTERS]; ///< force is 1 + this times what it should be; -1: dead thruster
    double gain_spread;         ///< and for each thruster one number more, uniform in -spread to spread, by the seed
    double force_forward_max_N; ///< 0: no limit
    double force_reverse_max_N; ///< as a positive number; 0: no limit
    double lag_s;               ///< time constant; 0: none
} sim_thruster_config_t;

typedef struct {
    sim_thruster_config_t config;
    double gain[SIM_THRUSTERS];
    double force_N[SIM_THRUSTERS];  ///< now
    double target_N[SIM_THRUSTERS]; ///< where the lag leads to
} sim_thruster_bank_t;

void sim_thruster_init(sim_thruster_bank_t* bank, const sim_thruster_config_t* config, uint64_t seed, uint64_t stream);

double sim_curve_force(const sim_curve_t* curve, double effort);

/// Takes commands, efforts or newtons, all finite; the forces start towards them.
void sim_thruster_command(sim_thruster_bank_t* bank, const double command[SIM_THRUSTERS]);

/// Force of each thruster after_s after now, under the commands of now.
void sim_thruster_force(const sim_thruster_bank_t* bank, double after_s, double force_N[SIM_THRUSTERS]);

/// Goes on by dt_s, by the closed form.
void sim_thruster_step(sim_thruster_bank_t* bank, double dt_s);

#endif
