/// Measured times, and a report of rows that prints as tables or as JSON.
#ifndef BENCH_FIGURES_H
#define BENCH_FIGURES_H

#include <jansson.h>
#include <stdbool.h>

/// The processor time that this process has spent: what others make the machine do does not count.
double spent_ms(void);

/// The time on the wall, for what is waited for.
double wall_ms(void);

/// A fixed chain of dependent products, quotients and roots: what one core does with doubles.
#define CALIBRATION_STEPS 100000
double calibrate_ms(void);

typedef struct {
    int count, room;
    double* value;
} samples_t;

void samples_add(samples_t* samples, double value);

/// Of at least one sample; quantile 1 is the largest.
double samples_quantile(samples_t* samples, double q);
double samples_mean(const samples_t* samples);

/// Sections in the order they are begun, each a list of rows, each a list of named figures.
typedef struct {
    json_t* sections;
} report_t;

report_t report_new(void);

/// Begins a section; the title says what its figures are.
void report_section(report_t* report, const char* name, const char* title);

/// Begins a row of the last section.
void report_row(report_t* report);

/// Adds to the last row. Rows of a section have the same names in the same order.
void report_text(report_t* report, const char* name, const char* text);
void report_figure(report_t* report, const char* name, double value);
void report_count(report_t* report, const char* name, int value);

/// Adds NAME_median_UNIT, NAME_p99_UNIT and NAME_worst_UNIT.
void report_samples(report_t* report, const char* name, const char* unit, samples_t* samples);

/// Takes over the sections of the other.
void report_append(report_t* report, report_t* other);

void report_print_json(const report_t* report);
void report_print_tables(const report_t* report);

#endif
