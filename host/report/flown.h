/// How a task was flown: where the vehicle was, as its navigation estimates and as a simulator knows, beside the plan's
/// own clock. Made from the messages of a flight one by one, with rows as far apart as a picture can do with.
#ifndef SSV_FLOWN_H
#define SSV_FLOWN_H

#include <jansson.h>
#include <stdbool.h>

#include "lcm_ssv_execution_t.h"
#include "lcm_ssv_vehicle_state_t.h"
#include "wire/tree.h"

/// Most rows of a track; before there are more, every second one goes and the next ones come half as often.
#define FLOWN_ROWS_MAX 1200
/// A row is kept when so much has changed since the one before: time, place, attitude.
#define FLOWN_STEP_S 0.5
#define FLOWN_STEP_M 0.02
#define FLOWN_STEP_RAD 0.034906585 ///< 2 deg

/// Who holds the beam.
typedef enum { FLOWN_LIES = 0, FLOWN_MATED = 1, FLOWN_DOCKED = 2 } flown_beam_t;

typedef struct {
    double t_s;         ///< since the timeline started
    double plan_time_s; ///< on the plan's clock; of the estimate alone
    lcm_ssv_pose_t X_IS;
    double speed_m_s, rate_rad_s;
    double u_N[6]; ///< mean of the thrusts commanded since the row before; of the estimate alone
    flown_beam_t beam;
} flown_row_t;

typedef struct {
    int count;
    flown_row_t row[FLOWN_ROWS_MAX];
    lcm_ssv_pose_t X_SB;        ///< when it was mated; zero before, as is the next
    lcm_ssv_pose_t X_IB_docked; ///< when it was docked
    double spacing;             ///< how many times as far apart as above the rows are by now
    double sum_N[6];            ///< since the last row
    int num_summed;
} flown_track_t;

typedef struct {
    flown_track_t estimate, truth; ///< the truth has no rows where nobody tells it
    bool has_started;
    double start_s;                   ///< on the vehicle's clock
    double flown_s, plan_time_s;      ///< as told last
    bool is_told;                     ///< whether an execution_t is without its state yet
    lcm_ssv_vehicle_state_t early[2]; ///< truths that came before the start was known
} flown_t;

void flown_begin(flown_t* flown);

/// Takes note of a message of the flight. @return whether it has a place in it: a state that is of another time is of
/// another flight.
bool flown_note_execution(flown_t* flown, const lcm_ssv_execution_t* news);
bool flown_note_estimate(flown_t* flown, const lcm_ssv_vehicle_state_t* state);
bool flown_note_truth(flown_t* flown, const lcm_ssv_vehicle_state_t* state);

/// The row that a state is at once, for whoever does not wait for the next one that is kept; the estimate's goes by
/// the clock of the execution_t before it. It must have had its place.
flown_row_t flown_row_of(const flown_t* flown, const lcm_ssv_vehicle_state_t* state);

/// What happened up to the last estimate, as host/FORMATS.md tells. @return NULL if a number is not finite, or out of
/// memory.
json_t* flown_to_json(const flown_t* flown);

/// @return false with the error set.
bool flown_from_tree(const tree_t* tree, flown_t* flown, tree_error_t* error);

#endif
