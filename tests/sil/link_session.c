// A whole session of both ends in virtual time: upload, commit, arm, start, beats, trims, pause, stop. Writes every
// frame that was sent, those to the vehicle to DIR/up.bin and those from it to DIR/down.bin, and the timeline file to
// DIR/timeline.
#include <stdio.h>
#include <stdlib.h>

#include "two_ends.h"

static FILE *up_file, *down_file;
static world_t world;

static FILE* open_in(const char* folder, const char* name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE* file = fopen(path, "wb");
    if (file == NULL) {
        perror(path);
        exit(1);
    }
    return file;
}

static void keep(const uint8_t* frame, size_t length, bool up) { fwrite(frame, 1, length, up ? up_file : down_file); }

static void give(ssv_link_command_t command, int32_t value, uint64_t plan_hash) {
    if (!ssv_link_planner_command(&world.planner, world.now_us, command, value, plan_hash)) exit(1);
    const ssv_link_planner_event_t event =
        world_await(&world, SSV_LINK_PLANNER_ANSWERED, world.now_us + INT64_C(10000000));
    if (event.kind != SSV_LINK_PLANNER_ANSWERED || event.of.answer.result != SSV_LINK_ACCEPTED) {
        fprintf(stderr, "command %d was not accepted\n", (int)command);
        exit(1);
    }
}

static void pass(int64_t us) {
    const int64_t until_us = world.now_us + us;
    while (world.now_us < until_us) world_run(&world, until_us);
}

int main(int argc, char** argv) {
    static uint8_t bytes[SSV_TIMELINE_FILE_BYTES_MAX];
    if (argc != 2) return 2;
    up_file = open_in(argv[1], "up.bin");
    down_file = open_in(argv[1], "down.bin");
    draw_seed(5);
    world_init(&world, 5760, 5000, 0);
    world.watch = keep;
    world.state.pose =
        (ssv_link_pose_t){true, {0.01F, 0.02F, 0.03F}, {1, 0, 0, 0}, {0.1F, 0.2F, 0.3F}, {0.4F, 0.5F, 0.6F}};
    for (int i = 0; i < SSV_NUM_THRUSTERS; i++) world.state.u_N[i] = (float)(i + 1);
    const ssv_timeline_t timeline = draw_timeline(SSV_MAX_SEGMENTS);
    const ssv_timeline_stamp_t stamp = {EPOCH_US, 600000};
    const size_t length = ssv_timeline_encode(&timeline, &stamp, bytes, sizeof bytes);
    FILE* file = open_in(argv[1], "timeline");
    fwrite(bytes, 1, length, file);
    fclose(file);

    pass(1500000);
    ssv_link_planner_upload(&world.planner, bytes, length);
    if (world_await(&world, SSV_LINK_PLANNER_UPLOADED, world.now_us + 10000000).kind != SSV_LINK_PLANNER_UPLOADED)
        return 1;
    give(SSV_LINK_COMMIT, 0, timeline.plan_hash);
    give(SSV_LINK_ARM, 1, 0);
    give(SSV_LINK_START, 0, timeline.plan_hash);
    for (uint32_t k = 1; k <= 30; k++) {
        ssv_link_planner_beat(&world.planner, 1, k);
        ssv_link_planner_trim(&world.planner, 1, k, INT64_C(100000000) * k, 0.25F,
                              (const float[]){1, -2, 3, -4, 5, -6});
        world.state.plan_time_ns = INT64_C(100000000) * k;
        world.state.segment = (int32_t)k;
        pass(100000);
    }
    give(SSV_LINK_PAUSE_CONTINUE, 0, 0);
    give(SSV_LINK_TERMINATE, 1, 0);
    give(SSV_LINK_DROP, 0, 0);
    pass(1500000);
    fclose(up_file);
    fclose(down_file);
    return world.has_beat && world.has_trim && world.trim.trim_N[5] == -6 ? 0 : 1;
}
