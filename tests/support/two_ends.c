// Both ends of the link and the line between them, in virtual time.
#include "two_ends.h"

#include <math.h>
#include <string.h>

/// [us] Ends that have nothing to send are asked again so much later.
#define TICK_US 5000

static uint64_t random_state;

void draw_seed(uint64_t seed) { random_state = seed; }

// splitmix64
uint64_t draw_bits(void) {
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double draw_between(double low, double high) { return low + (high - low) * ((double)(draw_bits() >> 11) * 0x1p-53); }

int draw_below(int n) { return (int)(draw_bits() % (uint64_t)n); }

ssv_timeline_t draw_timeline(int num_segments) {
    ssv_timeline_t timeline = {.plan_hash = draw_bits() | 1, .mass_configuration = 7, .u_max_N = 6};
    timeline.q_IS[0] = 1;
    timeline.num_segments = num_segments;
    for (int i = 0; i < num_segments; i++) {
        timeline.segment[i].duration_ns = 1 + (int64_t)(draw_bits() % UINT64_C(100000000000));
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
            timeline.segment[i].u_start_N[k] = (float)draw_between(-6, 6);
            timeline.segment[i].u_end_N[k] = (float)draw_between(-6, 6);
        }
    }
    timeline.num_events = 2;
    timeline.event[0] = (ssv_timeline_event_t){num_segments / 2, SSV_MATE};
    timeline.event[1] = (ssv_timeline_event_t){num_segments, SSV_DOCK};
    return timeline;
}

ssv_link_vehicle_config_t default_vehicle(void) {
    static const ssv_link_parameter_t parameters[] = {
        {"SSV_BEAT_WARN_S", 0.5F}, {"SSV_BEAT_STOP_S", 1}, {"SSV_FORCE_N", 6}};
    return (ssv_link_vehicle_config_t){.sysid = SSV_LINK_VEHICLE_SYSID,
                                       .compid = SSV_LINK_VEHICLE_COMPID,
                                       .boot_id = 77,
                                       .version = 0x00010000,
                                       .parameters = parameters,
                                       .num_parameters = 3,
                                       .mass_configuration = 7,
                                       .force_max_N = 6,
                                       .start_tolerance_m = 0.05F,
                                       .start_tolerance_rad = 0.05F};
}

ssv_link_planner_config_t default_planner(uint32_t boot_id) {
    return (ssv_link_planner_config_t){.sysid = SSV_LINK_VEHICLE_SYSID,
                                       .compid = SSV_LINK_PLANNER_COMPID,
                                       .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                       .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                       .boot_id = boot_id};
}

static line_t line(double bytes_per_s, int64_t delay_us, double loss) {
    return (line_t){.bytes_per_s = bytes_per_s, .delay_us = delay_us, .loss = loss};
}

void world_init(world_t* world, double bytes_per_s, int64_t delay_us, double loss) {
    memset(world, 0, sizeof *world);
    const ssv_link_vehicle_config_t vehicle = default_vehicle();
    const ssv_link_planner_config_t planner = default_planner(1);
    ssv_link_vehicle_init(&world->vehicle, &vehicle);
    ssv_link_planner_init(&world->planner, &planner);
    world->state.may_swap = true;
    world->state.pose.known = true;
    world->state.pose.q_IS[0] = 1;
    world->up = line(bytes_per_s, delay_us, loss);
    world->down = line(bytes_per_s, delay_us, loss);
}

static void land(line_t* line, int64_t now_us, const uint8_t* frame, size_t length) {
    if (line->count == MAX_FLIGHTS) return;
    flight_t* flight = &line->flight[(line->first + line->count) % MAX_FLIGHTS];
    flight->at_us = now_us;
    flight->length = length;
    memcpy(flight->bytes, frame, length);
    line->count++;
}

static void depart(line_t* line, int64_t now_us, const uint8_t* frame, size_t length) {
    line->free_us = now_us + (int64_t)ceil(1e6 * (double)length / line->bytes_per_s);
    line->num_frames++;
    line->num_bytes += (long)length;
    if (line->cut || draw_between(0, 1) < line->loss) return;
    uint8_t bytes[SSV_LINK_FRAME_BYTES_MAX];
    memcpy(bytes, frame, length);
    if (line->corruption > 0 && draw_between(0, 1) < line->corruption)
        bytes[draw_below((int)length)] ^= (uint8_t)(1 << draw_below(8));
    land(line, line->free_us + line->delay_us, bytes, length);
    if (line->repetition > 0 && draw_between(0, 1) < line->repetition)
        land(line, line->free_us + line->delay_us, bytes, length);
}

