/// Thresholds of the geometry of maneuvers: what each is in which scalar, and what breaks beyond it.
#ifndef SSV_MOTION_TOLERANCE_H
#define SSV_MOTION_TOLERANCE_H

#include "ssv/real.h"

/// Shorter maneuvers [m or rad] have length 0: they are rounding of the geometry, not motion. 1e-8 in double, 9.5e-7
/// in fixed, 1.9e-6 in float. Smaller, and a scene that needs no motion gets legs by rounding.
#define SSV_LENGTH_MIN real_max(REAL(1e-8), 16 * REAL_NOISE)

/// A screw whose axis is farther away than this [m] is measured along its path and not by its angle, in every scalar:
/// in radians a flight that hardly turns would have a twist of millions of metres.
#define SSV_PIVOT_FAR_M REAL(10)

/// A screw in which the vehicle moves less than this per radian [m] is measured by its angle, in every scalar: along
/// the path it would have a rate of hundreds of radians per metre.
#define SSV_PIVOT_NEAR_M REAL(0.01)

/// No maneuver is ever so fast [m/s or rad/s]: a cap that asks for no less is none. Larger, and the quotient that tells
/// a cap on a point that hardly moves overflows in fixed point.
#define SSV_SPEED_NEVER REAL(1000)

/// Below this angle [rad] three terms of the sine and cosine are as good as all, in every scalar. Larger, and the
/// series errs; smaller, and the difference of angle and sine cancels.
#define SSV_SMALL_RAD REAL(1e-3)

/// A thrust coefficient smaller than this fraction of the largest is rounding of the allocation and counts as none.
/// 2^-30 in double, 2^-28 in fixed, 2e-6 in float. Smaller, and thrusters that idle are told apart by rounding; larger,
/// and drag goes lost: where a second costs next to nothing, a millionth of it decides how long a coast is worth while.
#define SSV_COEFFICIENT_MIN real_max(REAL(9.3132257461547852e-10), 16 * REAL_EPSILON)

#endif
