/// The motion of a plan as rows over time, for pictures and plots: each row is the planner's own sample, and they
/// follow one another so closely that what lies between can be taken from a straight line.
#ifndef SSV_TRACK_H
#define SSV_TRACK_H

#include <stdbool.h>
#include <stddef.h>

#include "near.h"

/// A row is never farther from the next one than this, nor is what lies between farther from the straight line.
#define TRACK_STEP_M 0.02
#define TRACK_STEP_RAD 0.034906585 ///< 2 deg
#define TRACK_BEND_M 3e-4
#define TRACK_BEND_RAD 1e-3
/// Most rows of a plan; one that needs more has them farther apart.
#define TRACK_ROWS_MAX 6000

typedef struct {
    double t_s;
    lcm_ssv_pose_t X_IS;
    double speed_m_s, rate_rad_s;
    int leg;
    bool mated;
    double behind_m, ahead_m; ///< way of the vehicle in the transit, later of the beam's contact, as of near_place_t
    near_t near;
} track_row_t;

typedef struct {
    int count;
    track_row_t* rows;
    near_scene_t scene;
    ssv_clearance_t clearance; ///< of the whole plan, anew; of no obstacle where there is nothing around
    int closest;               ///< the row where it was seen
    // What those refer to.
    ssv_scene_t core_scene;
    ssv_problem_t problem;
    ssv_plan_t plan;
} track_t;

/// Samples a plan; task and plan stay the caller's and must stay as they are. The track must not be moved.
/// @return false with a sentence in `error` if the plan is none that can be sampled, its question none that can be
/// asked, or out of memory; then there is nothing to free.
bool track_of_plan(const lcm_ssv_task_t* task, const lcm_ssv_plan_t* plan, track_t* track, char* error,
                   size_t error_size);

void track_free(track_t* track);

/// The plan at any time, sampled anew.
track_row_t track_at(const track_t* track, double t_s);

/// The nearest pair of a vehicle that flies the plan, but is somewhere else at that time of it.
near_t track_near(const track_t* track, double t_s, const lcm_ssv_pose_t* X_IS, bool mated);

#endif
