/// Both ends of the link joined by a line of a given rate, delay and loss, in virtual time: nothing sleeps, and the
/// same seed gives the same run. Also seeded timelines.
#ifndef TESTS_TWO_ENDS_H
#define TESTS_TWO_ENDS_H

#include "ssv/link.h"

#define MAX_FLIGHTS 512
#define EPOCH_US INT64_C(1767225600000000) // [us] 2026-01-01, what Unix clocks say at the start

/// Uniform in [low, high), [0, n), all 64-bit numbers.
void draw_seed(uint64_t seed);
double draw_between(double low, double high);
int draw_below(int n);
uint64_t draw_bits(void);

/// A sound timeline with so many segments.
ssv_timeline_t draw_timeline(int num_segments);

typedef struct {
    int64_t at_us; ///< when it arrives
    size_t length;
    uint8_t bytes[SSV_LINK_FRAME_BYTES_MAX];
} flight_t;

/// One direction: the sender is asked for a frame whenever the last one has left, as by a serial port's interrupt.
typedef struct {
    double bytes_per_s;
    int64_t delay_us;
    double loss, corruption, repetition; ///< chance per frame that it is lost, has a bit flipped, arrives twice
    bool cut;                            ///< nothing passes
    int64_t free_us;
    int first, count;
    flight_t flight[MAX_FLIGHTS];
    long num_frames, num_bytes; ///< sent
} line_t;

typedef struct {
    int64_t now_us;
    ssv_link_vehicle_t vehicle;
    ssv_link_vehicle_state_t state;
    ssv_link_planner_t planner;
    line_t up, down; ///< to the vehicle, from it
    int num_commits, num_commands;
    bool has_beat;
    ssv_link_beat_t beat;
    bool has_trim;
    ssv_link_trim_t trim;
    void (*watch)(const uint8_t* frame, size_t length, bool up); ///< sees every frame that is sent; may be null
} world_t;

ssv_link_vehicle_config_t default_vehicle(void);
ssv_link_planner_config_t default_planner(uint32_t boot_id);
void world_init(world_t* world, double bytes_per_s, int64_t delay_us, double loss);

/// Lets time go on until the planner's end has an event or `until_us` has come; the vehicle accepts every command.
ssv_link_planner_event_t world_run(world_t* world, int64_t until_us);

/// The same, passing over all but this kind of event; SSV_LINK_PLANNER_NOTHING when none came in time.
ssv_link_planner_event_t world_await(world_t* world, ssv_link_planner_event_kind_t kind, int64_t until_us);

#endif
