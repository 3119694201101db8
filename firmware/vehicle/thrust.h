/// From newtons to efforts: one thruster's curve backwards, and the impulse that its dead band keeps back.
#ifndef VEHICLE_THRUST_H
#define VEHICLE_THRUST_H

#include "ssv/vehicle.h"

/// Whether a curve keeps the rules of ssv_thrust_branch_t.
bool ssv_thrust_is_sound(const ssv_thrust_curve_t* curve);

/// The effort that gives a demand for one tick, or as near as the thruster comes to it. What the dead band keeps back
/// is added to `carried_N` and given later, in ticks at the band's edge, so that the impulse is right to half of one
/// such tick. What the thruster is too weak for is not carried: later it would be wrong.
/// @param given_N what the effort should give.
float ssv_thrust_effort(const ssv_thrust_curve_t* curve, float force_scale, float force_max_N, float demand_N,
                        float* carried_N, float* given_N);

#endif
