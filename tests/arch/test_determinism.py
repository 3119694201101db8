"""The same scenario gives the same plan, bit for bit, whatever compiled the planner."""
import os
import pathlib
import shutil
import tempfile
import unittest

from core import CORE, HERE, SUPPORT, core_flags, run

SEED = 20260
COUNT = 20000 if os.environ.get("SSV_LONG") else 500
BUILDS = [["gcc", "-O0"], ["gcc", "-O2", "-DNDEBUG"], ["gcc", "-O3", "-march=native"], ["clang", "-O0"], ["clang", "-O2"]]


def hashes(compiler):
    with tempfile.TemporaryDirectory() as scratch:
        program = pathlib.Path(scratch) / "plan_hashes"
        sources = [*sorted(CORE.glob("*.c")), HERE / "plan_hashes.c", SUPPORT / "tasks.c"]
        run([compiler[0], *core_flags(), f"-I{SUPPORT}", *compiler[1:], *sources, "-lm", "-o", program])
        return run([program, SEED, COUNT]).splitlines()


class Determinism(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        print(f"seed {SEED}, {COUNT} scenarios")
        cls.first = hashes(BUILDS[0])

    def test_every_compiler_and_level_gives_the_same_plans(self):
        for compiler in BUILDS[1:]:
            with self.subTest(compiler=" ".join(compiler)):
                if not shutil.which(compiler[0]):
                    self.fail(f"{compiler[0]} is not installed")
                self.assertEqual(hashes(compiler), self.first)

    def test_the_drawn_scenarios_are_sound_questions_and_mostly_have_an_answer(self):
        self.assertEqual([line for line in self.first if "refused" in line], [])
        self.assertGreater(sum(" ok " in line for line in self.first), COUNT // 2)
        self.assertEqual(len({line.split()[-1] for line in self.first}), COUNT)

    def test_the_hashes_notice_another_arithmetic(self):
        self.assertNotEqual(hashes(["gcc", "-O2", "-ffast-math"]), self.first)


if __name__ == "__main__":
    unittest.main()
