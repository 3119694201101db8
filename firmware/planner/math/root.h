/// Where an increasing function takes a given value, kept between two arguments. The caller evaluates the function:
/// begin, propose an argument, tell the value there, propose the next.
#ifndef SSV_ROOT_H
#define SSV_ROOT_H

#include <stdbool.h>

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
ssv_root_t ssv_root_between(real_t target, real_t low, real_t y_low, real_t high, real_t y_high);

/// The value at the lower end alone is known. Until a value above the target has been told the caller proposes by
/// itself.
ssv_root_t ssv_root_from(real_t target, real_t low, real_t y_low, real_t high);

/// The value at x becomes that of one end.
void ssv_root_tell(ssv_root_t* root, real_t x, real_t y);

/// The same by the Illinois rule: an end that stays where it is a second time counts with half of its distance to the
/// target. Without that regula falsi creeps along a function that bends.
void ssv_root_tell_illinois(ssv_root_t* root, real_t x, real_t y);

/// Which share of the bracket lies below the place where a straight line through both ends takes the target.
real_t ssv_root_share(const ssv_root_t* root);

real_t ssv_root_middle(const ssv_root_t* root);

/// The next argument to evaluate in a bracket: regula falsi, but the middle after each third value, so that the bracket
/// shrinks whatever the function does.
real_t ssv_root_propose(const ssv_root_t* root);

/// Whether an argument lies strictly between the ends.
bool ssv_root_is_inside(const ssv_root_t* root, real_t x);

/// Whether this scalar has no number between the ends: then the function leaps past the target there.
bool ssv_root_is_exhausted(const ssv_root_t* root);

#endif
