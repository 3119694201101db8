/// The thruster timeline as the vehicle flies it: for the link and the vehicle, which know neither the planner nor its
/// scalar. Types alone; `ssv_timeline_of_plan` (ssv/planner.h) makes one of a plan.
///
/// Times are whole nanoseconds and only durations are kept, so a segment starts where the last one ended and their sum
/// is the plan's time: no error adds up. Flown open loop in simulation, times in microseconds carried a beam 3 mm off,
/// in nanoseconds 0.02 mm. Thrusts are IEEE 754 binary32, correctly rounded from every scalar:
/// at 6 N within 0.24 uN, which with these times is 0.2 mm; over the whole range of force_max_N (0.001 to 10000 N) as
/// good in proportion, where an integer of the same size would have to give up one end (micronewtons end at 2147 N). An
/// event belongs to a segment and not to a time: the thrusts of the vehicle alone and those of vehicle and beam differ
/// by far more than any rounding.
///
/// S is the vehicle's frame, I the inertial one, as in ssv/scenario.h.
#ifndef SSV_TIMELINE_H
#define SSV_TIMELINE_H

#include <stdint.h>

#define SSV_NUM_THRUSTERS 6
#define SSV_MAX_SEGMENTS 128
#define SSV_MAX_EVENTS 2

typedef enum { SSV_MATE = 0, SSV_DOCK = 1 } ssv_event_kind_t;

/// Each thrust runs on a straight line from its start to its end value.
typedef struct {
    int64_t duration_ns;                ///< [ns] > 0
    float u_start_N[SSV_NUM_THRUSTERS]; ///< [N] |u| <= u_max_N
    float u_end_N[SSV_NUM_THRUSTERS];   ///< [N] likewise
} ssv_timeline_segment_t;

/// What happens between two segments.
typedef struct {
    int32_t segment; ///< happens before this one; num_segments stands for the end
    ssv_event_kind_t kind;
} ssv_timeline_event_t;

typedef struct {
    uint64_t plan_hash;          ///< of the plan that this is
    uint32_t mass_configuration; ///< a number that the asker and the vehicle give to the bodies that the plan reckons
                                 ///< with; 0 until the asker fills it in, the planner knows none
    float u_max_N;               ///< [N] the largest thrust that is asked for: the vehicle must be able to give it
    float p_IS_m[3];             ///< [m] where the vehicle must rest at the start
    float q_IS[4];               ///< [-] and its attitude there, unit, scalar first
    int32_t num_segments;        ///< [0, SSV_MAX_SEGMENTS]
    ssv_timeline_segment_t segment[SSV_MAX_SEGMENTS];
    int32_t num_events;                         ///< [0, SSV_MAX_EVENTS]
    ssv_timeline_event_t event[SSV_MAX_EVENTS]; ///< in the order in which they happen
} ssv_timeline_t;

#endif
