/// Scenarios for tests of the core: the two models' bodies, the paper's case study, and random ones around
/// them. The draw uses IEEE sums, products and square roots alone, so a seed names the same scenarios on every machine.
#ifndef TESTS_SAMPLE_H
#define TESTS_SAMPLE_H

#include "ssv/planner.h"

/// Starts the sequence of draws anew.
void sample_seed(uint64_t seed);

/// Uniform in [low, high), [0, n), the ball's cube of half-width size, the unit sphere, and the unit quaternions.
double sample_between(double low, double high);
int sample_below(int n);
vec3_t sample_vector(double size);
vec3_t sample_direction(void);
quat_t sample_attitude(void);

/// Bodies of host/models: the SSV; the beam as the paper prints it (`ease` false: no drag) or as a real tube (`ease`
/// true).
ssv_vehicle_t model_vehicle(void);
ssv_beam_t model_beam(bool ease);

/// The paper's case study (Table 4) with every choice left free, weights 1 and 1, method paper.
ssv_scenario_t scenario_case_study(bool ease);

/// A random scenario within some 8 m; half of them with bodies varied by a quarter, added mass, every kind of drag, and
/// thrusters out of place.
ssv_scenario_t sample_scenario(void);

/// The same scenario with the whole scene carried off by X.
ssv_scenario_t scenario_moved(const ssv_scenario_t* scenario, pose_t X);

/// The mirror image of the scenario in the plane y = 0 of I. Body frames stay right-handed, so each is reflected along
/// one of its own axes too: y or z of the vehicle, whose +x stays the contact; x, y or z of the beam, where z swaps the
/// contacts. Thrusters are reflected as points and vectors.
typedef enum { MIRROR_X = 0, MIRROR_Y = 1, MIRROR_Z = 2 } mirror_axis_t;
ssv_scenario_t scenario_mirrored(const ssv_scenario_t* scenario, mirror_axis_t vehicle_axis, mirror_axis_t beam_axis);

#endif
