"""The vehicle's end of the link, and the thruster controller upon it, on a Cortex-M4: how large, how deep their stack, and that
they have no heap, no state of their own and no recursion. -V prints the figures."""
import collections
import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from core import ROOT, run

MAVLINK = pathlib.Path(os.environ["SSV_MAVLINK_DIR"]) / "include"
OPTIONS = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-std=c11", "-Os", "-ffp-contract=off",
           "-ffunction-sections", "-fdata-sections", "-fstack-usage", "-fcallgraph-info=su", f"-I{ROOT}/firmware/include",
           f"-I{ROOT}/firmware", "-isystem", MAVLINK]
LINK_SOURCES = tuple(f"link/{name}.c" for name in ("wire", "server", "vehicle", "timeline_file", "reason"))
VEHICLE_SOURCES = tuple(f"vehicle/{name}.c" for name in ("deadman", "default", "execution", "thrust", "vehicle"))
# Calls everything that a vehicle calls.
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
void entry(void) {
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
# Link and vehicle together are to have 24 KiB of text; the link's share. RAM: two timelines and 4 KiB.
TEXT_BYTES_MAX = 18 * 1024
RAM_BYTES_MAX = 2 * 7264 + 4096
STACK_BYTES_MAX = 1600
BOTH_TEXT_BYTES_MAX = 24 * 1024
BOTH_RAM_BYTES_MAX = 2 * 7264 + 8192
MAY_NEED = {"memcmp", "memcpy", "memmove", "memset", "strcmp", "strlen", "__aeabi_l2f", "__aeabi_ldivmod", "__aeabi_uldivmod"}


def deepest(folder):
    """Bytes of stack of the longest chain of calls, and the chain."""
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

    return max(depth(name, frozenset()) for name in own)


def measure(sources, user):
    """What sources and a user of theirs are on a Cortex-M4: functions needed, writable data, text, data + bss, stack, chain."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        (folder / "user.c").write_text(user)
        objects = []
        for source in (*(ROOT / "firmware" / name for name in sources), folder / "user.c"):
            objects.append(folder / f"{source.parent.name}-{source.stem}.o")
            run(["arm-none-eabi-gcc", *OPTIONS, "-c", source, "-o", objects[-1]])
        own = objects[:-1]
        needed = set(re.findall(r" U (\w+)", run(["arm-none-eabi-nm", *own])))
        defined = set(re.findall(r" [TR] (\w+)", run(["arm-none-eabi-nm", *own])))
        writable = re.findall(r" [bBdDC] (\w+)", run(["arm-none-eabi-nm", *own]))
        run(["arm-none-eabi-gcc", *OPTIONS[:4], "-nostartfiles", "--specs=nosys.specs", "-Wl,--gc-sections,-e,entry,-w",
             *objects, "-o", folder / "image"])
        text, data, bss = map(int, run(["arm-none-eabi-size", folder / "image"]).splitlines()[1].split()[:3])
        stack, chain = deepest(folder)
    return needed - defined, writable, text, data + bss, stack, chain


@unittest.skipUnless(shutil.which("arm-none-eabi-gcc"), "no cross compiler here")
class OnTarget(unittest.TestCase):
    def check(self, what, sources, user, text_max, ram_max, stack_max):
        needed, writable, text, ram, stack, chain = measure(sources, user)
        print(f"{what}, Cortex-M4, -Os: text {text}, RAM {ram}, stack {stack} ({' > '.join(chain)})", file=sys.stderr)
        self.assertEqual(needed - MAY_NEED, set())
        self.assertEqual(writable, [])
        self.assertLessEqual(text, text_max)
        self.assertLessEqual(ram, ram_max)
        self.assertLessEqual(stack, stack_max)

    def test_the_link_fits_needs_neither_heap_nor_recursion_and_keeps_nothing(self):
        self.check("vehicle's end of the link", LINK_SOURCES, LINK_USER, TEXT_BYTES_MAX, RAM_BYTES_MAX, STACK_BYTES_MAX)

    def test_link_and_vehicle_fit_need_neither_heap_nor_recursion_and_keep_nothing(self):
        self.check("link and vehicle", (*LINK_SOURCES, *VEHICLE_SOURCES), VEHICLE_USER, BOTH_TEXT_BYTES_MAX, BOTH_RAM_BYTES_MAX,
                   STACK_BYTES_MAX)


if __name__ == "__main__":
    unittest.main()
