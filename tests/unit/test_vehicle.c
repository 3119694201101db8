// Phases, commands, the dead-man and the brake of the thruster controller.
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "pilot.h"
#include "two_ends.h"
#include "unity.h"

#define NUM_PHASES (SSV_LINK_DONE + 1)

static pilot_t pilot;
static sil_config_t config;
static ssv_timeline_t timeline;
static char text[120];

// The SSV with a beam that nothing reaches by chance; every attempt hits.
static void set_scene(void) {
    memset(&config, 0, sizeof config);
    config.world.vehicle = (rb_body_t){.mass_kg = 76.2, .inertia_kg_m2 = {2.7, 2.7, 2.7}, .drag_lin_kg_s = 100};
    config.world.beam = (rb_body_t){.mass_kg = 11.4, .inertia_kg_m2 = {8.8, 8.8, 0.04}, .length_m = 3};
    config.world.X_nb.q[0] = config.world.X_nB.q[0] = 1;
    config.world.X_nB.p_m[0] = 0.4;
    for (int t = 0; t < SIM_THRUSTERS; t++) {
        config.world.thruster[t].n[t / 2] = t % 2 == 0 ? 1 : -1;
        config.world.thruster[t].r_m[(t / 2 + 2) % 3] = t % 2 == 0 ? 0.3025 : -0.3025;
    }
    config.port = (sim_port_t){.contact = 1, .axis_n = {1, 0, 0}};
    config.force_max_N = 6;
    config.boot_id = 1;
}

// Two legs of 20 s each that move and turn the vehicle, with a mate between them and a dock at the end.
static void set_timeline(void) {
    memset(&timeline, 0, sizeof timeline);
    timeline.plan_hash = UINT64_C(0x123456789abcdef1);
    timeline.u_max_N = 6;
    timeline.q_IS[0] = 1;
    timeline.num_segments = 4;
    for (int i = 0; i < 4; i++) {
        timeline.segment[i].duration_ns = INT64_C(10000000000);
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++)
            timeline.segment[i].u_start_N[k] = timeline.segment[i].u_end_N[k] =
                (i % 2 == 0 ? 1.0F : -1.0F) * (k == 0   ? 4
                                               : k == 1 ? -3.8F
                                               : k == 2 ? 1
                                                        : 0.5F);
    }
    timeline.num_events = 2;
    timeline.event[0] = (ssv_timeline_event_t){2, SSV_MATE};
    timeline.event[1] = (ssv_timeline_event_t){4, SSV_DOCK};
}

void setUp(void) {
    draw_seed(11);
    set_scene();
    set_timeline();
}
void tearDown(void) {}

static ssv_link_phase_t phase(void) { return pilot.sil.vehicle.state.phase; }

static void steps(int count) {
    while (count-- > 0) pilot_step(&pilot);
}

static bool has_thrust(void) {
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        if (pilot.sil.output.u_N[k] != 0 || (pilot.sil.output.is_armed && pilot.sil.output.effort[k] != 0)) return true;
    }
    return false;
}

// Brings the vehicle into a phase, some time after the commit.
static void bring_to(ssv_link_phase_t wanted) {
    TEST_ASSERT_NULL(pilot_init(&pilot, &config, &timeline, 1));
    if (wanted == SSV_LINK_DISARMED || wanted == SSV_LINK_READY) {
        while (pilot.num_done < (wanted == SSV_LINK_DISARMED ? 2 : 3)) pilot_step(&pilot);
        if (wanted == SSV_LINK_DISARMED) TEST_ASSERT_FALSE(pilot.sil.output.is_armed);
        return;
    }
    TEST_ASSERT_TRUE(pilot_await(&pilot, SSV_LINK_EXECUTING, 10));
    steps(600);
    TEST_ASSERT_EQUAL(SSV_LINK_EXECUTING, phase());
    if (wanted == SSV_LINK_HOLDING)
        TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_PAUSE_CONTINUE, 0, 0));
    if (wanted == SSV_LINK_BRAKING || wanted == SSV_LINK_STOPPED)
        TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_TERMINATE, 1, 0));
    TEST_ASSERT_TRUE_MESSAGE(pilot_await(&pilot, wanted, 60), "the phase is not reached");
}

