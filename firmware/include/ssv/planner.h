/// The onboard trajectory planner: what does it cost to fly to a beam and carry it to a hub port, and which thrusts do
/// it?
///
/// `ssv_problem_init` checks a scenario and caches what follows from it, `ssv_plan` searches and prices the candidates
/// and writes the plan, `ssv_plan_sample` reads the plan at a time. Where the price will do, there are `ssv_quote`,
/// `ssv_front` and `ssv_lower_bound`. The planner is a function of its input: no clock, no randomness, no heap, no
/// globals, no I/O; the same scenario gives the same plan, bit for bit. All memory is the caller's and every loop is
/// bounded by a constant of this header or of the sources. A problem is constant once it is made: any number of
/// questions about it may be answered side by side, each in a ssv_work_t of its own.
///
///     ssv_scenario_t scenario = ssv_scenario_default();   // then fill in bodies, poses and port
///     ssv_problem_t problem;
///     ssv_fault_t fault;
///     if (ssv_problem_init(&problem, &scenario, &fault) != SSV_OK) { ... fault.field names what is wrong ... }
///     static ssv_work_t work;                             // 8 kB, needs no initial value
///     static ssv_plan_t plan;                             // 23 kB
///     if (ssv_plan(&problem, &work, &plan) == SSV_OK) { ... plan.quote.cost, plan.segment[0..plan.num_segments) ... }
///
/// Frames, units and ranges: ssv/scenario.h (the question), ssv/plan.h (the answer).
#ifndef SSV_PLANNER_H
#define SSV_PLANNER_H

#include "ssv/plan.h"
#include "ssv/scenario.h"
#include "ssv/timeline.h"

#define SSV_VERSION "0.1.0"

// For the linker and the debugger the scalar is part of each name (ssv_plan_double, ssv_plan_float, ssv_plan_fixed): a
// program compiled for one scalar does not link with the archive of another, and the linker says which it lacks.
#define ssv_status_str SSV_NAME(ssv_status_str)
#define ssv_outcome_str SSV_NAME(ssv_outcome_str)
#define ssv_scenario_default SSV_NAME(ssv_scenario_default)
#define ssv_problem_init SSV_NAME(ssv_problem_init)
#define ssv_scenario_hash SSV_NAME(ssv_scenario_hash)
#define ssv_scene_check SSV_NAME(ssv_scene_check)
#define ssv_plan_clearance SSV_NAME(ssv_plan_clearance)
#define ssv_plan_arrival SSV_NAME(ssv_plan_arrival)
#define ssv_lower_bound SSV_NAME(ssv_lower_bound)
#define ssv_quote SSV_NAME(ssv_quote)
#define ssv_quote_begin SSV_NAME(ssv_quote_begin)
#define ssv_quote_step SSV_NAME(ssv_quote_step)
#define ssv_front SSV_NAME(ssv_front)
#define ssv_front_begin SSV_NAME(ssv_front_begin)
#define ssv_front_step SSV_NAME(ssv_front_step)
#define ssv_plan SSV_NAME(ssv_plan)
#define ssv_plan_begin SSV_NAME(ssv_plan_begin)
#define ssv_plan_step SSV_NAME(ssv_plan_step)
#define ssv_plan_hash SSV_NAME(ssv_plan_hash)
#define ssv_plan_sample SSV_NAME(ssv_plan_sample)
#define ssv_timeline_of_plan SSV_NAME(ssv_timeline_of_plan)

