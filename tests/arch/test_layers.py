"""Dependency direction: who includes whom, and which words the planner core must not know."""
import pathlib
import re
import shutil
import tempfile
import unittest

import modules
from core import ROOT, code_of, in_a_cycle

CORE_API = tuple(f"firmware/include/ssv/{name}.h"
                 for name in ("planner", "plan", "scenario", "timeline", "vec3", "real", "real_double", "real_float", "real_fixed"))
TIMELINE_API = "firmware/include/ssv/timeline.h"
LINK_API = "firmware/include/ssv/link.h"
VEHICLE_API = "firmware/include/ssv/vehicle.h"
GUIDANCE_API = "firmware/include/ssv/guidance.h"
EXECUTIVE_API = "firmware/include/ssv/executive.h"
ANSWER_API = "firmware/include/ssv/answer.h"
CHECK_API = "firmware/include/ssv/check.h"
ADDRESS_API = "firmware/include/ssv/address.h"
FIELDS = "firmware/planner/model/fields.def"
# The planner's own model, which the observer runs on.
MODEL = tuple(f"firmware/planner/model/{name}.h" for name in ("body", "allocation", "grasp"))
WIRE_API = tuple(f"host/wire/{name}.h" for name in ("message", "names", "tree"))

# What each folder may include beside its own files and the C and POSIX headers: folders, public headers, libraries.
MAY_INCLUDE = {
    "firmware/include/ssv": {*CORE_API, "lcmtypes"},
    "firmware/planner": {*CORE_API},
    "firmware/guidance": {*CORE_API, GUIDANCE_API, *MODEL},
    "firmware/link": {TIMELINE_API, LINK_API, "mavlink"},
    "firmware/vehicle": {TIMELINE_API, LINK_API, VEHICLE_API},
    "firmware/executive": {*CORE_API, LINK_API, GUIDANCE_API, EXECUTIVE_API},
    "firmware/bench": {TIMELINE_API, LINK_API, VEHICLE_API},
    "firmware/target": set(),
    "firmware/daemon": {*CORE_API, ANSWER_API, CHECK_API, ADDRESS_API, LINK_API, GUIDANCE_API, EXECUTIVE_API, "firmware/bench",
                        FIELDS, "lcmtypes", "lcm"},
    "host/wire": {ANSWER_API, "lcmtypes", "fyaml", "jansson"},
    "host/report": {*CORE_API, ANSWER_API, CHECK_API, *WIRE_API, "lcmtypes", "jansson"},
    "host": {*CORE_API, ANSWER_API, CHECK_API, ADDRESS_API, *WIRE_API, "host/report", "lcmtypes", "lcm", "jansson"},
    "sim/physics": set(),
    "sim/replay": {"sim/physics", "jansson"},
    "sim/sil": {"sim/physics", "sim/replay", TIMELINE_API, LINK_API, VEHICLE_API, "firmware/bench", "host/wire/tree.h"},
}
# Single files that may include more than their folder: what reads plans or tells the bus knows the message types.
FILE_MAY_INCLUDE = {"sim/replay/plan_file.c": {"lcmtypes", *WIRE_API}, "sim/sil/truth.c": {"lcmtypes", "lcm"},
                    "host/report/serve.c": {"microhttpd"}}
LIBRARIES = {"microhttpd": r"microhttpd", "lcm": r"lcm/", "fyaml": r"libfyaml", "jansson": r"jansson", "mavlink": r"(?:\w+/)?mavlink", "glib": r"glib"}
INCLUDE_ROOTS = ("firmware/include", "firmware", "sim", "host")

