/// Where an increasing function takes a given value, kept between two arguments. The caller evaluates the function:
/// begin, propose an argument, tell the value there, propose the next.
#ifndef SSV_ROOT_H
#define SSV_ROOT_H

#include <stdbool.h>

#include "planner/math/assert.h"
#include "ssv/real.h"

/// The value is above the target at `high`, and not above it at `low`.
typedef struct {
    real_t target;
    real_t low, high;
    real_t y_low, y_high; ///< values there; ssv_root_tell_illinois moves them towards the target
    bool bracketed;       ///< false: no value above the target is known yet, and `high` only bounds the search
    bool above;           ///< whether the last value that was told was above the target
    int num_told;
} ssv_root_t;

/// Values at both ends are known.
static inline ssv_root_t ssv_root_between(real_t target, real_t low, real_t y_low, real_t high, real_t y_high) {
    SSV_ASSERT(!(low > high));
    return (ssv_root_t){
        .target = target, .low = low, .high = high, .y_low = y_low, .y_high = y_high, .bracketed = true};
}

/// The value at the lower end alone is known. Until a value above the target has been told the caller proposes by
/// itself.
static inline ssv_root_t ssv_root_from(real_t target, real_t low, real_t y_low, real_t high) {
    SSV_ASSERT(!(low > high) && !(y_low > target));
    return (ssv_root_t){.target = target, .low = low, .high = high, .y_low = y_low, .y_high = target};
}

/// The value at x becomes that of one end.
static inline void ssv_root_tell(ssv_root_t* root, real_t x, real_t y) {
    SSV_ASSERT(!(x < root->low));
    root->above = y > root->target;
    *(root->above ? &root->high : &root->low) = x;
    *(root->above ? &root->y_high : &root->y_low) = y;
    root->bracketed = root->bracketed || root->above;
    root->num_told++;
}

/// The same by the Illinois rule: an end that stays where it is a second time counts with half of its distance to the
/// target. Without that regula falsi creeps along a function that bends.
static inline void ssv_root_tell_illinois(ssv_root_t* root, real_t x, real_t y) {
    const bool may_stay = root->bracketed && root->num_told > 0, was_above = root->above;
    ssv_root_tell(root, x, y);
    if (!may_stay || root->above != was_above) return;
    real_t* stale = root->above ? &root->y_low : &root->y_high;
    *stale = root->target + real_mul(REAL(0.5), *stale - root->target);
}

/// Which share of the bracket lies below the place where a straight line through both ends takes the target.
static inline real_t ssv_root_share(const ssv_root_t* root) {
    SSV_ASSERT(root->bracketed);
    return real_div(root->target - root->y_low, root->y_high - root->y_low);
}

static inline real_t ssv_root_middle(const ssv_root_t* root) { return real_mul(REAL(0.5), root->low + root->high); }

/// The next argument to evaluate in a bracket: regula falsi, but the middle after each third value, so that the bracket
/// shrinks whatever the function does.
static inline real_t ssv_root_propose(const ssv_root_t* root) {
    if (root->num_told % 3 == 0) return ssv_root_middle(root);
    return root->low + real_mul(root->high - root->low, ssv_root_share(root));
}

/// Whether an argument lies strictly between the ends.
static inline bool ssv_root_is_inside(const ssv_root_t* root, real_t x) { return x > root->low && x < root->high; }

/// Whether this scalar has no number between the ends: then the function leaps past the target there.
static inline bool ssv_root_is_exhausted(const ssv_root_t* root) {
    return !ssv_root_is_inside(root, ssv_root_middle(root));
}

#endif