static void test_disarmed_is_no_thrust_of_zero_but_no_number(void) {
    TEST_ASSERT_NULL(pilot_init(&pilot, &config, &timeline, 1));
    steps(1);
    TEST_ASSERT_FALSE(pilot.sil.output.is_armed);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) TEST_ASSERT_TRUE(isnan(pilot.sil.output.effort[k]));
    bring_to(SSV_LINK_STOPPED);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) TEST_ASSERT_EQUAL_FLOAT(0, pilot.sil.output.effort[k]);
}

// The whole table: every command in every phase, what it answers and where it leads.
static void test_every_command_in_every_phase(void) {
    enum { D = SSV_LINK_DISARMED, R, E, H, B, S, N };
    static const struct {
        ssv_link_command_t command;
        int value;
        int leads_to[NUM_PHASES];
        int reason[NUM_PHASES];
    } table[] = {
        {SSV_LINK_ARM, 1, {R, R, E, H, B, S, N}, {0, 0, 0, 0, SSV_LINK_COMMANDED, SSV_LINK_COMMANDED, 0}},
        {SSV_LINK_ARM, 0, {D, D, D, D, D, D, D}, {0}},
        {SSV_LINK_PAUSE_CONTINUE,
         0,
         {D, R, H, H, B, S, N},
         {SSV_LINK_NOT_ARMED, SSV_LINK_NOTHING, 0, 0, SSV_LINK_COMMANDED, SSV_LINK_COMMANDED, SSV_LINK_NOTHING}},
        {SSV_LINK_PAUSE_CONTINUE,
         1,
         {D, R, E, E, B, S, N},
         {SSV_LINK_NOT_ARMED, SSV_LINK_NOTHING, 0, 0, SSV_LINK_COMMANDED, SSV_LINK_COMMANDED, SSV_LINK_NOTHING}},
        {SSV_LINK_TERMINATE, 1, {D, S, B, B, B, S, S}, {0}},
        {SSV_LINK_START,
         1,
         {D, E, E, H, B, S, N},
         {SSV_LINK_NOT_ARMED, 0, 0, 0, SSV_LINK_COMMANDED, SSV_LINK_COMMANDED, 0}},
        {SSV_LINK_COMMIT, 1, {D, R, E, H, B, S, N}, {0}}, // once more: it is live already
        {SSV_LINK_DROP, 1, {D, R, E, H, B, S, N}, {0}},
    };
    for (int c = 0; c < (int)(sizeof table / sizeof *table); c++) {
        for (int p = 0; p < NUM_PHASES; p++) {
            (void)snprintf(text, sizeof text, "command %d value %d in phase %d", (int)table[c].command, table[c].value,
                           p);
            bring_to((ssv_link_phase_t)p);
            TEST_ASSERT_EQUAL_MESSAGE(p, phase(), text);
            pilot.num_done = 4; // from here on the pilot gives no command of its own
            pilot.planner.command.pending = false;
            TEST_ASSERT_TRUE_MESSAGE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, table[c].command,
                                                              table[c].value, timeline.plan_hash),
                                     text);
            steps(1);
            TEST_ASSERT_EQUAL_MESSAGE(table[c].reason[p] != SSV_LINK_NO_REASON, pilot.has_failed, text);
            TEST_ASSERT_EQUAL_MESSAGE(table[c].reason[p], pilot.refusal, text);
            TEST_ASSERT_EQUAL_MESSAGE(table[c].leads_to[p], phase(), text);
        }
    }
}

static void test_a_pause_slows_down_and_the_timeline_goes_on_where_it_was(void) {
    bring_to(SSV_LINK_HOLDING);
    const int64_t at_ns = pilot.sil.vehicle.state.plan_time_ns;
    TEST_ASSERT_TRUE(has_thrust());
    steps(4000);
    TEST_ASSERT_FALSE(has_thrust());
    TEST_ASSERT_EQUAL_INT64(at_ns, pilot.sil.vehicle.state.plan_time_ns);
    TEST_ASSERT_TRUE(fabs(pilot.sil.world.state.nu[0]) < 0.01);
    TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_PAUSE_CONTINUE, 1, 0));
    TEST_ASSERT_TRUE(pilot_await(&pilot, SSV_LINK_DONE, 60));
}

