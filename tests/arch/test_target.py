"""The planner on bare Cortex-M cores, emulated: it plans, and fixed point gives the same bits there as here."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from core import ROOT, run

NEEDED = ("arm-none-eabi-gcc", "qemu-system-arm")
WORK = pathlib.Path(os.environ["SSV_BUILD_DIR"]) / "target"  # kept, so that a second run compiles what changed
MACHINE = {"m3": "mps2-an385", "m4f": "mps2-an386", "m7": "mps2-an500"}
PLANNING = [("m7", "double")]


def build(cpu, scalar):
    """Cross compiles everything for a core; the folder with the images and the archive."""
    folder = WORK / f"{cpu}-{scalar}"
    run(["cmake", "-S", ROOT, "-B", folder, "-G", os.environ["SSV_GENERATOR"], "-DSSV_BUILD_HOST=OFF",
         f"--toolchain={ROOT}/firmware/target/arm-none-eabi.cmake", f"-DSSV_CPU={cpu}", f"-DSSV_REAL={scalar}",
         "-DCMAKE_BUILD_TYPE=Release"])
    run(["cmake", "--build", folder])
    return folder


def emulate(cpu, image):
    """The lines that an image prints; fails unless it ends with 0."""
    return run(["qemu-system-arm", "-M", MACHINE[cpu], "-nographic", "-monitor", "none", "-serial", "none",
                "-semihosting-config", "enable=on,target=native,arg=image", "-icount", "shift=5", "-kernel", image],
               timeout=300).splitlines()


class Target(unittest.TestCase):
    def test_the_case_study_is_planned_in_both_models_with_both_methods(self):
        for cpu, scalar in PLANNING:
            with self.subTest(cpu=cpu, scalar=scalar):
                lines = emulate(cpu, build(cpu, scalar) / "bin/plan.elf")
                print(f"Cortex-{cpu}, {scalar}: model, method, status, J, plan hash, instructions, bytes of stack", *lines,
                      sep="\n  ")
                costs = {tuple(line.split()[:2]): float(line.split()[3]) for line in lines}
                # J of the paper's method with both weights 1, as on the desktop.
                self.assertAlmostEqual(costs["paper", "paper"], 4296.29, delta=0.1)
                self.assertLess(costs["paper", "optimal"], costs["paper", "paper"])
                self.assertLess(costs["ease", "optimal"], costs["ease", "paper"])

    def test_fixed_point_gives_the_same_bits_on_a_core_without_floating_point(self):
        folder = build("m3", "fixed")
        lines = emulate("m3", folder / "bin/arithmetic.elf")
        print("Cortex-m3, fixed: operation, hash, mean and most instructions of a call", *lines, sep="\n  ")
        here = WORK / "arithmetic"
        run([os.environ["CC"], "-std=c11", "-O2", "-DSSV_REAL_FIXED", f"-I{ROOT}/firmware/include",
             ROOT / "tests/target/arithmetic.c", ROOT / "firmware/planner/real_fixed.c", "-o", here])
        self.assertEqual([line.split()[:2] for line in lines], [line.split()[:2] for line in run([here]).splitlines()])

    def test_the_fixed_archive_holds_no_floating_point(self):
        archive = build("m3", "fixed") / "firmware/libssv_planner.a"
        undefined = set(re.findall(r"\bU (\w+)", run(["arm-none-eabi-nm", "-u", archive])))
        self.assertIn("memset", undefined)
        floating = r"__aeabi_([fd]|\w+2[fd])|(a?sin|a?cos|a?tan|sqrt|log|exp)"
        self.assertEqual([name for name in sorted(undefined) if re.match(floating, name)], [])

    def test_a_fault_ends_the_emulator_with_its_own_exit_code(self):
        folder = build("m3", "fixed")
        source = folder / "fault.c"
        source.write_text("int main(void) { return *(volatile int*)0x90000000; }\n")
        run(["arm-none-eabi-gcc", "-mcpu=cortex-m3", "-mthumb", source, ROOT / "firmware/target/board.c",
             "--specs=rdimon.specs", "-nostartfiles", f"-T{ROOT}/firmware/target/mps2.ld", "-o", folder / "fault.elf"])
        with self.assertRaisesRegex(AssertionError, "ended with 70"):
            emulate("m3", folder / "fault.elf")


if __name__ == "__main__":
    missing = [program for program in NEEDED if not shutil.which(program)]
    if missing:
        print(f"Skipped: {' and '.join(missing)} not found. On Debian:\n"
              "  apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm")
        sys.exit(77)
    unittest.main()
