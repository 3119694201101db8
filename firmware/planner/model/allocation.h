/// Thrust allocation: which six thrusts make a wrench (paper Eqs. 12-14, solved in full).
#ifndef SSV_ALLOCATION_H
#define SSV_ALLOCATION_H

#include "ssv/planner.h"

/// Largest accepted condition number of the thruster matrix, forces in N and moments in N per hull radius. The default
/// vehicle has about 2; beyond this limit a thruster would have to give hundreds of newtons to make one.
#define SSV_CONDITION_MAX REAL(1000)

/// What is smaller than this share of the largest counts as nothing where it is said what the thrusters lack. Smaller,
/// and thrusters that are a little off are told to push where they hardly do.
#define SSV_LACK_MIN REAL(0.01)

/// Inverts the thruster matrix B (column i = [n_i; r_i x n_i] about S). It does not depend on what the vehicle carries,
/// since every wrench of the core is taken about S. @return SSV_OK, or SSV_E_SINGULAR with *allocation untouched and
/// *lack written.
ssv_status_t ssv_alloc_init(const ssv_vehicle_t* vehicle, ssv_allocation_t* allocation, ssv_lack_t* lack);

/// The thrusts [N] that make force [N] and moment about S [N m].
void ssv_alloc(const ssv_allocation_t* allocation, vec3_t force, vec3_t moment, real_t u_N[SSV_NUM_THRUSTERS]);

#endif
