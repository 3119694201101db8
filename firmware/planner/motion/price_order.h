/// When two prices count as equal. Prices that differ by rounding alone must not decide what is flown: then the order
/// of the tries decides, which all scalars share.
#ifndef SSV_PRICE_ORDER_H
#define SSV_PRICE_ORDER_H

#include "ssv/real.h"

/// The one rule: a is less than b by more than this fraction of b. The uses of it are named below.
static inline bool ssv_less_by(real_t a, real_t b, real_t fraction) { return a < b - real_mul(fraction, b); }

/// Even: what refinement passes over. It is the same in all scalars: with margins of their own they would refine along
/// other ways. Smaller, and double follows gains that float cannot see; larger, and the last gains are given away.
#define SSV_EVEN REAL(1e-9)

static inline bool ssv_less(real_t a, real_t b) { return ssv_less_by(a, b, SSV_EVEN); }

static inline bool ssv_even(real_t a, real_t b) { return !(real_abs(a - b) > real_mul(SSV_EVEN, a)); }

/// Clearly less: between seeds and between candidates. 5e-9 in double and fixed, 3.6e-7 in float, three units of its
/// last digit. Prices of mirror images are not: smaller, and rounding would choose among these.
#define SSV_CLEARLY real_max(REAL(5e-9), 3 * REAL_EPSILON)

static inline bool ssv_clearly_less(real_t a, real_t b) { return ssv_less_by(a, b, SSV_CLEARLY); }

/// Alike: so close, the first being the lesser, that what is found later decides. It is the same in all scalars.
/// Smaller, and float and double keep different ones for refinement; larger, and more must be refined.
#define SSV_ALIKE REAL(1e-4)

static inline bool ssv_alike(real_t least, real_t price) { return price - least <= real_mul(SSV_ALIKE, least); }

/// The paper's two ramps tie within this, the same in all scalars: the first is taken. Smaller, and where drag alone
/// brakes as well as thrust the scalars would take different ramps; larger, and the dearer ramp may be flown.
#define SSV_RAMPS_TIE REAL(1e-6)

#endif