static void test_a_stopped_vehicle_wants_to_be_disarmed_and_armed_anew_and_its_timeline_uploaded_anew(void) {
    static const ssv_link_command_t command[] = {SSV_LINK_ARM, SSV_LINK_ARM, SSV_LINK_ARM, SSV_LINK_START};
    static const int value[] = {1, 0, 1, 1};
    static const ssv_link_reason_t reason[] = {SSV_LINK_COMMANDED, SSV_LINK_NO_REASON, SSV_LINK_NO_REASON,
                                               SSV_LINK_NOTHING};
    bring_to(SSV_LINK_STOPPED);
    pilot.session++;
    for (int i = 0; i < 4; i++) {
        pilot.refusal = SSV_LINK_NO_REASON;
        TEST_ASSERT_TRUE(
            ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, command[i], value[i], timeline.plan_hash));
        steps(100);
        TEST_ASSERT_EQUAL(reason[i], pilot.refusal);
    }
    TEST_ASSERT_EQUAL(SSV_LINK_READY, phase());
}

static void test_a_miss_holds_and_going_on_is_another_attempt(void) {
    config.world.mate_limit.position_m = 1e-6;
    TEST_ASSERT_NULL(pilot_init(&pilot, &config, &timeline, 1));
    TEST_ASSERT_TRUE(pilot_await(&pilot, SSV_LINK_HOLDING, 40));
    TEST_ASSERT_EQUAL(SSV_LINK_TRACKING, pilot.sil.vehicle.state.reason);
    TEST_ASSERT_EQUAL(1, pilot.sil.num_attempts[SSV_MATE]);
    TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_PAUSE_CONTINUE, 1, 0));
    steps(5);
    TEST_ASSERT_EQUAL(2, pilot.sil.num_attempts[SSV_MATE]);
    pilot.sil.world.config.mate_limit.position_m = 0;
    TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_PAUSE_CONTINUE, 1, 0));
    TEST_ASSERT_TRUE(pilot_await(&pilot, SSV_LINK_DONE, 60));
    TEST_ASSERT_EQUAL(3, pilot.sil.num_attempts[SSV_MATE]);
    TEST_ASSERT_EQUAL(SIM_BEAM_DOCKED, pilot.sil.world.beam);
}

// Ticks with a trim of nothing every tenth of a second, until the vehicle is in the phase or they are over.
static void steps_trimmed(int count, ssv_link_phase_t until, float clock_rate) {
    static const float none_N[SSV_NUM_THRUSTERS];
    static uint32_t sequence;
    for (int k = 0; k < count && phase() != until; k++) {
        if (k % 20 == 0)
            ssv_link_planner_trim(&pilot.planner, pilot.session, ++sequence, pilot.sil.vehicle.state.plan_time_ns,
                                  clock_rate, none_N);
        pilot_step(&pilot);
    }
}

static void test_a_trimmed_timeline_waits_before_each_event_to_be_told_to_continue(void) {
    bring_to(SSV_LINK_EXECUTING);
    for (int e = 0; e < 2; e++) {
        steps_trimmed(8000, SSV_LINK_HOLDING, 1);
        TEST_ASSERT_EQUAL(SSV_LINK_HOLDING, phase());
        steps_trimmed(400, SSV_LINK_DONE, 0);
        TEST_ASSERT_EQUAL(0, pilot.sil.num_attempts[e]);
        TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_PAUSE_CONTINUE, 1, 0));
        steps(3);
        TEST_ASSERT_EQUAL(1, pilot.sil.num_attempts[e]);
    }
    TEST_ASSERT_TRUE(pilot_await(&pilot, SSV_LINK_DONE, 40));
    TEST_ASSERT_EQUAL(2, pilot.sil.vehicle.state.events);
    TEST_ASSERT_EQUAL(2, pilot.sil.vehicle.state.attempts);
}

