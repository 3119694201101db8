#include "plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "track.h"
#include "wire/names.h"

#define DEG_PER_RAD 57.295779513082321
/// [m] What is farther away is of no interest.
#define CLEARANCE_SHOWN_M 1.0
/// [m] Steps of the axis of clearances, whose least one leaves room below the margin.
#define CLEARANCE_STEP_M 0.1

// ---- The table ------------------------------------------------------------------------------------------------------

static void table_row(FILE* out, double start_s, const char* task, const char* phase, const track_row_t* row,
                      const double u_N[SSV_NUM_THRUSTERS]) {
    fprintf(out, "%.9g,\"", start_s + row->t_s);
    for (; *task != '\0'; task++) fputc(*task == '"' ? '\'' : *task, out);
    fprintf(out, "\",%s,%d", phase, row->leg + 1);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) fprintf(out, ",%.6g", u_N[k] + 0.0);
    fprintf(out, ",%.6g,%.6g,", row->speed_m_s, row->rate_rad_s * DEG_PER_RAD);
    if (row->near.obstacle != LCM_SSV_CLEARANCE_T_OBSTACLE_NONE) fprintf(out, "%.6g", row->near.distance_m);
    for (int i = 0; i < 3; i++) fprintf(out, ",%.9g", row->X_IS.p_m[i]);
    for (int i = 0; i < 4; i++) fprintf(out, ",%.9g", row->X_IS.q[i]);
    fputc('\n', out);
}

/// The rows of a segment: its start, the instants of the track within it, its end.
static void segment_rows(FILE* out, double start_s, const record_task_t* task, const track_t* track, int number,
                         int* next) {
    const lcm_ssv_segment_t* const segment = &task->plan.segments[number];
    const char* const phase = name_of(&names_phase, task->plan.legs[segment->leg].phase);
    const double end_s = segment->t_s + segment->duration_s;
    track_row_t row = track_at(track, segment->t_s);
    row.leg = segment->leg;
    table_row(out, start_s, task->name, phase, &row, segment->u_start_N);
    while (*next < track->count && track->rows[*next].t_s <= segment->t_s) ++*next;
    for (; *next < track->count && track->rows[*next].t_s < end_s; ++*next) {
        const double part = (track->rows[*next].t_s - segment->t_s) / segment->duration_s;
        double u_N[SSV_NUM_THRUSTERS];
        for (int k = 0; k < SSV_NUM_THRUSTERS; k++)
            u_N[k] = segment->u_start_N[k] + part * (segment->u_end_N[k] - segment->u_start_N[k]);
        table_row(out, start_s, task->name, phase, &track->rows[*next], u_N);
    }
    row = track_at(track, end_s);
    row.leg = segment->leg;
    table_row(out, start_s, task->name, phase, &row, segment->u_end_N);
}

bool plot_table(FILE* out, const plot_t* plot, char* error, size_t error_size) {
    const record_t* const record = plot->record;
    track_t* const track = malloc(sizeof *track);
    double start_s = 0;
    if (track == NULL) {
        snprintf(error, error_size, "out of memory");
        return false;
    }
    fputs("t_s,task,phase,leg", out);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) fprintf(out, ",u%d_N", k + 1);
    fputs(",speed_m_s,rate_deg_s,clearance_m,p_IS_x_m,p_IS_y_m,p_IS_z_m,q_IS_w,q_IS_x,q_IS_y,q_IS_z\n", out);
    for (int i = 0; i < record->count; i++) {
        const record_task_t* const task = &record->tasks[i];
        int next = 0;
        if (!track_of_plan(&task->question, &task->plan, track, error, error_size)) {
            free(track);
            return false;
        }
        for (int k = 0; k < task->plan.num_segments; k++) segment_rows(out, start_s, task, track, k, &next);
        track_free(track);
        start_s += task->plan.quote.time_s;
    }
    free(track);
    return true;
}

// ---- The script -----------------------------------------------------------------------------------------------------

/// A text as gnuplot takes it literally.
static void write_quoted(FILE* out, const char* text) {
    fputc('\'', out);
    for (; *text != '\0'; text++) {
        if (*text == '\'') fputc('\'', out);
        fputc(*text, out);
    }
    fputc('\'', out);
}

static double whole_s(const record_t* record) {
    double sum_s = 0;
    for (int i = 0; i < record->count; i++) sum_s += record->tasks[i].plan.quote.time_s;
    return sum_s;
}

static void shade_phases(FILE* out, const record_t* record) {
    double start_s = 0;
    int number = 1;
    for (int i = 0; i < record->count; i++) {
        const lcm_ssv_plan_t* const plan = &record->tasks[i].plan;
        for (int k = 0; k < plan->num_legs; k++) {
            const lcm_ssv_leg_t* const leg = &plan->legs[k];
            fprintf(
                out,
                "set object %d rectangle from %.9g, graph 0 to %.9g, graph 1 behind fillcolor rgb '%s' fillstyle solid "
                "noborder\n",
                number++, start_s + leg->t_start_s, start_s + leg->t_start_s + leg->duration_s,
                leg->phase == LCM_SSV_LEG_T_PHASE_TRANSIT ? "#e0eef6" : "#fbf0da");
        }
        start_s += plan->quote.time_s;
    }
}

static void write_data(FILE* out, const plot_t* plot) {
    if (plot->csv_path == NULL)
        fputs("$table", out);
    else
        write_quoted(out, plot->csv_path);
}

static void write_curve(FILE* out, const plot_t* plot, const char* column, const char* style) {
    write_data(out, plot);
    fprintf(out, " using 't_s':'%s' with lines title '%s' %s", column, column, style);
}

