/// A planner's end of the link that has a timeline flown by the simulated vehicle, open loop and in virtual time: it
/// uploads, commits, arms, starts and gives beats. The line between them is ideal but may be cut.
#ifndef TESTS_PILOT_H
#define TESTS_PILOT_H

#include "sil/sil.h"

typedef struct {
    sil_t sil;
    ssv_link_planner_t planner;
    uint8_t file[SSV_TIMELINE_FILE_BYTES_MAX];
    size_t length;
    uint64_t plan_hash;
    uint32_t session, progress;
    bool is_cut;                         ///< nothing passes between the ends
    bool is_frozen;                      ///< beats go on, the progress they tell does not
    bool has_failed;                     ///< an answer was not SSV_LINK_ACCEPTED, or the upload failed
    ssv_link_reason_t refusal;           ///< of the last command that was refused
    int num_done;                        ///< of the steps: upload, commit, arm, start
    ssv_link_execution_t execution;      ///< as the vehicle told it last
    char warning[SSV_LINK_TEXT_MAX + 1]; ///< its last text of SSV_LINK_WARNING or worse
} pilot_t;

/// @return NULL, or what is wrong with the configuration.
const char* pilot_init(pilot_t* pilot, const sil_config_t* config, const ssv_timeline_t* timeline, uint64_t seed);

/// One tick of everything.
void pilot_step(pilot_t* pilot);

/// Steps until the vehicle is in the phase. False when it is not after so long.
bool pilot_await(pilot_t* pilot, ssv_link_phase_t phase, double longest_s);

#endif
