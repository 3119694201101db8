/// Scenarios for tests of the core: the two models' bodies, the paper's case study, and seeded random tasks around
/// them. The draw uses IEEE sums, products and square roots alone, so a seed names the same tasks on every machine.
#ifndef TESTS_TASKS_H
#define TESTS_TASKS_H

#include "ssv/planner.h"

/// Starts the sequence of draws anew.
void task_seed(uint64_t seed);

/// Uniform in [low, high), [0, n), the ball's cube of half-width size, the unit sphere, and the unit quaternions.
double task_between(double low, double high);
int task_below(int n);
vec3_t task_vector(double size);
vec3_t task_direction(void);
quat_t task_attitude(void);

/// Bodies of host/models: the SSV; the beam as the paper prints it (`ease` false: no drag) or as a real tube (`ease`
/// true).
ssv_vehicle_t task_vehicle(void);
ssv_beam_t task_beam(bool ease);

/// The paper's case study (Table 4) with every choice left free, weights 1 and 1, method paper.
ssv_scenario_t task_case_study(bool ease);

/// A random task within some 8 m; half of them with bodies varied by a quarter, added mass, every kind of drag, and
/// thrusters out of place.
ssv_scenario_t task_random(void);

/// The same task with the whole scene carried off by X.
ssv_scenario_t task_moved(const ssv_scenario_t* task, pose_t X);

/// The mirror image of the task in the plane y = 0 of I. Body frames stay right-handed, so each is reflected along one
/// of its own axes too: y or z of the vehicle, whose +x stays the contact; x, y or z of the beam, where z swaps the
/// contacts. Thrusters are reflected as points and vectors.
typedef enum { TASK_X = 0, TASK_Y = 1, TASK_Z = 2 } task_axis_t;
ssv_scenario_t task_mirrored(const ssv_scenario_t* task, task_axis_t vehicle_axis, task_axis_t beam_axis);

#endif
