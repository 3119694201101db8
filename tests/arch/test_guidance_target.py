"""Guidance on a Cortex-M4: how large it is and how deep its own stack, and that it has no heap, no state of its own and no
floating point in fixed. -V prints the figures."""
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from core import ROOT, run

OPTIONS = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-std=c11", "-Os", "-ffp-contract=off",
           "-ffunction-sections", "-fdata-sections", "-fstack-usage", f"-I{ROOT}/firmware/include", f"-I{ROOT}/firmware"]
SOURCES = sorted((ROOT / "firmware/guidance").glob("*.c"))
# Of the 48 KiB of text and 32 KiB of RAM that link, vehicle and guidance are to share.
TEXT_BYTES_MAX = {"fixed": 14 * 1024, "float": 10 * 1024}
RAM_BYTES_MAX = {"fixed": 4 * 1024, "float": 2 * 1024}
FRAME_BYTES_MAX = 1536
# The planner's model and sampling, vectors and the scalar, which the planner's archive has.
MAY_NEED = r"(ssv_(alloc|body_\w+|grasp_\w+|plan_sample_\w+)|(real|vec3|quat|pose)_\w+|mem(cpy|set)|vec3|sqrtf|atan2f|sinf|cosf)$"


@unittest.skipUnless(shutil.which("arm-none-eabi-gcc"), "no cross compiler here")
class GuidanceOnTarget(unittest.TestCase):
    def test_it_fits_and_needs_neither_heap_nor_state_nor_in_fixed_floating_point(self):
        for scalar in ("fixed", "float"):
            with self.subTest(scalar=scalar), tempfile.TemporaryDirectory() as scratch:
                folder = pathlib.Path(scratch)
                (folder / "user.c").write_text('#include "ssv/guidance.h"\nssv_guidance_t guidance;\n')
                define = f"-DSSV_REAL_{scalar.upper()}"
                for source in (*SOURCES, folder / "user.c"):
                    run(["arm-none-eabi-gcc", *OPTIONS, define, "-c", source, "-o", folder / f"{source.stem}.o"])
                objects = [folder / f"{source.stem}.o" for source in SOURCES]
                symbols = run(["arm-none-eabi-nm", *objects])
                needed, defined = set(re.findall(r" U (\w+)", symbols)), set(re.findall(r" [TRW] (\w+)", symbols))
                sizes = [line.split() for line in run(["arm-none-eabi-size", *objects]).splitlines()[1:]]
                text = sum(int(size[0]) for size in sizes)
                ram = int(run(["arm-none-eabi-size", folder / "user.o"]).splitlines()[1].split()[2])
                frames = {name: int(size) for file in folder.glob("*.su")
                          for name, size in re.findall(r"^\S+:(\S+)\t(\d+)\t", file.read_text(), re.M)}
                deepest = max(frames, key=frames.get)
                print(f"guidance, Cortex-M4, -Os, {scalar}: text {text}, ram {ram}, largest frame {frames[deepest]} ({deepest})",
                      file=sys.stderr)
                self.assertEqual([name for name in sorted(needed - defined) if not re.match(MAY_NEED, name)], [])
                self.assertEqual(re.findall(r" [bBdDC] (\w+)", symbols), [])
                self.assertLessEqual(text, TEXT_BYTES_MAX[scalar])
                self.assertLessEqual(ram, RAM_BYTES_MAX[scalar])
                self.assertLessEqual(frames[deepest], FRAME_BYTES_MAX)


if __name__ == "__main__":
    unittest.main()
