#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "output.h"
#include "task_options.h"
#include "wire/message.h"

static const char doc[] =
    "Shows the question of a scenario file as it is understood: the model's bodies in it, the hub's port where it is, "
    "every "
    "default filled in. What it writes can be planned."
    "\vExamples:\n"
    "  ssv scenario task.yaml\n"
    "  ssv scenario task.yaml --output whole.yaml && ssv plan whole.yaml\n"
    "  ssv scenario plan.json               the question of a plan\n"
    "\n"
    "Whether the numbers make sense is for the planner to say.\n"
    "\n"
    "Exit codes:\n"
    "   0  shown\n"
    "   2  the scenario is refused: a file cannot be read, or a key or a value is\n"
    "      wrong; the message names it\n"
    "  64  wrong arguments\n"
    "   1  anything else, e.g. FILE cannot be written\n";

/// A number as short as it can be without meaning another.
static void write_number(FILE* out, double value) {
    char text[32];
    int digits = 15;
    do {
        snprintf(text, sizeof text, "%.*g", digits, value);
    } while (strtod(text, NULL) != value && ++digits <= 17);
    fputs(text, out);
}

static void write_inline(FILE* out, json_t* json) {
    const char* key;
    json_t* value;
    size_t i;
    const char* between = "";
    if (json_is_object(json)) {
        fputc('{', out);
        json_object_foreach(json, key, value) {
            fprintf(out, "%s%s: ", between, key);
            write_inline(out, value);
            between = ", ";
        }
        fputc('}', out);
    } else if (json_is_array(json)) {
        fputc('[', out);
        json_array_foreach(json, i, value) {
            fputs(between, out);
            write_inline(out, value);
            between = ", ";
        }
        fputc(']', out);
    } else if (json_is_real(json)) {
        write_number(out, json_real_value(json));
    } else {
        json_dumpf(json, out, JSON_ENCODE_ANY);
    }
}

/// Maps in lines of their own, all else within them.
static void write_yaml(FILE* out, json_t* json, int indent) {
    const char* key;
    json_t* value;
    size_t i;
    json_object_foreach(json, key, value) {
        fprintf(out, "%*s%s:", indent, "", key);
        if (json_is_object(value)) {
            fputc('\n', out);
            write_yaml(out, value, indent + 2);
        } else if (json_is_object(json_array_get(value, 0))) {
            json_t* element;
            json_array_foreach(value, i, element) {
                fprintf(out, "\n%*s- ", indent + 2, "");
                write_inline(out, element);
            }
            fputc('\n', out);
        } else {
            fputc(' ', out);
            write_inline(out, value);
            fputc('\n', out);
        }
    }
}

static json_t* question_json(const lcm_ssv_task_t* question) {
    return json_pack("{s:o,s:o}", "scenario", wire_to_json("scenario_t", &question->scenario), "scene",
                     wire_to_json("scene_t", &question->scene));
}

static bool report_json(FILE* out, const void* question) { return wire_json_write(out, question_json(question)); }

static bool report_yaml(FILE* out, const void* question) {
    json_t* const json = question_json(question);
    write_yaml(out, json, 0);
    json_decref(json);
    return json != NULL;
}

int scenario_command(int argc, char** argv) {
    task_options_t options;
    task_options_parse(&options, doc, 1, TASK_SHOWN, argc, argv);
    char error[1024];
    scenario_file_t file;
    lcm_ssv_task_t question;
    const bool sound = task_read(&options, options.paths[0], &file, &question, error, sizeof error);
    scenario_file_close(&file);
    if (!sound) {
        fprintf(stderr, "ssv: %s\n", error);
        return EXIT_INVALID;
    }
    return output_report(options.output_path, options.as_json ? report_json : report_yaml, &question) ? EXIT_OK
                                                                                                      : EXIT_FAILED;
}