#ifdef __cplusplus
extern "C" {
#endif

/// "double", "float" or "fixed", of the archive. The one name that is the same in all: a program that is linked with
/// two archives, whose inner functions would be mixed up, has it twice, and linkers refuse that.
extern const char ssv_scalar[];

/// A sentence for any status, e.g. "outside its range"; never NULL.
const char* ssv_status_str(ssv_status_t status);

/// A sentence for any outcome; never NULL.
const char* ssv_outcome_str(ssv_outcome_t outcome);

/// A scenario with identity poses, unit weights, every choice left to the method, and all physical numbers zero: those
/// must be filled in before `ssv_problem_init` accepts it.
ssv_scenario_t ssv_scenario_default(void);

/// Thrusts per wrench on S: row i gives thruster i [N] from [force [N]; moment about S [N m]] (paper Eqs. 12-14, in
/// full).
typedef struct {
    real_t u_per_wrench[SSV_NUM_THRUSTERS][6];
} ssv_allocation_t;

/// Obstacles by number, and the two that have none in the scene.
typedef struct {
    uint64_t obstacles;
    bool beam, tank;
} ssv_obstacles_t;

/// What vehicle and beam have around them.
typedef struct {
    const ssv_scene_t* scene;
    bool counts;             ///< whether there is anything to keep clear of
    ssv_obstacles_t all;     ///< what there is
    ssv_obstacles_t at_port; ///< what the docked contact may touch
    ssv_obstacles_t left;    ///< what the vehicle may touch where it starts
    ssv_obstacle_t beam;     ///< the beam as it lies
    real_t leaving_m;        ///< [m] length of the first stretch, 0 if nothing is left,
    real_t mating_m;         ///< [m] of the last stretch before mating,
    real_t docking_m;        ///< [m] and before docking
} ssv_surroundings_t;

/// A checked scenario with what follows from it. Made by `ssv_problem_init` only, constant afterwards; its fields are
/// not API.
typedef struct {
    ssv_scenario_t scenario; ///< as given, with quaternions and directions normalised, the heights filled in, and
                             ///< vehicle.force_max_N less the reserve
    uint64_t scenario_hash;
    ssv_allocation_t allocation;
    ssv_surroundings_t around;
} ssv_problem_t;

/// Memory that one question is answered in, in numbers.
#define SSV_WORK_REALS 1200

/// That memory: the caller's, one for each question under way. It needs no initial value, and what a question leaves in
/// it means nothing.
typedef union {
    real_t number[SSV_WORK_REALS];
    uint64_t hash; ///< this and the next for their alignment alone
    void* pointer;
} ssv_work_t;

/// Checks every field of the scenario against its range and caches the inverse of the thruster matrix.
/// @return SSV_OK, or a negative status; then *problem is untouched and *fault says which field. Costs about a
/// microsecond.
ssv_status_t ssv_problem_init(ssv_problem_t* problem, const ssv_scenario_t* scenario, ssv_fault_t* fault);

/// Checks a scene, and that there is an obstacle for each bit of the mask. @return SSV_OK, or a negative status; then
/// *fault says which field.
ssv_status_t ssv_scene_check(const ssv_scene_t* scene, uint64_t obstacles, ssv_fault_t* fault);

/// Where a plan for this problem ends if its timeline is flown open loop, by exact thrusters in still water: estimated
/// from the difference between the wrench of each line and what the motion asks for, carried through the linearised
/// motion of the body. The plan must be SSV_OK. Every field of *arrival is written. Nine of ten estimates are right
/// within two powers of ten, and rather too low (DESIGN.md 7). Costs about as much as the plan.
/// @return false if the scalar cannot hold the task: its rounding alone leads beside the goal, where lines would
/// arrive.
///         Where the lines miss, too, flying open loop is unstable, and more digits are no help.
bool ssv_plan_arrival(const ssv_problem_t* problem, const ssv_plan_t* plan, ssv_arrival_t* arrival);

/// How far a plan for this problem stays away from a scene, its own or one that was seen later: is the plan still good?
/// The plan must be SSV_OK, and the scene have passed ssv_scene_check with this mask. Every field of *clearance is
/// written. Costs about as much as a tenth of the plan.
void ssv_plan_clearance(const ssv_problem_t* problem, const ssv_plan_t* plan, const ssv_scene_t* scene,
                        uint64_t obstacles, ssv_clearance_t* clearance);

/// 64-bit hash (FNV-1a over the fields in the order declared) of a scenario, as given.
uint64_t ssv_scenario_hash(const ssv_scenario_t* scenario);

/// A price that no plan for this problem can undercut, whatever the method, from the balance of momentum (DESIGN.md
/// 11). Costs less than a microsecond. Where a number does not fit the scalar it is 0, which no plan undercuts either.
real_t ssv_lower_bound(const ssv_problem_t* problem);

/// The price without the plan: that of `ssv_plan`, to the last bit, unless that plan turns out not to fit its memory
/// (see SSV_TOO_MANY_SEGMENTS). @return quote->status. Every field of *quote is written; with SSV_INFEASIBLE only
/// status, scenario_hash and the candidates are meaningful, with SSV_NUMERIC_OVERFLOW the first two, the rest is zero.
ssv_status_t ssv_quote(const ssv_problem_t* problem, ssv_work_t* work, ssv_quote_t* quote);

/// The front over the scenario's candidates and over a ladder of weights from time alone to impulse alone, each rung
/// planned with the scenario's method and effort. A scheduler that changes its weights takes the point that costs least
/// with them. A point is what `ssv_quote` finds for that rung when it lists all candidates; one that would cost less
/// than the scenario's own quote, by the scenario's weights, is left out: it is not what a plan would be. Costs nine
/// such quotes. @return front->status; every field of *front is written.
ssv_status_t ssv_front(const ssv_problem_t* problem, ssv_work_t* work, ssv_front_t* front);

/// Plans. @return plan->quote.status. Every field of *plan is written.
ssv_status_t ssv_plan(const ssv_problem_t* problem, ssv_work_t* work, ssv_plan_t* plan);

/// Each of the three in slices, for who has other things to do between: begin, then step until it returns true, when
/// the answer is complete and the same to the last bit. A step looks at one candidate or height, or writes the plan.
/// The longest takes some 25 ms in fixed point on a desktop core and 3 ms in double (effort best), and there are at
/// most 110 of them in a quote or plan, where things stand in the way 350, and 9 times as many in a front. Until then
/// problem, work and answer stay where they are, and nobody else writes to them.
void ssv_quote_begin(const ssv_problem_t* problem, ssv_work_t* work, ssv_quote_t* quote);
bool ssv_quote_step(ssv_work_t* work, ssv_quote_t* quote);
void ssv_front_begin(const ssv_problem_t* problem, ssv_work_t* work, ssv_front_t* front);
bool ssv_front_step(ssv_work_t* work, ssv_front_t* front);
void ssv_plan_begin(const ssv_problem_t* problem, ssv_work_t* work, ssv_plan_t* plan);
bool ssv_plan_step(ssv_work_t* work, ssv_plan_t* plan);

/// 64-bit hash (FNV-1a over the fields in the order declared, plan_hash left out, arrays up to their counts) of a plan.
uint64_t ssv_plan_hash(const ssv_plan_t* plan);

/// The plan at time t_s; before the start and after the end the vehicle rests there with zero thrust. The plan must be
/// SSV_OK. At a joint the later leg counts. Pure; cost grows with the number of legs and segments.
void ssv_plan_sample(const ssv_plan_t* plan, real_t t_s, ssv_sample_t* sample);

/// The plan's thruster timeline in the form that the vehicle flies. The plan must be SSV_OK. Each start of a segment
/// and the end are rounded by themselves, and the durations are their differences; what lasts less than a nanosecond is
/// left out. Every field of *timeline is written.
void ssv_timeline_of_plan(const ssv_plan_t* plan, ssv_timeline_t* timeline);

#ifdef __cplusplus
}
#endif

#endif
