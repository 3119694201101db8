/// Paths: maneuvers in a row, phase after phase, and their price.
#ifndef SSV_PATH_H
#define SSV_PATH_H

#include "planner/model/body.h"
#include "planner/model/grasp.h"
#include "planner/motion/maneuver.h"
#include "planner/motion/question.h"
#include "ssv/planner.h"
#include "ssv/vec3.h"

/// On functions whose large frame must not become part of their caller's: the stack is the planner's work memory.
#define SSV_OWN_FRAME __attribute__((noinline))

/// Turn, translate, turn, approach.
#define SSV_MAX_PHASE_MANEUVERS 4

/// The path of one phase: its maneuvers, what each of them costs, and what they cost together.
typedef struct {
    int num_maneuvers;
    ssv_maneuver_t maneuver[SSV_MAX_PHASE_MANEUVERS];
    ssv_price_t maneuver_price[SSV_MAX_PHASE_MANEUVERS];
    ssv_price_t price;
} ssv_phase_path_t;

/// The path of the whole assembly: transit, mating, transfer.
typedef struct {
    ssv_grasp_t grasp;
    int num_maneuvers;
    ssv_maneuver_t maneuver[2 * SSV_MAX_PHASE_MANEUVERS]; ///< those of the transit first
    pose_t X_SB;                                          ///< beam in S once mated
    ssv_price_t price;
} ssv_path_t;

/// The vehicle without a beam.
ssv_assembly_t ssv_vehicle_alone(const ssv_problem_t* problem);

/// Vehicle and beam, mated at the attach height [m] along z_B, with the beam as it lies and the vehicle in the attitude
/// q_IS, its x axis towards the beam's. X_SB follows from the grasp, not from positions in I, which have fewer digits
/// far from the origin.
ssv_assembly_t ssv_vehicle_with_beam(const ssv_problem_t* problem, real_t height_m, quat_t q_IS);

/// Prices the maneuvers of a phase. *known is a path of the same assembly that has been priced, or NULL: a maneuver
/// that it has in the same place takes its price from there, because an exact price costs more than the comparison.
void ssv_phase_path_price(const ssv_question_t* question, const ssv_assembly_t* assembly, const ssv_phase_path_t* known,
                          ssv_phase_path_t* phase);

/// About what maneuvers cost together, by ssv_profile_estimate. @return false if the thrusters cannot do one of them;
/// then *price is meaningless.
bool ssv_maneuvers_estimate(const ssv_question_t* question, const ssv_assembly_t* assembly,
                            const ssv_maneuver_t maneuver[], int num_maneuvers, real_t closeness, real_t* price);

/// What both phases cost together, as ssv_path_join adds it up.
ssv_price_t ssv_path_price(const ssv_phase_path_t* transit, const ssv_phase_path_t* transfer);

/// A candidate with its price, which is zero unless feasible; if it comes too near something, *clearance says where.
ssv_candidate_t ssv_candidate_of(const ssv_grasp_t* grasp, const ssv_price_t* price, const ssv_clearance_t* clearance);

/// Joins both phases. The price is added up maneuver by maneuver, as the plan's legs will be: quoted is what is flown,
/// to the last bit.
void ssv_path_join(const ssv_grasp_t* grasp, const ssv_phase_path_t* transit, const ssv_phase_path_t* transfer,
                   pose_t X_SB, ssv_path_t* path);

#endif
