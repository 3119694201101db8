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
static const gauss_point_t gauss_3[GAUSS_3_POINTS] = {{REAL(0.11270166537925831), REAL(0.27777777777777778)},
                                                      {REAL(0.5), REAL(0.44444444444444444)},
                                                      {REAL(0.88729833462074169), REAL(0.27777777777777778)}};
static const gauss_point_t gauss_4[GAUSS_4_POINTS] = {{REAL(0.069431844202973712), REAL(0.17392742256872693)},
                                                      {REAL(0.33000947820757187), REAL(0.32607257743127307)},
                                                      {REAL(0.66999052179242813), REAL(0.32607257743127307)},
                                                      {REAL(0.93056815579702629), REAL(0.17392742256872693)}};

/// On [-1, 1]: the weights add up to 2.
static const gauss_point_t gauss_8[GAUSS_8_POINTS] = {
    {REAL(-0.96028985649753623), REAL(0.10122853629037626)}, {REAL(-0.79666647741362674), REAL(0.22238103445337447)},
    {REAL(-0.52553240991632899), REAL(0.31370664587788729)}, {REAL(-0.18343464249564980), REAL(0.36268378337836198)},
    {REAL(0.18343464249564980), REAL(0.36268378337836198)},  {REAL(0.52553240991632899), REAL(0.31370664587788729)},
    {REAL(0.79666647741362674), REAL(0.22238103445337447)},  {REAL(0.96028985649753623), REAL(0.10122853629037626)}};

#endif