# The generated MAVLink code is of one file, whose packets all others know.
MAVLINK_USER = "firmware/link/wire.c"
LINK_SYSTEM_HEADERS = {"float.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
CORE_SYSTEM_HEADERS = {"assert.h", "float.h", "limits.h", "stdatomic.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
# The storeys of the core: what the files of each folder may include of the others; those in no folder may include all.
STOREYS = {"math": set(), "model": {"math"}, "profile": {"math"}, "motion": {"math", "model", "profile"},
           "search": {"math", "model", "profile", "motion"}}
NOT_IN_CORE = {
    "heap": r"\b(?:malloc|calloc|realloc|free|alloca)\s*\(",
    "input or output": r"\b(?:\w*printf|\w*scanf|f?puts|putchar|fopen|fwrite|fread|perror)\s*\(|"
                       r"\b(?:FILE|stdin|stdout|stderr)\b",
    "operating system": r"\b(?:time|clock\w*|rand\w*|srand|getenv|exit|abort|signal|system|errno)\s*\(",
    "middleware": r"\b(?:lcm|mavlink)_\w+",
    "libm past real.h": r"\b(?:a?(?:sin|cos|tan)h?|atan2|sqrt|cbrt|hypot|exp[2m]?1?|log(?:2|10|1p|b)?|pow|fabs|fma|fmin|"
                        r"fmax|fmod|floor|ceil|round|trunc|l?lround|nextafter|copysign|isnan|isinf|isfinite)[fl]?\s*\(",
    "a scalar other than real_t": r"\b(?:float|double)\b",
}


# What runs on the vehicle's own controller.
ON_TARGET = {"firmware/link": "link", "firmware/vehicle": "vehicle", "firmware/executive": "executive"}
NOT_ON_TARGET = ("heap", "input or output", "operating system", "libm past real.h")


def folder_of(path):
    return next((folder for folder in MAY_INCLUDE if path.startswith(folder + "/")), None)


def resolve(root, source, name):
    """The file or generated folder that #include "name" means in `source`, as a path below root; None when unknown."""
    if re.fullmatch(r"(?:lcm_)?ssv_\w+_t\.h", name):
        return "lcmtypes"
    if name == "channels.h":
        return "lcmtypes"
    for base in (pathlib.PurePosixPath(source).parent, *INCLUDE_ROOTS):
        if (root / base / name).is_file():
            return (root / base / name).resolve().relative_to(root.resolve()).as_posix()
    return None


def module_of(path):
    return path.rpartition(".")[0]


def storey_of(path):
    """The folder of a file of the core; "" of those that stand in none, None of all other files."""
    match = re.fullmatch(r"firmware/planner/(?:(\w+)/)?\w+\.\w+", path)
    return match and (match[1] or "")


def include_breaches(root, path, text, modules):
    """What is wrong with the includes of one file; adds the modules that it includes to modules[its own]."""
    folder = folder_of(path)
    edges = modules.setdefault(module_of(path), set())
    for mark, name in re.findall(r'(?m)^\s*#\s*include\s*([<"])([^>"]+)[>"]', text):
        library = next((lib for lib, pattern in LIBRARIES.items() if re.match(pattern, name)), None)
        target = library if library else resolve(root, path, name) if mark == '"' else None
        if target is None:
            if mark == '"':
                yield f'"{name}" is in no folder that may be included'
            elif folder == "firmware/planner" and name not in CORE_SYSTEM_HEADERS:
                yield f"<{name}> is not for the core"
            elif folder in ON_TARGET and name not in LINK_SYSTEM_HEADERS:
                yield f"<{name}> is not for the {ON_TARGET[folder]}"
            elif folder == "firmware/guidance" and name not in CORE_SYSTEM_HEADERS:
                yield f"<{name}> is not for guidance"
            elif name == "math.h" and folder == "firmware/include/ssv" and not re.search(r"/real_(double|float)\.h$", path):
                yield "<math.h> is for the scalars alone"
            continue
        if not {target, folder_of(target)} & {*MAY_INCLUDE[folder], *FILE_MAY_INCLUDE.get(path, set()), folder}:
            yield f"must not include {target}"
        if path == TIMELINE_API:
            yield "the vehicle flies it without the planner or its scalar: it includes nothing of ours"
        if target == "mavlink" and path != MAVLINK_USER:
            yield f"the generated code is for {MAVLINK_USER} alone"
        if path == LINK_API and target != TIMELINE_API:
            yield "the link stands on the timeline alone"
        if path == VEHICLE_API and target != LINK_API:
            yield "the vehicle stands on the link alone"
        if path == GUIDANCE_API and target not in CORE_API:
            yield "guidance stands on the planner alone"
        if path == EXECUTIVE_API and target not in (LINK_API, GUIDANCE_API):
            yield "the executive stands on link and guidance alone"
        if path in CORE_API and target not in CORE_API:
            yield f"the core's headers stand by themselves, without {target}"
        if module_of(target) != module_of(path):
            edges.add(module_of(target))
            storey, below = storey_of(path), storey_of(target)
            if storey in STOREYS and below not in STOREYS[storey] | {storey, None}:
                yield f"{storey} must not know {below}"


def word_breaches(text, where, words):
    """Words in a file of the core or the link that it must not know."""
    for number, line in enumerate(code_of(text).splitlines(), 1):
        for what in words:
            if match := re.search(NOT_IN_CORE[what], line):
                yield f"line {number}: {what} in the {where}: {match[0].strip()}"


def breaches(root):
    """Every breach of the rules in the tree at root, one sentence each."""
    found, modules = [], {}
    for file in sorted(file for top in ("firmware", "host", "sim") for file in (root / top).glob("**/*.[ch]")):
        path, text = file.relative_to(root).as_posix(), file.read_text()
        if folder_of(path) is None:
            found.append(f"{path}: in a folder without a rule, see MAY_INCLUDE")
            continue
        if storey_of(path) not in {None, "", *STOREYS}:
            found.append(f"{path}: in no storey of the core, see STOREYS")
        found += [f"{path}: {breach}" for breach in include_breaches(root, path, text, modules)]
        if folder_of(path) == "firmware/planner":
            found += [f"{path}: {breach}" for breach in word_breaches(text, "core", NOT_IN_CORE)]
        if folder_of(path) in ON_TARGET:
            found += [f"{path}: {breach}" for breach in word_breaches(text, ON_TARGET[folder_of(path)], NOT_ON_TARGET)]
        if folder_of(path) == "firmware/guidance":
            found += [f"{path}: {breach}" for breach in word_breaches(text, "guidance", NOT_IN_CORE)]
    return found + [f"{module}: includes itself through other modules" for module in in_a_cycle(modules)]


class Layers(unittest.TestCase):
    def test_every_include_points_down_and_the_core_knows_neither_heap_nor_io_nor_middleware(self):
        self.assertEqual(breaches(ROOT), [])

    def test_each_rule_finds_its_planted_breach(self):
        planted = {
            ("firmware/planner/model/body.c", '#include "planner/profile/arc.h"'): "model must not know profile",
            ("firmware/planner/profile/arc.c", '#include "planner/model/body.h"'): "profile must not know model",
            ("firmware/planner/math/gauss.h", '#include "planner/model/body.h"'): "math must not know model",
            ("firmware/planner/motion/path.c", '#include "planner/search/seed.h"'): "motion must not know search",
            ("firmware/planner/search/seed.c", '#include "planner/segments.h"'): "search must not know",
            ("firmware/planner/odd/planted.c", ""): "in no storey of the core",
            ("firmware/planner/model/allocation.h", '#include "planner/planned.h"'): "in no folder",
            ("firmware/planner/motion/maneuver.c", '#include "ssv/answer.h"'): "must not include",
            ("firmware/planner/motion/maneuver.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("firmware/planner/motion/maneuver.c", "#include <lcm/lcm.h>"): "must not include lcm",
            ("firmware/planner/motion/maneuver.c", "#include <math.h>"): "is not for the core",
            ("firmware/planner/motion/maneuver.c", "#include <stdio.h>"): "is not for the core",
            ("firmware/planner/model/allocation.h", '#include "planner/motion/maneuver.h"'): "includes itself",
            ("firmware/planner/motion/maneuver.c", "void* p = malloc(3);"): "heap in the core",
            ("firmware/planner/motion/maneuver.c", "void f(void) { snprintf(0, 0, \"x\"); }"): "input or output in the core",
            ("firmware/planner/motion/maneuver.c", "FILE* f;"): "input or output in the core",
            ("firmware/planner/motion/maneuver.c", "long f(void) { return time(0); }"): "operating system in the core",
            ("firmware/planner/motion/maneuver.c", "int f(mavlink_message_t* m);"): "middleware in the core",
            ("firmware/planner/motion/maneuver.c", "real_t f(real_t x) { return sqrt(x); }"): "libm past real.h",
            ("firmware/planner/motion/maneuver.c", "static const double x = 1;"): "a scalar other than real_t",
            ("firmware/include/ssv/vec3.h", "#include <math.h>"): "for the scalars alone",
            ("firmware/include/ssv/planner.h", '#include "lcm_ssv_plan_t.h"'): "stand by themselves",
            ("firmware/include/ssv/timeline.h", '#include "ssv/real.h"'): "includes nothing of ours",
            ("firmware/link/server.c", '#include "ssv/mavlink.h"'): "is for firmware/link/wire.c alone",
            ("firmware/link/vehicle.c", '#include "ssv/plan.h"'): "must not include firmware/include/ssv/plan.h",
            ("firmware/link/vehicle.c", '#include "planner/model/body.h"'): "must not include firmware/planner",
            ("firmware/link/planner.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("firmware/link/planner.c", "#include <lcm/lcm.h>"): "must not include lcm",
            ("firmware/link/planner.c", "#include <stdio.h>"): "is not for the link",
            ("firmware/link/planner.c", "#include <time.h>"): "is not for the link",
            ("firmware/link/planner.c", "void* p = malloc(3);"): "heap in the link",
            ("firmware/link/planner.c", "long f(void) { return time(0); }"): "operating system in the link",
            ("firmware/include/ssv/link.h", '#include "ssv/scenario.h"'): "stands on the timeline alone",
            ("firmware/include/ssv/link.h", '#include "ssv/mavlink.h"'): "is for firmware/link/wire.c alone",
            ("firmware/vehicle/vehicle.c", '#include "ssv/plan.h"'): "must not include firmware/include/ssv/plan.h",
            ("firmware/vehicle/vehicle.c", '#include "link/bytes.h"'): "must not include firmware/link/bytes.h",
            ("firmware/vehicle/vehicle.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("firmware/vehicle/vehicle.c", '#include "ssv/mavlink.h"'): "must not include mavlink",
            ("firmware/vehicle/vehicle.c", '#include "physics/world.h"'): "must not include sim/physics/world.h",
            ("firmware/vehicle/thrust.c", "#include <math.h>"): "is not for the vehicle",
            ("firmware/vehicle/thrust.c", "#include <time.h>"): "is not for the vehicle",
            ("firmware/vehicle/thrust.c", "void* p = malloc(3);"): "heap in the vehicle",
            ("firmware/vehicle/thrust.c", "float f(float x) { return sqrtf(x); }"): "libm past real.h in the vehicle",
            ("firmware/include/ssv/vehicle.h", '#include "ssv/timeline.h"'): "stands on the link alone",
            ("firmware/link/vehicle.c", '#include "ssv/vehicle.h"'): "must not include firmware/include/ssv/vehicle.h",
            ("firmware/bench/planted.c", '#include "vehicle/thrust.h"'): "must not include firmware/vehicle/thrust.h",
            ("firmware/bench/planted.c", '#include "physics/world.h"'): "must not include sim/physics/world.h",
            ("firmware/executive/planted.c", '#include "ssv/vehicle.h"'): "must not include firmware/include/ssv/vehicle.h",
            ("firmware/executive/planted.c", '#include "bench/port.h"'): "must not include firmware/bench/port.h",
            ("firmware/executive/planted.c", "void* p = malloc(3);"): "heap in the executive",
            ("firmware/include/ssv/executive.h", '#include "ssv/answer.h"'): "the executive stands on link and guidance alone",
            ("firmware/vehicle/planted.c", '#include "ssv/executive.h"'): "must not include firmware/include/ssv/executive.h",
            ("sim/sil/planted.c", '#include "ssv/planner.h"'): "must not include firmware/include/ssv/planner.h",
            ("sim/sil/planted.c", '#include "vehicle/thrust.h"'): "must not include firmware/vehicle/thrust.h",
            ("sim/sil/planted.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("sim/physics/planted.c", '#include "sil/sil.h"'): "must not include sim/sil/sil.h",
            ("sim/physics/planted.c", '#include "ssv/vehicle.h"'): "must not include firmware/include/ssv/vehicle.h",
            ("firmware/guidance/law.c", '#include "ssv/link.h"'): "must not include firmware/include/ssv/link.h",
            ("firmware/guidance/law.c", '#include "link/wire.h"'): "must not include firmware/link/wire.h",
            ("firmware/guidance/law.c", '#include "ssv/answer.h"'): "must not include firmware/include/ssv/answer.h",
            ("firmware/guidance/law.c", '#include "daemon/log.h"'): "must not include firmware/daemon/log.h",
            ("firmware/guidance/law.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("firmware/guidance/law.c", "#include <lcm/lcm.h>"): "must not include lcm",
            ("firmware/guidance/law.c", '#include "planner/motion/path.h"'):
                "must not include firmware/planner/motion/path.h",
            ("firmware/guidance/law.c", "#include <stdio.h>"): "is not for guidance",
            ("firmware/guidance/law.c", "void* p = malloc(3);"): "heap in the guidance",
            ("firmware/guidance/law.c", "long f(void) { return time(0); }"): "operating system in the guidance",
            ("firmware/guidance/law.c", "real_t f(real_t x) { return sqrt(x); }"): "libm past real.h in the guidance",
            ("firmware/guidance/law.c", "static const double x = 1;"): "a scalar other than real_t in the guidance",
            ("firmware/include/ssv/guidance.h", '#include "ssv/link.h"'): "stands on the planner alone",
            ("firmware/planner/motion/maneuver.c", '#include "ssv/guidance.h"'):
                "must not include firmware/include/ssv/guidance.h",
            ("sim/physics/planted.c", '#include "ssv/guidance.h"'): "must not include firmware/include/ssv/guidance.h",
            ("firmware/planner/motion/maneuver.c", '#include "link/wire.h"'): "must not include firmware/link/wire.h",
            ("firmware/planner/motion/maneuver.c", '#include "ssv/mavlink.h"'): "must not include mavlink",
            ("firmware/daemon/answer.c", '#include "planner/motion/maneuver.h"'): "must not include firmware/planner/motion/maneuver.h",
            ("host/planted.c", '#include "planner/motion/maneuver.h"'): "must not include firmware/planner/motion/maneuver.h",
            ("host/wire/tree.c", '#include "cli/report.h"'): "must not include host/cli/report.h",
            ("host/cli/report.c", "#include <libfyaml.h>"): "must not include fyaml",
            ("host/report/page.c", '#include "cli/output.h"'): "must not include host/cli/output.h",
            ("host/report/page.c", "#include <lcm/lcm.h>"): "must not include lcm",
            ("host/report/live.c", "#include <microhttpd.h>"): "must not include microhttpd",
            ("sim/physics/rigid_body.c", '#include "wire/message.h"'): "must not include host/wire/message.h",
            ("sim/replay/replay.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("firmware/planner/motion/path.c", '#include "channels.h"'): "must not include lcmtypes",
            ("host/planted.c", '#include "physics/rigid_body.h"'): "must not include sim/physics/rigid_body.h",
            ("firmware/planted.c", ""): "in a folder without a rule",
            ("sim/planted.c", ""): "in a folder without a rule",
            ("sim/physics/planted.c", '#include "ssv/vec3.h"'): "must not include firmware/include/ssv/vec3.h",
            ("sim/physics/planted.c", '#include "planner/motion/maneuver.h"'):
                "must not include firmware/planner/motion/maneuver.h",
            ("sim/physics/planted.c", '#include "lcm_ssv_plan_t.h"'): "must not include lcmtypes",
            ("sim/physics/planted.c", "#include <jansson.h>"): "must not include jansson",
            ("sim/physics/planted.c", '#include "replay/replay.h"'): "must not include sim/replay/replay.h",
            ("sim/replay/planted.c", '#include "ssv/vec3.h"'): "must not include firmware/include/ssv/vec3.h",
            ("sim/replay/planted.c", '#include "planner/motion/maneuver.h"'):
                "must not include firmware/planner/motion/maneuver.h",
        }
        for (path, line), expected in planted.items():
            with self.subTest(path=path, line=line), tempfile.TemporaryDirectory() as scratch:
                tree = pathlib.Path(scratch)
                for folder in MAY_INCLUDE:
                    for file in (ROOT / folder).glob("**/*.[ch]"):
                        copy = tree / file.relative_to(ROOT)
                        copy.parent.mkdir(parents=True, exist_ok=True)
                        shutil.copy(file, copy)
                (tree / path).parent.mkdir(exist_ok=True)
                with open(tree / path, "a") as file:
                    file.write("\n" + line + "\n")
                self.assertIn(expected, "\n".join(breaches(tree)))

    def test_design_lists_each_module_of_the_core_with_what_it_is_for_and_what_it_includes(self):
        self.assertEqual(modules.written(), modules.table(), "bring it up to date: python3 tests/arch/modules.py")

    def test_words_in_comments_and_strings_do_not_count(self):
        self.assertEqual(code_of('a /* malloc(1) \n */ b // FILE\n "exit(1)" c').split(), ["a", "b", '""', "c"])


if __name__ == "__main__":
    unittest.main()
