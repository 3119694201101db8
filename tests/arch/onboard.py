"""What a vehicle flies with, measured on a Cortex-M4: its end of the link, the thruster controller, guidance."""
import collections
import dataclasses
import os
import pathlib
import re
import tempfile

from core import CORE, ROOT, run

MAVLINK = pathlib.Path(os.environ["SSV_MAVLINK_DIR"]) / "include"
CORTEX_M4 = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
OPTIONS = [*CORTEX_M4, "-std=c11", "-Os", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections", "-fstack-usage",
           "-fcallgraph-info=su", f"-I{ROOT}/firmware/include", f"-I{ROOT}/firmware", "-isystem", MAVLINK]
OPTIONS_OF = {"fixed": ["-fno-tree-sra"], "float": []}  # as in firmware/target/arm-none-eabi.cmake
LINK = [ROOT / f"firmware/link/{name}.c" for name in ("wire", "server", "vehicle", "timeline_file", "reason")]
VEHICLE = sorted((ROOT / "firmware/vehicle").glob("*.c"))
GUIDANCE = sorted((ROOT / "firmware/guidance").glob("*.c"))
# Each calls everything that a vehicle calls. What it holds counts as RAM; problem and plan are the planner's.
LINK_USER = """#include "ssv/link.h"
ssv_link_vehicle_t vehicle;
const ssv_link_vehicle_config_t config;
ssv_link_vehicle_state_t state;
uint8_t bytes[SSV_LINK_FRAME_BYTES_MAX];
void entry(void) {
    ssv_link_vehicle_event_t event;
    ssv_timeline_segment_t segment;
    ssv_link_vehicle_init(&vehicle, &config);
    ssv_link_vehicle_receive(&vehicle, 0, &state, bytes, sizeof bytes, &event);
    ssv_link_vehicle_answer(&vehicle, &event, SSV_LINK_ACCEPTED, SSV_LINK_NO_REASON);
    ssv_link_vehicle_say(&vehicle, 0, SSV_LINK_INFO, "");
    const uint8_t* live = ssv_link_vehicle_live(&vehicle, NULL);
    if (live != NULL) ssv_timeline_read_segment(live, 0, &segment);
    ssv_link_vehicle_poll(&vehicle, 0, &state, bytes);
}
"""
VEHICLE_USER = """#include "ssv/vehicle.h"
ssv_controller_t controller;
ssv_vehicle_config_t config;
ssv_link_pose_t pose;
uint8_t bytes[SSV_LINK_FRAME_BYTES_MAX];
void control(void) {
    ssv_vehicle_output_t output;
    ssv_vehicle_config_default(&config, 1);
    ssv_vehicle_init(&controller, &config);
    ssv_vehicle_receive(&controller, 0, bytes, sizeof bytes);
    ssv_vehicle_navigate(&controller, 0, &pose);
    ssv_vehicle_supply(&controller, 1);
    ssv_vehicle_tick(&controller, 0, &output);
    ssv_vehicle_attempted(&controller, 0, true);
    ssv_vehicle_poll(&controller, 0, bytes);
}
"""
GUIDANCE_USER = """#include "ssv/guidance.h"
ssv_guidance_t guidance;
extern const ssv_problem_t problem;
extern const ssv_plan_t plan;
void guide(void) {
    ssv_guidance_config_t config = {REAL(6), REAL(0)};
    ssv_guidance_command_t command;
    ssv_guidance_init(&guidance, &problem, &plan, &config);
    ssv_guidance_measure(&guidance, REAL(0), guidance.estimate.X_IS);
    ssv_guidance_step(&guidance, REAL(0.05), &command);
    ssv_guidance_attempted(&guidance, true);
}
"""
ALL = "link+vehicle+guidance"
PARTS = {"link": (LINK, LINK_USER),
         "link and vehicle": (LINK + VEHICLE, VEHICLE_USER + "void entry(void) { control(); }\n"),
         "guidance": (GUIDANCE, GUIDANCE_USER + "void entry(void) { guide(); }\n"),
         ALL: (LINK + VEHICLE + GUIDANCE, VEHICLE_USER + GUIDANCE_USER + "void entry(void) { control(); guide(); }\n")}


@dataclasses.dataclass
class Onboard:
    needed: set  # functions that the sources of these parts need and do not have
    writable: list  # data of theirs that can change
    text_bytes: int  # of their code and that of the C library and compiler for them; what the planner's archive has is not counted
    image_text_bytes: int  # with what they need of the planner's model, sampling and scalar, too
    ram_bytes: int
    stack_bytes: int  # of the longest chain of calls within the sources
    chain: list
    frame_bytes: int  # the largest of one function


def deepest(folder):
    """Bytes of stack of the longest chain of calls, the chain, and the largest frame."""
    own, calls = {}, collections.defaultdict(set)
    for file in folder.glob("*.ci"):
        text = file.read_text()
        for title, size in re.findall(r'node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes \(static\)', text):
            own[title] = int(size)
        for caller, callee in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls[caller].add(callee)

    def depth(name, above):
        assert name not in above, f"{name} calls itself"
        below = max((depth(callee, above | {name}) for callee in calls[name]), default=(0, []))
        return own.get(name, 0) + below[0], [name.rpartition(":")[2], *below[1]]

    return *max(depth(name, frozenset()) for name in own), max(own.values())


def measure(parts, scalar):
    """The Onboard of PARTS[parts] in a scalar."""
    sources, user = PARTS[parts]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        (folder / "user.c").write_text(user)

        def compiled(source):
            file = folder / f"{source.parent.name}-{source.stem}.o"
            run(["arm-none-eabi-gcc", *OPTIONS, *OPTIONS_OF[scalar], f"-DSSV_REAL_{scalar.upper()}", "-c", source, "-o", file])
            return file

        def sizes(objects):
            run(["arm-none-eabi-gcc", *CORTEX_M4, "-nostartfiles", "--specs=nosys.specs",
                 "-Wl,--gc-sections,-e,entry,-w,--unresolved-symbols=ignore-all", *objects, "-lm", "-o", folder / "image"])
            return list(map(int, run(["arm-none-eabi-size", folder / "image"]).splitlines()[1].split()[:3]))

        own = [compiled(source) for source in sources]
        with_user = [*own, compiled(folder / "user.c")]
        stack_bytes, chain, frame_bytes = deepest(folder)
        symbols = run(["arm-none-eabi-nm", *own])
        text, data, bss = sizes(with_user)
        image_text = text
        if "guidance" in parts:
            image_text = sizes([*with_user, *(compiled(source) for source in sorted(CORE.rglob("*.c")))])[0]
    return Onboard(set(re.findall(r" U (\w+)", symbols)) - set(re.findall(r" [TRW] (\w+)", symbols)),
                   re.findall(r" [bBdDC] (\w+)", symbols), text, image_text, data + bss, stack_bytes, chain, frame_bytes)