static void test_trims_slow_the_clock_of_the_timeline_and_its_thrusts_alike(void) {
    bring_to(SSV_LINK_EXECUTING);
    steps_trimmed(100, SSV_LINK_DONE, 1);
    float full_N = 0, half_N = 0;
    const int64_t start_ns = pilot.sil.vehicle.state.plan_time_ns;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) full_N += fabsf(pilot.sil.output.u_N[k]);
    steps_trimmed(100, SSV_LINK_DONE, 0.5F);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) half_N += fabsf(pilot.sil.output.u_N[k]);
    TEST_ASSERT_EQUAL_INT64(start_ns + 250000000, pilot.sil.vehicle.state.plan_time_ns);
    // The timeline's thrust itself changes by some percent meanwhile.
    TEST_ASSERT_FLOAT_WITHIN(0.05F * full_N, 0.5F * full_N, half_N);
    const int64_t standing_ns = pilot.sil.vehicle.state.plan_time_ns;
    steps_trimmed(100, SSV_LINK_DONE, 0);
    TEST_ASSERT_EQUAL_INT64(standing_ns, pilot.sil.vehicle.state.plan_time_ns);
    TEST_ASSERT_EQUAL_FLOAT(0, pilot.sil.output.u_N[0]);
}

static double kinetic_J(void) {
    double momentum[6], sum = 0;
    rb_momentum(&pilot.sil.world.craft, pilot.sil.world.state.nu, momentum);
    for (int i = 0; i < 6; i++) sum += momentum[i] * pilot.sil.world.state.nu[i] / 2;
    return sum;
}

static void test_the_brake_takes_energy_until_the_vehicle_is_slow(void) {
    config.world.vehicle.drag_lin_kg_s = 0; // so that nothing else does
    bring_to(SSV_LINK_BRAKING);
    double before_J = kinetic_J();
    TEST_ASSERT_TRUE(before_J > 0.1);
    while (phase() == SSV_LINK_BRAKING) {
        pilot_step(&pilot);
        TEST_ASSERT_TRUE(kinetic_J() <= before_J);
        before_J = kinetic_J();
    }
    TEST_ASSERT_EQUAL(SSV_LINK_STOPPED, phase());
    TEST_ASSERT_TRUE(before_J < 76.2 * 0.005 * 0.005 / 2 + 2.7 * 0.005 * 0.005 / 2 + 1e-6);
}

// ---- The dead-man ---------------------------------------------------------------------------------------------------

// Lets the vehicle fly without counted beats; it must be without thrust in time and stay so.
static void expect_stop(const char* why) {
    const int64_t cut_us = pilot.sil.now_us;
    while (phase() != SSV_LINK_STOPPED && pilot.sil.now_us - cut_us < 40000000) {
        pilot_step(&pilot);
        if (pilot.sil.now_us - cut_us > 1200000) TEST_ASSERT_NOT_EQUAL_MESSAGE(SSV_LINK_EXECUTING, phase(), why);
    }
    TEST_ASSERT_EQUAL_MESSAGE(SSV_LINK_STOPPED, phase(), why);
    TEST_ASSERT_EQUAL_MESSAGE(SSV_LINK_BEAT_LOST, pilot.sil.vehicle.state.reason, why);
    TEST_ASSERT_FALSE_MESSAGE(has_thrust(), why);
    TEST_ASSERT_TRUE_MESSAGE(pilot.sil.now_us - cut_us < 1200000 + pilot.sil.config.brake_max_us, why);
    pilot.is_cut = pilot.is_frozen = false;
    steps(200);
    TEST_ASSERT_EQUAL_MESSAGE(SSV_LINK_STOPPED, phase(), why);
    TEST_ASSERT_FALSE_MESSAGE(has_thrust(), why);
}

static void test_after_a_cut_at_any_time_the_thrust_is_zero_in_time_and_stays_so(void) {
    for (int trial = 0; trial < 200; trial++) {
        (void)snprintf(text, sizeof text, "trial %d", trial);
        TEST_ASSERT_NULL(pilot_init(&pilot, &config, &timeline, 1));
        TEST_ASSERT_TRUE(pilot_await(&pilot, SSV_LINK_EXECUTING, 10));
        steps(draw_below(7000));
        pilot.is_cut = true;
        expect_stop(text);
    }
}

