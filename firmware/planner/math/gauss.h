/// The Gauss-Legendre rules of the planner. A rule with n points is exact for polynomials up to degree 2 n - 1.
#ifndef SSV_GAUSS_H
#define SSV_GAUSS_H

#include "ssv/real.h"

typedef struct {
    real_t node, weight;
} gauss_point_t;

#define GAUSS_3_POINTS 3
#define GAUSS_4_POINTS 4
#define GAUSS_8_POINTS 8

/// On [0, 1]: the weights add up to 1.
extern const gauss_point_t gauss_3[GAUSS_3_POINTS], gauss_4[GAUSS_4_POINTS];

/// On [-1, 1]: the weights add up to 2.
extern const gauss_point_t gauss_8[GAUSS_8_POINTS];

#endif
