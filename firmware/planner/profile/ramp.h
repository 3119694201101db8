/// Ramps: how speed rises from rest, or falls to it, under a rule that binds some thruster at each speed (DESIGN.md 5).
#ifndef SSV_RAMP_H
#define SSV_RAMP_H

#include "planner/profile/arc.h"
#include "planner/profile/limits.h"

/// Which thruster is bound, at its limit or to no thrust. The thrifty rules are those of the optimal profile.
typedef enum { SSV_SPEED_UP, SSV_BRAKE, SSV_COAST, SSV_THRIFTY_UP, SSV_THRIFTY_SLOW } ssv_policy_t;

/// A leg's laws, and what the rules need beside them.
typedef struct {
    ssv_laws_t laws;
    real_t top;                     ///< speeds go up to here
    real_t size[SSV_NUM_THRUSTERS]; ///< of the idle law, up to the top: what rounding is judged against
    real_t weight_time,
        weight_impulse; ///< of the thrifty rules, whose marginal cost of distance is that of holding the top
    bool coasts[SSV_NUM_THRUSTERS]; ///< thrifty rules: whether a coast on this thruster differs from a cruise, up to
                                    ///< the top
} ssv_steering_t;

/// Sets the speed that ramps go up to.
void ssv_steering_up_to(ssv_steering_t* steering, real_t top);

/// The law of no stretch.
#define SSV_NO_LAW (-1)

/// A stretch of a ramp under one law, between two speeds.
typedef struct {
    real_t v_low, v_high;
    ssv_moments_t m; ///< integrals over it; distance is from v_low to v_high
    int law;         ///< see ssv_ramp_law
} ssv_stretch_t;

/// A ramp from rest upwards. The stretches lie `step` apart, so that two ramps can grow from both ends of one array. A
/// ramp to a speed of zero is empty: it has no stretch, covers no distance and takes no time.
typedef struct {
    ssv_stretch_t* first;
    int step, num;
    int last;          ///< where it was last looked at: the stretch, -1 of an empty ramp,
    ssv_stretch_t cut; ///< and that up to there
} ssv_ramp_table_t;

static inline ssv_stretch_t* ssv_ramp_stretch(const ssv_ramp_table_t* ramp, int k) {
    return ramp->first + k * ramp->step;
}

/// Speed up to which a ramp goes.
static inline real_t ssv_ramp_top(const ssv_ramp_table_t* ramp) {
    return ramp->num > 0 ? ssv_ramp_stretch(ramp, ramp->num - 1)->v_high : REAL(0);
}

/// dv/dt = Q(v) of a stretch.
void ssv_ramp_law(const ssv_laws_t* laws, int law, real_t c[3]);

/// Extends the ramp under one rule to a speed, with at most `room` stretches in all. @return false if these do not
/// suffice.
bool ssv_ramp_extend(const ssv_steering_t* steering, ssv_policy_t policy, real_t top, int room, ssv_ramp_table_t* ramp);

/// Ends the ramp where its speed would no longer fall.
void ssv_ramp_keep_slowing(const ssv_laws_t* laws, ssv_ramp_table_t* ramp);

/// Integrals of a law between two speeds, low to high whichever way it goes.
ssv_moments_t ssv_ramp_integrals(const real_t law[3], real_t v_low, real_t v_high);

/// Fills the integrals of all stretches.
void ssv_ramp_measure(const ssv_laws_t* laws, ssv_ramp_table_t* ramp);

/// |dv/dt| at a speed; 0 on an empty ramp.
real_t ssv_ramp_acceleration(const ssv_laws_t* laws, const ssv_ramp_table_t* ramp, real_t v);

/// Distance from rest to v, and |dv/dt| there; keeps the cut there. Both are 0 on an empty ramp, which has no cut.
real_t ssv_ramp_reach(const ssv_laws_t* laws, ssv_ramp_table_t* ramp, real_t v, real_t* acceleration);

/// Whether some thruster idles on the ramp where ssv_ramp_reach last looked.
bool ssv_ramp_idles(const ssv_ramp_table_t* ramp);

/// Stretch k <= ramp->last of the ramp as far as ssv_ramp_reach last looked.
static inline const ssv_stretch_t* ssv_ramp_up_to_cut(const ssv_ramp_table_t* ramp, int k) {
    return k == ramp->last ? &ramp->cut : ssv_ramp_stretch(ramp, k);
}

#endif
