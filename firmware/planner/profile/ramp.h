/// Ramps: how speed rises from rest, or falls to it, under a switching rule that says at each speed which thruster is
/// bound and to what (DESIGN.md 5).
#ifndef SSV_RAMP_H
#define SSV_RAMP_H

#include <stdbool.h>

#include "planner/math/assert.h"
#include "planner/profile/arc.h"
#include "planner/profile/limits.h"
#include "ssv/real.h"
#include "ssv/scenario.h"

/// Which thruster is bound. SPEED_UP and BRAKE: the one with the tightest limit, to that limit (bang arcs). COAST: the
/// one whose idling gives the least total thrust (coast arcs). MIN_COST_UP and MIN_COST_SLOW: as the optimality
/// conditions ask, to its limit or to no thrust.
typedef enum { SSV_SPEED_UP, SSV_BRAKE, SSV_COAST, SSV_MIN_COST_UP, SSV_MIN_COST_SLOW } ssv_switching_rule_t;

/// What the switching rules of a leg look at. The weights and `coasts` are for the minimum-cost rules alone.
typedef struct {
    ssv_thruster_groups_t groups;
    real_t top_speed;               ///< speeds go up to here
    real_t size[SSV_NUM_THRUSTERS]; ///< largest idle acceleration up to the top speed: what rounding is judged against
    real_t weight_time;             ///< the marginal cost of distance is that of a cruise at the top speed
    real_t weight_impulse;
    bool coasts[SSV_NUM_THRUSTERS]; ///< whether an arc on which this group idles differs from a cruise
} ssv_switching_t;

/// Sets the speed that ramps go up to.
void ssv_switching_up_to(ssv_switching_t* switching, real_t top_speed);

/// The id of no arc. Others: see ssv_ramp_dv_dt.
#define SSV_NO_ARC (-1)

/// An arc of a ramp, between two speeds.
typedef struct {
    real_t v_low, v_high;
    ssv_moments_t m; ///< integrals over it, as if it went from v_low to v_high
    int arc_id;
} ssv_speed_arc_t;

/// A ramp from rest upwards, as the table of its arcs; a ramp that slows is the same against time. The arcs lie `step`
/// apart in an array, so that two ramps can grow from both ends of one. A ramp to a speed of zero is empty: it has no
/// arc, covers no distance and takes no time.
///
/// A leg flies its ramps only up to the peak. ssv_ramp_distance_to notes how far that is: arcs 0 to `last` are flown,
/// all but `last` to their ends; `partial` is the flown part of arc `last`. Of an empty ramp last is -1.
typedef struct {
    ssv_speed_arc_t* first;
    int step, num;
    int last;
    ssv_speed_arc_t partial;
} ssv_ramp_table_t;

static inline ssv_speed_arc_t* ssv_ramp_arc(const ssv_ramp_table_t* ramp, int k) {
    SSV_ASSERT(k >= 0 && k < ramp->num);
    return ramp->first + k * ramp->step;
}

/// Speed up to which a ramp goes.
static inline real_t ssv_ramp_top_speed(const ssv_ramp_table_t* ramp) {
    return ramp->num > 0 ? ssv_ramp_arc(ramp, ramp->num - 1)->v_high : REAL(0);
}

/// The coefficients of dv/dt on an arc: those of the group of thrusters that its id says is bound.
void ssv_ramp_dv_dt(const ssv_thruster_groups_t* groups, int arc_id, real_t dv_dt[3]);

/// Extends the ramp under one rule to a speed, with at most `room` arcs in all.
/// @return false if these do not suffice.
bool ssv_ramp_extend(const ssv_switching_t* switching, ssv_switching_rule_t rule, real_t top_speed, int room,
                     ssv_ramp_table_t* ramp);

/// Ends the ramp at the first arc that does not slow the body all along.
void ssv_ramp_keep_slowing(const ssv_thruster_groups_t* groups, ssv_ramp_table_t* ramp);

/// Integrals between two speeds, counted as positive whichever way dv/dt leads.
ssv_moments_t ssv_ramp_integrals(const real_t dv_dt[3], real_t v_low, real_t v_high);

/// Fills the integrals of all arcs.
void ssv_ramp_measure(const ssv_thruster_groups_t* groups, ssv_ramp_table_t* ramp);

/// |dv/dt| at a speed; 0 on an empty ramp.
real_t ssv_ramp_acceleration(const ssv_thruster_groups_t* groups, const ssv_ramp_table_t* ramp, real_t v);

/// Distance from rest to speed v, and |dv/dt| there. The ramp is flown up to there from now on. Both are 0 on an empty
/// ramp.
real_t ssv_ramp_distance_to(const ssv_thruster_groups_t* groups, ssv_ramp_table_t* ramp, real_t v,
                            real_t* acceleration);

/// Whether the last arc that is flown is a coast arc.
bool ssv_ramp_ends_coasting(const ssv_ramp_table_t* ramp);

/// Arc k <= ramp->last as far as it is flown.
static inline const ssv_speed_arc_t* ssv_ramp_flown_arc(const ssv_ramp_table_t* ramp, int k) {
    SSV_ASSERT(k >= 0 && k <= ramp->last);
    return k == ramp->last ? &ramp->partial : ssv_ramp_arc(ramp, k);
}

#endif
