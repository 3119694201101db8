/// A task that is flown: the executive on the vehicle's port, and what the bus is told about it.
#ifndef SSV_FLIGHT_H
#define SSV_FLIGHT_H

#include <lcm/lcm.h>

#include "bench/key.h"
#include "bench/port.h"
#include "lcm_ssv_control_t.h"
#include "ssv/answer.h"
#include "ssv/executive.h"

typedef struct {
    const char* link;      ///< as port_open
    const char* key;       ///< file of the key that the link is signed with; NULL for none
    const char* lockstep;  ///< UDP port on the loopback that gives a simulator leave; NULL for the real clock
    double rate;           ///< simulated seconds per second in lockstep; 0 for as fast as it goes
    double thruster_lag_s; ///< [s]
} flight_options_t;

typedef struct {
    lcm_t* lcm;
    flight_options_t options;
    port_t port, leave; ///< to the vehicle, to the simulator
    bool is_open;
    int64_t zero_us; ///< [us] of the real clock when flight_now_us was 0
    int64_t lock_us; ///< [us] the simulator's time
    bool simulator_gone;
    ssv_executive_t executive;
    ssv_scene_t scene; ///< that the problem refers to
    ssv_problem_t problem;
    ssv_plan_t plan;
    lcm_ssv_answer_t answer; ///< whose task it is
    int64_t told_us;         ///< [us] when the bus was told last
    int32_t sequence, num_plans;
    int64_t begun_us;        ///< [us] of the task
    int64_t begun_clock_us;  ///< [us] likewise, by the real clock
    int64_t epoch_us;        ///< of the last plan
    bool has_news;           ///< whether the bus does not know yet how the task ended
    int32_t num_endings;     ///< how often the end has been told
    int64_t ending_clock_us; ///< [us] when, by the real clock
    ssv_work_t work;         ///< to plan anew
    uint8_t message[2048];
} flight_t;

/// Opens the ports. @return false with a sentence in `error`.
bool flight_open(flight_t* flight, lcm_t* lcm, const flight_options_t* options, uint32_t boot_id, char* error,
                 size_t error_size);

/// Whether a task is under way, or its end has not been told yet.
bool flight_is_under_way(const flight_t* flight);

/// Whether the vehicle has been heard within the last 2 s.
bool flight_hears(const flight_t* flight);

/// Begins to fly a plan that was just made, whose problem and plan are copied. False while another one is under way.
bool flight_begin(flight_t* flight, const ssv_answer_t* answer);

/// Obeys, if the control is for this planner and the task under way.
void flight_control(flight_t* flight, const lcm_ssv_control_t* control);

/// Stops what is under way.
void flight_stop(flight_t* flight);

/// What is due: hears, steps, sends, tells the bus.
void flight_turn(flight_t* flight);

/// How long until something is due [us], 0 or more, unless bytes come before; INT64_MAX for nothing.
int64_t flight_wait_us(const flight_t* flight);

void flight_close(flight_t* flight);

#endif
