"""What cmake --install leaves works by itself: the programs start, and somebody else's project finds the planner."""
import os
import pathlib
import tempfile
import unittest

from core import HERE, SUPPORT, core_flags, run

BUILD = os.environ["SSV_BUILD_DIR"]
CLEAN = {"PATH": "/usr/bin:/bin"}


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = pathlib.Path(scratch.name)
        cls.prefix = cls.scratch / "prefix"
        run(["cmake", "--install", BUILD, "--prefix", cls.prefix])

    def test_only_the_core_headers_are_installed(self):
        headers = sorted(str(path.relative_to(self.prefix)) for path in self.prefix.glob("**/*.h"))
        self.assertEqual(headers, [f"include/ssv/{name}.h" for name in
                                   ("plan", "planner", "real", "real_double", "real_fixed", "real_float", "scenario", "vec3")])

    @unittest.skipUnless(os.environ["SSV_BUILD_HOST"] == "ON", "built without the programs")
    def test_installed_programs_start_and_do_not_lean_on_the_build_folder(self):
        programs = sorted(path.name for path in (self.prefix / "bin").iterdir())
        self.assertEqual(programs, ["ssv", "ssv-fixed", "ssv-float", "ssv-plannerd", "ssv-plannerd-fixed", "ssv-plannerd-float",
                                    "ssv-replay"])
        for program in programs:
            with self.subTest(program=program):
                self.assertTrue(run([self.prefix / "bin" / program, "--version"], env=CLEAN).strip())
                self.assertNotIn(BUILD, run(["readelf", "-d", self.prefix / "bin" / program]))

    def test_another_project_finds_the_package_and_plans_the_same(self):
        sources = [HERE / "plan_hashes.c", SUPPORT / "sample.c"]
        run(["cmake", "-S", HERE / "consumer", "-B", self.scratch / "consumer", "-G", os.environ["SSV_GENERATOR"],
             f"-DCMAKE_PREFIX_PATH={self.prefix}", f"-DPROGRAM_INCLUDE={SUPPORT}",
             f"-DPROGRAM_SOURCES={';'.join(map(str, sources))}", "-DCMAKE_BUILD_TYPE=Release"])
        run(["cmake", "--build", self.scratch / "consumer"])
        run([os.environ["CC"], *core_flags(), f"-I{SUPPORT}", *sources, os.environ["SSV_PLANNER_ARCHIVE"], "-lm",
             "-o", self.scratch / "direct"])
        seed_and_count = [7, 5]
        self.assertEqual(run([self.scratch / "consumer/consumer", *seed_and_count]),
                         run([self.scratch / "direct", *seed_and_count]))


if __name__ == "__main__":
    unittest.main()
