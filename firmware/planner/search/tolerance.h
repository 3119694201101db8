/// Thresholds of the search: what each is in which scalar, and what breaks beyond it. All of them stand for the
/// geometry or for the price of a motion, not for rounding, so they are the same in every scalar. Equal prices:
/// planner/motion/price_order.h; how much is tried: budget.h.
#ifndef SSV_SEARCH_TOLERANCE_H
#define SSV_SEARCH_TOLERANCE_H

#include "ssv/real.h"

/// A flight shorter than this [m] has no direction, so the attitude of travel is free. Smaller, and the direction is
/// that of rounding; larger, and short flights go off their direction.
#define SSV_NO_DIRECTION_M REAL(1e-6)

/// A part across an axis shorter than this (of a unit vector) does not say how to roll about the axis; any roll does
/// then. Smaller, and rounding rolls the vehicle.
#define SSV_NO_ROLL REAL(1e-6)

/// A twist whose square is below this does not bend the chord of the flight by anything that counts. Smaller, and the
/// division by it loses its digits.
#define SSV_NO_TWIST_SQ REAL(1e-6)

/// A turn with half an angle below this [rad] costs nothing as far as the rough price goes. Smaller, and its axis is
/// that of rounding.
#define SSV_NO_TURN REAL(1e-4)

/// Drag that is less than this part of the vehicle's linear drag, at the speeds of its flights, does not count: the
/// search is that for linear drag. Smaller, and a vehicle like the models' is searched for longer, to find the same;
/// larger, and beams that brake more than the vehicle are flown broadside.
#define SSV_DRAG_COUNTS REAL(0.1)

/// Flights shorter than this [m] are priced per metre as if they were as long. Smaller, and the price of getting under
/// way hides what the drag is.
#define SSV_SHORT_FLIGHT_M REAL(0.5)

/// Directions of the body that cost more per metre than the cheapest times this are not seeded; the search still finds
/// its way in between. Smaller, and a vehicle that is not quite symmetric loses seeds; larger, and each search pays for
/// seeds that do not win.
#define SSV_DIRECTION_SLACK REAL(1.05)

/// Part of the price of a turn that it keeps when it is made in flight, roughly. It ranks seeds and nothing else.
#define SSV_SWING_SHARE REAL(0.25)

/// A grasp is left out if its estimate is this many times a price that is known. Estimates are never that much too
/// high: smaller, and the cheapest grasp might be left out; larger, and more grasps are priced for nothing.
#define SSV_ESTIMATE_MARGIN REAL(1.1)

/// Part of the price of the turns of the best candidate so far that those of another are counted with at least, before
/// they are known. Larger, and candidates are left out that would win.
#define SSV_TURNS_AT_LEAST REAL(0.5)

/// Transfers that cost no more than the cheapest times this get the price of their transits before one is chosen.
/// Smaller, and the cheaper whole is missed; larger, and each candidate is looked at for longer.
#define SSV_TRANSIT_DECIDES REAL(1.5)

/// A candidate is not searched whose screening came out at this many times a price that is known: a search rarely gains
/// more than that on its screening. Smaller, and it gives away gains; larger, and it searches for nothing.
#define SSV_SEARCH_GAIN REAL(1.02)

/// A parabola is not trusted beyond so many steps from where it was measured. Larger, and steps along a direction that
/// is nearly straight jump out of where the price is known.
#define SSV_FARTHEST_STEP REAL(2.5)

/// How much a step may shrink and grow from one sweep to the next. Less, and it follows no valley; more, and one odd
/// parabola spoils the step for good.
#define SSV_STEP_SHRINK REAL(0.3)
#define SSV_STEP_GROW REAL(1.5)

/// First step along the beam, as part of its length. It is halved where neither side gains.
#define SSV_FIRST_HEIGHT_STEP REAL(0.125)

/// What a trial pays that does not keep the margin, as a factor of its price: so much at least, and so much more for
/// each metre that it lacks, up to so many. Larger, and the search goes around where it could slide out; smaller, and
/// it ends in the way. Neither matters much.
#define SSV_SHORTFALL_AT_LEAST REAL(1.02)
#define SSV_SHORTFALL_PER_M REAL(4)
#define SSV_SHORTFALL_MOST_M REAL(1)

/// So many times the shortest maneuver (planner/motion/tolerance.h) may go lost where maneuvers are left out: up to
/// four in each of two phases, turns about pivots that are up to ten metres away. Smaller, and the bound may be above a
/// price of next to nothing; larger, and tasks of a few micrometres have no bound.
#define SSV_LEFT_OUT REAL(100)

/// How closely what a trial lacks is told [m]. Smaller, and trials in the way take longer.
#define SSV_SHORTFALL_BRACKET_M REAL(0.02)

#endif