static void test_a_planner_that_makes_no_progress_counts_as_silent(void) {
    bring_to(SSV_LINK_EXECUTING);
    pilot.is_frozen = true;
    expect_stop("frozen");
}

static void test_the_silence_is_warned_of_before_it_stops(void) {
    bring_to(SSV_LINK_EXECUTING);
    pilot.is_frozen = true;
    steps(100); // half a second, and less than a beat's interval more
    TEST_ASSERT_EQUAL_STRING("", pilot.warning);
    steps(45);
    TEST_ASSERT_EQUAL(SSV_LINK_EXECUTING, phase());
    TEST_ASSERT_EQUAL_STRING("planner makes no progress", pilot.warning);
    pilot.is_frozen = false;
    steps(400);
    TEST_ASSERT_EQUAL(SSV_LINK_EXECUTING, phase());
}

// Gives beats of another planner's end five times a second while the own one is silent.
static void expect_stop_among(uint8_t compid, uint32_t boot_id, uint32_t session, uint32_t progress, const char* why) {
    static ssv_link_planner_t other;
    const ssv_link_planner_config_t other_config = {.sysid = SSV_LINK_VEHICLE_SYSID,
                                                    .compid = compid,
                                                    .vehicle_sysid = SSV_LINK_VEHICLE_SYSID,
                                                    .vehicle_compid = SSV_LINK_VEHICLE_COMPID,
                                                    .boot_id = boot_id};
    ssv_link_planner_init(&other, &other_config);
    bring_to(SSV_LINK_EXECUTING);
    const int64_t cut_us = pilot.sil.now_us;
    pilot.is_cut = true;
    while (pilot.sil.now_us - cut_us < 1200000) {
        uint8_t frame[SSV_LINK_FRAME_BYTES_MAX];
        size_t length;
        ssv_link_planner_beat(&other, session, progress++);
        while ((length = ssv_link_planner_poll(&other, pilot.sil.now_us, frame)) > 0)
            ssv_vehicle_receive(&pilot.sil.vehicle, pilot.sil.now_us, frame, length);
        pilot_step(&pilot);
    }
    TEST_ASSERT_EQUAL_MESSAGE(SSV_LINK_BEAT_LOST, pilot.sil.vehicle.state.reason, why);
}

static void test_foreign_and_replayed_beats_do_not_count(void) {
    expect_stop_among(190, 41, 1, 100000, "another component");
    expect_stop_among(SSV_LINK_PLANNER_COMPID, 40, 1, 100000, "another boot");
    expect_stop_among(SSV_LINK_PLANNER_COMPID, 41, 2, 100000, "another session");
    expect_stop_among(SSV_LINK_PLANNER_COMPID, 41, 1, 1, "beats of before");
}

static void test_a_start_wants_beats_and_a_session_that_was_not_flown(void) {
    bring_to(SSV_LINK_STOPPED);
    // All anew but the session: upload, commit, arm, start.
    TEST_ASSERT_TRUE(ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, SSV_LINK_ARM, 0, 0));
    steps(20);
    const uint32_t session = pilot.session;
    for (int again = 0; again < 2; again++) {
        pilot.session = session + (uint32_t)again;
        pilot.num_done = 0;
        pilot.refusal = SSV_LINK_NO_REASON;
        steps(50); // a beat of the session comes before its start
        pilot.sil.vehicle.link.config.start_tolerance_m = 100;
        pilot.sil.vehicle.link.config.start_tolerance_rad = 3;
        TEST_ASSERT_TRUE(ssv_link_planner_upload(&pilot.planner, pilot.file, pilot.length));
        steps(600);
        TEST_ASSERT_EQUAL(again == 0 ? SSV_LINK_BEAT_LOST : SSV_LINK_NO_REASON, pilot.refusal);
        TEST_ASSERT_EQUAL(again == 0 ? SSV_LINK_READY : SSV_LINK_EXECUTING, phase());
    }
}

// ---- Trims ----------------------------------------------------------------------------------------------------------

