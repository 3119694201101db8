/// Thresholds of the profile: what each means, its value in each scalar, and what breaks when it is larger or smaller.
///
/// Speeds, distances, times and thrusts are in the units of a leg (DESIGN.md 5), where its length, its largest thrust
/// and the peak of a short leg are about 1. A threshold that tells a number from rounding is the larger of what the
/// method asks for and some REAL_NOISE, which is 2.2e-16 in double, 1.2e-7 in float and 6.0e-8 in fixed point; behind
/// it stand its values in these three. A threshold with one value has it in every scalar. Where a figure says what
/// breaks it was seen, all else follows from how the threshold is used.
#ifndef SSV_TOLERANCE_H
#define SSV_TOLERANCE_H

#include "ssv/real.h"

// ---- The thrusters along a leg (limits.c) ----

/// Optimal profiles count time as at least this many newtons of thrust. Smaller: legs of days, and without a price on
/// time at all no leg would end. Larger: cheap and slow legs of a scenario with a small W1 are missed.
#define SSV_TIME_PRICE_MIN_N REAL(1e-3)

/// A thruster whose acceleration is a smaller share of the largest is passive: it holds drag alone and limits nothing.
/// 1e-11 | 1.2e-4 | 6.1e-5. Larger: thrusters that do act pass their limit (a thousand times in float: 0.5 N beyond 6
/// N). Smaller: limit over acceleration overflows fixed point, and the idle curve of such a thruster is rounding.
#define PASSIVE_SHARE real_max(REAL(1e-11), 1024 * REAL_NOISE)

/// Idle curves whose coefficients agree to this share of their size are one curve, and their thrusters one group.
/// 1e-10 | 4.8e-7 | 2.4e-7. Larger: thrusters that differ count as one and one of them passes its limit. Smaller: two
/// curves that differ by rounding take turns along a ramp, and it has more arcs than there is room for.
#define SAME_IDLE_CURVE real_max(REAL(1e-10), 4 * REAL_NOISE)

/// To choose the unit of speed, the price of a leg counts as holding its peak down to no less than 2^(-6/2) of what
/// inertia allows. Larger: a unit so small that the speed of full thrust overflows it. Smaller: slow legs lose digits.
#define PRICE_HOLDS_DOWN_EXPONENT 6

// ---- Integrals of one arc (arc.c) ----

/// Where dv/dt changes by less than this factor between two speeds, the integrals are taken by quadrature. Larger:
/// Gauss's rule with 8 points errs by more than 1e-9. Smaller: the closed forms cancel.
#define QUADRATURE_RATIO REAL(1.3)

/// Coefficients of dv/dt are scaled to stay below this, so that the discriminant fits. Larger: fixed point overflows.
/// Smaller: small coefficients lose digits.
#define COEFFICIENT_MAX REAL(255)

/// A root this many times beyond both speeds counts as that far: dv/dt hardly changes between them. Larger: its
/// product with a time may overflow fixed point. Smaller: roots that do bend dv/dt are moved.
#define FAR_ROOT REAL(1000)

/// The time to a speed that is only approached. Smaller: such a leg could pass for one within the longest plan.
/// Larger: it overflows fixed point when it is scaled.
#define ENDLESS_S REAL(1e6)

/// Below this argument tanh x = tan x = x: the next term is a third of the square of it. Larger: that term is lost.
/// Smaller: the quotient of two tiny numbers loses its digits.
#define LINEAR_ARGUMENT REAL(1e-8)

/// Below this argument log(1 + y) / y is summed as a series. Larger: nine terms are too few (the next is the ninth
/// power over 11). Smaller: the closed form of the first moment cancels.
#define LOG_SERIES_ARGUMENT REAL(1e-2)

// ---- Which arc holds at which speed (ramp.c) ----

/// More arcs than any ramp has: bounds the loop. Smaller: a ramp ends before its top speed. Larger: a mistake takes
/// longer to show.
#define MAX_SWITCHES 48

/// Accelerations of two arcs that differ by less than this share of their size are equal. 1e-11 | 1.9e-6 | 9.5e-7.
/// Larger: arcs that do part are taken for one. Smaller: rounding decides which of two equal arcs holds, and the next
/// question is answered the other way (a thousandth in float: a thruster 0.9 N beyond its limit of 6 N).
#define SAME_ACCELERATION real_max(REAL(1e-11), 16 * REAL_NOISE)

/// The next switch speed lies at least this share of the top speed beyond the last. 9.3e-10 | 1.9e-6 | 9.5e-7. Larger:
/// a thruster passes its limit between them by that share of its slope. Smaller: the same switch is found again.
#define SWITCH_SPACING real_max(REAL(9.3132257461547852e-10), 16 * REAL_NOISE)

/// The minimum-cost rules judge an arc this share of the speed beyond where it takes over. 1e-6 | 3.1e-5 | 1.5e-5.
/// Larger: arcs shorter than that are skipped. Smaller: the signs that decide are rounding.
#define LOOK_AHEAD real_max(REAL(1e-6), 256 * REAL_NOISE)

