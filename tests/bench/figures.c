#define _GNU_SOURCE
#include "figures.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define CELL_SIZE 128

static double time_ms(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec / 1e6;
}

double spent_ms(void) { return time_ms(CLOCK_PROCESS_CPUTIME_ID); }

double wall_ms(void) { return time_ms(CLOCK_MONOTONIC); }

double calibrate_ms(void) {
    volatile double outside = 2; // read and written between the two looks at the clock, so the loop stays there
    const double start = spent_ms();
    double x = outside;
    for (int i = 0; i < CALIBRATION_STEPS; i++) {
        x = sqrt(x * 1.25 + 3 / x);
    }
    outside = x;
    return spent_ms() - start;
}

void samples_add(samples_t* samples, double value) {
    if (samples->count == samples->room) {
        samples->room = 2 * samples->room + 64;
        double* longer = realloc(samples->value, (size_t)samples->room * sizeof *longer);
        if (longer == NULL) abort();
        samples->value = longer;
    }
    samples->value[samples->count++] = value;
}

static int compare(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

double samples_quantile(samples_t* samples, double q) {
    qsort(samples->value, (size_t)samples->count, sizeof samples->value[0], compare);
    return samples->value[(int)(q * (samples->count - 1))];
}

double samples_mean(const samples_t* samples) {
    double sum = 0;
    for (int i = 0; i < samples->count; i++) sum += samples->value[i];
    return sum / samples->count;
}

report_t report_new(void) { return (report_t){json_array()}; }

static json_t* last(json_t* array) { return json_array_get(array, json_array_size(array) - 1); }
static json_t* rows_of(const report_t* report) { return json_object_get(last(report->sections), "rows"); }

void report_section(report_t* report, const char* name, const char* title) {
    json_array_append_new(report->sections, json_pack("{s:s, s:s, s:[]}", "name", name, "title", title, "rows"));
}

void report_row(report_t* report) { json_array_append_new(rows_of(report), json_object()); }

void report_text(report_t* report, const char* name, const char* text) {
    json_object_set_new(last(rows_of(report)), name, json_string(text));
}

void report_figure(report_t* report, const char* name, double value) {
    json_object_set_new(last(rows_of(report)), name, json_real(value));
}

void report_count(report_t* report, const char* name, int value) {
    json_object_set_new(last(rows_of(report)), name, json_integer(value));
}

void report_samples(report_t* report, const char* name, const char* unit, samples_t* samples) {
    static const struct {
        const char* name;
        double q;
    } quantile[] = {{"median", 0.5}, {"p99", 0.99}, {"worst", 1}};
    for (int i = 0; i < 3; i++) {
        char key[CELL_SIZE];
        snprintf(key, sizeof key, "%s_%s_%s", name, quantile[i].name, unit);
        report_figure(report, key, samples_quantile(samples, quantile[i].q));
    }
}

void report_append(report_t* report, report_t* other) {
    json_array_extend(report->sections, other->sections);
    json_decref(other->sections);
}

void report_print_json(const report_t* report) {
    json_dumpf(report->sections, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
    putchar('\n');
}

static void write_cell(const json_t* value, char cell[CELL_SIZE]) {
    if (json_is_string(value)) {
        snprintf(cell, CELL_SIZE, "%s", json_string_value(value));
    } else if (json_is_integer(value)) {
        snprintf(cell, CELL_SIZE, "%" JSON_INTEGER_FORMAT, json_integer_value(value));
    } else {
        const double x = json_real_value(value);
        const int digits = x != 0 ? 3 - (int)floor(log10(fabs(x))) : 3;
        snprintf(cell, CELL_SIZE, "%.*f", digits < 0 ? 0 : digits > 6 ? 6 : digits, x);
    }
}

// A header is as narrow as its longest word: plan_p99_ms stands as plan, p99, ms below one another.
#define MAX_HEADER_LINES 5

static int word_of(const char* key, int line, const char** word) {
    for (; line > 0 && *key != '\0'; line--) {
        key += strcspn(key, "_");
        key += *key == '_';
    }
    *word = key;
    return (int)strcspn(key, "_");
}

static int width_of(const json_t* rows, const char* key) {
    int width = 0;
    for (size_t r = 0; r < json_array_size(rows); r++) {
        char cell[CELL_SIZE];
        write_cell(json_object_get(json_array_get(rows, r), key), cell);
        width = (int)strlen(cell) > width ? (int)strlen(cell) : width;
    }
    for (int line = 0; line < MAX_HEADER_LINES; line++) {
        const char* word;
        const int length = word_of(key, line, &word);
        width = length > width ? length : width;
    }
    return width;
}

static void print_table(const json_t* rows) {
    json_t* first = json_array_get(rows, 0);
    const char* key;
    json_t* value;
    for (int line = 0; line < MAX_HEADER_LINES; line++) {
        bool any = false;
        json_object_foreach(first, key, value) {
            const char* word;
            any = any || word_of(key, line, &word) > 0;
        }
        json_object_foreach(first, key, value) {
            const char* word;
            const int length = word_of(key, line, &word), width = width_of(rows, key);
            if (any) printf(json_is_string(value) ? "%-*.*s  " : "%*.*s  ", width, length, word);
        }
        if (any) putchar('\n');
    }
    for (size_t r = 0; r < json_array_size(rows); r++) {
        json_object_foreach(json_array_get(rows, r), key, value) {
            char cell[CELL_SIZE];
            write_cell(value, cell);
            printf(json_is_string(value) ? "%-*s  " : "%*s  ", width_of(rows, key), cell);
        }
        putchar('\n');
    }
}

void report_print_tables(const report_t* report) {
    for (size_t s = 0; s < json_array_size(report->sections); s++) {
        json_t* section = json_array_get(report->sections, s);
        printf("%s%s\n\n", s > 0 ? "\n" : "", json_string_value(json_object_get(section, "title")));
        print_table(json_object_get(section, "rows"));
    }
}