static void thrust_panels(FILE* out, const plot_t* plot) {
    const double most_N = plot->record->tasks[0].question.scenario.vehicle.force_max_N;
    fprintf(out, "set yrange [%.6g:%.6g]\nset ytics ('-%.3g' %.6g, '0' 0, '%.3g' %.6g)\n", -1.15 * most_N,
            1.15 * most_N, most_N, -most_N, most_N, most_N);
    for (int k = 0; k < SSV_NUM_THRUSTERS; k++) {
        char column[16];
        snprintf(column, sizeof column, "u%d_N", k + 1);
        fprintf(out, "set ylabel 'T%d [N]'\nplot ", k + 1);
        write_curve(out, plot, column, "linecolor rgb '#1a1a1a'\n");
    }
}

/// All thrusts in one, where there is no room for six.
static void sum_panel(FILE* out, const plot_t* plot) {
    fputs("set yrange [0:*]\nset ytics auto\nset ylabel 'thrust [N]'\nplot ", out);
    write_data(out, plot);
    fputs(
        " using 't_s':(abs(column('u1_N'))+abs(column('u2_N'))+abs(column('u3_N'))+abs(column('u4_N'))"
        "+abs(column('u5_N'))+abs(column('u6_N'))) with lines\n",
        out);
}

static void speed_panel(FILE* out, const plot_t* plot) {
    fputs("set yrange [0:*]\nset ytics auto\nset ylabel 'speed [m/s]'\n", out);
    if (plot->columns == 0)
        fputs("set y2range [0:*]\nset y2tics\nset ytics nomirror\nset y2label 'rate [deg/s], dashed'\n", out);
    fputs("plot ", out);
    write_curve(out, plot, "speed_m_s", "linecolor rgb '#0072b2'");
    if (plot->columns == 0) {
        fputs(", ", out);
        write_curve(out, plot, "rate_deg_s", "axes x1y2 dashtype 2 linecolor rgb '#8a5f00'");
        fputs("\nunset y2tics\nunset y2label\nset ytics mirror", out);
    }
    fputc('\n', out);
}

/// The last panel, which has the axis of time.
static void clearance_panel(FILE* out, const plot_t* plot, double least_m) {
    fputs("set format x\nset xlabel 't [s]'\nset ylabel 'clear [m]'\n", out);
    fprintf(out, "set yrange [%.6g:%.6g]\nplot ", fmin(0, CLEARANCE_STEP_M * floor(least_m / CLEARANCE_STEP_M)),
            CLEARANCE_SHOWN_M);
    write_curve(out, plot, "clearance_m", "linecolor rgb '#1a1a1a'");
    fprintf(out, ", %.6g with lines title 'margin' dashtype 3 linecolor rgb '#d00000'\n",
            plot->record->tasks[0].question.scenario.margin_m);
}

/// The least clearance of the plans, 0 if there is none below.
static bool least_clearance(const record_t* record, double* least_m, char* error, size_t error_size) {
    track_t* const track = malloc(sizeof *track);
    bool sound = track != NULL;
    *least_m = 0;
    if (!sound) snprintf(error, error_size, "out of memory");
    for (int i = 0; i < record->count && sound; i++) {
        sound = track_of_plan(&record->tasks[i].question, &record->tasks[i].plan, track, error, error_size);
        if (!sound) break;
        if (track->clearance.obstacle != SSV_OBSTACLE_NONE)
            *least_m = fmin(*least_m, real_to_double(track->clearance.seen_m));
        track_free(track);
    }
    free(track);
    return sound;
}

bool plot_script(FILE* out, const plot_t* plot, char* error, size_t error_size) {
    const bool is_svg = plot->columns == 0;
    double least_m = 0;
    if (!least_clearance(plot->record, &least_m, error, error_size)) return false;
    if (is_svg) {
        fputs("# Thrusts, speed and clearance of ", out);
        fprintf(out, "%s: run gnuplot on this file\n", plot->record->title);
        fputs("set terminal svg size 900,1100 font 'sans,11' background rgb 'white'\n", out);
    } else {
        fprintf(out, "set terminal dumb %d %d\n", plot->columns, plot->lines);
    }
    if (plot->output_path != NULL) {
        fputs("set output ", out);
        write_quoted(out, plot->output_path);
        fputc('\n', out);
    }
    if (plot->csv_path == NULL) {
        fputs("$table << end_of_table\n", out);
        if (!plot_table(out, plot, error, error_size)) return false;
        fputs("end_of_table\n", out);
    }
    fputs(
        "set datafile separator comma\nset datafile columnheaders\nset datafile missing ''\nset encoding utf8\nunset "
        "key\n",
        out);
    fprintf(out, "set xrange [0:%.9g]\n", whole_s(plot->record));
    if (is_svg) {
        fputs("set grid\nset lmargin 11\nset rmargin 10\nset bmargin 1.4\nset tmargin 0.6\nset format x ''\n", out);
        shade_phases(out, plot->record);
    }
    fprintf(out, "set multiplot layout %d,1 margins %s spacing %s\n", is_svg ? 8 : 3,
            is_svg ? "0.1,0.9,0.06,0.98" : "0.17,0.98,0.1,0.98", is_svg ? "0.02" : "0.06");
    if (is_svg)
        thrust_panels(out, plot);
    else
        sum_panel(out, plot);
    speed_panel(out, plot);
    clearance_panel(out, plot, least_m);
    fputs("unset multiplot\n", out);
    return true;
}
