"""The vehicle's end of the link on a Cortex-M4: how large it is, how deep its stack, and that it has no heap, no state of
its own and no recursion. -V prints the figures."""
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
SOURCES = ("wire", "server", "vehicle", "timeline_file", "reason")
# Calls everything that a vehicle calls.
USER = """#include "ssv/link.h"
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
# Link and vehicle together are to have 24 KiB of text; the link's share. RAM: two timelines and 4 KiB.
TEXT_BYTES_MAX = 18 * 1024
RAM_BYTES_MAX = 2 * 7264 + 4096
STACK_BYTES_MAX = 1600
MAY_NEED = {"memcmp", "memcpy", "memmove", "memset", "strcmp", "strlen", "__aeabi_ldivmod", "__aeabi_uldivmod"}


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


@unittest.skipUnless(shutil.which("arm-none-eabi-gcc"), "no cross compiler here")
class LinkOnTarget(unittest.TestCase):
    def test_it_fits_needs_neither_heap_nor_recursion_and_keeps_nothing(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            (folder / "user.c").write_text(USER)
            for source in (*(ROOT / f"firmware/link/{name}.c" for name in SOURCES), folder / "user.c"):
                run(["arm-none-eabi-gcc", *OPTIONS, "-c", source, "-o", folder / f"{source.stem}.o"])
            objects = [folder / f"{name}.o" for name in SOURCES]
            needed = set(re.findall(r" U (\w+)", run(["arm-none-eabi-nm", *objects])))
            defined = set(re.findall(r" [TR] (\w+)", run(["arm-none-eabi-nm", *objects])))
            writable = re.findall(r" [bBdDC] (\w+)", run(["arm-none-eabi-nm", *objects]))
            run(["arm-none-eabi-gcc", *OPTIONS[:4], "-nostartfiles", "--specs=nosys.specs", "-Wl,--gc-sections,-e,entry,-w",
                 *objects, folder / "user.o", "-o", folder / "image"])
            text, data, bss = map(int, run(["arm-none-eabi-size", folder / "image"]).splitlines()[1].split()[:3])
            stack, chain = deepest(folder)
        print(f"vehicle's end of the link, Cortex-M4, -Os: text {text}, data {data}, bss {bss}, stack {stack} "
              f"({' > '.join(chain)})", file=sys.stderr)
        self.assertEqual((needed - defined) - MAY_NEED, set())
        self.assertEqual(writable, [])
        self.assertLessEqual(text, TEXT_BYTES_MAX)
        self.assertLessEqual(data + bss, RAM_BYTES_MAX)
        self.assertLessEqual(stack, STACK_BYTES_MAX)


if __name__ == "__main__":
    unittest.main()
