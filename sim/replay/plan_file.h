/// Reads a plan as `ssv plan --format json` writes it, and checks every number before anything flies on it.
///
/// A plan file stands by itself: it carries the question (`scenario` and `scene`) and the
/// answer (`plan`), as the messages have them. Of the answer the choice, the time, impulse and clearance that it claims
/// and the thrusts are used; the poses that it claims to reach are not, as the task decides.
#ifndef SIM_PLAN_FILE_H
#define SIM_PLAN_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "physics/clearance.h"
#include "physics/rigid_body.h"

#define PLAN_THRUSTERS 6

/// Two instants of a plan file closer than this are one; of one that was computed in float, a rounding more.
#define PLAN_TIME_TOLERANCE_S 1e-6

/// Each thrust runs on a straight line from its start to its end value.
typedef struct {
    double duration_s;
    double u_start_N[PLAN_THRUSTERS], u_end_N[PLAN_THRUSTERS];
} plan_segment_t;

typedef struct {
    int64_t request_id;
    double rounding; ///< [-] of its numbers, relative: of the arithmetic that it was computed in

    // the task
    rb_body_t vehicle, beam;
    double force_max_N;
    rb_thruster_t thruster[PLAN_THRUSTERS];
    rb_pose_t X_IS, X_IB;        ///< vehicle and beam at the start, at rest
    double p_IP_m[3], axis_I[3]; ///< port, and its unit axis out of the hub
    double standoff_m;           ///< vehicle centre to beam axis when mated

    // the choice, one that the scenario permits
    int contact;            ///< 1 at z = -length/2 of the beam, 2 at +length/2
    double attach_height_m; ///< where along the beam's z the vehicle mates
    double ring_angle_rad;  ///< on which side, about z from x

    sim_surroundings_t around; ///< what stands around task and choice

    // the claims
    double time_s, impulse_Ns;
    double clearance_m; ///< certified; read if `around` counts

    // the timeline, contiguous from t = 0; the vehicle mates after the transit segments and docks after the last
    size_t num_segments, num_transit_segments;
    plan_segment_t* segment;
} plan_file_t;

/// @param path file, or "-" for standard input.
/// @return whether *plan holds a plan; then free it with `plan_file_free`. If not, error says what is wrong, where, and
/// what would be right.
bool plan_file_read(const char* path, plan_file_t* plan, char* error, size_t error_size);

void plan_file_free(plan_file_t* plan);

#endif