static void test_a_trim_counts_in_full_then_fades_then_the_vehicle_stops(void) {
    const float trim_N[SSV_NUM_THRUSTERS] = {0, 0, 0, 0, 0, 1.5F};
    bring_to(SSV_LINK_EXECUTING);
    steps(1);
    const float without_N = pilot.sil.output.u_N[5];
    ssv_link_planner_trim(&pilot.planner, pilot.session, 1, pilot.sil.vehicle.state.plan_time_ns, 1, trim_N);
    steps(1);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, without_N + 1.5F, pilot.sil.output.u_N[5]);
    steps(60);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, without_N + 1.5F, pilot.sil.output.u_N[5]);
    steps(50);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, without_N + 0.75F, pilot.sil.output.u_N[5]);
    steps(60);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, without_N, pilot.sil.output.u_N[5]);
    steps(40);
    TEST_ASSERT_EQUAL(SSV_LINK_BEAT_LOST, pilot.sil.vehicle.state.reason);
    TEST_ASSERT_EQUAL(SSV_LINK_BRAKING, phase());
}

static void test_trims_that_are_old_or_of_others_or_for_another_time_are_passed_over(void) {
    const float trim_N[SSV_NUM_THRUSTERS] = {0, 0, 0, 0, 0, 1.5F};
    bring_to(SSV_LINK_EXECUTING);
    steps(1);
    const float without_N = pilot.sil.output.u_N[5];
    const int64_t plan_time_ns = pilot.sil.vehicle.state.plan_time_ns;
    ssv_link_planner_trim(&pilot.planner, pilot.session + 1, 1, plan_time_ns, 1, trim_N);
    steps(1);
    ssv_link_planner_trim(&pilot.planner, pilot.session, 2, plan_time_ns + INT64_C(3000000000), 1, trim_N);
    steps(1);
    ssv_link_planner_trim(&pilot.planner, pilot.session, 0, plan_time_ns, 1, trim_N);
    steps(1);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, without_N, pilot.sil.output.u_N[5]);
}

// ---- Anything -------------------------------------------------------------------------------------------------------

static void check_invariants(const char* trial) {
    const ssv_link_phase_t now = phase();
    const bool may_thrust =
        now == SSV_LINK_EXECUTING || now == SSV_LINK_HOLDING || now == SSV_LINK_BRAKING || now == SSV_LINK_DONE;
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        const float effort = pilot.sil.output.effort[k];
        if (now == SSV_LINK_DISARMED) TEST_ASSERT_TRUE_MESSAGE(isnan(effort), trial);
        if (now != SSV_LINK_DISARMED) TEST_ASSERT_TRUE_MESSAGE(fabsf(effort) <= 1, trial);
        if (now != SSV_LINK_DISARMED && !may_thrust) TEST_ASSERT_TRUE_MESSAGE(effort == 0, trial);
        TEST_ASSERT_TRUE_MESSAGE(fabsf(pilot.sil.output.u_N[k]) <= pilot.sil.config.thrust_max_N, trial);
    }
}

static void act(void) {
    static const ssv_link_command_t command[] = {SSV_LINK_ARM,    SSV_LINK_PAUSE_CONTINUE, SSV_LINK_TERMINATE,
                                                 SSV_LINK_COMMIT, SSV_LINK_START,          SSV_LINK_DROP};
    const ssv_timeline_stamp_t stamp = {EPOCH_US, 600000};
    float trim_N[SSV_NUM_THRUSTERS];
    switch (draw_below(8)) {
        case 0: // another timeline, which nobody flies before its commit
            timeline.plan_hash = draw_bits() | 1;
            pilot.length = ssv_timeline_encode(&timeline, &stamp, pilot.file, sizeof pilot.file);
            ssv_link_planner_upload(&pilot.planner, pilot.file, pilot.length);
            break;
        case 1: pilot.is_cut = draw_below(4) == 0; break;
        case 2: pilot.is_frozen = draw_below(4) == 0; break;
        case 3: pilot.session = 1 + (uint32_t)draw_below(30); break;
        case 4:
            for (int k = 0; k < SSV_NUM_THRUSTERS; k++) trim_N[k] = (float)draw_between(-9, 9);
            ssv_link_planner_trim(&pilot.planner, pilot.session, (uint32_t)draw_below(100),
                                  pilot.sil.vehicle.state.plan_time_ns, 1, trim_N);
            break;
        default:
            ssv_link_planner_command(&pilot.planner, pilot.sil.now_us, command[draw_below(6)], draw_below(4) != 0,
                                     draw_below(8) == 0 ? draw_bits() : timeline.plan_hash);
    }
}