static void send(world_t* world) {
    uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
    line_t* lines[2] = {&world->up, &world->down};
    for (int i = 0; i < 2; i++) {
        if (world->now_us < lines[i]->free_us) continue;
        const size_t length = i == 0 ? ssv_link_planner_poll(&world->planner, world->now_us, frame)
                                     : ssv_link_vehicle_poll(&world->vehicle, world->now_us, &world->state, frame);
        if (length == 0) continue;
        if (world->watch != NULL) world->watch(frame, length, i == 0);
        depart(lines[i], world->now_us, frame, length);
    }
}

static const flight_t* arrived(line_t* line, int64_t now_us) {
    if (line->count == 0 || line->flight[line->first].at_us > now_us) return NULL;
    const flight_t* flight = &line->flight[line->first];
    line->first = (line->first + 1) % MAX_FLIGHTS;
    line->count--;
    return flight;
}

static void vehicle_takes(world_t* world, const flight_t* flight) {
    ssv_link_vehicle_event_t event;
    for (size_t at = 0; at < flight->length;) {
        at += ssv_link_vehicle_receive(&world->vehicle, world->now_us, &world->state, flight->bytes + at,
                                       flight->length - at, &event);
        if (event.kind == SSV_LINK_VEHICLE_COMMITTED) world->num_commits++;
        if (event.kind == SSV_LINK_VEHICLE_BEAT) {
            world->has_beat = true;
            world->beat = event.of.beat;
        }
        if (event.kind == SSV_LINK_VEHICLE_TRIM) {
            world->has_trim = true;
            world->trim = event.of.trim;
        }
        if (event.kind != SSV_LINK_VEHICLE_COMMANDED) continue;
        world->num_commands++;
        if (event.of.command.command == SSV_LINK_ARM)
            world->state.phase = event.of.command.value == 1 ? SSV_LINK_READY : SSV_LINK_DISARMED;
        if (event.of.command.command == SSV_LINK_START) world->state.phase = SSV_LINK_EXECUTING;
        if (event.of.command.command == SSV_LINK_TERMINATE) world->state.phase = SSV_LINK_STOPPED;
        ssv_link_vehicle_answer(&world->vehicle, &event, SSV_LINK_ACCEPTED, SSV_LINK_NO_REASON);
    }
}

static int64_t sooner(int64_t a, int64_t b) { return a < b ? a : b; }

// When something can happen next.
static int64_t next_us(const world_t* world) {
    const line_t* lines[2] = {&world->up, &world->down};
    int64_t next = world->now_us + TICK_US;
    for (int i = 0; i < 2; i++) {
        if (lines[i]->free_us > world->now_us) next = sooner(next, lines[i]->free_us);
        if (lines[i]->count > 0) next = sooner(next, lines[i]->flight[lines[i]->first].at_us);
    }
    return next > world->now_us ? next : world->now_us + 1;
}

ssv_link_planner_event_t world_run(world_t* world, int64_t until_us) {
    ssv_link_planner_event_t event = {.kind = SSV_LINK_PLANNER_NOTHING};
    while (world->now_us < until_us) {
        const flight_t* flight;
        while ((flight = arrived(&world->up, world->now_us)) != NULL) vehicle_takes(world, flight);
        while ((flight = arrived(&world->down, world->now_us)) != NULL) {
            ssv_link_planner_receive(&world->planner, world->now_us, flight->bytes, flight->length, &event);
            if (event.kind != SSV_LINK_PLANNER_NOTHING) return event; // a frame is one packet, so nothing of it is left
        }
        ssv_link_planner_receive(&world->planner, world->now_us, NULL, 0, &event);
        if (event.kind != SSV_LINK_PLANNER_NOTHING) return event;
        send(world);
        world->now_us = next_us(world);
    }
    return event;
}

ssv_link_planner_event_t world_await(world_t* world, ssv_link_planner_event_kind_t kind, int64_t until_us) {
    for (;;) {
        const ssv_link_planner_event_t event = world_run(world, until_us);
        if (event.kind == kind || event.kind == SSV_LINK_PLANNER_NOTHING) return event;
        if (event.kind == SSV_LINK_PLANNER_UPLOAD_FAILED && kind == SSV_LINK_PLANNER_UPLOADED) return event;
    }
}
