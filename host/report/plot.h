/// Plots for paper and terminal: a plan's thrusts, speed and clearance over time as a table and as what gnuplot is to
/// do with it.
#ifndef SSV_PLOT_H
#define SSV_PLOT_H

#include <stdbool.h>
#include <stdio.h>

#include "record.h"

/// What is plotted, and where to.
typedef struct {
    const record_t* record;
    const char* csv_path;    ///< of the table; NULL: it stands in the script
    const char* output_path; ///< of the SVG; NULL: standard output
    int columns, lines;      ///< of a terminal that gets letters instead of an SVG; 0 = an SVG
} plot_t;

/// Writes the table, one row for each instant; times of later tasks go on where the one before ends. @return false with
/// a sentence in `error` if a plan is none that can be sampled.
bool plot_table(FILE* out, const plot_t* plot, char* error, size_t error_size);

/// Writes the script. @return likewise.
bool plot_script(FILE* out, const plot_t* plot, char* error, size_t error_size);

#endif
