"""Somebody else's project has the planner: as cmake --install leaves it, or as a subproject, which is the library alone; and a
build of the library alone needs nothing but a compiler."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from core import HERE, ROOT, SUPPORT, core_flags, run

BUILD = os.environ["SSV_BUILD_DIR"]
CLEAN = {"PATH": "/usr/bin:/bin"}


def configure(source, folder, **settings):
    """Configures with nothing found but what these settings and the system give."""
    run(["cmake", "-S", source, "-B", folder, "-G", os.environ["SSV_GENERATOR"], f"-DCMAKE_C_COMPILER={os.environ['CC']}",
         *(f"-D{name}={value}" for name, value in settings.items())],
        env={name: value for name, value in os.environ.items() if name != "CMAKE_PREFIX_PATH"})


def is_program(path):
    return path.is_file() and os.access(path, os.X_OK) and "CMakeFiles" not in path.parts and path.suffix != ".so"


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = pathlib.Path(scratch.name)
        cls.prefix = cls.scratch / "prefix"
        run(["cmake", "--install", BUILD, "--prefix", cls.prefix])

    def test_only_the_core_headers_are_installed_and_those_of_the_messages_in_a_folder_of_their_own(self):
        headers = sorted(str(path.relative_to(self.prefix)) for path in self.prefix.glob("**/*.h")
                         if path.parent.name != "ssv_lcmtypes")
        self.assertEqual(headers, [f"include/ssv/{name}.h" for name in
                                   ("plan", "planner", "real", "real_double", "real_fixed", "real_float", "scenario",
                                    "timeline", "vec3")])

    @unittest.skipUnless(os.environ["SSV_BUILD_HOST"] == "ON", "built without the programs")
    def test_installed_programs_start_and_do_not_lean_on_the_build_folder(self):
        programs = sorted(path.name for path in (self.prefix / "bin").iterdir())
        self.assertEqual(programs, ["ssv", "ssv-fixed", "ssv-float", "ssv-plannerd", "ssv-plannerd-fixed", "ssv-plannerd-float",
                                    "ssv-replay", "ssv-sim", "ssv-vehicle"])
        for program in programs:
            with self.subTest(program=program):
                self.assertTrue(run([self.prefix / "bin" / program, "--version"], env=CLEAN).strip())
                self.assertNotIn(BUILD, run(["readelf", "-d", self.prefix / "bin" / program]))

    def test_another_project_finds_the_package_and_plans_the_same(self):
        sources = [HERE / "plan_hashes.c", SUPPORT / "sample.c"]
        configure(HERE / "consumer", self.scratch / "consumer", HOW="installed", CMAKE_PREFIX_PATH=self.prefix,
                  PROGRAM_INCLUDE=SUPPORT, PROGRAM_SOURCES=";".join(map(str, sources)), CMAKE_BUILD_TYPE="Release")
        run(["cmake", "--build", self.scratch / "consumer"])
        run([os.environ["CC"], *core_flags(), f"-I{SUPPORT}", *sources, os.environ["SSV_PLANNER_ARCHIVE"], "-lm",
             "-o", self.scratch / "direct"])
        seed_and_count = [7, 5]
        self.assertEqual(run([self.scratch / "consumer/consumer", *seed_and_count]),
                         run([self.scratch / "direct", *seed_and_count]))
        self.assertEqual(run([self.scratch / "consumer/fly_cxx"]), run([self.scratch / "consumer/fly_c"]))


    @unittest.skipUnless(os.environ["SSV_BUILD_HOST"] == "ON", "built without the programs")
    def test_another_project_asks_a_planner_by_the_messages_that_are_installed(self):
        lcm = next((pathlib.Path(BUILD) / "venv/lib").glob("python3*/site-packages"))
        folder = self.scratch / "asker"
        configure(HERE / "consumer", folder, HOW="installed", COMPONENTS="lcmtypes", CMAKE_PREFIX_PATH=f"{self.prefix};{lcm}")
        run(["cmake", "--build", folder])
        url = f"udpm://239.255.76.67:{20000 + os.getpid() % 20000}?ttl=0"
        daemon = subprocess.Popen([self.prefix / "bin/ssv-plannerd", "--lcm-url", url], stderr=subprocess.DEVNULL)
        try:
            asked = float.fromhex(run([folder / "ask", url]))
        finally:
            daemon.terminate()
            daemon.wait()
        planned = float.fromhex(run([folder / "fly_c"]).split()[2])
        self.assertAlmostEqual(asked / planned, 1, 12)  # half a turn is rounded by one and not by the other
        files, jar = (folder / "other_languages.txt").read_text().splitlines()
        self.assertEqual(sorted(pathlib.Path(file).name for file in files.split(";")),
                         sorted(path.name for path in (ROOT / "lcmtypes").glob("*.lcm")))
        for file in files.split(";"):
            self.assertEqual(pathlib.Path(file).read_text(), (ROOT / "lcmtypes" / pathlib.Path(file).name).read_text())
        if (pathlib.Path(BUILD) / "share/ssv_lcmtypes.jar").exists():
            self.assertEqual(pathlib.Path(jar).read_bytes(), (pathlib.Path(BUILD) / "share/ssv_lcmtypes.jar").read_bytes())


class Subproject(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = pathlib.Path(scratch.name)

    def assert_nothing_else_was_looked_for(self, folder):
        entries = re.findall(r"^(\w+):", (folder / "CMakeCache.txt").read_text(), re.M)
        self.assertIn("SSV_REAL", entries)
        self.assertEqual([name for name in entries if re.match("lcm|SSV_UNITY|JANSSON|CYAML|Java|.*Python", name)], [])

    def test_as_a_subproject_the_planner_is_the_library_alone_in_the_scalar_asked_for(self):
        for how, scalar in (("subdirectory", "double"), ("fetched", "fixed"), ("subdirectory", "float")):
            with self.subTest(how=how, scalar=scalar):
                folder = self.scratch / f"{how}-{scalar}"
                configure(HERE / "consumer", folder, HOW=how, PLANNER=ROOT,
                          **({} if scalar == "double" else {"SSV_REAL": scalar}))
                self.assert_nothing_else_was_looked_for(folder)
                run(["cmake", "--build", folder])
                self.assertEqual([path.name for path in folder.rglob("*.a")], ["libssv_planner.a"])
                self.assertEqual({path.name for path in folder.rglob("*") if is_program(path)}, {"fly_c", "fly_cxx"})
                in_c = run([folder / "fly_c"])
                self.assertEqual(in_c.split()[:2], [scalar, scalar])
                self.assertEqual(run([folder / "fly_cxx"]), in_c)
                self.assertIn("Total Tests: 0", run(["ctest", "--test-dir", folder, "--show-only"]))
                run(["cmake", "--install", folder, "--prefix", folder / "prefix"])
                self.assertEqual([path.name for path in (folder / "prefix").rglob("*") if path.is_file()], ["fly_c"])

    def test_a_parent_that_compiles_everything_with_fast_math_is_refused_with_the_reason(self):
        with self.assertRaisesRegex(AssertionError, "cannot be built with -ffast-math"):
            configure(HERE / "consumer", self.scratch / "fast", HOW="subdirectory", PLANNER=ROOT,
                      CMAKE_C_FLAGS="-ffast-math")
            run(["cmake", "--build", self.scratch / "fast"])

    def test_the_library_alone_needs_neither_lcm_nor_unity_nor_jansson(self):
        folder = self.scratch / "alone"
        configure(ROOT, folder, SSV_BUILD_HOST="OFF", SSV_BUILD_TESTS="OFF", SSV_REAL="fixed")
        self.assert_nothing_else_was_looked_for(folder)
        run(["cmake", "--build", folder])
        run(["cmake", "--install", folder, "--prefix", folder / "prefix"])
        self.assertTrue(list((folder / "prefix").glob("lib*/**/libssv_planner.a")))


if __name__ == "__main__":
    unittest.main()