/// Thrusters whose idle curves are this close, as a share of the acceleration, idle together. 1e-9 | 7.6e-6 | 3.8e-6.
/// Larger: a coast arc between them is skipped. Smaller: the tests of two kinks that are one contradict each other.
#define IDLE_TOGETHER real_max(REAL(1e-9), 64 * REAL_NOISE)

// ---- Where the ramps meet (profile.c) ----

/// Faster than any vehicle [m/s or rad/s]: without drag no thruster holds the speed back. Smaller: fast vehicles are
/// slowed. Larger: fixed point overflows.
#define ENDLESS_SPEED REAL(1e4)

/// Terminal speed is only approached: the cruise is this share slower, and takes that share longer. 6.0e-8 | 7.6e-6 |
/// 3.8e-6. Larger: time is given away. Smaller: dv/dt at the end of the ramp is rounding, and so is its time.
#define TERMINAL_MARGIN real_max(REAL(5.9604644775390625e-8), 64 * REAL_NOISE)

/// How closely two ramps without a cruise cover the leg, as a share of it. 1e-11 | 4.8e-7 | 2.4e-7. Larger: legs end
/// short. Smaller: rounding of the distance keeps the iteration from ending before MAX_PEAK_STEPS.
#define PEAK_TOLERANCE real_max(REAL(1e-11), 4 * REAL_NOISE)

/// A cruise shorter than this is what that tolerance left, and is dropped. Larger: real cruises are dropped and the leg
/// ends short. Smaller: arcs of no length.
#define CRUISE_MIN (2 * PEAK_TOLERANCE)

/// Most evaluations of a peak. Smaller: hard legs end short of PEAK_TOLERANCE. Larger: a mistake takes longer.
#define MAX_PEAK_STEPS 60

/// The first peak to try: the acceleration at this part of a ramp's peak is typical of all of it, so many corrections
/// are made, and the result is at most this part of the top speed. Other values take more steps, nothing else.
#define TYPICAL_PART REAL(0.7)
#define NUM_PEAK_GUESSES 3
#define FIRST_PEAK_MAX REAL(0.9)

/// Longest step of the peak's log-odds. Larger: one bad slope throws the peak to an end. Smaller: more steps.
#define LOG_ODDS_STEP_MAX REAL(4)

/// The odds of a peak are taken against a speed this share above the top speed. Larger: near a terminal speed the
/// distance bends over the log-odds, and Newton takes more steps. Smaller: the odds of the top overflow fixed point.
#define ODDS_HEADROOM REAL(1e-5)

/// Where the ramps cover less than this share of the leg, the Newton step is the longest one without asking. Smaller:
/// the quotient overflows fixed point. Larger: more steps.
#define COVERED_MIN REAL(1e-6)

/// After so many steps every other one halves the bracket. Smaller: halving in the way of Newton. Larger: legs on which
/// Newton creeps take longer.
#define NUM_FREE_STEPS 8

// ---- The optimal leg (profile.c) ----

/// The ramps of a short optimal leg end short of it by up to twice this share, and the rest is cruised; in the price
/// that is the square. Larger: the price suffers. Smaller: more steps.
#define SHORTFALL REAL(1e-5)

/// An estimated peak above this part of the cruise speed is taken for the cruise speed. Other values take more steps.
#define NEAR_CRUISE REAL(0.97)

/// While no peak is known to be too high, the next is this factor beyond what the last one asks for. Larger: a wide
/// bracket. Smaller: many steps from below.
#define OVERSHOOT REAL(1.003)

/// Longer than any cruise, as a multiple of the leg. Smaller: short legs that should cruise turn at a higher peak.
/// Larger: fixed point overflows.
#define ENDLESS_CRUISE REAL(100)

/// A coast counts as the cruise if the drag of the thruster that idles costs less than the first of these shares of
/// the cruise, or takes less than the second off the square of the speed along the whole leg. Larger: coasts that save
/// something are missed. Smaller: no scalar can tell the speeds at which such a coast begins and ends apart.
#define COAST_COST_MIN REAL(1e-7)
#define COAST_SLOWS_MIN REAL(1e-4)

/// A speed that fixed point rounds to nothing makes a leg longer than 2^30 of its own units of time; no plan is longer
/// than 2^15 s. Larger first or smaller second: a leg that a finer scalar could fly is called too long. The other way
/// round: a leg that is too long is called an overflow.
#define NO_SPEED_EXPONENT 30
#define LONGEST_PLAN_EXPONENT 15

/// Longest time of an arc, as a power of two in seconds, that is carried over to SI units. Larger: fixed point
/// overflows. Smaller: legs within the longest plan are refused.
#define LONGEST_ARC_EXPONENT 24

/// A thrust below this share of the limit is none. 1e-11 | 1.9e-6 | 9.5e-7. Larger: impulse is missed. Smaller: the
/// sign of rounding cuts an arc's integral in parts.
#define NO_THRUST real_max(REAL(1e-11), 16 * REAL_NOISE)

// ---- The estimate (estimate.c) ----

/// Peaks stay below this part of the terminal speed. Larger: accelerations there are rounding. Smaller: long flights
/// are estimated too dear.
#define BELOW_TERMINAL REAL(0.99999)

/// Most peaks that an estimate evaluates. Smaller: turns are off by more. Larger: time.
#define NUM_ESTIMATE_STEPS 5

#endif
