"""The same scenario gives the same plan, bit for bit, whatever compiled the planner; in fixed point also on other processors.

A class's name as argument runs that class alone: each is a test of its own to ctest.
"""
import concurrent.futures
import os
import pathlib
import shutil
import tempfile
import unittest

from core import CORE, HERE, SUPPORT, core_flags, run

SEED = 20260
LONG = os.environ.get("SSV_LONG")
DOUBLE_COUNT = 20000 if LONG else 500
FIXED_COUNT = 10000 if LONG else 1000
DOUBLE_BUILDS = [["gcc", "-O0"], ["gcc", "-O2", "-DNDEBUG"], ["gcc", "-O3", "-march=native"], ["clang", "-O0"], ["clang", "-O2"]]
UNDEFINED = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]
FIXED_BUILDS = [["gcc", "-O0"], ["gcc", "-O2", "-DNDEBUG"], ["gcc", "-O3", "-march=native"], ["clang", "-O2"],
                ["gcc", "-O2", *UNDEFINED]]
EMULATOR = {"arm-linux-gnueabihf-gcc": "qemu-arm", "aarch64-linux-gnu-gcc": "qemu-aarch64"}
PACKAGES = {"arm-linux-gnueabihf-gcc": "gcc-arm-linux-gnueabihf libc6-dev-armhf-cross qemu-user",
            "aarch64-linux-gnu-gcc": "gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user"}


def emulator_of(compiler):
    """What runs a program of this compiler: nothing at all here; None if it is not installed."""
    if compiler[0] not in EMULATOR:
        return []
    name = EMULATOR[compiler[0]]
    found = shutil.which(name) or shutil.which(f"{name}-static")
    return [found] if found else None


def is_installed(compiler):
    return shutil.which(compiler[0]) is not None and emulator_of(compiler) is not None


def hashes(compiler, scalar="DOUBLE", count=DOUBLE_COUNT):
    """The lines of plan_hashes built so; None if the compiler or its emulator is not installed."""
    if not is_installed(compiler):
        return None
    flags = [flag for flag in core_flags() if not flag.startswith("-DSSV_REAL_")]
    with tempfile.TemporaryDirectory() as scratch:
        program = pathlib.Path(scratch) / "plan_hashes"
        sources = [*sorted(CORE.glob("**/*.c")), HERE / "plan_hashes.c", SUPPORT / "sample.c"]
        run([compiler[0], *flags, f"-DSSV_REAL_{scalar}", f"-I{SUPPORT}", *compiler[1:], *sources, "-lm", "-o", program])
        return run([*emulator_of(compiler), program, SEED, count]).splitlines()


def all_hashes(builds, *arguments):
    """Those of each build, in their order; two at a time."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda build: hashes(build, *arguments), builds))


class Double(unittest.TestCase):
    """The planner in double."""

    @classmethod
    def setUpClass(cls):
        print(f"double: seed {SEED}, {DOUBLE_COUNT} scenarios")
        cls.first, *cls.others = all_hashes(DOUBLE_BUILDS)

    def test_every_compiler_and_level_gives_the_same_plans(self):
        for compiler, lines in zip(DOUBLE_BUILDS[1:], self.others):
            with self.subTest(compiler=" ".join(compiler)):
                if lines is None:
                    self.fail(f"{compiler[0]} is not installed")
                self.assertEqual(lines, self.first)

    def test_the_drawn_scenarios_are_sound_questions_and_mostly_have_an_answer(self):
        self.assertEqual([line for line in self.first if "refused" in line], [])
        self.assertGreater(sum(" ok " in line for line in self.first), DOUBLE_COUNT // 2)
        self.assertEqual(len({line.split()[-1] for line in self.first}), DOUBLE_COUNT)

    def test_the_hashes_notice_another_arithmetic(self):
        self.assertNotEqual(hashes(["gcc", "-O2", "-funsafe-math-optimizations"]), self.first)


class Fixed(unittest.TestCase):
    """The planner in fixed point; one build watches for undefined behaviour, such as a sum that does not fit."""

    @classmethod
    def setUpClass(cls):
        print(f"fixed: seed {SEED}, {FIXED_COUNT} scenarios")
        cls.first, *cls.others = all_hashes(FIXED_BUILDS, "FIXED", FIXED_COUNT)

    def test_every_compiler_and_level_gives_the_same_plans(self):
        for compiler, lines in zip(FIXED_BUILDS[1:], self.others):
            with self.subTest(compiler=" ".join(compiler)):
                if lines is None:
                    self.fail(f"{compiler[0]} is not installed")
                self.assertEqual(lines, self.first)

    def test_most_scenarios_have_a_plan_and_each_its_own(self):
        self.assertEqual([line for line in self.first if "refused" in line], [])
        self.assertGreater(sum(" ok " in line for line in self.first), FIXED_COUNT // 2)
        self.assertEqual(len({line.split()[-1] for line in self.first}), FIXED_COUNT)


class OtherProcessor:
    """The planner in fixed point on an emulated processor, against a build of this machine."""

    def test_the_processor_gives_the_same_plans(self):
        print(f"fixed: seed {SEED}, {FIXED_COUNT} scenarios")
        here, there = all_hashes([FIXED_BUILDS[1], [self.COMPILER, "-O2", "-static"]], "FIXED", FIXED_COUNT)
        if there is None:
            self.skipTest(f"no {self.COMPILER} or no {EMULATOR[self.COMPILER]}; on Debian: apt-get install "
                          f"{PACKAGES[self.COMPILER]}")
        self.assertEqual(there, here)


class Arm(OtherProcessor, unittest.TestCase):
    COMPILER = "arm-linux-gnueabihf-gcc"


class Aarch64(OtherProcessor, unittest.TestCase):
    COMPILER = "aarch64-linux-gnu-gcc"


if __name__ == "__main__":
    unittest.main()