static void test_no_sequence_of_commands_beats_and_uploads_breaks_what_must_hold(void) {
    long num_flown = 0;
    for (int trial = 0; trial < 2000; trial++) {
        (void)snprintf(text, sizeof text, "trial %d", trial);
        set_timeline();
        TEST_ASSERT_NULL(pilot_init(&pilot, &config, &timeline, (uint64_t)trial));
        for (int action = 0; action < 25; action++) {
            if (action > draw_below(6)) act();
            for (int tick = draw_below(60); tick > 0; tick--) {
                pilot_step(&pilot);
                check_invariants(text);
                // What is flown is the live timeline, and that was committed: its hash is not the one that still waits.
                const ssv_link_phase_t now = phase();
                if (now != SSV_LINK_EXECUTING && now != SSV_LINK_HOLDING) continue;
                TEST_ASSERT_EQUAL_PTR_MESSAGE(ssv_link_vehicle_live(&pilot.sil.vehicle.link, NULL),
                                              pilot.sil.vehicle.execution.file, text);
                num_flown++;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN(10000, num_flown); // ticks: or the sequences say nothing
}

// The fuzzer found it: by an attitude that is none a brake could push along the motion.
static void test_navigation_whose_attitude_is_not_of_unit_length_is_passed_over(void) {
    static ssv_controller_t vehicle;
    static ssv_vehicle_config_t defaults;
    ssv_link_pose_t pose = {.q_IS = {0.1F, 0.2F, 0, 0}};
    ssv_vehicle_config_default(&defaults, 1);
    TEST_ASSERT_TRUE(ssv_vehicle_init(&vehicle, &defaults));
    ssv_vehicle_navigate(&vehicle, 0, &pose);
    TEST_ASSERT_FALSE(vehicle.state.pose.known);
    pose.q_IS[0] = 0.6F;
    pose.q_IS[1] = 0.8F;
    ssv_vehicle_navigate(&vehicle, 0, &pose);
    TEST_ASSERT_TRUE(vehicle.state.pose.known);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_disarmed_is_no_thrust_of_zero_but_no_number);
    RUN_TEST(test_every_command_in_every_phase);
    RUN_TEST(test_a_pause_slows_down_and_the_timeline_goes_on_where_it_was);
    RUN_TEST(test_a_stopped_vehicle_wants_to_be_disarmed_and_armed_anew_and_its_timeline_uploaded_anew);
    RUN_TEST(test_a_miss_holds_and_going_on_is_another_attempt);
    RUN_TEST(test_a_trimmed_timeline_waits_before_each_event_to_be_told_to_continue);
    RUN_TEST(test_trims_slow_the_clock_of_the_timeline_and_its_thrusts_alike);
    RUN_TEST(test_the_brake_takes_energy_until_the_vehicle_is_slow);
    RUN_TEST(test_after_a_cut_at_any_time_the_thrust_is_zero_in_time_and_stays_so);
    RUN_TEST(test_a_planner_that_makes_no_progress_counts_as_silent);
    RUN_TEST(test_the_silence_is_warned_of_before_it_stops);
    RUN_TEST(test_foreign_and_replayed_beats_do_not_count);
    RUN_TEST(test_a_start_wants_beats_and_a_session_that_was_not_flown);
    RUN_TEST(test_a_trim_counts_in_full_then_fades_then_the_vehicle_stops);
    RUN_TEST(test_trims_that_are_old_or_of_others_or_for_another_time_are_passed_over);
    RUN_TEST(test_navigation_whose_attitude_is_not_of_unit_length_is_passed_over);
    RUN_TEST(test_no_sequence_of_commands_beats_and_uploads_breaks_what_must_hold);
    return UNITY_END();
}
